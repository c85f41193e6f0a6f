// See scad_program.hpp. OpenSCAD writes to its standard output (since 2021.01), so there is no temporary
// file, and the paths of imports are relative to the .scad file's folder, wherever the process runs.
#include "host/model/csg/scad_program.hpp"

#include <algorithm>
#include <filesystem>
#include <regex>
#include <sstream>

#include "host/model/child_process.hpp"
#include "host/model/text.hpp"

namespace mortise::model_reader {
namespace {

constexpr const char* kProgram = "openscad";

bool begins_with(const std::string& text, const std::string& beginning) {
    return text.compare(0, beginning.size(), beginning) == 0;
}

std::string name_of(const std::string& definition) { return definition.substr(0, definition.find('=')); }

/// Whether the name stands in the text as a word of its own.
bool has_word(const std::string& text, const std::string& name) {
    for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + 1)) {
        const std::size_t end = at + name.size();
        if ((at == 0 || !is_name_part(text[at - 1])) && (end == text.size() || !is_name_part(text[end]))) {
            return true;
        }
    }
    return false;
}

std::string seconds_text(double seconds) {
    std::ostringstream text;
    text << seconds;
    return text.str();
}

/// OpenSCAD's message with its place in front, where it is in the file itself: "part.scad:3: syntax error".
/// The definitions stand behind the file's last line.
std::string located(const std::string& message, const std::string& path, const std::string& text,
                    bool with_definitions) {
    static const std::regex place("^(.*),? in file (.*), line ([0-9]{1,9})$");
    std::smatch parts;
    // Regular expressions recurse along their text; messages are short.
    constexpr std::size_t kLongest = 2000;
    if (message.size() > kLongest || !std::regex_match(message, parts, place) ||
        std::filesystem::path(parts[2].str()).filename() != std::filesystem::path(path).filename()) {
        return path + ": openscad: " + message.substr(0, kLongest);
    }
    const long lines = std::count(text.begin(), text.end(), '\n') + 1;
    if (std::stol(parts[3]) > lines) {
        return path + ": openscad: " + parts[1].str() + ", at the end of the file" +
               (with_definitions ? " or in a --define" : "");
    }
    return path + ":" + parts[3].str() + ": openscad: " + parts[1].str();
}

/// What OpenSCAD says on a line of its standard error.
struct Remarks {
    std::string error;  ///< the first one; empty: none
    std::string other;  ///< the first line that is no error, warning or output of the model
    std::vector<std::string> warnings;
};

Remarks read_remarks(const std::string& err) {
    Remarks remarks;
    std::istringstream lines(err);
    for (std::string line; std::getline(lines, line);) {
        const std::string error = "ERROR: ";
        const std::string warning = "WARNING: ";
        if (begins_with(line, error)) {
            if (remarks.error.empty()) remarks.error = line.substr(error.size());
        } else if (begins_with(line, warning)) {
            remarks.warnings.push_back(line.substr(warning.size()));
        } else if (remarks.other.empty() && !line.empty() && !begins_with(line, "ECHO: ") &&
                   !begins_with(line, "TRACE: ") && !begins_with(line, "DEPRECATED: ")) {
            remarks.other = line;
        }
    }
    return remarks;
}

}  // namespace

void check_definitions(const std::vector<std::string>& definitions) {
    for (const std::string& definition : definitions) {
        const std::string name = name_of(definition);
        const std::size_t first = begins_with(name, "$") ? 1 : 0;
        const bool named = name.size() > first && is_name_start(name[first]) &&
                           std::all_of(name.begin() + static_cast<std::ptrdiff_t>(first), name.end(),
                                       [](char c) { return is_name_part(c); });
        if (named && definition.size() > name.size() + 1) continue;
        throw Error(ExitCode::kUsage,
                    "--define '" + definition + "': expected NAME=VALUE, such as width=4.5 or 'label=\"A\"'");
    }
}

ConvertedScad convert_scad(const std::string& path, const std::string& text, const ReadOptions& options) {
    check_definitions(options.definitions);
    const std::string program = find_program(kProgram);
    if (program.empty()) {
        throw Error(ExitCode::kInput,
                    path +
                        ": .scad files are converted by the program openscad, which is not installed; "
                        "install it (apt install openscad, or openscad.org), or convert the file where "
                        "it is: openscad -o part.csg part.scad");
    }
    // An absolute path cannot be taken for an option.
    std::vector<std::string> words = {"-o", "-", "--export-format", "csg"};
    for (const std::string& definition : options.definitions) {
        words.push_back("-D");
        words.push_back(definition);
    }
    words.push_back(std::filesystem::absolute(path).string());
    ChildResult result = run_child(program, words, options.conversion_seconds);
    if (result.timed_out) {
        throw Error(ExitCode::kInput, path + ": openscad took longer than " +
                                          seconds_text(options.conversion_seconds) +
                                          " s and was ended; look for an endless loop, or convert the file "
                                          "yourself: openscad -o part.csg part.scad");
    }
    // A failed assertion is an error, too, although the exit code is 0.
    const Remarks remarks = read_remarks(result.err);
    if (result.code != 0 || !remarks.error.empty()) {
        std::string message = remarks.error.empty() ? remarks.other : remarks.error;
        if (message.empty()) message = "failed with exit code " + std::to_string(result.code);
        throw Error(ExitCode::kInput, located(message, path, text, !options.definitions.empty()));
    }
    ConvertedScad converted;
    converted.csg = std::move(result.out);
    for (const std::string& warning : remarks.warnings) {
        converted.warnings.push_back(located(warning, path, text, !options.definitions.empty()));
    }
    // OpenSCAD takes any name. One from an included file is not in sight.
    for (const std::string& definition : options.definitions) {
        const std::string name = name_of(definition);
        if (name[0] == '$' || has_word(text, name) || has_word(text, "include")) continue;
        converted.warnings.push_back(path + ": --define " + name + " has no effect: the file has no '" +
                                     name + "'");
    }
    return converted;
}

}  // namespace mortise::model_reader
