// The convex solids that a part of the tree is the union of: what hull() and minkowski() work on.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/model/solids/solid_bounds.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

struct ConvexPiece {
    enum class Kind : std::uint8_t {
        kPoints,   ///< the hull of `points`
        kSphere,   ///< centre a, radius ra
        kDisc,     ///< centre a, unit normal b, radius ra: part of a hull
        kFrustum,  ///< from a with radius ra to b with radius rb; one radius may be 0
        kRounded,  ///< `rounded` in `frame`, which keeps lengths; a plate's rounding may be 0: a prism
    };
    Kind kind = Kind::kPoints;
    std::vector<Vec3> points;
    Vec3 a{};
    Vec3 b{};
    double ra = 0;
    double rb = 0;
    std::shared_ptr<const RoundedSolid> rounded;
    Affine frame = kIdentity;
    bool facetted = false;  ///< the points stand for a curved surface
    bool curved = false;    ///< so they do in the model: not an approximation of ours
};

/// Whether it is a prism over discs: a plate that is not rounded.
inline bool is_prism(const ConvexPiece& piece) {
    return piece.kind == ConvexPiece::Kind::kRounded && piece.rounded->shape == RoundedSolid::Shape::kPlate &&
           piece.rounded->rounding == 0;
}

/// Number of straight pieces of a full circle where a curved solid has to be facetted.
inline constexpr int kFacets = 96;

struct SweptShapes;  // extrusion_pieces.hpp

/// The operation that needs the pieces, for errors.
struct Wanted {
    std::string name;  ///< e.g. "hull"
    const std::string& source;
    SourceLocation where;
    const KnownExtents* known = nullptr;  ///< hulls that are known already; for only_hull
    bool only_hull = false;               ///< pieces may be replaced by their hull: bodies need not be convex
    bool differences = false;             ///< of solids with flat faces are taken apart, too
    const SweptShapes* swept = nullptr;   ///< extrusions whose shapes are known
};

/// The pieces of a node in the frame of the model. Throws Error(kInput) where the tree has anything that
/// is not a union of convex, bounded solids: formulas, unbounded solids, differences but those of solids with
/// flat faces where `differences` is set, extrusions that are not convex and not known by `swept`.
std::vector<ConvexPiece> convex_pieces(const Model& model, std::uint32_t node, const Wanted& wanted);

ConvexPiece rounded_piece(RoundedSolid solid, const Affine& frame);

/// The same solid as points on its surface.
ConvexPiece facetted(const ConvexPiece& piece);

}  // namespace mortise::model_reader
