// A vertical line meets a closed solid in segments, and each ends on a face. So the shadow is that of all
// faces, and what the planes of faces cut out of the solid is part of it: the shadow is the union of the
// sections by all planes that carry a face of a primitive, seen from above.
#include "host/model/solids/shadow_planes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/model/affine.hpp"
#include "host/model/outlines/polygons.hpp"
#include "host/model/solids/facetted_primitives.hpp"
#include "host/model/solids/plane_cut.hpp"
#include "host/model/text.hpp"

namespace mortise::model_reader {
namespace {

using Op = CsgNode::Op;
using Kind = Primitive::Kind;

constexpr int kMostSides = 96;
constexpr int kMostSphereSides = 48;
/// Planes times faces.
constexpr double kMostWork = 2e7;
/// Sections united at a time: what lies inside the union so far is gone soon.
constexpr std::size_t kBatch = 4096;

/// distance = normal · x - offset, of unit length and upwards.
struct Carrier {
    Vec3 normal{};
    double offset = 0;
};

class FacePlanes {
  public:
    FacePlanes(const Model& model, const NodeBoxes& boxes, const Fragments& fragments, const Wanted& wanted)
        : model_(model), boxes_(boxes), fragments_(fragments), wanted_(wanted) {}

    std::optional<std::uint32_t> run(std::uint32_t root, const Affine& map, FlatTree& flat) {
        const Box3 box = image_of(map, boxes_.at(root));
        if (is_empty(box)) return {};
        copy_facetted(root);
        if (!is_finite(box)) refuse("a solid without end is not supported");
        for (std::size_t k = 0; k < 3; ++k) {
            size_ = std::max(size_, box.max[k] - box.min[k]);
            centre_[k] = (box.min[k] + box.max[k]) / 2;
        }
        collect(map);
        const double work = static_cast<double>(carriers_.size()) * static_cast<double>(faces_);
        if (work > kMostWork) {
            refuse("the solid has " + std::to_string(faces_) + " faces in " +
                   std::to_string(carriers_.size()) +
                   " planes; expected a product below 20 million: choose fewer facets ($fn)");
        }
        Contours loops;
        std::size_t points = 0;
        for (const Carrier& carrier : carriers_) {
            const Vec3& n = carrier.normal;
            const Affine level = {1, 0, 0, 0, 0, 1, 0, 0, n[0], n[1], n[2], -carrier.offset};
            FlatTree sections;
            const auto shape =
                section(facetted_, facetted_root(), compose(level, map), facetted_boxes_, sections, wanted_);
            if (!shape) continue;
            for (auto& loop : to_contours(sections, *shape)) {
                points += loop.size();
                loops.push_back(std::move(loop));
            }
            if (points < limit_) continue;
            loops = wound(loops);
            points = 0;
            for (const auto& loop : loops) points += loop.size();
            limit_ = points + kBatch;
        }
        loops = closed(wound(loops));
        if (loops.empty()) return {};
        const std::uint32_t node = flat.add_contours(loops);
        if (flat.nodes[node].contours.empty()) return {};
        return node;
    }

  private:
    [[noreturn]] void refuse(const std::string& what) const {
        fail(wanted_.source, wanted_.where, "'" + wanted_.name + "': " + what);
    }

    std::uint32_t facetted_root() const { return static_cast<std::uint32_t>(facetted_.nodes.size() - 1); }

    /// The subtree with polyhedra for its round primitives. They lie inside these, in the same boxes.
    void copy_facetted(std::uint32_t root) {
        std::vector<std::uint32_t> below;
        for (const auto& entry : boxes_) below.push_back(entry.first);
        std::sort(below.begin(), below.end());
        std::vector<char> used(root + std::size_t{1});
        used[root] = 1;
        for (std::size_t i = below.size(); i-- > 0;) {
            if (below[i] > root || used[below[i]] == 0) continue;
            for (const std::uint32_t child : model_.nodes[below[i]].children) used[child] = 1;
        }
        std::unordered_map<std::uint32_t, std::uint32_t> renamed;
        for (const std::uint32_t old : below) {
            if (old > root || used[old] == 0) continue;
            CsgNode node = model_.nodes[old];
            for (std::uint32_t& child : node.children) child = renamed.at(child);
            if (node.op == Op::kPrimitive) node.primitive = facetted(old);
            facetted_.nodes.push_back(std::move(node));
            renamed[old] = facetted_root();
            facetted_boxes_[facetted_root()] = boxes_.at(old);
        }
    }

    Primitive facetted(std::uint32_t index) const {
        const Primitive& given = model_.nodes[index].primitive;
        const auto told = fragments_.find(index);
        const int sides = std::min(told != fragments_.end() ? told->second : kMostSides, kMostSides);
        Primitive result;
        switch (given.kind) {
            case Kind::kConvex:
            case Kind::kPolyhedron: return given;
            case Kind::kSphere: return facetted_sphere(given.radius, std::min(sides, kMostSphereSides));
            case Kind::kCylinder: add_frustum_sides(result.planes, sides, given.radius, 0); return result;
            case Kind::kCone:
                add_frustum_sides(result.planes, sides, given.radius, given.slope);
                return result;
            case Kind::kTorus:
                refuse("a revolution of a circle is not supported in what is neither a union nor upright");
            default: refuse("a solid given by a formula, or an extrusion with twist, is not supported");
        }
    }

    /// The planes of all faces that are not upright.
    void collect(const Affine& root_map) {
        std::vector<std::pair<std::uint32_t, Affine>> open = {{facetted_root(), root_map}};
        while (!open.empty()) {
            const auto [index, map] = open.back();
            open.pop_back();
            const CsgNode& node = facetted_.nodes[index];
            const Affine below = node.op == Op::kTransform ? compose(map, node.map) : map;
            for (const std::uint32_t child : node.children) open.push_back({child, below});
            if (node.op != Op::kPrimitive) continue;
            if (node.primitive.kind == Kind::kPolyhedron) {
                add_triangles(*node.primitive.triangles, map);
            } else {
                add_planes(node.primitive.planes, map);
            }
        }
        const auto key = [this](const Carrier& carrier) {
            constexpr double kSteps = 1e9;
            return std::array<double, 4>{
                std::round(carrier.normal[0] * kSteps), std::round(carrier.normal[1] * kSteps),
                std::round(carrier.normal[2] * kSteps),
                std::round((carrier.offset - dot(carrier.normal, centre_)) / size_ * kSteps)};
        };
        std::sort(carriers_.begin(), carriers_.end(),
                  [&key](const Carrier& a, const Carrier& b) { return key(a) < key(b); });
        carriers_.erase(std::unique(carriers_.begin(), carriers_.end(),
                                    [&key](const Carrier& a, const Carrier& b) { return key(a) == key(b); }),
                        carriers_.end());
    }

    void add_carrier(Vec3 normal, const Vec3& point) {
        ++faces_;
        const double size = length(normal);
        if (!(std::fabs(normal[2]) > kSameHeight * size)) return;
        for (double& component : normal) component /= normal[2] > 0 ? size : -size;
        carriers_.push_back({normal, dot(normal, point)});
    }

    void add_planes(const std::vector<Plane>& planes, const Affine& map) {
        const Affine inverse = inverse_of(map);
        for (const Plane& plane : planes) {
            Vec3 normal{};
            double value = -plane.offset;
            for (std::size_t k = 0; k < 3; ++k) {
                value += plane.normal[k] * inverse[4 * k + 3];
                for (std::size_t j = 0; j < 3; ++j) normal[j] += plane.normal[k] * inverse[4 * k + j];
            }
            const double square = dot(normal, normal);
            add_carrier(normal, {-value * normal[0] / square, -value * normal[1] / square,
                                 -value * normal[2] / square});
        }
    }

    void add_triangles(const TriangleSurface& surface, const Affine& map) {
        for (const auto& triangle : surface.triangles) {
            std::array<Vec3, 3> p{};
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3& q = surface.points[triangle[k]];
                for (std::size_t j = 0; j < 3; ++j)
                    p[k][j] = dot({map[4 * j], map[4 * j + 1], map[4 * j + 2]}, q) + map[4 * j + 3];
            }
            const Vec3 u = {p[1][0] - p[0][0], p[1][1] - p[0][1], p[1][2] - p[0][2]};
            const Vec3 v = {p[2][0] - p[0][0], p[2][1] - p[0][1], p[2][2] - p[0][2]};
            // The flattest of triangles have no direction; their neighbours cover them.
            const Vec3 normal = cross(u, v);
            if (length(normal) > kSameHeight * kSameHeight * size_ * size_) add_carrier(normal, p[0]);
        }
    }

    /// Without the cracks and dents that rounding leaves where sections meet.
    Contours closed(const Contours& loops) const {
        const double gap = kSameHeight * size_;
        Contours result =
            offset(offset(loops, gap, OffsetCorner::kRound, 16), -gap, OffsetCorner::kMiter, 16);
        std::vector<Vec2> given;
        for (const auto& loop : loops) given.insert(given.end(), loop.begin(), loop.end());
        std::sort(given.begin(), given.end());
        for (auto& loop : result) {
            drop_straight(loop, 2 * gap);
            for (Vec2& point : loop) point = nearest(given, point, 2 * gap);
            loop.erase(std::unique(loop.begin(), loop.end()), loop.end());
        }
        result.erase(std::remove_if(result.begin(), result.end(),
                                    [](const std::vector<Vec2>& loop) { return loop.size() < 3; }),
                     result.end());
        return result;
    }

    /// Of sorted points the nearest one within a distance, or the point itself.
    static Vec2 nearest(const std::vector<Vec2>& sorted, const Vec2& point, double distance) {
        Vec2 best = point;
        double least = distance;
        for (auto at = std::lower_bound(sorted.begin(), sorted.end(), Vec2{point[0] - distance, -HUGE_VAL});
             at != sorted.end() && (*at)[0] <= point[0] + distance; ++at) {
            const double away = std::hypot((*at)[0] - point[0], (*at)[1] - point[1]);
            if (away < least) {
                least = away;
                best = *at;
            }
        }
        return best;
    }

    const Model& model_;
    const NodeBoxes& boxes_;
    const Fragments& fragments_;
    const Wanted& wanted_;
    Model facetted_;
    NodeBoxes facetted_boxes_;
    std::vector<Carrier> carriers_;
    std::size_t faces_ = 0;
    std::size_t limit_ = kBatch;
    double size_ = 0;
    Vec3 centre_{};
};

}  // namespace

std::optional<std::uint32_t> shadow_by_planes(const Model& model, std::uint32_t node, const Affine& map,
                                              const NodeBoxes& boxes, const Fragments& fragments,
                                              FlatTree& flat, const Wanted& wanted) {
    return FacePlanes(model, boxes, fragments, wanted).run(node, map, flat);
}

std::optional<Box3> flat_faced_bounds(const Model& model, std::uint32_t node, const Wanted& wanted) {
    const NodeBoxes boxes = node_boxes(model, node);
    for (const auto& entry : boxes) {
        const CsgNode& part = model.nodes[entry.first];
        const Kind kind = part.primitive.kind;
        if (part.op == Op::kPrimitive && kind != Kind::kConvex && kind != Kind::kPolyhedron) return {};
    }
    constexpr Affine kZAlongX = {0, 0, 1, 0, 0, 1, 0, 0, -1, 0, 0, 0};
    std::array<Box2, 2> sides;
    for (std::size_t k = 0; k < 2; ++k) {
        FlatTree flat;
        const auto shape =
            shadow_by_planes(model, node, k == 0 ? kIdentity : kZAlongX, boxes, {}, flat, wanted);
        if (!shape) return {};
        sides[k] = flat_bounds(flat, *shape);
    }
    const auto& [xy, zy] = sides;
    return Box3{{xy.min[0], xy.min[1], zy.min[0]}, {xy.max[0], xy.max[1], zy.max[0]}};
}

}  // namespace mortise::model_reader
