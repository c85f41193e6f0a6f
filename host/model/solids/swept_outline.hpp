// Solids swept by outlines with many edges, as one surface of triangles: what a cell of the mesh sees of it
// is local, and its tangent-continuous sides are one smooth surface.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "host/model/outlines/contours.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// Sides of an outline that turn by no more degrees stand for one curve, in a loop of more edges than this,
/// or one that turns twice in a row by no more than the last: the flank of a tooth.
inline constexpr double kSmoothTurn = 25;
inline constexpr std::size_t kMostSharpEdges = 12;
inline constexpr double kHardlyTurn = 10;

/// The angle up to which sides join: kSmoothTurn if some loop has a curve (and `smooth` is wanted), else 0.
double outline_sharp_angle(const Contours& loops, bool smooth);

/// Whether an outline is better a prism than a formula of half-planes: it has curves, or more than a few
/// edges and a loop that is not convex.
bool wants_prism(const Contours& loops, bool smooth);

/// From z = low, where the outline is scaled by low_scale about the z axis, to z = high. The scales are not
/// negative, one at most is 0: an apex.
struct PrismSpan {
    double low = 0;
    double high = 1;
    double low_scale = 1;
    double high_scale = 1;
};

/// Precondition: loops as in FlatNode::contours. Groups: bottom, top, and what `next_side` returns for each
/// curve and each straight side of a loop, or for the whole loop if they are more than 24.
Primitive prism(const Contours& loops, const PrismSpan& span, double sharp_angle,
                const std::function<std::string()>& next_side);

/// Where copies of an outline stand, row after row; neighbours are joined by triangles.
struct OutlineRows {
    std::size_t count = 0;  ///< a multiple of four in a ring
    double twist = 0;       ///< radians by which the outline turns per unit of height
    bool is_ring = false;   ///< the last row is joined to the first; else both are capped
    /// Edges (with the inside on their left) and the way to the next row make an outward normal. `row` is
    /// less than `count`, which may be less than given.
    std::function<Vec3(const Vec2& point, std::size_t row, std::size_t count)> place;
};

/// As `prism`. Rows join if they turn by no more than kSmoothTurn; so do sides of an outline with curves.
/// Edges are divided where they are long beside `width`, that of the outline: thin triangles are slow, and a
/// twisted edge leaves the surface that it sweeps by a quarter of its length times the angle. So they are
/// where the normal of that surface turns along them, those of curves by points of an arc: the chord of a
/// circle, swept steeply, is a groove. Where that would be very many triangles there are fewer rows, a
/// quarter at least; no surface if these are too many.
std::optional<Primitive> swept_outline(const Contours& loops, OutlineRows rows, double width, bool smooth,
                                       const std::function<std::string()>& next_side);

}  // namespace mortise::model_reader
