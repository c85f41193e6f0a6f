#include "tests/mesher/rounded_solids.hpp"

namespace mortise::test {
namespace {

constexpr double kQuarterTurn = 1.57079632679489661923;

NodeIndex placed(Model& model, NodeIndex node, const Vec3& at) {
    return model.add_transform(translation(at), node);
}

}  // namespace

NodeIndex add_stadium(Model& model, double radius, double length, double low, double high) {
    return unite(model, {add_cylinder(model, radius, low, high),
                         placed(model, add_cylinder(model, radius, low, high), {length, 0, 0}),
                         add_box(model, {0, -radius, low}, {length, radius, high})});
}

NodeIndex add_capsule(Model& model, double radius, double length) {
    return unite(model, {add_cylinder(model, radius, 0, length), add_ball(model, {0, 0, 0}, radius),
                         add_ball(model, {0, 0, length}, radius)});
}

NodeIndex add_rounded_plate(Model& model, const Vec3& half, double radius) {
    const double x = half[0] - radius, y = half[1] - radius;
    std::vector<NodeIndex> parts = {add_box(model, {-half[0], -y, -half[2]}, {half[0], y, half[2]}),
                                    add_box(model, {-x, -half[1], -half[2]}, {x, half[1], half[2]})};
    for (const double i : {-1.0, 1.0}) {
        for (const double j : {-1.0, 1.0})
            parts.push_back(placed(model, add_cylinder(model, radius, -half[2], half[2]), {i * x, j * y, 0}));
    }
    return unite(model, parts);
}

NodeIndex add_rounded_box(Model& model, const Vec3& half, double radius) {
    std::vector<NodeIndex> parts;
    const Vec3 inner = {half[0] - radius, half[1] - radius, half[2] - radius};
    const Affine turns[3] = {rotation({0, 1, 0}, kQuarterTurn), rotation({1, 0, 0}, kQuarterTurn), kIdentity};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        Vec3 core = inner;
        core[axis] = half[axis];
        parts.push_back(add_box(model, {-core[0], -core[1], -core[2]}, core));
        for (int k = 0; k < 4; ++k) {
            Vec3 at = inner;
            at[axis] = 0;
            at[(axis + 1) % 3] *= (k & 1) != 0 ? 1 : -1;
            at[(axis + 2) % 3] *= (k & 2) != 0 ? 1 : -1;
            const NodeIndex bar = add_cylinder(model, radius, -inner[axis], inner[axis]);
            parts.push_back(placed(model, model.add_transform(turns[axis], bar), at));
        }
    }
    for (int c = 0; c < 8; ++c) {
        parts.push_back(add_ball(model,
                                 {(c & 1) != 0 ? inner[0] : -inner[0], (c & 2) != 0 ? inner[1] : -inner[1],
                                  (c & 4) != 0 ? inner[2] : -inner[2]},
                                 radius));
    }
    return unite(model, parts);
}

NodeIndex add_rounded_disc(Model& model, double radius, double rim) {
    return unite(model, {add_torus(model, radius, rim), add_cylinder(model, radius, -rim, rim)});
}

NodeIndex add_teardrop(Model& model, double radius, double low, double high) {
    const NodeIndex corner = add_box(model, {0, 0, low}, {radius, radius, high});
    return unite(model, {add_cylinder(model, radius, low, high),
                         model.add_transform(rotation({0, 0, 1}, 0.5 * kQuarterTurn), corner)});
}

NodeIndex add_filleted_box(Model& model, const Vec3& size, double radius) {
    const NodeIndex away =
        subtract(model, {add_box(model, {-1, -1, -1}, {radius, radius, size[2] + 1}),
                         placed(model, add_cylinder(model, radius, -2, size[2] + 2), {radius, radius, 0})});
    return subtract(model, {add_box(model, {0, 0, 0}, size), away});
}

}  // namespace mortise::test
