// Errors and exit codes: everything that Mortise can tell its caller went wrong.
//
// Inside the library an error is thrown once, as mortise::Error, by the code that knows its cause;
// the command line turns it into one line on stderr and the exit code below.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

namespace mortise {

/// Exit codes of every `mortise` command; documented in the README, append-only.
enum class ExitCode : std::int32_t {
    kOk = 0,
    kUsage = 1,    ///< unknown option, value out of range
    kInput = 2,    ///< a model that is not understood, or is no bounded solid; a damaged mesh file
    kMeshing = 3,  ///< no valid mesh could be made, or `check` found the mesh invalid
    kQuality = 4,  ///< --quality-floor not met
    kDevice = 5,   ///< no OpenCL device, a failing kernel build, out of memory
    kFiles = 6,    ///< a file cannot be opened, read or written
};

/// What went wrong, in one line that names the thing, its value, its limit and what to do.
class Error : public std::runtime_error {
  public:
    Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
    ExitCode code() const noexcept { return code_; }

  private:
    ExitCode code_;
};

/// MeshOptions::progress asked to stop: an Error(kMeshing), so catch this one first to tell it from a
/// failure.
class Interrupted : public Error {
  public:
    Interrupted() : Error(ExitCode::kMeshing, "interrupted") {}
};

/// A place in a text file. Lines and columns count from 1; 0 means unknown.
struct SourceLocation {
    std::uint32_t line = 0;
    std::uint32_t column = 0;
};

}  // namespace mortise
