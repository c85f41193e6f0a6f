// The skin of a mesh in pieces: what bounds a part of a region that touches no other part of it, or a hollow.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/probe/skin.hpp"
#include "mortise/mesh.hpp"

namespace mortise::probe {

/// A facet seen from one of its two sides.
struct SkinSide {
    std::uint32_t facet;
    bool is_inside;
};

struct SkinPiece {
    std::uint16_t region = 0;
    double volume = 0;  ///< of the root box; negative for what lies around others
    Vec3 low{}, high{};
    std::vector<SkinSide> sides;
};

/// Pieces of at most so many facets that have a volume, by their first facets; but for the largest of a
/// region that has no larger piece: that is its body, which others have come off. `nodes` of the mesh. Time:
/// linear.
std::vector<SkinPiece> list_small_pieces(const Skin& skin, const FacetBlock& facets, std::size_t nodes,
                                         std::size_t most);

}  // namespace mortise::probe
