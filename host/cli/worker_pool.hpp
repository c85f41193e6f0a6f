// Work shared out to child processes: one that crashes, or is killed for want of memory, costs its own item
// only.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace mortise::cli {

/// Calls work(i) for every i < count in one of `jobs` child processes, and done(i, result, 0) here with what
/// it returned, in any order; done(i, "", signal) if the process ended by a signal (or with an exit code,
/// then 0 - code; 5 if `work` threw). Call it before any thread has been started. Throws Error(kFiles) if no
/// process can be started and none is at work.
void run_in_processes(std::size_t count, std::size_t jobs,
                      const std::function<std::string(std::size_t)>& work,
                      const std::function<void(std::size_t, std::string, int)>& done);

}  // namespace mortise::cli
