#include "host/model/solids/sweep.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/model/outlines/disc_hulls.hpp"
#include "host/model/outlines/polygon_formula.hpp"
#include "host/model/outlines/polygons.hpp"

namespace mortise::model_reader {
namespace {

constexpr std::size_t kMostNamedEdges = 24;
constexpr double kRound = 1e-12;  ///< relative

}  // namespace

Piece Sweep::sweep(const FlatTree& tree, std::uint32_t root) {
    return fold<Piece>(
        tree, root,
        [this](const FlatNode& node, const FlatMap& map) {
            if (node.op == FlatNode::Op::kCircle) return circle(map, node.radius, next_side());
            if (!node.discs.empty()) {
                const auto discs = mapped(node.discs, map);
                if (std::optional<Piece> piece = discs ? rounded_outline(*discs) : std::nullopt)
                    return *piece;
            }
            return contours(mapped(node.contours, map));
        },
        [this](FlatNode::Op op, std::vector<Piece> pieces) { return combine(op, std::move(pieces)); });
}

Piece Sweep::combine(FlatNode::Op op, std::vector<Piece> pieces) {
    using State = Piece::State;
    if (pieces.empty()) return {};
    Piece first;
    if (op == FlatNode::Op::kDifference) {
        first = std::move(pieces[0]);
        if (first.state == State::kNothing) return first;
        pieces.erase(pieces.begin());
    }
    const bool is_intersection = op == FlatNode::Op::kIntersection;
    const State neutral = is_intersection ? State::kEverything : State::kNothing;
    const State absorbing = is_intersection ? State::kNothing : State::kEverything;
    Piece flat{State::kPlanes};
    std::vector<Piece> kept;
    for (Piece& piece : pieces) {
        if (piece.state == absorbing) return op == FlatNode::Op::kDifference ? Piece{} : Piece{absorbing};
        if (piece.state == neutral) continue;
        if (is_intersection && piece.state == State::kPlanes) {
            std::move(piece.planes.begin(), piece.planes.end(), std::back_inserter(flat.planes));
        } else {
            kept.push_back(std::move(piece));
        }
    }
    if (!flat.planes.empty()) kept.push_back(std::move(flat));
    if (op == FlatNode::Op::kDifference) {
        if (kept.empty()) return first;
        kept.insert(kept.begin(), std::move(first));
    }
    if (kept.empty()) return {neutral};
    if (kept.size() == 1) return std::move(kept[0]);
    std::vector<std::uint32_t> children;
    for (Piece& piece : kept) children.push_back(to_node(std::move(piece)));
    const CsgNode::Op operation = is_intersection                   ? CsgNode::Op::kIntersection
                                  : op == FlatNode::Op::kDifference ? CsgNode::Op::kDifference
                                                                    : CsgNode::Op::kUnion;
    return {State::kNode, {}, model_.add_operation(operation, std::move(children))};
}

std::uint32_t Sweep::to_node(Piece piece) {
    switch (piece.state) {
        case Piece::State::kNode: return piece.node;
        case Piece::State::kNothing: return model_.add_operation(CsgNode::Op::kUnion, {});
        case Piece::State::kEverything: return model_.add_operation(CsgNode::Op::kIntersection, {});
        case Piece::State::kPlanes: break;
    }
    Primitive convex;
    convex.planes = std::move(piece.planes);
    return model_.add_primitive(std::move(convex), {}, where_);
}

Piece Sweep::planes(std::vector<Plane> list, const std::string& side) const {
    for (Plane& plane : list) plane.name = side;
    return {Piece::State::kPlanes, std::move(list)};
}

Piece Sweep::primitive(Primitive primitive, const std::string& side) {
    return {Piece::State::kNode, {}, model_.add_primitive(std::move(primitive), name_ + "_" + side, where_)};
}

std::optional<Piece> Sweep::node_of(std::optional<Primitive> primitive) {
    if (!primitive) return std::nullopt;
    return Piece{Piece::State::kNode, {}, model_.add_primitive(std::move(*primitive), name_, where_)};
}

Piece Sweep::expression(const std::string& formula, const std::string& side) {
    Primitive result;
    result.kind = Primitive::Kind::kExpression;
    result.expression = formula;
    return primitive(std::move(result), side);
}

Piece Sweep::moved(const Affine& map, Piece piece) {
    if (map == kIdentity) return piece;
    return {Piece::State::kNode, {}, model_.add_transform(map, to_node(std::move(piece)))};
}

Piece Sweep::complement(Piece piece) {
    return {
        Piece::State::kNode, {}, model_.add_operation(CsgNode::Op::kComplement, {to_node(std::move(piece))})};
}

/// Inside is left of the loop: a hole, clockwise, is given reversed.
Piece Sweep::loop(const std::vector<Vec2>& points, bool is_outer) {
    const PolygonFormula formula = polygon_formula(points);
    const bool named = points.size() <= kMostNamedEdges;
    std::vector<std::string> names;
    for (std::size_t i = 0; i < (named ? points.size() : 1); ++i) names.push_back(next_side());
    std::vector<Piece> values(formula.nodes.size());
    for (std::size_t i = 0; i < formula.nodes.size(); ++i) {
        const PolygonFormula::Node& node = formula.nodes[i];
        if (node.type == PolygonFormula::Node::Type::kEdge) {
            const Vec2& from = points[node.edge];
            const Vec2& to = points[(node.edge + 1) % points.size()];
            Vec2 normal = {to[1] - from[1], from[0] - to[0]};
            const double larger = std::max(std::fabs(normal[0]), std::fabs(normal[1]));
            normal = {normal[0] / larger, normal[1] / larger};
            values[i] =
                half_plane(normal, normal[0] * from[0] + normal[1] * from[1], names[named ? node.edge : 0]);
            continue;
        }
        const bool is_and = node.type == PolygonFormula::Node::Type::kAnd;
        if (!is_and && is_outer) ends_at_apex_ = false;
        std::vector<Piece> parts;
        for (const std::uint32_t child : node.children) parts.push_back(std::move(values[child]));
        values[i] = combine(is_and ? FlatNode::Op::kIntersection : FlatNode::Op::kUnion, std::move(parts));
    }
    return std::move(values.back());
}

Piece Sweep::contours(Contours loops) {
    adjust(loops);
    // Maps that squash the shape may make points equal.
    for (auto& points : loops) {
        points.erase(std::unique(points.begin(), points.end()), points.end());
        while (points.size() > 1 && points.front() == points.back()) points.pop_back();
    }
    loops.erase(
        std::remove_if(loops.begin(), loops.end(), [](const auto& points) { return points.size() < 3; }),
        loops.end());
    if (std::optional<Piece> piece = outline(loops)) return std::move(*piece);
    std::vector<Piece> outer;
    for (std::size_t i = 0; i < loops.size();) {
        std::vector<Piece> parts = {loop(loops[i], true)};
        for (++i; i < loops.size() && signed_area(loops[i]) < 0; ++i) {
            std::reverse(loops[i].begin(), loops[i].end());
            parts.push_back(loop(loops[i], false));
        }
        outer.push_back(combine(FlatNode::Op::kDifference, std::move(parts)));
    }
    return combine(FlatNode::Op::kUnion, std::move(outer));
}

Ellipse ellipse_of(const FlatMap& map, double radius) {
    Ellipse ellipse;
    ellipse.centre = {map[2], map[5]};
    // The inverse of radius² M Mᵀ.
    const double xx = map[0] * map[0] + map[1] * map[1];
    const double xy = map[0] * map[3] + map[1] * map[4];
    const double yy = map[3] * map[3] + map[4] * map[4];
    const double scale = 1 / (radius * determinant(map));
    ellipse.xx = yy * scale * scale;
    ellipse.xy = -xy * scale * scale;
    ellipse.yy = xx * scale * scale;
    ellipse.round = std::fabs(xx - yy) <= kRound * (xx + yy) && std::fabs(xy) <= kRound * (xx + yy);
    ellipse.radius = map[1] == 0 && map[3] == 0 ? radius * std::fabs(map[0]) : radius * std::sqrt(xx);
    if (ellipse.radius == 0) ellipse.radius = radius * std::sqrt(xx);
    return ellipse;
}

}  // namespace mortise::model_reader
