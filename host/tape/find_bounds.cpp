// The box of a compiled model: by its structure, else by interval arithmetic in ever smaller boxes.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "host/common/message_text.hpp"
#include "host/tape/compile.hpp"
#include "host/tape/convex_bounds.hpp"
#include "host/tape/reference.hpp"
#include "host/tape/surface_bounds.hpp"
#include "kernels/shared/surface.h"

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

/// Boxes that cover what may be solid in `box`, from repeated halving; none: that part is empty. Stops where
/// halving once more could make more than `most_cells`. `skip(cell)`: whether a box need not be looked at.
template <class Skip>
std::vector<Box3> cover(const CompiledModel& compiled, const Box3& box, std::size_t most_cells,
                        const Skip& skip) {
    constexpr int kLevels = 6;
    double side = 0;
    for (std::size_t j = 0; j < 3; ++j) side = std::max(side, box.max[j] - box.min[j]);
    const BoundModel model = bind(compiled, box.min, side);
    struct Node {
        Cell cell;
        std::vector<std::uint32_t> tape;
    };
    const auto box_of = [&](const Cell& cell) {
        Box3 result;
        for (std::size_t j = 0; j < 3; ++j) {
            result.min[j] = std::max(box.min[j], box.min[j] + (cell.centre[j] - cell.half) * side);
            result.max[j] = std::min(box.max[j], box.min[j] + (cell.centre[j] + cell.half) * side);
        }
        return result;
    };
    std::vector<Node> cells = {{{{0.5, 0.5, 0.5}, 0.5}, model.tape}};
    for (int level = 0; level < kLevels && cells.size() * 8 <= most_cells; ++level) {
        std::vector<Node> next;
        for (const Node& node : cells) {
            for (int c = 0; c < 8; ++c) {
                Cell child = node.cell;
                child.half *= 0.5;
                for (int j = 0; j < 3; ++j) child.centre[j] += ((c >> j) & 1) != 0 ? child.half : -child.half;
                const Box3 at = box_of(child);
                if (!(at.min[0] < at.max[0] && at.min[1] < at.max[1] && at.min[2] < at.max[2]) || skip(at))
                    continue;
                std::vector<std::uint32_t> pruned;
                const std::int32_t region = classify_cell(model, node.tape, child, &pruned);
                if (region == 0 || (region == kUnknown && is_empty(pruned))) continue;
                next.push_back({child, region == kUnknown ? std::move(pruned) : node.tape});
            }
        }
        cells = std::move(next);
    }
    std::vector<Box3> boxes;
    for (const Node& node : cells) boxes.push_back(box_of(node.cell));
    return boxes;
}

constexpr std::size_t kMostCells = 8192;

std::vector<Box3> cover(const CompiledModel& compiled, const Box3& box) {
    return cover(compiled, box, kMostCells, [](const Box3&) { return false; });
}

Box3 around(const std::vector<Box3>& boxes) {
    Box3 all = kNothing;
    for (const Box3& box : boxes) grow(all, box);
    return all;
}

/// The solid's box in `box`, by cells of ever smaller boxes; nothing if it is empty there.
std::optional<Box3> tighten(const CompiledModel& compiled, Box3 box) {
    constexpr int kRounds = 60;
    for (int round = 0; round < kRounds; ++round) {
        const std::vector<Box3> cells = cover(compiled, box);
        if (cells.empty()) return std::nullopt;
        const Box3 shrunk = around(cells);
        bool settled = true;
        for (std::size_t j = 0; j < 3; ++j)
            settled = settled && shrunk.max[j] - shrunk.min[j] > 0.9 * (box.max[j] - box.min[j]);
        box = shrunk;
        if (settled) break;
    }
    return box;
}

constexpr double kFar = 1e4;  ///< unbounded directions are searched this many model scales wide

struct Found {
    Box3 box{};
    int unbounded_along = -1;  ///< axis; -1: none
};

bool is_finite(const Box3& box) {
    bool finite = true;
    for (std::size_t j = 0; j < 3; ++j)
        finite = finite && std::isfinite(box.min[j]) && std::isfinite(box.max[j]);
    return finite;
}

[[noreturn]] void refuse_as_empty(const CompiledModel& compiled, const std::string& source) {
    throw Error(ExitCode::kInput, source + ": the solid is empty" +
                                      (compiled.is_cut ? ", or lies outside of the box that cuts it" : ""));
}

/// What of the compiled bounds is within `reach` of the origin.
Box3 cut_bounds(const CompiledModel& compiled, double reach) {
    Box3 box = compiled.bounds;
    shrink(box, {{-reach, -reach, -reach}, {reach, reach, reach}});
    return box;
}

Box3 tightened(const CompiledModel& compiled, const Box3& box, const std::string& source) {
    const std::optional<Box3> tight = tighten(compiled, box);
    if (!tight) refuse_as_empty(compiled, source);
    return *tight;
}

Found search(const CompiledModel& compiled, const std::string& source) {
    const Box3& known = compiled.bounds;
    if (!(known.min[0] < known.max[0] && known.min[1] < known.max[1] && known.min[2] < known.max[2]))
        refuse_as_empty(compiled, source);
    if (is_finite(known)) return {known};
    const Box3 box = cut_bounds(compiled, kFar * compiled.scale);
    const std::vector<Box3> cells = cover(compiled, box);
    if (cells.empty()) refuse_as_empty(compiled, source);
    const Box3 all = around(cells);
    for (std::size_t j = 0; j < 3; ++j) {
        if ((!std::isfinite(known.min[j]) && all.min[j] <= box.min[j]) ||
            (!std::isfinite(known.max[j]) && all.max[j] >= box.max[j])) {
            // Flat parts fill so many cells that these stay too large to be told empty.
            const Box3 convex = convex_bounds(compiled);
            if (convex.min[0] > convex.max[0]) refuse_as_empty(compiled, source);
            if (is_finite(convex)) return {tightened(compiled, convex, source)};
            return {box, static_cast<int>(j)};
        }
    }
    return {tightened(compiled, all, source)};
}

/// Far away the intervals of a formula that turns the solid (a twist, a rotation by hand) tell nothing. A
/// part around the origin with nothing about it, up to kClear times as far, is what is meant: the smallest
/// such.
std::optional<Box3> find_island(const CompiledModel& compiled) {
    constexpr double kClear = 4;
    constexpr int kDoublings = 12;
    constexpr std::size_t kMostShellCells = 32768;
    for (int k = 0; k <= kDoublings; ++k) {
        const double reach = std::ldexp(compiled.scale, k);
        const Box3 inner = cut_bounds(compiled, reach);
        const Box3 outer = cut_bounds(compiled, kClear * reach);
        const auto is_inner = [&inner](const Box3& cell) {
            bool inside = true;
            for (std::size_t j = 0; j < 3; ++j)
                inside = inside && cell.min[j] >= inner.min[j] && cell.max[j] <= inner.max[j];
            return inside;
        };
        if (!cover(compiled, outer, kMostShellCells, is_inner).empty()) continue;
        if (const std::optional<Box3> box = tighten(compiled, inner)) return box;
    }
    return std::nullopt;
}

/// Whether formulas have no finite value far away along an axis, on rays from the middle outwards, and no
/// point there is known to be solid: then nothing tells where the solid ends.
bool overflows(const CompiledModel& compiled, std::size_t axis) {
    constexpr int kSteps = 4;  // to both sides, across the axis
    if (!compiled.polyhedra.empty()) return false;
    const double reach = kFar * compiled.scale;
    const Box3 box = cut_bounds(compiled, reach);
    const BoundModel model = bind(compiled, {-reach, -reach, -reach}, 2 * reach);
    bool has_overflow = false;
    for (const double end : {box.min[axis], box.max[axis]}) {
        if (std::fabs(end) < reach) continue;
        for (int k = 0; k < (2 * kSteps + 1) * (2 * kSteps + 1); ++k) {
            const double across[2] = {static_cast<double>(k % (2 * kSteps + 1) - kSteps) / kSteps,
                                      static_cast<double>(k / (2 * kSteps + 1) - kSteps) / kSteps};
            double x[3];
            for (std::size_t j = 0; j < 3; ++j) {
                // Closer together near the middle, where solids are.
                const double t = j == axis ? 0 : across[j == (axis + 1) % 3 ? 0 : 1];
                x[j] = 0.5 + 0.5 * (j == axis ? end / reach : t * t * t);
            }
            bool is_finite = true;
            for (const Surface& surface : model.surfaces) {
                const double value = surface_value(&surface, model.expression_ops.data(), x[0], x[1], x[2]);
                is_finite = is_finite && std::isfinite(value);
            }
            if (is_finite && region_at(model, x[0], x[1], x[2]) != 0) return false;
            has_overflow = has_overflow || !is_finite;
        }
    }
    return has_overflow;
}

[[noreturn]] void refuse_unbounded(const CompiledModel& compiled, int axis, const std::string& source) {
    static const char* const kCut =
        "cut it with --box x0 y0 z0 x1 y1 z1 or intersect it with a bounded solid; a solid that is bounded "
        "needs --box, or a line of bounds in a .formula file, to say where it is";
    const std::string distance = rounded_text(kFar * compiled.scale);
    if (overflows(compiled, static_cast<std::size_t>(axis))) {
        throw Error(ExitCode::kInput,
                    source + ": a formula has no finite value " + distance + " from the origin along " +
                        "xyz"[axis] +
                        " (as where exp or a power overflows), which hides where the solid ends; write it so "
                        "that it is finite there, or " +
                        kCut);
    }
    throw Error(ExitCode::kInput, source + ": no end of the solid was found along " + "xyz"[axis] +
                                      " within " + distance + " of the origin; " + kCut);
}

std::string island_text(const Box3& box) {
    return "the solid could not be shown to end; taken as what lies in " + place_text(box.min) + " to " +
           place_text(box.max) + ", with nothing around it; --box tells for certain";
}

}  // namespace

Box3 find_bounds(const CompiledModel& compiled, const std::string& source,
                 std::vector<std::string>* warnings) {
    const Found found = search(compiled, source);
    if (found.unbounded_along < 0) return found.box;
    const std::optional<Box3> island = find_island(compiled);
    if (!island) refuse_unbounded(compiled, found.unbounded_along, source);
    if (warnings != nullptr) warnings->push_back(island_text(*island));
    return *island;
}

Box3 find_bounds(const Model& model, const CompiledModel& compiled, const Box3* clip,
                 std::vector<std::string>* warnings) {
    const bool is_hinted =
        std::any_of(model.nodes.begin(), model.nodes.end(), [](const CsgNode& node) { return node.bounds; });
    if (!is_hinted) return find_bounds(compiled, model.source, warnings);
    const Found found = search(compiled, model.source);
    if (found.unbounded_along < 0) return found.box;
    return find_bounds(compile(model, clip, NodeBounds::kCut), model.source, warnings);
}

}  // namespace mortise::tape
