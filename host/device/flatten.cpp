// See flatten.hpp. A line-by-line pass that knows comments and two directives; it does not evaluate #if, so
// an #include "..." in an inactive branch must still name an existing file.
#include "host/device/flatten.hpp"

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "mortise/error.hpp"

namespace mortise::device {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxDepth = 32;  // of nested includes: more can only be a .def file that includes itself

/// Blanks comments of one line; `in_comment` carries a block comment over to the next line.
std::string without_comments(const std::string& line, bool& in_comment) {
    std::string code;
    bool in_string = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
        const char next = i + 1 < line.size() ? line[i + 1] : '\0';
        if (in_comment) {
            if (line[i] == '*' && next == '/') {
                in_comment = false;
                ++i;
            }
            continue;
        }
        if (!in_string && line[i] == '/' && next == '/') break;
        if (!in_string && line[i] == '/' && next == '*') {
            in_comment = true;
            code += ' ';
            ++i;
            continue;
        }
        if (line[i] == '"' && (i == 0 || line[i - 1] != '\\')) in_string = !in_string;
        code += line[i];
    }
    return code;
}

/// The rest of a directive line "# name rest", without blanks around it; nothing for other lines.
std::optional<std::string> directive(const std::string& code, const std::string& name) {
    const char* const blanks = " \t\r";
    std::size_t at = code.find_first_not_of(blanks);
    if (at == std::string::npos || code[at] != '#') return std::nullopt;
    at = code.find_first_not_of(blanks, at + 1);
    if (at == std::string::npos || code.compare(at, name.size(), name) != 0) return std::nullopt;
    const std::size_t begin = code.find_first_not_of(blanks, at + name.size());
    if (begin == std::string::npos) return std::string();
    return code.substr(begin, code.find_last_not_of(blanks) + 1 - begin);
}

class Flattener {
  public:
    explicit Flattener(const KernelReader& read) : read_(read) {}

    void append(const std::string& path, const std::string& text, int depth) {
        taken_.insert(path);
        out_ << "#line 1 \"kernels/" << path << "\"\n";
        std::istringstream lines(text);
        std::string line;
        bool in_comment = false;
        for (int number = 1; std::getline(lines, line); ++number) {
            const std::string code = without_comments(line, in_comment);
            const std::optional<std::string> target = directive(code, "include");
            if (target && !target->empty() && target->front() == '"') {
                include(path, number, *target, depth);
            } else if (directive(code, "pragma") == std::string("once")) {
                out_ << '\n';
            } else {
                out_ << line << '\n';
            }
        }
    }

    std::string text() const { return out_.str(); }

  private:
    void include(const std::string& path, int number, const std::string& quoted, int depth) {
        const std::string where = "kernels/" + path + ":" + std::to_string(number);
        const std::size_t end = quoted.find('"', 1);
        if (end == std::string::npos) {
            throw Error(ExitCode::kDevice, where + ": #include " + quoted + " has no closing quote");
        }
        std::string target = quoted.substr(1, end - 1);
        if (depth == kMaxDepth) {
            throw Error(ExitCode::kDevice, where + ": includes nest deeper than " +
                                               std::to_string(kMaxDepth) + "; \"" + target +
                                               "\" seems to include itself");
        }
        if (target.rfind("kernels/", 0) == 0) target.erase(0, 8);
        for (const fs::path& folder : {fs::path(path).parent_path(), fs::path()}) {
            const std::string found = (folder / target).lexically_normal().generic_string();
            if (found.rfind("..", 0) == 0) continue;
            const bool repeatable = fs::path(found).extension() == ".def";
            if (!repeatable && taken_.count(found) != 0) {
                out_ << '\n';
                return;
            }
            if (const std::optional<std::string> text = read_(found)) {
                append(found, *text, depth + 1);
                out_ << "#line " << number + 1 << " \"kernels/" << path << "\"\n";
                return;
            }
        }
        throw Error(ExitCode::kDevice, where + ": include file \"" + target + "\" not found below kernels/");
    }

    const KernelReader& read_;
    std::set<std::string> taken_;
    std::ostringstream out_;
};

}  // namespace

KernelReader folder_reader(const std::string& kernels_folder) {
    return [root = fs::path(kernels_folder)](const std::string& path) -> std::optional<std::string> {
        std::error_code error;
        if (!fs::is_regular_file(root / path, error)) return std::nullopt;
        std::ifstream file(root / path, std::ios::binary);
        if (!file) return std::nullopt;
        std::ostringstream text;
        text << file.rdbuf();
        return text.str();
    };
}

std::string flatten_kernel(const std::string& file, const KernelReader& read) {
    const std::string path = fs::path(file).lexically_normal().generic_string();
    const std::optional<std::string> text = read(path);
    if (!text) throw Error(ExitCode::kDevice, "kernel file kernels/" + path + " not found");
    Flattener flattener(read);
    flattener.append(path, *text, 0);
    return flattener.text();
}

}  // namespace mortise::device
