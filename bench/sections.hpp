// The sections of the report. Each measures in child processes, prints its figures with what they mean, and
// returns them for the JSON file.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace mortise::bench {

struct Settings {
    int repeats = 5;
    int command_repeats = 7;
    int threads = 1;      ///< "all threads"
    int finer = 0;        ///< added to every level
    int level_limit = 9;  ///< higher levels are lowered to this one; a sphere of level 10 takes 60 GB
    std::size_t copy_bytes = std::size_t{256} << 20;
    std::string program;                            ///< the command `mortise`; empty: not measured
    int batch_models = 200;                         ///< of the section batch
    bool with_lattice = false;                      ///< section mesh: the lattice of struts, too
    bool with_billion = false;                      ///< section stream: 10^9 elements, too
    bool with_peers = true;                         ///< false: all other meshers count as not installed
    int peer_repeats = 3;                           ///< if there are not fewer `repeats`
    std::vector<double> large_meshes = {1e6, 1e7};  ///< elements of Mortise's other meshes beside peers'
    double peer_seconds = 30;     ///< a peer whose run would take longer makes a coarser mesh
    std::string cgal_program;     ///< made from cgal_mesh.cpp; empty: none
    std::string quartet_program;  ///< empty: none
    std::string python_netgen;    ///< Python that may have Netgen's module

    int level(int wanted) const { return wanted + finer < level_limit ? wanted + finer : level_limit; }
};

nlohmann::json copy_section(const Settings& settings);
nlohmann::json octree_section(const Settings& settings);
nlohmann::json graded_section(const Settings& settings);

/// `copy_bytes_per_second`: of all threads, or 0 if it was not measured.
nlohmann::json mesh_section(const Settings& settings, double copy_bytes_per_second);
nlohmann::json stages_section(const Settings& settings, double copy_bytes_per_second);
/// `copy_gain`: copy bandwidth of all threads to that of one, or 0.
nlohmann::json threads_section(const Settings& settings, double copy_gain);
nlohmann::json command_section(const Settings& settings);
nlohmann::json batch_section(const Settings& settings);
nlohmann::json jacobians_section(const Settings& settings);
nlohmann::json stream_section(const Settings& settings);
nlohmann::json peers_section(const Settings& settings);

/// Tells on stderr what is being measured, so that a long run is seen to be alive.
void announce(const std::string& what);

/// "1 thread", "2 threads".
std::string count_of_threads(int threads);

}  // namespace mortise::bench
