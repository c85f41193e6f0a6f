// Mortise beside other meshers at equal mean edge length; see sections.hpp.
//
// Speeds of meshers compare only within one run on one machine, so all take turns, with the same cores. The
// target is the mean edge length of Mortise's hybrid mesh. Meshes of different types have different numbers
// of elements and nodes at the same edge length, so all three currencies are printed: elements/s, nodes/s
// (what a solver pays for), and time. What is left of a difference in edge length is taken out of the time by
// its third power, as if time grew linearly with the number of elements; most grow faster.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <vector>

#include "bench/peers.hpp"
#include "bench/print.hpp"
#include "bench/process.hpp"
#include "bench/sections.hpp"
#include "bench/statistics.hpp"
#include "bench/workers.hpp"
#include "mortise/error.hpp"

namespace mortise::bench {
namespace {

using nlohmann::json;

constexpr double kTolerance = 0.03;  ///< of the mean edge length
constexpr int kRounds = 4;           ///< of correcting a peer's size
constexpr double kCoarse = 1.7;      ///< first, a peer makes edges so many times as long, to tell its time

/// One mesher's line of the table.
struct Row {
    std::string name;
    std::string note;
    double elements = 0;
    double nodes = 0;
    double mean_edge = 0;
    Samples seconds;
    bool is_peer = false;
    bool at_target = true;

    double elements_per_second() const { return elements / seconds.median(); }
    double nodes_per_second() const { return nodes / seconds.median(); }
    double seconds_at(double edge) const { return seconds.median() * std::pow(mean_edge / edge, 3); }
};

/// A mesh of Mortise's own: of the target's level, or larger, where fixed costs do not count any more.
struct Own {
    Row row;
    Task task;
};

/// Hexahedra and tetrahedra, in meshes that belong together.
struct OwnPair {
    std::string name;
    Own hybrid, tetrahedra;
};

/// Finds the size of cells that gives about so many elements.
void set_elements(double wanted, Task& task) {
    for (int round = 0; round < kRounds; ++round) {
        const json measured = measure_in_child(task);
        const double excess = measured.at("elements").get<double>() / wanted;
        if (std::fabs(excess - 1) <= kTolerance) break;
        task.size = measured.at("cell_size").get<double>() * std::cbrt(excess);
    }
}

/// `elements`: how many it shall have, or 0 for those of the level.
Own own_side(const Settings& settings, const Task& base, const std::string& name, double elements,
             bool tetrahedra) {
    Own own;
    own.task = base;
    own.task.tetrahedra = tetrahedra;
    own.row.name = std::string("Mortise") + (tetrahedra ? ", tetrahedra" : "") + ", " + name;
    own.row.note =
        "Mesher::generate, kernels loaded, memory warm: improvement, features, scaled Jacobians included";
    own.task.kind = "mesh";
    if (elements > 0) set_elements(elements, own.task);
    own.task.kind = "edges";
    own.row.mean_edge = measure_in_child(own.task).at("mean_edge");
    own.task.kind = "mesh";
    own.task.path.clear();
    own.task.repeats = settings.repeats < 3 ? settings.repeats : 3;
    return own;
}

/// The boundary of the tetrahedra that belong to the target goes to `surface`.
std::vector<OwnPair> own_meshes(const Settings& settings, const char* model, int level,
                                const std::string& surface) {
    Task base;
    base.model = model;
    base.level = level;
    base.threads = settings.threads;
    Task with_surface = base;
    with_surface.path = surface;
    const std::string name = "level " + std::to_string(level);
    std::vector<OwnPair> meshes = {
        {name, own_side(settings, base, name, 0, false), own_side(settings, with_surface, name, 0, true)}};
    for (const double elements : settings.large_meshes) {
        const std::string large = grouped(static_cast<std::uint64_t>(elements)) + " elements";
        meshes.push_back({large, own_side(settings, base, large, elements, false),
                          own_side(settings, base, large, elements, true)});
    }
    return meshes;
}

void run_own(Own& own) {
    const json measured = measure_in_child(own.task);
    own.row.elements = measured.at("elements");
    own.row.nodes = measured.at("nodes");
    own.row.seconds.values.push_back(collect(measured.at("runs"), "seconds").median());
}

/// Finds the peer's size that gives the target's mean edge length, or a longer one if a run would take too
/// long; the job then has that size.
void calibrate(const Settings& settings, const Peer& peer, double target, PeerJob& job, Row& row) {
    job.size = kCoarse * target;
    PeerRun run = peer.run(job);
    double wanted = target;
    while (run.seconds * std::pow(run.mean_edge / wanted, 3) > settings.peer_seconds) wanted *= 1.1;
    row.at_target = wanted == target;
    for (int round = 0; round < kRounds; ++round) {
        if (std::fabs(run.mean_edge / wanted - 1) <= kTolerance) break;
        job.size *= wanted / run.mean_edge;
        run = peer.run(job);
    }
}

json to_json(const Row& row, double target) {
    return {{"name", row.name},
            {"time_holds", row.note},
            {"is_peer", row.is_peer},
            {"at_target", row.at_target},
            {"elements", row.elements},
            {"nodes", row.nodes},
            {"mean_edge", row.mean_edge},
            {"seconds", to_json(row.seconds)},
            {"spread", row.seconds.spread()},
            {"elements_per_second", row.elements_per_second()},
            {"nodes_per_second", row.nodes_per_second()},
            {"seconds_at_target_edge", row.seconds_at(target)}};
}

void print(const std::vector<Row>& rows, double target) {
    Table table({{"", ""},
                 {"elements", ""},
                 {"nodes", ""},
                 {"mean edge", "to target"},
                 {"time", "s"},
                 {"spread", ""},
                 {"elements", "k/s"},
                 {"nodes", "k/s"},
                 {"time at", "target edge"}});
    for (const Row& row : rows) {
        table.add({row.name, grouped(static_cast<std::uint64_t>(row.elements)),
                   grouped(static_cast<std::uint64_t>(row.nodes)), fixed(row.mean_edge / target, 2),
                   short_number(row.seconds.median()), percent(row.seconds.spread()),
                   short_number(1e-3 * row.elements_per_second()),
                   short_number(1e-3 * row.nodes_per_second()), short_number(row.seconds_at(target)) + " s"});
    }
    table.print();
}

/// Mortise's rates as multiples of each peer's, for each pair of its own meshes.
json print_ratios(const std::vector<OwnPair>& own, const std::vector<Row>& theirs, double target) {
    json ratios = json::array();
    for (const OwnPair& pair : own) {
        const Row& hybrid = pair.hybrid.row;
        const bool is_target = hybrid.mean_edge == target;
        Table table({{"Mortise to", pair.name},
                     {"nodes/s", ""},
                     {"elements/s", ""},
                     {"tetrahedra:", "tets/s"},
                     {is_target ? "time at" : "", is_target ? "target edge" : ""}});
        for (const Row& row : theirs) {
            json ratio = {{"mesh", pair.name},
                          {"peer", row.name},
                          {"nodes_per_second", hybrid.nodes_per_second() / row.nodes_per_second()},
                          {"elements_per_second", hybrid.elements_per_second() / row.elements_per_second()},
                          {"tetrahedra_per_second",
                           pair.tetrahedra.row.elements_per_second() / row.elements_per_second()}};
            if (is_target) ratio["time_at_equal_edge"] = row.seconds_at(target) / hybrid.seconds.median();
            std::vector<std::string> cells = {row.name};
            for (const char* field :
                 {"nodes_per_second", "elements_per_second", "tetrahedra_per_second", "time_at_equal_edge"})
                cells.push_back(ratio.contains(field) ? short_number(ratio.at(field)) : "");
            table.add(cells);
            ratios.push_back(ratio);
        }
        if (!theirs.empty()) table.print();
    }
    return ratios;
}

json compare(const Settings& settings, const char* model, std::vector<Peer> peers,
             const ScratchFolder& folder) {
    const int level = settings.level(5);
    PeerJob job;
    job.model = model;
    job.surface = folder.path() / (job.model + ".smesh");
    announce(job.model + " beside others: Mortise's edge lengths");
    std::vector<OwnPair> own = own_meshes(settings, model, level, job.surface.string());
    const double target = own[0].hybrid.row.mean_edge;
    std::vector<PeerJob> jobs;
    std::vector<Row> theirs;
    for (auto peer = peers.begin(); peer != peers.end();) {
        announce(job.model + ": " + peer->name + ", edge length");
        Row row;
        row.name = peer->name;
        row.note = peer->note;
        row.is_peer = true;
        try {
            calibrate(settings, *peer, target, job, row);
        } catch (const Error& error) {
            std::printf("  left out: %s: %s\n", peer->name.c_str(), error.what());
            peer = peers.erase(peer);
            continue;
        }
        jobs.push_back(job);
        theirs.push_back(row);
        ++peer;
    }
    for (int run = 0; run < std::min(settings.repeats, settings.peer_repeats); ++run) {
        announce(job.model + ": all in turn, run " + std::to_string(run + 1));
        for (OwnPair& pair : own) {
            run_own(pair.hybrid);
            run_own(pair.tetrahedra);
        }
        for (std::size_t i = 0; i < peers.size(); ++i) {
            PeerRun made;
            try {
                made = peers[i].run(jobs[i]);
            } catch (const Error& error) {
                std::printf("  %s, one run: %s\n", peers[i].name.c_str(), error.what());
                continue;
            }
            theirs[i].elements = made.elements;
            theirs[i].nodes = made.nodes;
            theirs[i].mean_edge = made.mean_edge;
            theirs[i].seconds.values.push_back(made.seconds);
        }
    }
    theirs.erase(std::remove_if(theirs.begin(), theirs.end(),
                                [](const Row& row) { return row.seconds.values.empty(); }),
                 theirs.end());
    std::vector<Row> rows;
    for (const OwnPair& pair : own) rows.insert(rows.end(), {pair.hybrid.row, pair.tetrahedra.row});
    rows.insert(rows.end(), theirs.begin(), theirs.end());
    std::printf("  %s: target edge length %s (Mortise's hybrid mesh of level %d)\n", model,
                short_number(target).c_str(), level);
    print(rows, target);
    for (const Row& row : rows) {
        if (!row.at_target)
            std::printf(
                "  %s: coarser than the target, for a run at it would take more than %s s "
                "(--peer-seconds)\n",
                row.name.c_str(), short_number(settings.peer_seconds).c_str());
    }
    json result = {{"model", model}, {"level", level}, {"target_edge", target}, {"rows", json::array()}};
    for (const Row& row : rows) result["rows"].push_back(to_json(row, target));
    result["ratios"] = print_ratios(own, theirs, target);
    std::printf("\n");
    return result;
}

}  // namespace

json peers_section(const Settings& settings) {
    std::printf(
        "Beside other meshers at equal mean edge length, in turn, on the same %d cores\n"
        "  times are each program's own, of meshing: no start, no files; Mortise: Mesher::generate, "
        "kernels loaded\n"
        "  Gmsh, CGAL, Netgen: from the solid, surface and volume; TetGen: volume only, in Mortise's "
        "surface\n",
        settings.threads);
    const ScratchFolder folder;
    json result;
    const std::vector<Peer> peers = find_peers(settings, folder.path(), result["skipped"]);
    result["models"] = json::array();
    for (const char* model : {"sphere", "bracket"}) {
        result["models"].push_back(compare(settings, model, peers, folder));
        std::fflush(stdout);
    }
    return result;
}

}  // namespace mortise::bench
