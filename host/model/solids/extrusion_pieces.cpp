#include "host/model/solids/extrusion_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/model/affine.hpp"
#include "host/model/agreement.hpp"
#include "host/model/outlines/convex_parts.hpp"
#include "host/model/outlines/polygons.hpp"
#include "host/model/text.hpp"

namespace mortise::model_reader {
namespace {

constexpr std::size_t kMostPieces = 256;

/// How a map scales circles; 0: it makes ellipses of them.
double circle_scale(const FlatMap& map) {
    const double x = std::hypot(map[0], map[3]), y = std::hypot(map[1], map[4]);
    const bool is_square = std::fabs(map[0] * map[1] + map[3] * map[4]) <= kSame * x * y;
    return is_square && same(x, y) ? x : 0;
}

bool keeps_lengths(const Affine& m) {
    const Vec3 x = {m[0], m[4], m[8]}, y = {m[1], m[5], m[9]}, z = {m[2], m[6], m[10]};
    return same(length(x), 1) && same(length(y), 1) && same(length(z), 1) && perpendicular(x, y) &&
           perpendicular(y, z) && perpendicular(z, x);
}

class Pieces {
  public:
    Pieces(const FlatTree& shapes, const LinearSweep& sweep, const Affine& map, const Wanted& wanted)
        : shapes_(shapes),
          sweep_(sweep),
          map_(map),
          wanted_(wanted),
          keeps_circles_(sweep.scale == Vec2{1, 1} && keeps_lengths(map)) {}

    /// The parts of a union each by itself: they may overlap.
    std::vector<ConvexPiece> all_of(std::uint32_t root) {
        std::vector<std::pair<std::uint32_t, FlatMap>> pending = {{root, kFlatIdentity}};
        while (!pending.empty()) {
            const auto [index, map] = pending.back();
            pending.pop_back();
            const FlatNode& node = shapes_.nodes[index];
            if (node.op == FlatNode::Op::kTransform) {
                pending.push_back({node.children[0], compose(map, node.map)});
            } else if (node.op == FlatNode::Op::kUnion) {
                for (std::size_t k = node.children.size(); k-- > 0;)
                    pending.push_back({node.children[k], map});
            } else if (!add_round(node, map)) {
                add_polygons(index, map);
            }
        }
        return std::move(pieces_);
    }

  private:
    Vec3 at(const Vec2& p, bool top) const {
        const Vec2 scale = top ? sweep_.scale : Vec2{1, 1};
        return image(map_, {scale[0] * p[0], scale[1] * p[1], sweep_.base + (top ? sweep_.height : 0)});
    }

    /// A circle, or the hull of some, that the sweep leaves as they are.
    bool add_round(const FlatNode& node, const FlatMap& map) {
        const double scale = circle_scale(map);
        if (!keeps_circles_ || scale == 0) return false;
        if (node.op == FlatNode::Op::kCircle) {
            ConvexPiece cylinder;
            cylinder.kind = ConvexPiece::Kind::kFrustum;
            cylinder.a = at({map[2], map[5]}, false);
            cylinder.b = at({map[2], map[5]}, true);
            cylinder.ra = cylinder.rb = scale * node.radius;
            pieces_.push_back(std::move(cylinder));
            return true;
        }
        if (node.discs.empty()) return false;
        RoundedSolid plate;
        plate.shape = RoundedSolid::Shape::kPlate;
        for (const Disc& disc : node.discs) {
            const Vec2 centre = image_of(map, disc.center);
            plate.balls.push_back({{centre[0], centre[1], 0}, scale * disc.radius});
        }
        plate.low = sweep_.base;
        plate.high = sweep_.base + sweep_.height;
        pieces_.push_back(rounded_piece(std::move(plate), map_));
        return true;
    }

    void add_polygons(std::uint32_t index, const FlatMap& map) {
        const std::optional<Contours> parts =
            convex_parts(normalised(mapped(to_contours(shapes_, index), map)), kMostPieces);
        if (!parts || pieces_.size() + parts->size() > kMostPieces) {
            fail(wanted_.source, wanted_.where,
                 "'" + wanted_.name + "': an extrusion among its children has more than " +
                     std::to_string(kMostPieces) + " convex parts; expected simpler shapes");
        }
        for (const auto& loop : *parts) {
            ConvexPiece prism;
            for (const bool top : {false, true}) {
                for (const Vec2& p : loop) prism.points.push_back(at(p, top));
            }
            pieces_.push_back(std::move(prism));
        }
    }

    const FlatTree& shapes_;
    const LinearSweep& sweep_;
    const Affine& map_;
    const Wanted& wanted_;
    const bool keeps_circles_;
    std::vector<ConvexPiece> pieces_;
};

/// Whether the shape is an intersection of convex leaves.
bool is_one_outline(const FlatTree& shapes, std::uint32_t root) {
    return fold<bool>(
        shapes, root,
        [](const FlatNode& node, const FlatMap&) {
            if (node.op == FlatNode::Op::kCircle || !node.discs.empty()) return true;
            return node.contours.empty() || convex_parts(node.contours, 1).has_value();
        },
        [](FlatNode::Op op, const std::vector<bool>& convex) {
            const bool all = std::find(convex.begin(), convex.end(), false) == convex.end();
            return all &&
                   (op == FlatNode::Op::kIntersection || (op == FlatNode::Op::kUnion && convex.size() <= 1));
        });
}

}  // namespace

std::optional<std::vector<ConvexPiece>> extrusion_pieces(const FlatTree& shapes, const KnownSweep& known,
                                                         const Affine& map, const Wanted& wanted) {
    if (is_one_outline(shapes, known.outline)) return std::nullopt;
    return Pieces(shapes, known.sweep, map, wanted).all_of(known.outline);
}

}  // namespace mortise::model_reader
