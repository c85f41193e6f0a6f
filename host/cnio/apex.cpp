// Where the apexes of cells and of faces that are fans lie (corner before crease before
// surface before centre).
#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/cnio/cell.hpp"
#include "host/tape/projection.hpp"

namespace mortise::cnio {
namespace {

// Per edge of the cell or patch.
constexpr double kNear = 0.6;       ///< surfaces farther from the middle are not looked at
constexpr double kMargin = 0.35;    ///< the apex may move this far along each axis; with 0.45 slivers stay
constexpr double kReach = 0.7;      ///< in all
constexpr double kTangent = 0.1;    ///< sine between gradients below which surfaces do not cross
constexpr double kSettled = 1e-10;  ///< the last step
constexpr double kSectionsAreOne = 1e-6;
constexpr double kRival = 0.0015;  ///< a surface this close to the apex may be the one that matters; with
                                   ///< 0.02 thin steps get worse

double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

}  // namespace

/// Distance from a surface, to first order, box-local; infinite where the gradient vanishes.
double Cell::distance_to(std::size_t surface, const double* x) const {
    if (is_solid(surface)) return kMortiseInfinity;
    bool negated = false;
    const std::uint32_t at = surface_at(surface, x, &negated);
    const SurfaceSample s =
        surface_sample(&model_.surfaces[at], model_.expression_ops.data(), x[0], x[1], x[2]);
    const double distance = std::fabs(s.value) / std::sqrt(dot(s.gradient, s.gradient));
    return std::isfinite(distance) ? distance : kMortiseInfinity;
}

/// Of the angle between two surfaces' normals, of either side.
double Cell::cosine(std::size_t a, std::size_t b, const double* x) const {
    SurfaceSample of[2];
    for (int k = 0; k < 2; ++k) {
        bool negated = false;
        const std::uint32_t at = surface_at(k == 0 ? a : b, x, &negated);
        of[k] = surface_sample(&model_.surfaces[at], model_.expression_ops.data(), x[0], x[1], x[2]);
    }
    const double* u = of[0].gradient;
    const double* v = of[1].gradient;
    return std::fabs(dot(u, v)) / std::sqrt(dot(u, u) * dot(v, v));
}

/// Surfaces of the cell as what they are in the model at a point.
std::vector<std::uint32_t> Cell::model_surfaces(const std::vector<std::size_t>& surfaces,
                                                const double* x) const {
    std::vector<std::uint32_t> result;
    bool negated = false;
    for (const std::size_t s : surfaces) result.push_back(surface_at(s, x, &negated));
    return result;
}

/// The point next to the middle on some surfaces; false if there is none, or not well inside.
bool Cell::apex_on(const ApexSearch& search, const std::vector<std::size_t>& surfaces,
                   LatticePoint& apex) const {
    double start[3];
    position(search.middle, start);
    const double size = search.scale.size;
    const tape::ProjectionLimits limits = {kReach * size, kTangent, kSettled * size, search.fixed_axis};
    double x[3] = {start[0], start[1], start[2]};
    const std::vector<std::uint32_t> on = model_surfaces(surfaces, x);
    if (!tape::project(model_, on.data(), on.size(), limits, x)) return false;
    if (const std::vector<std::uint32_t> there = model_surfaces(surfaces, x); there != on) {
        std::copy(start, start + 3, x);
        if (!tape::project(model_, there.data(), there.size(), limits, x)) return false;
    }
    const double unit = size_ / units_ * search.scale.step;
    apex = search.middle;
    for (std::size_t j = 0; j < 3; ++j) {
        if (!(std::fabs(x[j] - start[j]) <= kMargin * size)) return false;
        apex[j] += search.scale.step * static_cast<std::int32_t>(std::rint((x[j] - start[j]) / unit));
    }
    return !snaps() || !is_crowding(search, apex);
}

/// In a face that lies in a surface: leaves out this one, and of those whose sections are one there (two
/// solids that meet in it) all but one.
void Cell::leave_distinct(int fixed_axis, const double* middle, NearSurfaces& near) const {
    struct Section {
        double distance;
        double normal[3];
    };
    std::vector<Section> sections;
    const auto is_seen = [&](const std::pair<double, std::size_t>& entry) {
        bool negated = false;
        const std::uint32_t at = surface_at(entry.second, middle, &negated);
        const SurfaceSample s = surface_sample(&model_.surfaces[at], model_.expression_ops.data(), middle[0],
                                               middle[1], middle[2]);
        Section own{s.value, {s.gradient[0], s.gradient[1], s.gradient[2]}};
        own.normal[fixed_axis] = 0;
        const double steepness = std::sqrt(dot(own.normal, own.normal));
        const double slope = std::sqrt(dot(s.gradient, s.gradient));
        if (!(steepness > kTangent * slope)) return std::fabs(s.value) <= kSectionsAreOne * slope * size_;
        own.distance /= steepness;
        for (double& x : own.normal) x /= steepness;
        for (const Section& other : sections) {
            const double cosine = dot(own.normal, other.normal);
            const double apart = own.distance - (cosine < 0 ? -other.distance : other.distance);
            if (std::fabs(cosine) >= 1 - kSectionsAreOne && std::fabs(apart) <= kSectionsAreOne * size_)
                return true;
        }
        sections.push_back(own);
        return false;
    };
    near.erase(std::remove_if(near.begin(), near.end(), is_seen), near.end());
}

/// The middle, or the point next to it on up to `most` surfaces that pass close to it; of a joint where both
/// its surfaces meet, if it can be had, so that their facets part there.
LatticePoint Cell::apex_near(const ApexSearch& search, const std::vector<std::size_t>& surfaces,
                             std::size_t most) const {
    double start[3];
    position(search.middle, start);
    NearSurfaces near;
    for (const std::size_t s : surfaces) {
        const double distance = distance_to(s, start);
        if (distance < kNear * search.scale.size) near.push_back({distance, s});
    }
    std::sort(near.begin(), near.end());
    if (search.fixed_axis < 3) leave_distinct(search.fixed_axis, start, near);
    LatticePoint apex;
    for (std::size_t count = std::min(near.size(), most); count > 0; --count) {
        std::vector<std::size_t> on;
        bool joined = false;
        for (std::size_t k = 0; k < count; ++k) {
            on.push_back(near[k].second);
            joined = joined || is_joint(near[k].second);
        }
        if (joined && count < 3) {
            on.push_back(joined_[0]);
            if (apex_on(search, on, apex)) return apex;
            on.pop_back();
        }
        if (!apex_on(search, on, apex)) continue;
        const auto hidden = search.fixed_axis < 3 ? near.end() : beside_boundary(apex, count, near);
        if (hidden == near.end()) return apex;
        near.erase(hidden);
        count = std::min(near.size(), most) + 1;
    }
    return search.middle;
}

/// Of the first `count` surfaces, which meet in a point, the one most alike to another that passes just
/// beside it, if the solid does not end at the point: a hole is mostly a little deeper than its plate. None
/// otherwise.
Cell::NearSurfaces::const_iterator Cell::beside_boundary(const LatticePoint& point, std::size_t count,
                                                         const NearSurfaces& near) const {
    double x[3];
    position(point, x);
    const auto first = near.begin();
    const auto others = first + static_cast<std::ptrdiff_t>(count);
    const auto rival = std::find_if(others, near.end(), [&](const std::pair<double, std::size_t>& entry) {
        return distance_to(entry.second, x) < kRival * size_;
    });
    if (rival == near.end()) return near.end();
    std::vector<std::int8_t> signs(surfaces_.size());
    for (std::size_t s = 0; s < signs.size(); ++s)
        signs[s] = static_cast<std::int8_t>(pure_sign(s, point, size_));
    for (auto on = first; on != others; ++on) signs[on->second] = 0;
    if (local_tape_.resolve(signs.data()) == kUnknown) return near.end();
    return std::max_element(first, others, [&](const auto& a, const auto& b) {
        return cosine(a.second, rival->second, x) < cosine(b.second, rival->second, x);
    });
}

/// The pole of the leaf, if it stands for the middle of this face, or for the apex.
bool Cell::pole_at(int face, LatticePoint& at) const {
    if (pole_ == nullptr) return false;
    const bool is_apex = face == octree::LeafPole::kInside;
    if (is_apex ? !pole_->has_apex : pole_->face != face) return false;
    at = is_apex ? pole_->apex : pole_->at;
    for (std::int32_t& x : at) x *= units_ / kCellUnits;
    return true;
}

/// Puts a node that stands for the pole on all its surfaces: it may have moved here along them, and not all
/// pass through it exactly.
void Cell::settle_pole(LocalNode node, int face) {
    LatticePoint pole;
    if (!pole_at(face, pole) || nodes_[node].point != pole) return;
    for (const std::uint32_t surface : pole_->through) {
        const std::size_t place = surface_place(surface);
        if (place < surfaces_.size()) set_sign(node, place, 0);
    }
}

LatticePoint Cell::apex(std::size_t most) const {
    LatticePoint pole;
    if (pole_at(octree::LeafPole::kInside, pole)) return pole;
    std::vector<std::size_t> named;
    std::vector<LocalNode> all(nodes_.size());
    std::iota(all.begin(), all.end(), LocalNode{0});
    for (std::size_t s = 0; s < surfaces_.size(); ++s) {
        if (is_named(s) && !only_touches(s, all.data(), all.size())) named.push_back(s);
    }
    return apex_near({centre(), 3, {1, size_}}, named, most);
}

/// Of a face that becomes a fan: its middle, or a point on the face's surfaces, a pole before others. The
/// middle where it alone tells that a surface passes.
LatticePoint Cell::fan_centre(const std::vector<LocalNode>& loop, const Patch& patch) const {
    LatticePoint pole;
    if (!patch.quarter && pole_at(patch.face, pole)) return pole;
    const std::uint8_t* active = row(patch.row);
    std::vector<std::size_t> on_face;
    for (std::size_t s = 0; s < surfaces_.size(); ++s) {
        if (active[s] == 0 || only_touches(s, loop.data(), loop.size())) continue;
        on_face.push_back(s);
        const int middle = pure_sign(s, patch.middle, patch.scale.size);
        const bool alone = middle != 0 && std::all_of(loop.begin(), loop.end(), [&](LocalNode node) {
                               return sign(node, s) == -middle;
                           });
        if (alone) return patch.middle;
    }
    return apex_near({patch.middle, patch.face / 2, patch.scale}, on_face, kMostApexSurfaces);
}

}  // namespace mortise::cnio
