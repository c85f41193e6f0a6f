// Walks a tree and collects its convex pieces, with an explicit stack.
#include "host/model/solids/convex_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "host/common/constants.hpp"
#include "host/model/affine.hpp"
#include "host/model/agreement.hpp"
#include "host/model/solids/convex_differences.hpp"
#include "host/model/solids/convex_leaves.hpp"
#include "host/model/solids/extrusion_pieces.hpp"
#include "host/model/solids/rounded_facets.hpp"

namespace mortise::model_reader {
namespace {

/// A solid whose hull is known: points, and the discs of an extrusion's ends.
void add_extents(const std::vector<Extent>& extents, const Affine& map, std::vector<ConvexPiece>& pieces) {
    const auto direction = [&](const Vec3& v) {
        return Vec3{map[0] * v[0] + map[1] * v[1] + map[2] * v[2],
                    map[4] * v[0] + map[5] * v[1] + map[6] * v[2],
                    map[8] * v[0] + map[9] * v[1] + map[10] * v[2]};
    };
    ConvexPiece points;
    for (const Extent& extent : extents) {
        const Vec3 center = image(map, extent.centre);
        const Vec3 u = direction(extent.axes[0]);
        const Vec3 v = direction(extent.axes[1]);
        if (u == Vec3{} && v == Vec3{}) {
            points.points.push_back(center);
            points.curved = points.curved || extent.is_curved;
        } else if (same(length(u), length(v)) && perpendicular(u, v)) {
            ConvexPiece disc;
            disc.kind = ConvexPiece::Kind::kDisc;
            disc.a = center;
            disc.b = unit(cross(u, v));
            disc.ra = length(u);
            pieces.push_back(std::move(disc));
        } else {
            points.facetted = true;
            for (int i = 0; i < kFacets; ++i) {
                const double turn = kTurn * i / kFacets;
                Vec3 point = center;
                for (std::size_t k = 0; k < 3; ++k) point[k] += std::cos(turn) * u[k] + std::sin(turn) * v[k];
                points.points.push_back(point);
            }
        }
    }
    if (!points.points.empty()) pieces.push_back(std::move(points));
}

/// The primitives below an intersection.
std::vector<Leaf> leaves_below(const Model& model, std::uint32_t root, const Affine& map,
                               const Wanted& wanted) {
    std::vector<Leaf> leaves;
    std::vector<std::pair<std::uint32_t, Affine>> pending = {{root, map}};
    while (!pending.empty()) {
        const auto [index, to_model] = pending.back();
        pending.pop_back();
        const CsgNode& node = model.nodes[index];
        const bool single = node.op == CsgNode::Op::kUnion && node.children.size() == 1;
        if (node.op == CsgNode::Op::kPrimitive) {
            leaves.push_back({&node.primitive, to_model});
        } else if (node.op == CsgNode::Op::kTransform) {
            pending.push_back({node.children[0], compose(to_model, node.map)});
        } else if (node.op == CsgNode::Op::kIntersection || single) {
            for (const std::uint32_t child : node.children) pending.push_back({child, to_model});
        } else {
            refuse(wanted,
                   "an intersection with a union or a difference in it (as an extrusion becomes that is not "
                   "convex, and twisted or scaled apart along x and y) is not supported; expected "
                   "intersections of convex solids");
        }
    }
    return leaves;
}

[[noreturn]] void refuse_difference(const Wanted& wanted, const std::string& what) {
    refuse(wanted, "a difference " + what +
                       " is not supported; expected cubes, spheres, cylinders, polyhedra, their unions and "
                       "convex intersections");
}

/// Of an extrusion whose shape is not convex; none: it is something else.
std::optional<std::vector<ConvexPiece>> sweep_pieces(std::uint32_t index, const Affine& map,
                                                     const Wanted& wanted) {
    if (wanted.swept == nullptr) return std::nullopt;
    const auto known = wanted.swept->sweeps.find(index);
    if (known == wanted.swept->sweeps.end()) return std::nullopt;
    return extrusion_pieces(wanted.swept->shapes, known->second, map, wanted);
}

/// Refuses pieces with round faces: what is left of them is not convex.
void require_flat(const std::vector<ConvexPiece>& pieces, const Wanted& wanted) {
    for (const ConvexPiece& piece : pieces) {
        if (piece.kind != ConvexPiece::Kind::kPoints || piece.facetted)
            refuse_difference(wanted, "of round solids among its children");
    }
}

/// What a difference takes away, in the frame of the model; differences in it are refused, so there is no
/// recursion.
std::vector<ConvexPiece> taken_away(const Model& model, const CsgNode& node, const Affine& map,
                                    Wanted wanted) {
    wanted.differences = false;
    std::vector<ConvexPiece> cuts;
    for (std::size_t k = 1; k < node.children.size(); ++k) {
        std::vector<ConvexPiece> pieces = convex_pieces(model, node.children[k], wanted);
        require_flat(pieces, wanted);
        for (ConvexPiece& piece : pieces) {
            for (Vec3& point : piece.points) point = image(map, point);
            cuts.push_back(std::move(piece));
        }
    }
    return cuts;
}

}  // namespace

ConvexPiece rounded_piece(RoundedSolid solid, const Affine& frame) {
    ConvexPiece piece;
    piece.kind = ConvexPiece::Kind::kRounded;
    piece.rounded = std::make_shared<const RoundedSolid>(std::move(solid));
    piece.frame = frame;
    return piece;
}

std::vector<ConvexPiece> convex_pieces(const Model& model, std::uint32_t root, const Wanted& wanted) {
    struct Item {
        std::uint32_t node;
        Affine map;
        std::size_t cuts;  ///< taken away from all below: a list in `sets`
    };
    struct Set {
        std::vector<ConvexPiece> cuts;
        std::size_t next;
    };
    constexpr auto kNone = static_cast<std::size_t>(-1);
    // Below a difference hulls will not do.
    Wanted strict = wanted;
    strict.known = nullptr;
    strict.only_hull = false;
    std::vector<Set> sets;
    std::vector<ConvexPiece> pieces;
    std::vector<Item> pending = {{root, kIdentity, kNone}};
    while (!pending.empty()) {
        const auto [index, map, cuts] = pending.back();
        pending.pop_back();
        if (wanted.known != nullptr && wanted.only_hull && cuts == kNone) {
            const auto known = wanted.known->find(index);
            if (known != wanted.known->end()) {
                add_extents(known->second, map, pieces);
                continue;
            }
        }
        const auto add_made = [&, below = cuts](std::vector<ConvexPiece> made) {
            for (std::size_t set = below; set != kNone; set = sets[set].next) {
                require_flat(made, wanted);
                take_away(made, sets[set].cuts, wanted);
            }
            for (ConvexPiece& piece : made) pieces.push_back(std::move(piece));
        };
        if (auto swept = sweep_pieces(index, map, wanted)) {
            add_made(std::move(*swept));
            continue;
        }
        const CsgNode& node = model.nodes[index];
        switch (node.op) {
            case CsgNode::Op::kTransform:
                pending.push_back({node.children[0], compose(map, node.map), cuts});
                break;
            case CsgNode::Op::kUnion:
                for (std::size_t k = node.children.size(); k-- > 0;)
                    pending.push_back({node.children[k], map, cuts});
                break;
            case CsgNode::Op::kPrimitive:
            case CsgNode::Op::kIntersection: {
                std::vector<ConvexPiece> made;
                const Wanted& here = cuts == kNone ? wanted : strict;
                if (node.op == CsgNode::Op::kPrimitive) {
                    add_primitive({&node.primitive, map}, here, made);
                } else {
                    add_intersection(leaves_below(model, index, map, here), here, made);
                }
                add_made(std::move(made));
                break;
            }
            case CsgNode::Op::kDifference: {
                if (!wanted.differences) refuse_difference(wanted, "among its children");
                if (node.children.empty()) break;
                std::vector<ConvexPiece> set = taken_away(model, node, map, strict);
                const std::size_t below = set.empty() ? cuts : sets.size();
                if (!set.empty()) sets.push_back({std::move(set), cuts});
                pending.push_back({node.children[0], map, below});
                break;
            }
            case CsgNode::Op::kComplement: refuse_difference(wanted, "among its children");
        }
    }
    return pieces;
}

ConvexPiece facetted(const ConvexPiece& piece) {
    if (piece.kind == ConvexPiece::Kind::kPoints) return piece;
    ConvexPiece result;
    result.facetted = true;
    if (piece.kind == ConvexPiece::Kind::kRounded) {
        for (const Vec3& point : points_of(*piece.rounded))
            result.points.push_back(image(piece.frame, point));
        return result;
    }
    const auto add_circle = [&](const Affine& frame, double radius, double level) {
        for (int i = 0; i < (radius > 0 ? kFacets : 1); ++i) {
            const double turn = kTurn * i / kFacets;
            result.points.push_back(
                image(frame, Vec3{radius * std::cos(turn), radius * std::sin(turn), level}));
        }
    };
    if (piece.kind == ConvexPiece::Kind::kSphere) {
        const Affine frame = translation(piece.a);
        for (int ring = 0; ring <= kFacets / 2; ++ring) {
            const double polar = kTurn * ring / kFacets;
            const bool pole = ring == 0 || ring == kFacets / 2;
            add_circle(frame, pole ? 0 : piece.ra * std::sin(polar), piece.ra * std::cos(polar));
        }
        return result;
    }
    if (piece.kind == ConvexPiece::Kind::kDisc) {
        add_circle(frame_along(piece.b, piece.a), piece.ra, 0);
        return result;
    }
    const Vec3 axis = {piece.b[0] - piece.a[0], piece.b[1] - piece.a[1], piece.b[2] - piece.a[2]};
    const Affine frame = frame_along(axis, piece.a);
    add_circle(frame, piece.ra, 0);
    add_circle(frame, piece.rb, length(axis));
    return result;
}

}  // namespace mortise::model_reader
