#include "host/model/solids/node_boxes.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/common/constants.hpp"
#include "host/model/affine.hpp"
#include "host/model/solids/convex_hull.hpp"
#include "host/model/solids/rounded_facets.hpp"

namespace mortise::model_reader {
namespace {

using Kind = Primitive::Kind;

constexpr Box3 kAll = {{-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, kInfinity}};
constexpr Box3 kNothing = {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};

Box3 box_around(const std::vector<Vec3>& points) {
    Box3 box = kNothing;
    for (const Vec3& p : points) {
        for (std::size_t k = 0; k < 3; ++k) {
            box.min[k] = std::min(box.min[k], p[k]);
            box.max[k] = std::max(box.max[k], p[k]);
        }
    }
    return box;
}

Box3 united(const Box3& a, const Box3& b) {
    Box3 box = a;
    for (std::size_t k = 0; k < 3; ++k) {
        box.min[k] = std::min(a.min[k], b.min[k]);
        box.max[k] = std::max(a.max[k], b.max[k]);
    }
    return box;
}

Box3 convex_box(const std::vector<Plane>& planes) {
    Box3 box = kAll;
    bool slanted = false;
    for (const Plane& plane : planes) {
        std::size_t axis = 3;
        bool along = true;
        for (std::size_t k = 0; k < 3; ++k) {
            if (plane.normal[k] == 0) continue;
            along = along && axis == 3;
            axis = k;
        }
        slanted = slanted || !along;
        if (!along || axis == 3) continue;
        const double place = plane.offset / plane.normal[axis];
        double& side = plane.normal[axis] > 0 ? box.max[axis] : box.min[axis];
        side = plane.normal[axis] > 0 ? std::min(side, place) : std::max(side, place);
    }
    // As few as two caps, or a wedge, are not worth a hull.
    std::vector<Vec3> vertices;
    if (slanted && planes.size() >= 4 && vertices_of(planes, vertices) == Boundedness::kBounded) {
        return common_box(box, box_around(vertices));
    }
    return box;
}

Box3 primitive_box(const Primitive& primitive) {
    const double r = primitive.radius;
    switch (primitive.kind) {
        case Kind::kConvex: return convex_box(primitive.planes);
        case Kind::kSphere: return {{-r, -r, -r}, {r, r, r}};
        case Kind::kCylinder: return {{-r, -r, -kInfinity}, {r, r, kInfinity}};
        case Kind::kTorus: {
            const double reach = primitive.major + r;
            return {{-reach, -reach, -r}, {reach, reach, r}};
        }
        case Kind::kPolyhedron: return box_around(primitive.triangles->points);
        case Kind::kRounded: return box_of(*primitive.rounded);
        default: return kAll;
    }
}

/// The part of a box that a cone leaves, if the child is one, moved or not.
Box3 cone_part(const Model& model, std::uint32_t child, const Box3& box) {
    Affine map = kIdentity;
    while (model.nodes[child].op == CsgNode::Op::kTransform) {
        map = compose(map, model.nodes[child].map);
        child = model.nodes[child].children[0];
    }
    const CsgNode& node = model.nodes[child];
    if (node.op != CsgNode::Op::kPrimitive || node.primitive.kind != Kind::kCone) return box;
    Box3 local = image_of(inverse_of(map), box);
    const auto radius = [&](double z) { return node.primitive.radius + node.primitive.slope * z; };
    const double widest = std::max(radius(local.min[2]), radius(local.max[2]));
    if (!std::isfinite(widest)) return box;
    const double apex = -node.primitive.radius / node.primitive.slope;
    if (node.primitive.slope > 0) local.min[2] = std::max(local.min[2], apex);
    if (node.primitive.slope < 0) local.max[2] = std::min(local.max[2], apex);
    for (std::size_t k = 0; k < 2; ++k) {
        local.min[k] = std::max(local.min[k], -widest);
        local.max[k] = std::min(local.max[k], widest);
    }
    return common_box(box, image_of(map, local));
}

}  // namespace

NodeBoxes node_boxes(const Model& model, std::uint32_t root) {
    // Children have smaller numbers than their parents.
    std::vector<std::uint32_t> nodes;
    std::vector<std::uint32_t> open = {root};
    NodeBoxes boxes;
    while (!open.empty()) {
        const std::uint32_t node = open.back();
        open.pop_back();
        if (!boxes.emplace(node, kAll).second) continue;
        nodes.push_back(node);
        open.insert(open.end(), model.nodes[node].children.begin(), model.nodes[node].children.end());
    }
    std::sort(nodes.begin(), nodes.end());
    for (const std::uint32_t index : nodes) {
        const CsgNode& node = model.nodes[index];
        Box3 box = kAll;
        switch (node.op) {
            case CsgNode::Op::kPrimitive: box = primitive_box(node.primitive); break;
            case CsgNode::Op::kUnion:
                box = kNothing;
                for (const std::uint32_t child : node.children) box = united(box, boxes[child]);
                break;
            case CsgNode::Op::kIntersection:
                for (const std::uint32_t child : node.children) box = common_box(box, boxes[child]);
                for (const std::uint32_t child : node.children) box = cone_part(model, child, box);
                break;
            case CsgNode::Op::kDifference:
                box = node.children.empty() ? kNothing : boxes[node.children[0]];
                break;
            case CsgNode::Op::kTransform: box = image_of(node.map, boxes[node.children[0]]); break;
            case CsgNode::Op::kComplement: break;
        }
        if (node.bounds) box = common_box(box, *node.bounds);
        boxes[index] = box;
    }
    return boxes;
}

Box3 image_of(const Affine& map, const Box3& box) {
    if (is_empty(box)) return kNothing;
    Box3 image{};
    for (std::size_t row = 0; row < 3; ++row) {
        double low = map[4 * row + 3];
        double high = low;
        for (std::size_t k = 0; k < 3; ++k) {
            const double factor = map[4 * row + k];
            if (factor == 0) continue;
            low += factor * (factor > 0 ? box.min[k] : box.max[k]);
            high += factor * (factor > 0 ? box.max[k] : box.min[k]);
        }
        image.min[row] = low;
        image.max[row] = high;
    }
    return image;
}

Box3 common_box(const Box3& a, const Box3& b) {
    Box3 box = a;
    for (std::size_t k = 0; k < 3; ++k) {
        box.min[k] = std::max(a.min[k], b.min[k]);
        box.max[k] = std::min(a.max[k], b.max[k]);
    }
    return box;
}

bool is_empty(const Box3& box) {
    return !(box.min[0] <= box.max[0] && box.min[1] <= box.max[1] && box.min[2] <= box.max[2]);
}

bool is_finite(const Box3& box) {
    return std::all_of(box.min.begin(), box.min.end(), [](double x) { return std::isfinite(x); }) &&
           std::all_of(box.max.begin(), box.max.end(), [](double x) { return std::isfinite(x); });
}

}  // namespace mortise::model_reader
