#include "host/tape/rounded.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "host/common/rounded_parts.hpp"
#include "host/tape/arena.hpp"

namespace mortise::tape {
namespace {

using Shape = RoundedSolid::Shape;

/// The least radius that the surface is rounded with.
double least_radius(const RoundedSolid& solid) {
    if (solid.shape == Shape::kPlate) return solid.rounding;
    double least = HUGE_VAL;
    for (const Ball& ball : solid.balls) least = std::min(least, ball.radius);
    return least;
}

}  // namespace

Surface write_rounded(const RoundedSolid& solid, std::vector<ExpressionOp>& arena) {
    static_assert(static_cast<int>(Shape::kHull) == kRoundedHull &&
                  static_cast<int>(Shape::kColumn) == kRoundedColumn &&
                  static_cast<int>(Shape::kPlate) == kRoundedPlate &&
                  static_cast<int>(Shape::kRevolution) == kRoundedRevolution &&
                  static_cast<int>(Shape::kRing) == kRoundedRing);
    const RoundedParts parts = rounded_parts(solid);
    const auto shape = static_cast<double>(solid.shape);
    std::vector<double> data = {shape,
                                static_cast<double>(parts.facets.size()),
                                static_cast<double>(parts.arcs.size()),
                                static_cast<double>(parts.caps.size()),
                                (solid.low + solid.high) / 2,
                                (solid.high - solid.low) / 2,
                                solid.rounding,
                                parts.reach};
    const auto add = [&data](const Vec3& v) { data.insert(data.end(), v.begin(), v.end()); };
    for (const auto& facet : parts.facets) {
        add(facet.normal);
        data.push_back(facet.support);
    }
    for (const auto& arc : parts.arcs) {
        const Ball& ball = parts.balls[arc.ball];
        add(ball.center);
        add(arc.axis);
        data.insert(data.end(), {arc.along, arc.across, ball.radius});
        add(arc.middle);
        data.push_back(arc.cosine);
    }
    for (const auto& cap : parts.caps) {
        const Ball& ball = parts.balls[cap.ball];
        add(ball.center);
        data.insert(data.end(), {ball.radius, static_cast<double>(cap.axes.size())});
        for (std::size_t k = 0; k < cap.axes.size(); ++k) {
            add(cap.axes[k]);
            data.push_back(cap.along[k]);
        }
    }
    Surface surface{};
    surface.kind = kSurfaceRounded;
    surface.map[0] = surface.map[5] = surface.map[10] = 1;
    surface.form[0] = least_radius(solid);
    surface.form[1] = static_cast<double>(arena.size());  // no other starts there
    surface.form[2] = shape;
    surface.form[3] = parts.reach;
    append_numbers(data, arena, surface);
    return surface;
}

}  // namespace mortise::tape
