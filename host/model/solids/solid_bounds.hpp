// Exact sizes of simple solids.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <vector>

#include "host/model/solids/extrusion.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// An ellipsoid, a disc or a point: centre + the axes' combinations by vectors of length 1 at most.
struct Extent {
    Vec3 centre{};
    std::array<Vec3, 3> axes{};
    bool is_curved = false;  ///< a point of an outline with curves (swept_outline.hpp)
};

/// Nodes of the model whose convex hull is that of these extents.
using KnownExtents = std::map<std::uint32_t, std::vector<Extent>>;

/// Of an extrusion without twist, if the shape is a union of leaves; else none.
std::optional<std::vector<Extent>> linear_extents(const FlatTree& tree, std::uint32_t root,
                                                  const LinearSweep& sweep);

/// The smallest box around a solid, if it is a union of nodes with known extents and of whole cubes, spheres,
/// cylinders, cones and tori, as the .csg reader makes them; else none.
std::optional<Box3> exact_bounds(const Model& model, std::uint32_t root, const KnownExtents& known);

}  // namespace mortise::model_reader
