// The box of a compiled model: by its structure, else by interval arithmetic in ever smaller boxes.
#include <algorithm>
#include <array>
#include <cmath>

#include "host/tape/compile.hpp"
#include "host/tape/reference.hpp"

namespace mortise::tape {
namespace {

/// Whether a short tape is outside whatever its surfaces' signs: p ∧ ¬p, as formulas that use a minimum twice
/// have it.
bool is_empty(const std::vector<std::uint32_t>& tape) {
    constexpr std::size_t kMostWords = 64;
    for (const std::uint32_t word : tape) {
        if (tape_operation(word) == kTapeSpatial) return false;
    }
    return tape.size() <= kMostWords && resolve_signs(tape.data(), tape.size(), nullptr, 0, nullptr) == 0;
}

struct Found {
    Box3 box{};
    int unbounded_along = -1;  ///< axis; -1: none
};

Found search(const CompiledModel& compiled, const std::string& source) {
    constexpr double kFar = 1e4;             // unbounded directions are searched this many model scales wide
    constexpr std::size_t kMaxCells = 8192;  // cells that a round may hold
    Box3 box = compiled.bounds;
    if (!(box.min[0] < box.max[0] && box.min[1] < box.max[1] && box.min[2] < box.max[2])) {
        throw Error(ExitCode::kInput, source + ": the solid is empty");
    }
    bool finite = true;
    for (std::size_t j = 0; j < 3; ++j)
        finite = finite && std::isfinite(box.min[j]) && std::isfinite(box.max[j]);
    if (finite) return {box};
    std::array<bool, 6> open{};
    for (std::size_t j = 0; j < 3; ++j) {
        open[2 * j] = !std::isfinite(box.min[j]);
        open[2 * j + 1] = !std::isfinite(box.max[j]);
        box.min[j] = std::max(box.min[j], -kFar * compiled.scale);
        box.max[j] = std::min(box.max[j], kFar * compiled.scale);
    }
    for (int round = 0; round < 60; ++round) {
        Vec3 extent{};
        double side = 0;
        for (std::size_t j = 0; j < 3; ++j) side = std::max(side, extent[j] = box.max[j] - box.min[j]);
        const BoundModel model = bind(compiled, box.min, side);
        struct Node {
            Cell cell;
            std::vector<std::uint32_t> tape;
        };
        std::vector<Node> cells = {{{{0.5, 0.5, 0.5}, 0.5}, model.tape}};
        for (int level = 0; level < 6 && cells.size() * 8 <= kMaxCells; ++level) {
            std::vector<Node> next;
            for (const Node& node : cells) {
                for (int c = 0; c < 8; ++c) {
                    Cell child = node.cell;
                    child.half *= 0.5;
                    bool outside = false;
                    for (int j = 0; j < 3; ++j) {
                        child.centre[j] += ((c >> j) & 1) != 0 ? child.half : -child.half;
                        outside = outside || (child.centre[j] - child.half) * side >=
                                                 extent[static_cast<std::size_t>(j)];
                    }
                    std::vector<std::uint32_t> pruned;
                    if (outside) continue;
                    const std::int32_t region = classify_cell(model, node.tape, child, &pruned);
                    if (region == 0 || (region == kUnknown && is_empty(pruned))) continue;
                    next.push_back({child, region == kUnknown ? std::move(pruned) : node.tape});
                }
            }
            cells = std::move(next);
        }
        if (cells.empty()) throw Error(ExitCode::kInput, source + ": the solid is empty");
        Box3 shrunk{{1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}};
        for (const Node& node : cells) {
            for (std::size_t j = 0; j < 3; ++j) {
                const double low = box.min[j] + (node.cell.centre[j] - node.cell.half) * side;
                const double high = box.min[j] + (node.cell.centre[j] + node.cell.half) * side;
                shrunk.min[j] = std::min(shrunk.min[j], std::max(low, box.min[j]));
                shrunk.max[j] = std::max(shrunk.max[j], std::min(high, box.max[j]));
            }
        }
        if (round == 0) {
            for (std::size_t j = 0; j < 3; ++j) {
                if ((open[2 * j] && shrunk.min[j] <= box.min[j]) ||
                    (open[2 * j + 1] && shrunk.max[j] >= box.max[j])) {
                    return {box, static_cast<int>(j)};
                }
            }
        }
        bool settled = true;
        for (std::size_t j = 0; j < 3; ++j) {
            settled = settled && shrunk.max[j] - shrunk.min[j] > 0.9 * (box.max[j] - box.min[j]);
        }
        box = shrunk;
        if (settled) break;
    }
    return {box};
}

[[noreturn]] void refuse_unbounded(int axis, const std::string& source) {
    throw Error(ExitCode::kInput, source + ": the solid is unbounded along " + "xyz"[axis] +
                                      "; cut it with --box x0 y0 z0 x1 y1 z1 or intersect it with a bounded "
                                      "solid");
}

}  // namespace

Box3 find_bounds(const CompiledModel& compiled, const std::string& source) {
    const Found found = search(compiled, source);
    if (found.unbounded_along >= 0) refuse_unbounded(found.unbounded_along, source);
    return found.box;
}

Box3 find_bounds(const Model& model, const CompiledModel& compiled, const Box3* clip) {
    const Found found = search(compiled, model.source);
    if (found.unbounded_along < 0) return found.box;
    const bool is_hinted =
        std::any_of(model.nodes.begin(), model.nodes.end(), [](const CsgNode& node) { return node.bounds; });
    if (!is_hinted) refuse_unbounded(found.unbounded_along, model.source);
    return find_bounds(compile(model, clip, NodeBounds::kCut), model.source);
}

}  // namespace mortise::tape
