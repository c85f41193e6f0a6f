// Mortise beside other meshers at equal mean edge length; see sections.hpp.
//
// Speeds of meshers compare only within one run on one machine, so all take turns, with the same cores. The
// target is the mean edge length of Mortise's hybrid mesh. Meshes of different types have different numbers
// of elements and nodes at the same edge length, so all three currencies are printed: elements/s, nodes/s
// (what a solver pays for), and time. What is left of a difference in edge length is taken out of the time by
// its third power, as if time grew linearly with the number of elements; most grow faster.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
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

/// Mortise's own side: the same model at the target's level, as tetrahedra, and larger, where fixed costs do
/// not count any more.
struct Own {
    Row row;
    Task task;
};

Own own_side(const Settings& settings, const char* model, int level, bool tetrahedra,
             const std::string& surface) {
    Own own;
    own.task.model = model;
    own.task.level = level;
    own.task.threads = settings.threads;
    own.task.tetrahedra = tetrahedra;
    own.row.name =
        std::string("Mortise") + (tetrahedra ? ", tetrahedra" : "") + ", level " + std::to_string(level);
    own.row.note =
        "Mesher::generate, kernels loaded, memory warm: improvement, features, scaled Jacobians included";
    own.task.kind = "edges";
    own.task.path = surface;
    own.row.mean_edge = measure_in_child(own.task).at("mean_edge");
    own.task.kind = "mesh";
    own.task.repeats = settings.repeats < 3 ? settings.repeats : 3;
    return own;
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

/// Mortise's rates as multiples of each peer's: at the same edge length, and with the larger mesh.
json print_ratios(const std::vector<Row>& rows, double target) {
    const Row& same = rows[0];
    const Row& tetrahedra = rows[1];
    const Row& large = rows[2];
    const Row& large_tetrahedra = rows[3];
    json ratios = json::array();
    Table table({{"Mortise to", ""},
                 {"nodes/s", same.name.substr(9)},
                 {"elements/s", ""},
                 {"time", ""},
                 {"tetrahedra:", "tets/s"},
                 {"nodes/s", large.name.substr(9)},
                 {"elements/s", ""},
                 {"tetrahedra:", "tets/s"}});
    for (const Row& row : rows) {
        if (!row.is_peer) continue;
        const json ratio = {
            {"peer", row.name},
            {"nodes_per_second", same.nodes_per_second() / row.nodes_per_second()},
            {"elements_per_second", same.elements_per_second() / row.elements_per_second()},
            {"time_at_equal_edge", row.seconds_at(target) / same.seconds.median()},
            {"tetrahedra_per_second", tetrahedra.elements_per_second() / row.elements_per_second()},
            {"large_nodes_per_second", large.nodes_per_second() / row.nodes_per_second()},
            {"large_elements_per_second", large.elements_per_second() / row.elements_per_second()},
            {"large_tetrahedra_per_second",
             large_tetrahedra.elements_per_second() / row.elements_per_second()}};
        std::vector<std::string> cells = {row.name};
        for (const char* field :
             {"nodes_per_second", "elements_per_second", "time_at_equal_edge", "tetrahedra_per_second",
              "large_nodes_per_second", "large_elements_per_second", "large_tetrahedra_per_second"})
            cells.push_back(short_number(ratio.at(field)));
        table.add(cells);
        ratios.push_back(ratio);
    }
    if (!ratios.empty()) table.print();
    return ratios;
}

json compare(const Settings& settings, const char* model, std::vector<Peer> peers,
             const ScratchFolder& folder) {
    const int level = settings.level(5);
    const int large_level = settings.level(7);
    PeerJob job;
    job.model = model;
    job.surface = folder.path() / (job.model + ".smesh");
    announce(job.model + " beside others: Mortise's edge lengths");
    std::vector<Own> own = {own_side(settings, model, level, false, ""),
                            own_side(settings, model, level, true, job.surface.string()),
                            own_side(settings, model, large_level, false, ""),
                            own_side(settings, model, large_level, true, "")};
    const double target = own[0].row.mean_edge;
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
        for (Own& one : own) run_own(one);
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
    std::vector<Row> rows;
    for (const Own& one : own) rows.push_back(one.row);
    std::copy_if(theirs.begin(), theirs.end(), std::back_inserter(rows),
                 [](const Row& row) { return !row.seconds.values.empty(); });
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
    result["ratios"] = print_ratios(rows, target);
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
