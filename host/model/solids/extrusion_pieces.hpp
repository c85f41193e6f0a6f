// Extrusions as convex pieces, for minkowski() and differences below hull(): from the plane shape, since the
// tree of planes that an extrusion becomes does not tell its parts.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "host/model/solids/convex_pieces.hpp"
#include "host/model/solids/extrusion.hpp"

namespace mortise::model_reader {

/// An extrusion without twist, scaled alike along x and y: its shape, a node of the scene's plane shapes.
struct KnownSweep {
    std::uint32_t outline = 0;
    LinearSweep sweep;
};

using KnownSweeps = std::map<std::uint32_t, KnownSweep>;  ///< by nodes of the model

/// What is known of a scene's extrusions.
struct SweptShapes {
    const FlatTree& shapes;
    const KnownSweeps& sweeps;
};

/// Convex pieces of an extrusion under a map: cylinders and plates where the shape has circles, and hulls of
/// circles, that stay round; prisms for all else. None if the shape is one convex outline, which the node
/// itself shows exactly. Throws Error(kInput) for more than a few hundred.
std::optional<std::vector<ConvexPiece>> extrusion_pieces(const FlatTree& shapes, const KnownSweep& known,
                                                         const Affine& map, const Wanted& wanted);

}  // namespace mortise::model_reader
