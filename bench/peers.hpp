// The meshers that Mortise is compared with: how each is run, and what it says of its run.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/sections.hpp"

namespace mortise::bench {

/// One mesh by another program.
struct PeerRun {
    double elements = 0;
    double nodes = 0;
    double seconds = 0;    ///< of meshing, as the program reports it: no start, no file
    double mean_edge = 0;  ///< each edge counted once
};

/// What a peer is asked for.
struct PeerJob {
    std::string model;              ///< "sphere" or "bracket"
    double size = 0;                ///< in the peer's own sense, near the length of an edge
    std::filesystem::path surface;  ///< of the same model: .smesh, for those that only fill a surface
};

struct Peer {
    std::string name;
    std::string note;  ///< what its time holds and what it does not
    /// Throws Error if the program fails or says something unexpected.
    std::function<PeerRun(const PeerJob&)> run;
};

/// Those that are installed; prints a line for each that is not, and notes it in `skipped`. Files go to
/// `folder`.
std::vector<Peer> find_peers(const Settings& settings, const std::filesystem::path& folder,
                             nlohmann::json& skipped);

}  // namespace mortise::bench
