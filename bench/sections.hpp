// The sections of the report. Each measures in child processes, prints its figures with what they mean, and
// returns them for the JSON file.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

namespace mortise::bench {

struct Settings {
    int repeats = 5;
    int command_repeats = 7;
    int threads = 1;       ///< "all threads"
    int level_limit = 99;  ///< higher levels are lowered to this one
    std::size_t copy_bytes = std::size_t{256} << 20;
    std::string program;  ///< the command `mortise`; empty: not measured

    int level(int wanted) const { return wanted < level_limit ? wanted : level_limit; }
};

nlohmann::json copy_section(const Settings& settings);
nlohmann::json octree_section(const Settings& settings);

/// `copy_bytes_per_second`: of all threads, or 0 if it was not measured.
nlohmann::json mesh_section(const Settings& settings, double copy_bytes_per_second);
nlohmann::json threads_section(const Settings& settings);
nlohmann::json command_section(const Settings& settings);
nlohmann::json jacobians_section(const Settings& settings);
nlohmann::json stream_section(const Settings& settings);
nlohmann::json gmsh_section(const Settings& settings);

/// Tells on stderr what is being measured, so that a long run is seen to be alive.
void announce(const std::string& what);

/// "1 thread", "2 threads".
std::string count_of_threads(int threads);

}  // namespace mortise::bench
