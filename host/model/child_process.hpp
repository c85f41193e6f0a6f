// Another program as a child: no shell, its output in memory, ended with its parent or after a time limit.
#pragma once

#include <string>
#include <vector>

namespace mortise::model_reader {

struct ChildResult {
    int code = 0;            ///< exit code; 128 + n if signal n ended it
    bool timed_out = false;  ///< it was ended by us
    std::string out;         ///< standard output
    std::string err;         ///< the beginning of standard error
};

/// The program of that name in the folders of PATH; empty if there is none.
std::string find_program(const std::string& name);

/// Runs `path` and waits for it, at most `seconds`. Its standard input is empty. Throws Error(kFiles) if it
/// cannot be started, Error(kInput) if its output is larger than any model.
ChildResult run_child(const std::string& path, const std::vector<std::string>& arguments, double seconds);

}  // namespace mortise::model_reader
