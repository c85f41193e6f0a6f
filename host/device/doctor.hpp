// `mortise doctor`: checks everything that running on an OpenCL device needs, and says how to repair it.
#pragma once

#include <string>
#include <vector>

namespace mortise::device {

/// One check and its outcome.
struct DoctorLine {
    bool ok = false;
    std::string what;    ///< e.g. "linker on PATH"
    std::string detail;  ///< what was found, e.g. its path
    std::string remedy;  ///< what to do; empty if ok
};

/// Runs all checks, in the order in which later ones depend on earlier ones; never throws. Takes about a
/// second when programs have to be built, and 0.3 s of busy threads to measure the speed-up.
std::vector<DoctorLine> doctor(const std::string& choice = {});

}  // namespace mortise::device
