// What the user sees on stderr: one updating line with stage and percentage (terminals only), and warnings.
#pragma once

#include <set>
#include <string>

namespace mortise::cli {

class Progress {
  public:
    explicit Progress(bool quiet);
    ~Progress() { clear(); }
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void show(const char* stage, double fraction);
    void clear();
    void warn(const std::string& message);  ///< each message once

  private:
    bool active_ = false;
    bool shown_ = false;
    std::set<std::string> warned_;
};

/// The text as one line: line breaks and other control characters become spaces, runs of spaces one.
std::string one_line(const std::string& text);

}  // namespace mortise::cli
