// The shadow of a solid along z. That of a union is the union of shadows; nothing of the kind holds for
// differences and intersections, but for two cases: all is upright (plates with holes and pockets), where the
// sections between the heights of horizontal faces tell; and what is taken away, or kept, is upright and at
// least as high as the rest, where its section tells. All others go through shadow_planes.cpp.
#include <algorithm>
#include <cmath>
#include <utility>

#include "host/model/affine.hpp"
#include "host/model/outlines/polygons.hpp"
#include "host/model/solids/plane_cut.hpp"
#include "host/model/solids/section.hpp"
#include "host/model/solids/shadow_planes.hpp"
#include "host/model/text.hpp"

namespace mortise::model_reader {
namespace {

using Op = CsgNode::Op;
using Kind = Primitive::Kind;

constexpr int kSides = 96;
/// Sections that a shadow may be made of, times nodes.
constexpr double kMostSections = 1e6;

Vec3 direction(const Affine& m, const Vec3& v) {
    return {dot({m[0], m[1], m[2]}, v), dot({m[4], m[5], m[6]}, v), dot({m[8], m[9], m[10]}, v)};
}

class Shadow {
  public:
    Shadow(const Model& model, std::uint32_t root, const Fragments& fragments, FlatTree& flat,
           const Wanted& wanted)
        : model_(model),
          boxes_(node_boxes(model, root)),
          fragments_(fragments),
          flat_(flat),
          wanted_(wanted) {
        const Box3& box = boxes_.at(root);
        for (std::size_t k = 0; k < 3; ++k) {
            if (std::isfinite(box.max[k] - box.min[k])) size_ = std::max(size_, box.max[k] - box.min[k]);
        }
    }

    std::optional<std::uint32_t> run(std::uint32_t root) {
        std::vector<std::uint32_t> parts;
        std::vector<Item> open = {{root, kIdentity, kNone}};
        while (!open.empty()) {
            const Item item = open.back();
            open.pop_back();
            const CsgNode& node = model_.nodes[item.node];
            if (node.op == Op::kTransform) {
                open.push_back({node.children[0], compose(item.map, node.map), item.trim});
            } else if (node.op == Op::kUnion) {
                for (const std::uint32_t child : node.children) open.push_back({child, item.map, item.trim});
            } else if (auto levels = upright_levels(item.node, item.map)) {
                add_sections(item, std::move(*levels), parts);
            } else if (node.op == Op::kPrimitive) {
                add_primitive(item, parts);
            } else if (!trim(item, open)) {
                add_pieces(item, parts);
            }
        }
        if (parts.empty()) return {};
        return parts.size() == 1 ? parts[0] : flat_.add_operation(FlatNode::Op::kUnion, std::move(parts));
    }

  private:
    static constexpr std::size_t kNone = static_cast<std::size_t>(-1);

    /// Taken from the shadow, or all that is kept of it; a list by `next`.
    struct Trim {
        FlatNode::Op operation;
        std::uint32_t shape;
        std::size_t next;
    };
    struct Item {
        std::uint32_t node;
        Affine map;
        std::size_t trim;
    };

    [[noreturn]] void refuse(const std::string& what) const {
        fail(wanted_.source, wanted_.where, "'" + wanted_.name + "': " + what);
    }

    void add(std::optional<std::uint32_t> shape, std::size_t trim, std::vector<std::uint32_t>& parts) {
        if (!shape) return;
        for (; trim != kNone; trim = trims_[trim].next) {
            shape = flat_.add_operation(trims_[trim].operation, {*shape, trims_[trim].shape});
        }
        parts.push_back(*shape);
    }

    void add_hull(const std::vector<Vec3>& points, std::size_t trim, std::vector<std::uint32_t>& parts) {
        std::vector<Vec2> flat;
        flat.reserve(points.size());
        for (const Vec3& p : points) flat.push_back({p[0], p[1]});
        const Contours hull = convex_hull(Contours{flat});
        if (!hull.empty()) add(flat_.add_contours(hull), trim, parts);
    }

    /// Appends the heights at which horizontal faces of a primitive lie; false if it has faces that are
    /// neither horizontal nor upright.
    bool primitive_levels(const Primitive& primitive, const Affine& map, std::vector<double>& levels) const {
        const bool column =
            primitive.kind == Kind::kRounded && primitive.rounded->shape == RoundedSolid::Shape::kColumn;
        if (primitive.kind == Kind::kCylinder || column) {
            const Vec3 axis = direction(map, {0, 0, 1});
            return std::hypot(axis[0], axis[1]) <= kSameHeight * length(axis);
        }
        if (primitive.kind == Kind::kConvex) {
            const Affine inverse = inverse_of(map);
            for (const Plane& plane : primitive.planes) {
                Vec3 normal{};
                double value = -plane.offset;
                for (std::size_t k = 0; k < 3; ++k) {
                    value += plane.normal[k] * inverse[4 * k + 3];
                    for (std::size_t j = 0; j < 3; ++j) normal[j] += plane.normal[k] * inverse[4 * k + j];
                }
                const double size = length(normal);
                if (std::fabs(normal[2]) <= kSameHeight * size) continue;
                if (std::hypot(normal[0], normal[1]) > kSameHeight * size) return false;
                levels.push_back(-value / normal[2]);
            }
            return true;
        }
        if (primitive.kind != Kind::kPolyhedron) return false;
        const TriangleSurface& surface = *primitive.triangles;
        for (const auto& triangle : surface.triangles) {
            std::array<Vec3, 3> p{};
            for (std::size_t k = 0; k < 3; ++k) p[k] = image(map, surface.points[triangle[k]]);
            const Vec3 u = {p[1][0] - p[0][0], p[1][1] - p[0][1], p[1][2] - p[0][2]};
            const Vec3 v = {p[2][0] - p[0][0], p[2][1] - p[0][1], p[2][2] - p[0][2]};
            const Vec3 normal = cross(u, v);
            // How far the triangle is from being upright, or horizontal.
            const double height =
                std::max({p[0][2], p[1][2], p[2][2]}) - std::min({p[0][2], p[1][2], p[2][2]});
            const double longest = std::max(length(u), length(v));
            const bool upright = std::fabs(normal[2]) <= kSameHeight * longest * size_;
            if (!upright && height > kSameHeight * size_) return false;
            for (const Vec3& point : p) levels.push_back(point[2]);
        }
        return true;
    }

    /// The heights of the horizontal faces of a solid all of whose other faces are upright, without those
    /// that agree; nothing if it is no such solid.
    std::optional<std::vector<double>> upright_levels(std::uint32_t root, const Affine& map) const {
        std::vector<double> levels;
        std::vector<std::pair<std::uint32_t, Affine>> open = {{root, map}};
        while (!open.empty()) {
            const auto [index, to_model] = open.back();
            open.pop_back();
            const CsgNode& node = model_.nodes[index];
            const Affine below = node.op == Op::kTransform ? compose(to_model, node.map) : to_model;
            for (const std::uint32_t child : node.children) open.push_back({child, below});
            if (node.op == Op::kPrimitive && !primitive_levels(node.primitive, to_model, levels)) return {};
        }
        std::sort(levels.begin(), levels.end());
        const auto agree = [this](double a, double b) { return b - a <= 2 * kSameHeight * size_; };
        levels.erase(std::unique(levels.begin(), levels.end(), agree), levels.end());
        return levels;
    }

    std::optional<std::uint32_t> section_at(std::uint32_t node, const Affine& map, double height) {
        return section(model_, node, compose(translation({0, 0, -height}), map), boxes_, flat_, wanted_);
    }

    void add_sections(const Item& item, std::vector<double> levels, std::vector<std::uint32_t>& parts) {
        const Box3 box = image_of(item.map, boxes_.at(item.node));
        if (is_empty(box)) return;
        if (!is_finite(box)) refuse("a solid without end is not supported");
        if (static_cast<double>(levels.size()) * static_cast<double>(boxes_.size()) > kMostSections) {
            refuse("the solid has faces at " + std::to_string(levels.size()) +
                   " heights; expected a product with its nodes below a million");
        }
        for (std::size_t i = 0; i + 1 < levels.size(); ++i) {
            const double middle = (levels[i] + levels[i + 1]) / 2;
            if (middle < box.min[2] || middle > box.max[2]) continue;
            add(section_at(item.node, item.map, middle), item.trim, parts);
        }
    }

    void add_primitive(const Item& item, std::vector<std::uint32_t>& parts) {
        const Primitive& primitive = model_.nodes[item.node].primitive;
        const Affine& map = item.map;
        if (primitive.kind == Kind::kSphere) {
            const double square = primitive.radius * primitive.radius;
            const Vec3 x = {map[0], map[1], map[2]};
            const Vec3 y = {map[4], map[5], map[6]};
            add(add_ellipse(flat_, {map[3], map[7]}, square * dot(x, x), square * dot(x, y),
                            square * dot(y, y), kSides),
                item.trim, parts);
            return;
        }
        if (primitive.kind != Kind::kPolyhedron) {
            add_pieces(item, parts);
            return;
        }
        // The side towards +z covers the shadow.
        const TriangleSurface& surface = *primitive.triangles;
        Contours triangles;
        const double least = kSameHeight * kSameHeight * size_ * size_;
        for (const auto& triangle : surface.triangles) {
            std::vector<Vec2> loop;
            for (const std::uint32_t corner : triangle) {
                const Vec3 p = image(map, surface.points[corner]);
                loop.push_back({p[0], p[1]});
            }
            const double area = signed_area(loop);
            const bool towards = (area > 0) == (relative_determinant(map) > 0);
            if (!towards || std::fabs(area) <= least) continue;
            if (area < 0) std::reverse(loop.begin(), loop.end());
            triangles.push_back(std::move(loop));
        }
        const std::uint32_t node = flat_.add_contours(wound(triangles));
        if (!flat_.nodes[node].contours.empty()) add(node, item.trim, parts);
    }

    /// Pushes the one child that is not upright, or not high enough, with what the others leave of its
    /// shadow.
    bool trim(const Item& item, std::vector<Item>& open) {
        const CsgNode& node = model_.nodes[item.node];
        if (node.op != Op::kDifference && node.op != Op::kIntersection) return false;
        if (node.children.empty()) return true;
        const bool difference = node.op == Op::kDifference;
        // Whose shadow it is: the first child, or the lowest.
        std::size_t body = 0;
        const auto height = [&](std::size_t i) {
            const Box3 box = image_of(item.map, boxes_.at(node.children[i]));
            return is_empty(box) ? 0 : box.max[2] - box.min[2];
        };
        std::vector<std::optional<std::vector<double>>> levels;
        for (const std::uint32_t child : node.children) levels.push_back(upright_levels(child, item.map));
        for (std::size_t i = 1; i < node.children.size() && !difference; ++i) {
            if (levels[body].has_value() != levels[i].has_value() ? levels[body].has_value()
                                                                  : height(i) < height(body)) {
                body = i;
            }
        }
        const Box3 box = image_of(item.map, boxes_.at(node.children[body]));
        if (is_empty(box)) return true;
        if (!std::isfinite(box.min[2]) || !std::isfinite(box.max[2])) return false;
        const double margin = 4 * kSameHeight * size_;
        const double middle = (box.min[2] + box.max[2]) / 2;
        std::vector<std::uint32_t> shapes;
        for (std::size_t i = 0; i < node.children.size(); ++i) {
            if (i == body) continue;
            if (!levels[i]) return false;
            for (const double level : *levels[i]) {
                if (level > box.min[2] + margin && level < box.max[2] - margin) return false;
            }
            // Only where the body is does it matter, so solids without end are cut there.
            const std::optional<std::uint32_t> shape = section_at(node.children[i], item.map, middle);
            if (shape) {
                shapes.push_back(*shape);
            } else if (!difference) {
                return true;
            }
        }
        std::size_t list = item.trim;
        for (const std::uint32_t shape : shapes) {
            trims_.push_back(
                {difference ? FlatNode::Op::kDifference : FlatNode::Op::kIntersection, shape, list});
            list = trims_.size() - 1;
        }
        open.push_back({node.children[body], item.map, list});
        return true;
    }

    void add_pieces(const Item& item, std::vector<std::uint32_t>& parts) {
        std::vector<ConvexPiece> pieces;
        try {
            pieces = convex_pieces(model_, item.node, wanted_);
        } catch (const Error&) {  // the tree has something else
            add(shadow_by_planes(model_, item.node, item.map, boxes_, fragments_, flat_, wanted_), item.trim,
                parts);
            return;
        }
        for (const ConvexPiece& piece : pieces) {
            if (piece.kind == ConvexPiece::Kind::kFrustum) {
                const Vec3 a = image(item.map, piece.a);
                const Vec3 b = image(item.map, piece.b);
                const double wider = std::max(piece.ra, piece.rb);
                const Affine frame = compose(
                    item.map,
                    frame_along({piece.b[0] - piece.a[0], piece.b[1] - piece.a[1], piece.b[2] - piece.a[2]},
                                piece.ra >= piece.rb ? piece.a : piece.b));
                const Vec3 u = direction(frame, {wider, 0, 0});
                const Vec3 v = direction(frame, {0, wider, 0});
                const double aside = std::hypot(a[0] - b[0], a[1] - b[1]);
                if (aside <= kSameHeight * std::max(length(u), length(v))) {
                    const Vec3& centre = piece.ra >= piece.rb ? a : b;
                    add(add_ellipse(flat_, {centre[0], centre[1]}, u[0] * u[0] + v[0] * v[0],
                                    u[0] * u[1] + v[0] * v[1], u[1] * u[1] + v[1] * v[1], kSides),
                        item.trim, parts);
                    continue;
                }
            }
            std::vector<Vec3> points = facetted(piece).points;
            for (Vec3& point : points) point = image(item.map, point);
            add_hull(points, item.trim, parts);
        }
    }

    const Model& model_;
    NodeBoxes boxes_;
    const Fragments& fragments_;
    FlatTree& flat_;
    const Wanted& wanted_;
    double size_ = 0;
    std::vector<Trim> trims_;
};

}  // namespace

std::optional<std::uint32_t> shadow(const Model& model, std::uint32_t node, const Fragments& fragments,
                                    FlatTree& flat, const Wanted& wanted) {
    return Shadow(model, node, fragments, flat, wanted).run(node);
}

}  // namespace mortise::model_reader
