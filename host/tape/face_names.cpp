#include "host/tape/face_names.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/constants.hpp"
#include "host/common/vec3.hpp"
#include "host/tape/polyhedron.hpp"

namespace mortise::tape {
namespace {

/// Of the root box: a point so close to a side of a solid counts as inside.
constexpr double kOnSide = 1e-9;

}  // namespace

FaceNames::FaceNames(const CompiledModel& compiled, const BoundModel& model)
    : compiled_(compiled), model_(model) {
    if (model.namesakes.empty() || compiled.polyhedra.empty()) return;
    constexpr Vec3 kHigh = {kInfinity, kInfinity, kInfinity}, kLow = {-kInfinity, -kInfinity, -kInfinity};
    box_.assign(compiled.surfaces.size(), {kHigh, kLow});
    for (const WorldPolyhedron& polyhedron : compiled.polyhedra) {
        const Box3 box = bounds_of(polyhedron.shape);
        for (const std::uint32_t surface : polyhedron.surface) {
            for (std::size_t j = 0; j < 3; ++j) {  // bodies of one file may share a plane
                box_[surface].min[j] = std::min(box_[surface].min[j], box.min[j]);
                box_[surface].max[j] = std::max(box_[surface].max[j], box.max[j]);
            }
        }
    }
}

std::uint32_t FaceNames::name(std::uint32_t surface, std::int32_t region, const Vec3& point) const {
    const auto [first, last] =
        std::equal_range(model_.namesakes.begin(), model_.namesakes.end(), Namesake{surface, 0, 0},
                         [](const Namesake& a, const Namesake& b) { return a.surface < b.surface; });
    if (first == last) return model_.surface_name[surface];
    const auto is_own = [region](const Namesake& n) { return n.region == region; };
    const auto own = std::find_if(first, last, is_own);
    const bool any_own = own != last;
    for (auto n = any_own ? own : first; n != last && (!any_own || is_own(*n)); ++n) {
        if (is_face_of(n->compiled, point)) return compiled_.surfaces[n->compiled].name;
    }
    return any_own ? compiled_.surfaces[own->compiled].name : model_.surface_name[surface];
}

bool FaceNames::is_face_of(std::uint32_t compiled, const Vec3& point) const {
    const std::uint32_t place = compiled_.sides_of[compiled];
    if (place == CompiledModel::kNoSides) {
        const double reach = kOnSide * model_.side;
        for (std::size_t j = 0; j < 3; ++j) {
            if (point[j] < box_[compiled].min[j] - reach || point[j] > box_[compiled].max[j] + reach)
                return false;
        }
        return true;
    }
    const Sides& sides = compiled_.sides[place];
    return std::all_of(sides.literals.begin(), sides.literals.end(), [&](std::uint32_t literal) {
        const std::uint32_t other = tape_surface(literal);
        if (model_.bound_surface[other] == model_.bound_surface[compiled]) return true;
        return is_inside(other, (tape_negated(literal) != 0) == sides.is_conjunction, point);
    });
}

bool FaceNames::is_inside(std::uint32_t compiled, bool is_flipped, const Vec3& point) const {
    const SurfaceSample s = surface_sample(&compiled_.surfaces[compiled].surface,
                                           compiled_.expression_ops.data(), point[0], point[1], point[2]);
    const double reach = kOnSide * model_.side * length({s.gradient[0], s.gradient[1], s.gradient[2]});
    return (is_flipped ? -s.value : s.value) <= reach;
}

}  // namespace mortise::tape
