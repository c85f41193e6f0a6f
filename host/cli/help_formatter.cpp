#include "host/cli/help_formatter.hpp"

#include <iomanip>
#include <sstream>
#include <vector>

namespace mortise::cli {
namespace {

constexpr int kNameColumn = 24;

void line(std::ostream& out, const std::string& name, const std::string& text) {
    out << "  " << std::left << std::setw(kNameColumn) << name << " " << text << "\n";
}

}  // namespace

std::string HelpFormatter::make_help(const CLI::App* app, std::string, CLI::AppFormatMode) const {
    std::ostringstream out;
    out << app->get_description() << "\nUsage: " << usage_ << "\n";
    for (const std::string& group : app->get_groups()) {
        if (group.empty()) continue;  // options that are not shown
        const auto options = app->get_options([&group](const CLI::Option* option) {
            return option->nonpositional() && option->get_group() == group;
        });
        if (!options.empty()) out << "\n" << group << ":\n";
        for (const CLI::Option* option : options) {
            const std::string value = option->get_option_text();
            line(out, option->get_name(false, true) + (value.empty() ? "" : " " + value),
                 option->get_description());
        }
    }
    const std::vector<const CLI::App*> commands = app->get_subcommands({});
    if (!commands.empty()) {
        out << "\nOther commands (`mortise COMMAND --help`):\n";
        for (const CLI::App* command : commands) line(out, command->get_name(), command->get_description());
    }
    out << app->get_footer();
    return out.str();
}

}  // namespace mortise::cli
