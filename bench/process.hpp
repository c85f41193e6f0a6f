// Child processes (POSIX), what they cost, and how busy the machine was meanwhile.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace mortise::bench {

struct ProgramResult {
    int exit_code = 0;        ///< 128 + signal if a signal ended it
    std::string output;       ///< stdout; with stderr if they were merged
    double wall_seconds = 0;  ///< from before the start to its end
};

/// Runs a program (found on PATH if the name has no slash) to its end. `environment` adds to or replaces
/// variables of this process. With `merge_errors` its stderr is part of the output, otherwise it goes to
/// ours. Throws Error(kFiles) if it cannot be started.
ProgramResult run_program(const std::vector<std::string>& arguments,
                          const std::vector<std::pair<std::string, std::string>>& environment = {},
                          bool merge_errors = false);

/// Absolute path of this program.
std::string own_path();

/// Whether PATH has an executable file of that name.
bool is_on_path(const std::string& name);

/// A new folder for temporary files, removed with its content at the end.
class ScratchFolder {
  public:
    ScratchFolder();
    ~ScratchFolder();
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

/// Largest resident memory of this process so far, and its resident memory now; 0 if the system does not say.
std::uint64_t peak_resident_bytes();
std::uint64_t resident_bytes();

/// How much of the machine others used since construction (Linux; elsewhere unknown).
class LoadWatch {
  public:
    LoadWatch();
    struct Load {
        bool known = false;
        double others = 0;  ///< share of all cores that other processes used, 0 to 1
        double stolen = 0;  ///< share of all cores that the hypervisor gave to other machines, 0 to 1
    };
    Load so_far() const;

  private:
    double busy_ = 0;
    double stolen_ = 0;
    double total_ = 0;
    double own_ = 0;
};

}  // namespace mortise::bench
