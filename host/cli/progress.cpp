// See progress.hpp.
#include "host/cli/progress.hpp"

#include <unistd.h>

#include <cstdio>

namespace mortise::cli {

Progress::Progress(bool quiet) : active_(!quiet && isatty(STDERR_FILENO) != 0) {}

void Progress::show(const char* stage, double fraction) {
    if (!active_) return;
    std::fprintf(stderr, "\r\033[K%3d%% %s", static_cast<int>(100 * fraction), stage);
    std::fflush(stderr);
    shown_ = true;
}

void Progress::clear() {
    if (!shown_) return;
    std::fputs("\r\033[K", stderr);
    shown_ = false;
}

void Progress::warn(const std::string& message) {
    if (!warned_.insert(message).second) return;
    clear();
    std::fprintf(stderr, "warning: %s\n", one_line(message).c_str());
}

std::string one_line(const std::string& text) {
    std::string line;
    for (const char c : text) {
        const bool blank = static_cast<unsigned char>(c) <= ' ' || c == '\x7f';
        if (!blank) {
            line += c;
        } else if (!line.empty() && line.back() != ' ') {
            line += ' ';
        }
    }
    if (!line.empty() && line.back() == ' ') line.pop_back();
    return line;
}

}  // namespace mortise::cli
