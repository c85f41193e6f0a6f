#include "host/tape/convex_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/common/constants.hpp"
#include "host/tape/linear_program.hpp"
#include "host/tape/polyhedron.hpp"
#include "host/tape/surface_bounds.hpp"

namespace mortise::tape {
namespace {

constexpr int kAround = 8;      ///< planes around a circle
constexpr double kRoom = 1e-3;  ///< of the box, for what linear programs round

bool is_empty(const Box3& box) {
    return !(box.min[0] <= box.max[0] && box.min[1] <= box.max[1] && box.min[2] <= box.max[2]);
}

/// What a set is known to lie in. Half-spaces are in units of `scale`.
struct KnownBounds {
    Box3 box = kEverything;
    std::vector<HalfSpace> half_spaces;
    std::vector<const Surface*> double_cones;  ///< convex only where something else ends them
};

class ConvexBounds {
  public:
    explicit ConvexBounds(const CompiledModel& compiled) : compiled_(compiled), scale_(compiled.scale) {}

    Box3 run() {
        std::vector<KnownBounds> stack;
        const auto pop = [&stack] {
            KnownBounds top = std::move(stack.back());
            stack.pop_back();
            return top;
        };
        for (const std::uint32_t word : compiled_.tape) {
            switch (tape_operation(word)) {
                case kTapeLiteral: stack.push_back(literal(word)); break;
                case kTapeSpatial: stack.push_back(polyhedron(word)); break;
                case kTapeSelectConst: break;  // outside of it all is empty
                case kTapeAnd: {
                    KnownBounds b = pop();
                    stack.back() = both(std::move(stack.back()), std::move(b));
                    break;
                }
                default: {  // or, select
                    const KnownBounds b = pop();
                    stack.back() = either(stack.back(), b);
                    break;
                }
            }
        }
        return box_of(stack.back());
    }

  private:
    /// direction · u <= offset in the surface's own frame.
    void add(KnownBounds& bounds, const Surface& surface, const Vec3& direction, double offset) const {
        HalfSpace plane;
        double shift = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) plane.normal[j] += direction[i] * surface.map[4 * i + j];
            shift += direction[i] * surface.map[4 * i + 3];
        }
        const double length = std::hypot(plane.normal[0], plane.normal[1], plane.normal[2]);
        if (!(length > 0) || !std::isfinite(length)) return;
        for (double& n : plane.normal) n /= length;
        plane.offset = (offset - shift) / length / scale_;
        bounds.half_spaces.push_back(plane);
    }

    /// |(u0, u1)| + slope · u2 <= radius
    void add_around(KnownBounds& bounds, const Surface& surface, double slope, double radius) const {
        for (int i = 0; i < kAround; ++i) {
            const double angle = 2 * kPi * i / kAround;
            add(bounds, surface, {std::cos(angle), std::sin(angle), slope}, radius);
        }
    }

    /// |u_axis| <= extent
    void add_slab(KnownBounds& bounds, const Surface& surface, std::size_t axis, double extent) const {
        for (const double sign : {-1.0, 1.0}) {
            Vec3 direction{};
            direction[axis] = sign;
            add(bounds, surface, direction, extent);
        }
    }

    KnownBounds literal(std::uint32_t word) const {
        const Surface& s = compiled_.surfaces[tape_surface(word)].surface;
        const bool negated = tape_negated(word) != 0;
        KnownBounds bounds;
        bounds.box = half_bounds(s, negated);
        if (s.kind == kSurfacePlane) {
            // Row 0 alone is the plane's.
            const double sign = negated ? -1 : 1;
            add(bounds, s, {sign, 0, 0}, 0);
        }
        if (negated) return bounds;
        if (s.kind == kSurfaceCone) add_around(bounds, s, 1, 0);
        if (s.kind == kSurfaceQuadric) {
            if (s.form[2] < 0) {
                bounds.double_cones.push_back(&s);
            } else {
                add_around(bounds, s, 0, 1);
                if (s.form[2] > 0) add_slab(bounds, s, 2, 1);
            }
        }
        if (s.kind == kSurfaceTorus) {
            const double radius = std::sqrt(-s.form[3]);
            add_around(bounds, s, 0, s.form[0] + radius);
            add_slab(bounds, s, 2, radius);
        }
        if (s.kind == kSurfaceRounded) {
            add_around(bounds, s, 0, s.form[3]);
            if (s.form[2] != kRoundedColumn) add_slab(bounds, s, 2, s.form[3]);
        }
        return bounds;
    }

    KnownBounds polyhedron(std::uint32_t word) const {
        KnownBounds bounds;
        if (tape_negated(word) == 0) bounds.box = bounds_of(compiled_.polyhedra[tape_surface(word)].shape);
        return bounds;
    }

    static KnownBounds both(KnownBounds a, KnownBounds b) {
        if (a.half_spaces.size() < b.half_spaces.size()) std::swap(a, b);
        shrink(a.box, b.box);
        a.half_spaces.insert(a.half_spaces.end(), b.half_spaces.begin(), b.half_spaces.end());
        a.double_cones.insert(a.double_cones.end(), b.double_cones.begin(), b.double_cones.end());
        return a;
    }

    KnownBounds either(const KnownBounds& a, const KnownBounds& b) const {
        KnownBounds bounds;
        bounds.box = box_of(a);
        grow(bounds.box, box_of(b));
        return bounds;
    }

    Box3 box_of(const KnownBounds& bounds) const {
        if (is_empty(bounds.box)) return kNothing;
        if (bounds.half_spaces.empty()) return bounds.box;
        KnownBounds all = bounds;
        for (std::size_t j = 0; j < 3; ++j) {
            Vec3 axis{};
            axis[j] = 1;
            if (std::isfinite(bounds.box.max[j]))
                all.half_spaces.push_back({axis, bounds.box.max[j] / scale_});
            axis[j] = -1;
            if (std::isfinite(bounds.box.min[j]))
                all.half_spaces.push_back({axis, -bounds.box.min[j] / scale_});
        }
        for (const Surface* cone : bounds.double_cones) end_cone(all, *cone);
        Box3 box = bounds.box;
        for (std::size_t j = 0; j < 3; ++j) {
            for (const double sign : {-1.0, 1.0}) {
                Vec3 axis{};
                axis[j] = sign;
                const std::optional<Vec3> end = farthest(all.half_spaces, axis);
                if (!end) return kNothing;
                if (std::fabs((*end)[j]) > 0.5 * kFarthest) continue;
                double& side = sign < 0 ? box.min[j] : box.max[j];
                side = sign < 0 ? std::max(side, (*end)[j] * scale_) : std::min(side, (*end)[j] * scale_);
            }
        }
        return box;
    }

    /// |(u0, u1)| <= |u2|: a cylinder, where |u2| is known to end.
    void end_cone(KnownBounds& bounds, const Surface& cone) const {
        const Vec3 row = {cone.map[8], cone.map[9], cone.map[10]};
        const double length = std::hypot(row[0], row[1], row[2]);
        if (!(length > 0)) return;
        double extent = 0;
        for (const double sign : {-1.0, 1.0}) {
            const Vec3 direction = {sign * row[0] / length, sign * row[1] / length, sign * row[2] / length};
            const std::optional<Vec3> end = farthest(bounds.half_spaces, direction);
            if (!end) return;
            double reached = 0;
            for (std::size_t j = 0; j < 3; ++j) reached += direction[j] * (*end)[j];
            if (reached > 0.5 * kFarthest) return;
            const double u2 = sign * length * reached * scale_ + cone.map[11];
            extent = std::max(extent, std::fabs(u2));
        }
        add_around(bounds, cone, 0, extent);
    }

    const CompiledModel& compiled_;
    double scale_;
};

}  // namespace

Box3 convex_bounds(const CompiledModel& compiled) {
    Box3 box = ConvexBounds(compiled).run();
    if (is_empty(box)) return box;
    for (std::size_t j = 0; j < 3; ++j) {
        const double room = kRoom * (box.max[j] - box.min[j]) + 1e-6 * compiled.scale;
        box.min[j] -= room;
        box.max[j] += room;
    }
    return box;
}

}  // namespace mortise::tape
