#include "host/model/solids/solid_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/common/constants.hpp"
#include "host/model/affine.hpp"
#include "host/model/solids/convex_hull.hpp"
#include "host/model/solids/swept_outline.hpp"

namespace mortise::model_reader {
namespace {

using Kind = Primitive::Kind;

Extent disc(double z, double radius) { return {{0, 0, z}, {{{radius, 0, 0}, {0, radius, 0}, {0, 0, 0}}}}; }

/// The corners of a bounded polyhedron: where three planes meet and no other one cuts. Of many planes by
/// their dual hull, whose corners have rounding errors that those of cubes shall not have.
std::vector<Extent> corners(const std::vector<Plane>& planes) {
    constexpr std::size_t kFew = 16;
    std::vector<Extent> result;
    const std::size_t count = planes.size();
    if (count > kFew) {
        std::vector<Vec3> vertices;
        if (vertices_of(planes, vertices) != Boundedness::kBounded) return result;
        for (const Vec3& vertex : vertices) result.push_back({vertex, {}});
        return result;
    }
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = i + 1; j < count; ++j) {
            const Vec3 line = cross(planes[i].normal, planes[j].normal);
            if (!(length(line) > 0)) continue;
            for (std::size_t k = j + 1; k < count; ++k) {
                const double volume = dot(line, planes[k].normal);
                if (std::fabs(volume) <= 1e-9 * length(line) * length(planes[k].normal)) continue;
                const Vec3 jk = cross(planes[j].normal, planes[k].normal);
                const Vec3 ki = cross(planes[k].normal, planes[i].normal);
                Vec3 p{};
                for (std::size_t c = 0; c < 3; ++c) {
                    p[c] =
                        (planes[i].offset * jk[c] + planes[j].offset * ki[c] + planes[k].offset * line[c]) /
                        volume;
                }
                const bool inside = std::all_of(planes.begin(), planes.end(), [&](const Plane& plane) {
                    const double size = length(plane.normal) * length(p) + std::fabs(plane.offset);
                    return dot(plane.normal, p) - plane.offset <= 1e-9 * size;
                });
                if (inside) result.push_back({p, {}});
            }
        }
    }
    return result;
}

/// The cylinder or cone of csg_primitives.cpp: a side and its caps, one of which lacks at an apex.
std::optional<std::vector<Extent>> capped(const Model& model, const CsgNode& node) {
    if (node.op != CsgNode::Op::kIntersection || node.children.size() != 2) return {};
    const CsgNode* side = &model.nodes[node.children[0]];
    const CsgNode& caps = model.nodes[node.children[1]];
    double origin = 0;
    if (side->op == CsgNode::Op::kTransform) {
        if (side->map != translation({0, 0, side->map[11]})) return {};
        origin = side->map[11];
        side = &model.nodes[side->children[0]];
    }
    const Primitive& round = side->primitive;
    if (side->op != CsgNode::Op::kPrimitive || (round.kind != Kind::kCylinder && round.kind != Kind::kCone) ||
        caps.op != CsgNode::Op::kPrimitive || caps.primitive.kind != Kind::kConvex) {
        return {};
    }
    const double slope = round.kind == Kind::kCone ? round.slope : 0;
    std::vector<Extent> result;
    for (const Plane& plane : caps.primitive.planes) {
        if (plane.normal[0] != 0 || plane.normal[1] != 0) return {};
        const double z = plane.offset / plane.normal[2];
        result.push_back(disc(z, round.radius + slope * (z - origin)));
    }
    if (result.size() == 1 && slope != 0) result.push_back(disc(origin - round.radius / slope, 0));
    if (result.size() != 2) return {};
    return result;
}

std::optional<std::vector<Extent>> extents_of(const Model& model, const CsgNode& node) {
    if (node.op != CsgNode::Op::kPrimitive) return capped(model, node);
    const double r = node.primitive.radius;
    const std::array<Vec3, 3> ball = {{{r, 0, 0}, {0, r, 0}, {0, 0, r}}};
    switch (node.primitive.kind) {
        case Kind::kConvex: return corners(node.primitive.planes);
        case Kind::kSphere: return std::vector<Extent>{{{}, ball}};
        default: return {};
    }
}

}  // namespace

std::optional<std::vector<Extent>> linear_extents(const FlatTree& tree, std::uint32_t root,
                                                  const LinearSweep& sweep) {
    if (sweep.twist != 0 || !has_exact_bounds(tree, root)) return {};
    std::vector<Extent> result;
    bool curved = false;
    const auto add = [&](const Vec2& centre, const Vec2& first, const Vec2& second) {
        const auto at = [](const Vec2& p, const Vec2& scale, double z) {
            return Vec3{p[0] * scale[0], p[1] * scale[1], z};
        };
        const Vec2 unscaled = {1, 1};
        for (const bool top : {false, true}) {
            const Vec2& scale = top ? sweep.scale : unscaled;
            const double z = sweep.base + (top ? sweep.height : 0);
            result.push_back(
                {at(centre, scale, z), {{at(first, scale, 0), at(second, scale, 0), {}}}, curved});
        }
    };
    fold<char>(
        tree, root,
        [&](const FlatNode& node, const FlatMap& map) {
            const double r = node.radius;
            curved = outline_sharp_angle(node.contours, sweep.smooth) > 0;
            if (node.op == FlatNode::Op::kCircle) {
                add({map[2], map[5]}, {map[0] * r, map[3] * r}, {map[1] * r, map[4] * r});
            }
            for (const Disc& disc : node.discs) {
                const double radius = disc.radius;
                add(image_of(map, disc.center), {map[0] * radius, map[3] * radius},
                    {map[1] * radius, map[4] * radius});
            }
            if (!node.discs.empty()) return '\0';
            for (const auto& loop : node.contours) {
                for (const Vec2& point : loop) add(image_of(map, point), {0, 0}, {0, 0});
            }
            return '\0';
        },
        [](FlatNode::Op, const std::vector<char>&) { return '\0'; });
    return result;
}

std::optional<Box3> exact_bounds(const Model& model, std::uint32_t root, const KnownExtents& known) {
    Box3 box = {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
    std::vector<std::pair<std::uint32_t, Affine>> open = {{root, kIdentity}};
    while (!open.empty()) {
        const auto [index, map] = open.back();
        open.pop_back();
        const CsgNode& node = model.nodes[index];
        const auto found = known.find(index);
        if (found == known.end() && (node.op == CsgNode::Op::kUnion || node.op == CsgNode::Op::kTransform)) {
            const bool maps = node.op == CsgNode::Op::kTransform;
            for (const std::uint32_t child : node.children) {
                open.push_back({child, maps ? compose(map, node.map) : map});
            }
            continue;
        }
        const auto extents = found != known.end() ? found->second : extents_of(model, node);
        if (!extents) return {};
        for (const Extent& extent : *extents) {
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3 row = {map[4 * k], map[4 * k + 1], map[4 * k + 2]};
                const Vec3 along = {dot(row, extent.axes[0]), dot(row, extent.axes[1]),
                                    dot(row, extent.axes[2])};
                const double centre = dot(row, extent.centre) + map[4 * k + 3];
                box.min[k] = std::min(box.min[k], centre - length(along));
                box.max[k] = std::max(box.max[k], centre + length(along));
            }
        }
    }
    for (std::size_t k = 0; k < 3; ++k) {
        if (!(box.min[k] < box.max[k])) return {};
    }
    return box;
}

}  // namespace mortise::model_reader
