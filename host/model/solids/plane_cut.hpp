// What the plane z = 0 cuts out of single primitives.
#pragma once

#include <optional>
#include <vector>

#include "host/model/outlines/flat_tree.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// normal · (x, y) <= offset, of unit length.
struct HalfPlane {
    Vec2 normal{};
    double offset = 0;
};

/// A part of the plane z = 0.
struct Slice {
    enum class State : std::uint8_t {
        kNothing,
        kEverything,
        kPlanes,  ///< the intersection of `planes`
        kNode,    ///< a node of the flat tree
    };
    State state = State::kNothing;
    std::vector<HalfPlane> planes{};
    std::uint32_t node = 0;
};

/// The plane, and what the cutting of one solid has in common.
struct PlaneCut {
    FlatTree& flat;
    double size = 1;       ///< of the whole solid
    bool above = true;     ///< surfaces in the plane count as just below it, else as just above
    bool touched = false;  ///< some surface lies in the plane
    int sides = 96;        ///< of curves that are no ellipses
};

/// The slice of a primitive's image under `map`, right inside the box `clip` at least. Nothing if it is of no
/// kind that can be told: a formula, a torus cut askew, a curve without end.
std::optional<Slice> slice_of(const Primitive& primitive, const Affine& map, const Box3& clip, PlaneCut& cut);

/// { c + L u : |u| <= 1 } with L Lᵀ = {{xx, xy}, {xy, yy}}, as a node; a circle if it is one to six digits.
std::uint32_t add_ellipse(FlatTree& flat, const Vec2& centre, double xx, double xy, double yy, int sides);

/// The half-planes' common part of a rectangle that is some larger than the clip box; the rectangle itself
/// if there are none.
Contours cut_rectangle(const std::vector<HalfPlane>& planes, const Box3& clip);

/// Drops points that lie on the line between those kept, to that distance.
void drop_straight(std::vector<Vec2>& loop, double tolerance);

}  // namespace mortise::model_reader
