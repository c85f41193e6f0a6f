// Cells of several sizes: 2:1 balance alone, and what a coarse interior saves.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "bench/models.hpp"
#include "bench/workers.hpp"
#include "host/octree/octree.hpp"
#include "mortise/mesher.hpp"

namespace mortise::bench {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

/// Nodes that meet a sphere in the unit cube, off its middle so that nothing is symmetric, level by level:
/// the tree of its surface, unbalanced.
octree::SplitNodes split_at_sphere(int finest) {
    constexpr double kCentre[3] = {0.47, 0.51, 0.53};
    constexpr double kRadius = 0.4;
    octree::SplitNodes split(static_cast<std::size_t>(finest));
    split[0] = {0};
    for (int level = 1; level < finest; ++level) {
        const double edge = std::ldexp(1.0, -level);
        for (const std::uint64_t parent : split[static_cast<std::size_t>(level) - 1]) {
            for (std::uint64_t child = 8 * parent; child < 8 * parent + 8; ++child) {
                double nearest = 0;
                double farthest = 0;
                for (int j = 0; j < 3; ++j) {
                    const double low = gather_bits(child >> j) * edge - kCentre[j];
                    const double high = low + edge;
                    const double inner = low > 0 ? low : high < 0 ? high : 0;
                    nearest += inner * inner;
                    farthest += std::max(low * low, high * high);
                }
                if (nearest <= kRadius * kRadius && farthest >= kRadius * kRadius)
                    split[static_cast<std::size_t>(level)].push_back(child);
            }
        }
    }
    return split;
}

struct Counts {
    std::uint64_t elements = 0, boundary = 0, transition = 0;
};

Counts count(const Mesh& mesh) {
    Counts counts;
    for (const ElementBlock& block : mesh.elements) {
        counts.elements += block.size();
        for (const std::uint8_t kind : block.kind) {
            const auto of = static_cast<ElementKind>(kind);
            counts.transition += of == ElementKind::kTransition ? 1 : 0;
            counts.boundary += of == ElementKind::kSnio || of == ElementKind::kCnio ? 1 : 0;
        }
    }
    return counts;
}

}  // namespace

nlohmann::json measure_balance(const Task& task) {
    const octree::SplitNodes wanted = split_at_sphere(task.level);
    nlohmann::json result = {{"runs", nlohmann::json::array()}};
    for (int run = 0; run < task.repeats; ++run) {
        octree::SplitNodes split = wanted;
        const auto begin = Clock::now();
        octree::balance(split, {}, task.threads);
        result["runs"].push_back({{"seconds", Seconds(Clock::now() - begin).count()}});
        std::uint64_t nodes = 0;
        for (const auto& level : split) nodes += level.size();
        result["leaves"] = 7 * nodes + 1;
    }
    return result;
}

nlohmann::json measure_graded(const Task& task) {
    const Model model = make_model(task.model);
    MeshOptions options;
    options.threads = task.threads;
    options.level = std::min(task.level, 3);
    Mesher mesher;
    mesher.generate(model, options);  // loads the kernels
    options.level = task.level;
    options.interior_coarsening = task.level;

    nlohmann::json result;
    for (const bool hanging : {false, true}) {
        options.hanging = hanging;
        MeshReport report;
        const auto begin = Clock::now();
        const Counts counts = count(mesher.generate(model, options, &report));
        const std::string name = hanging ? "hanging" : "conforming";
        result[name + "_seconds"] = Seconds(Clock::now() - begin).count();
        result[name + "_elements"] = counts.elements;
        if (hanging) continue;
        // Coarse leaves are cubes or transition cells; in a mesh of one size each would be cubes of the
        // finest.
        std::uint64_t coarse = 0;
        std::uint64_t fine = 0;
        for (std::size_t level = 0; level + 1 < report.leaves.size(); ++level) {
            coarse += report.leaves[level];
            fine += report.leaves[level] << (3 * (report.leaves.size() - 1 - level));
        }
        result["uniform_elements"] =
            counts.elements - (coarse - report.transition_cells) - counts.transition + fine;
        result["boundary_elements"] = counts.boundary;
        result["transition_cells"] = report.transition_cells;
        result["transition_elements"] = counts.transition;
    }
    return result;
}

}  // namespace mortise::bench
