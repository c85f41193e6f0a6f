// The real program as a child process, and a temporary folder for its files.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <string>
#include <utility>
#include <vector>

/// A folder that goes away with the object.
class ScratchFolder {
  public:
    ScratchFolder();
    ~ScratchFolder();
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    std::string file(const std::string& name) const { return path_ + "/" + name; }
    /// Writes a file (and the folders above it) and returns its path.
    std::string write(const std::string& name, const std::string& content) const;
    /// Names in a subfolder, sorted; the subfolder is made if it is not there.
    std::vector<std::string> names(const std::string& subfolder) const;

  private:
    std::string path_;
};

struct Outcome {
    int code = -1;    ///< exit code, or -1 if a signal ended it
    int signal = 0;   ///< that signal
    std::string out;  ///< standard output
    std::string err;  ///< standard error
    double seconds = 0;
};

using Environment = std::vector<std::pair<std::string, std::string>>;

/// A run of `mortise`; its standard streams are files, so it sees no terminal.
class Program {
  public:
    /// `out`: where its standard output goes, and is not read again; empty: into Outcome::out.
    explicit Program(const std::vector<std::string>& arguments, const Environment& environment = {},
                     const std::string& out = {});
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;
    ~Program();

    bool running();
    void send(int signal_number) const;
    Outcome wait();

  private:
    ScratchFolder streams_;
    pid_t process_ = -1;
    bool ended_ = false;
    int status_ = 0;
    std::chrono::steady_clock::time_point start_;
};

Outcome run(const std::vector<std::string>& arguments, const Environment& environment = {});

std::string read_file(const std::string& path);

/// Whether the text is exactly one line that begins so.
bool is_one_line(const std::string& text, const std::string& beginning);

bool contains(const std::string& text, const std::string& part);

/// A model of assets/models.
std::string asset(const std::string& name);
