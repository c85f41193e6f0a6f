// The octree stage alone: kernel time of the descent, and the host reference on the same model.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "bench/models.hpp"
#include "bench/workers.hpp"
#include "host/octree/octree.hpp"
#include "host/tape/reference.hpp"

namespace mortise::bench {
namespace {

/// Cube about the solid with one cell of margin, as the pipeline takes it.
tape::BoundModel bind_to_cube(const Model& model, int level) {
    const tape::CompiledModel compiled = tape::compile(model);
    const Box3 bounds = tape::find_bounds(compiled, model.source);
    const double cells = std::ldexp(1.0, level);
    double side = 0;
    for (std::size_t j = 0; j < 3; ++j) side = std::max(side, bounds.max[j] - bounds.min[j]);
    side *= cells / (cells - 2);
    Vec3 origin{};
    for (std::size_t j = 0; j < 3; ++j) origin[j] = 0.5 * (bounds.min[j] + bounds.max[j] - side);
    return tape::bind(compiled, origin, side);
}

/// Depth-first descent by the scalar reference, in double precision with pruned tapes, on one thread. Counts
/// classified cells.
std::uint64_t descend_by_reference(const tape::BoundModel& model, const std::vector<std::uint32_t>& tape,
                                   const tape::Cell& parent, int levels) {
    std::uint64_t cells = 8;
    for (int c = 0; c < 8; ++c) {
        tape::Cell child;
        child.half = 0.5 * parent.half;
        for (int j = 0; j < 3; ++j) {
            child.centre[j] = parent.centre[j] + (((c >> j) & 1) != 0 ? child.half : -child.half);
        }
        std::vector<std::uint32_t> pruned;
        const std::int32_t region = tape::classify_cell(model, tape, child, &pruned);
        if (region == kUnknown && levels > 1) cells += descend_by_reference(model, pruned, child, levels - 1);
    }
    return cells;
}

double kernel_seconds(const device::Device& device) {
    double sum = 0;
    for (const device::KernelTime& time : device.times()) {
        if (time.entry == "descend" || time.entry == "gather_children") sum += time.seconds;
    }
    return sum;
}

}  // namespace

nlohmann::json measure_octree(const Task& task) {
    using Clock = std::chrono::steady_clock;
    using Seconds = std::chrono::duration<double>;
    const tape::BoundModel model = bind_to_cube(make_model(task.model), task.level);
    device::Device device;
    octree::build(device, model, task.level, nullptr);  // loads the kernels, and makes malloc keep its pages

    nlohmann::json result = {{"device", device.info().name},
                             {"compute_units", device.info().compute_units},
                             {"is_gpu", device.info().is_gpu},
                             {"surfaces", model.surfaces.size()},
                             {"runs", nlohmann::json::array()}};
    for (int run = 0; run < task.repeats; ++run) {
        device.reset_times();
        const auto begin = Clock::now();
        const octree::Octree tree = octree::build(device, model, task.level, nullptr);
        const auto built = Clock::now();
        const std::uint64_t cells =
            descend_by_reference(model, model.tape, {{0.5, 0.5, 0.5}, 0.5}, task.level);
        const auto end = Clock::now();
        result["cells"] = tree.cells_evaluated;
        result["nio_cells"] = tree.nio.size();
        result["tree_bytes"] = tree.nio.size() * sizeof(TreeNode) + tree.tapes.size() * sizeof(std::uint32_t);
        result["reference_cells"] = cells;
        result["runs"].push_back({{"kernel_seconds", kernel_seconds(device)},
                                  {"stage_seconds", Seconds(built - begin).count()},
                                  {"reference_seconds", Seconds(end - built).count()}});
    }
    return result;
}

}  // namespace mortise::bench
