// What a cell makes of corners that snap: it is meshed while they are where they were, on their surfaces
// (docs/design/snapping.md).
#include <algorithm>
#include <cmath>

#include "host/cnio/cell.hpp"
#include "host/octree/odd_corner.hpp"
#include "host/tape/projection.hpp"

namespace mortise::cnio {
namespace {

// Per edge of the cell or patch.
constexpr double kApart = 0.4;        ///< between an apex and where a corner is moved to
constexpr double kOnWithin = 1e-5;    ///< a moved node, of all surfaces that it should be on
constexpr double kTargetReach = 0.7;  ///< of a node's way
constexpr double kCrossing = 0.1;     ///< as tape::ProjectionLimits::tangent
constexpr double kLastStep = 1e-10;

}  // namespace

/// A corner that snaps is on its surfaces for all cells around it.
void Cell::snap_corner(LocalNode corner) {
    const octree::SnappedVertex* vertex = tree_.snapped_at(tree_.vertex_of(leaf_.morton, level_, corner));
    if (vertex == nullptr) return;
    snapped_ |= static_cast<std::uint8_t>(1u << corner);
    for (std::size_t j = 0; j < 3; ++j) nodes_[corner].target[j] += vertex->moved[j] * (units_ / kCellUnits);
    for (std::size_t s = 0; s < surfaces_.size(); ++s) {
        if (vertex->is_on(surfaces_[s])) set_sign(corner, s, 0);
    }
}

/// See octree::odd_corner.
std::size_t Cell::odd_corner(const Patch& patch) const {
    if (!snaps() || patch.quarter) return 4;
    return octree::odd_corner(tree_, model_, leaf_.morton, patch.face);
}

void Cell::settle_targets(std::size_t first, const std::uint8_t* active) {
    if (!snaps()) return;
    const tape::ProjectionLimits limits = {kTargetReach * scale_.size, kCrossing, kLastStep * scale_.size};
    const double unit = size_ / units_ * scale_.step;
    for (std::size_t i = first; i < nodes_.size(); ++i) {
        std::vector<std::size_t> wanted;
        bool is_off = false;
        for (std::size_t s = 0; s < surfaces_.size(); ++s) {
            if ((active != nullptr && active[s] == 0) || sign(i, s) != 0 || is_solid(s) || is_joint(s))
                continue;
            wanted.push_back(s);
            is_off = is_off || pure_sign(s, nodes_[i].point, scale_.size) != 0;
        }
        if (!is_off) continue;
        // Of surfaces that do not cross, the first.
        double start[3];
        double at[3];
        position(nodes_[i].point, start);
        std::copy(start, start + 3, at);
        std::vector<std::uint32_t> on;
        for (const std::size_t s : wanted) {
            double x[3] = {start[0], start[1], start[2]};
            on.push_back(surfaces_[s]);
            if (tape::project(model_, on.data(), on.size(), limits, x))
                std::copy(x, x + 3, at);
            else
                on.pop_back();
        }
        misplaced_ =
            misplaced_ || on.empty() || std::any_of(wanted.begin(), wanted.end(), [&](std::size_t s) {
                return !(distance_to(s, at) <= kOnWithin * scale_.size);
            });
        for (std::size_t j = 0; j < 3; ++j)
            nodes_[i].target[j] +=
                scale_.step * static_cast<std::int32_t>(std::rint((at[j] - start[j]) / unit));
    }
}

/// Whether a surface passes through corners that snap, and nowhere else between these nodes.
bool Cell::only_touches(std::size_t surface, const LocalNode* nodes, std::size_t count) const {
    if (!snaps() || sides(nodes, count, surface).are_mixed()) return false;
    return std::any_of(nodes, nodes + count, [&](LocalNode node) {
        return sign(node, surface) == 0 && nodes_[node].target != nodes_[node].point;
    });
}

/// Whether an apex would lie close to where a corner of the cell, or of the face, will be moved to.
bool Cell::is_crowding(const ApexSearch& search, const LatticePoint& apex) const {
    const auto axis = static_cast<std::size_t>(search.fixed_axis);
    for (std::size_t c = 0; c < 8; ++c) {
        if (nodes_[c].target == nodes_[c].point) continue;
        if (axis < 3 && nodes_[c].point[axis] != apex[axis]) continue;
        if (distance(nodes_[c].target, apex) < kApart * units_) return true;
    }
    return false;
}

/// Sign in the middle of a patch, where corners have moved to if they snap.
int Cell::middle_sign(std::size_t surface, const Patch& patch) const {
    if (!snaps()) return pure_sign(surface, patch.middle, patch.scale.size);
    LatticePoint sum{};
    for (const LocalNode corner : patch.corner) {
        for (std::size_t j = 0; j < 3; ++j) sum[j] += nodes_[corner].target[j];
    }
    return pure_sign(surface, {sum[0] / 4, sum[1] / 4, sum[2] / 4}, patch.scale.size);
}

}  // namespace mortise::cnio
