// The convex pieces that primitives, and intersections of them, are.
#pragma once

#include <string>
#include <vector>

#include "host/model/solids/convex_pieces.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// A primitive below an intersection, in the frame of the model.
struct Leaf {
    const Primitive* primitive;
    Affine map;
};

[[noreturn]] void refuse(const Wanted& wanted, const std::string& what);

/// Appends the pieces of an intersection of leaves, or nothing if it is empty. Refuses what is not convex.
void add_intersection(const std::vector<Leaf>& leaves, const Wanted& wanted,
                      std::vector<ConvexPiece>& pieces);

/// The same for one leaf, whose hull will do where `wanted` says so.
void add_primitive(const Leaf& leaf, const Wanted& wanted, std::vector<ConvexPiece>& pieces);

}  // namespace mortise::model_reader
