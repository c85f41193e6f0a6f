// See bound_models.hpp.
#include "tests/tape/bound_models.hpp"

#include <algorithm>
#include <cmath>

#include "kernels/shared/surface.h"
#include "kernels/shared/tape.h"
#include "tests/mesher/random_source.hpp"
#include "tests/mesher/solids.hpp"

namespace mortise::test {

tape::BoundModel bind_model(const Model& model, int level) {
    const tape::CompiledModel compiled = tape::compile(model);
    const Box3 bounds = tape::find_bounds(compiled, "test");
    double extent = 0;
    for (std::size_t j = 0; j < 3; ++j) extent = std::max(extent, bounds.max[j] - bounds.min[j]);
    const double cells = std::ldexp(1.0, level);
    const double side = level >= 3 ? extent * (cells / (cells - 2)) : 1.25 * extent;
    Vec3 origin{};
    for (std::size_t j = 0; j < 3; ++j) origin[j] = 0.5 * (bounds.min[j] + bounds.max[j] - side);
    return tape::bind(compiled, origin, side);
}

std::int32_t run_tape(const std::uint32_t* words, std::size_t length, const std::vector<bool>& inside,
                      std::size_t* deepest) {
    std::vector<std::int32_t> stack;
    for (std::size_t i = 0; i < length; ++i) {
        const std::uint32_t word = words[i];
        switch (word >> 29) {
            case kTapeLiteral:
                stack.push_back(inside.at(word & 0x0fffffffu) != ((word >> 28 & 1u) != 0) ? 1 : 0);
                break;
            case kTapeAnd:
            case kTapeOr: {
                const bool b = stack.back() != 0;
                stack.pop_back();
                const bool a = stack.back() != 0;
                stack.back() = (word >> 29 == kTapeAnd ? a && b : a || b) ? 1 : 0;
                break;
            }
            case kTapeSelect: {
                const bool chosen = stack.back() != 0;
                stack.pop_back();
                if (chosen) stack.back() = static_cast<std::int32_t>(word & 0xfffu);
                break;
            }
            default:
                stack.back() =
                    static_cast<std::int32_t>(stack.back() != 0 ? word & 0xfffu : word >> 12 & 0xfffu);
        }
        if (deepest != nullptr) *deepest = std::max(*deepest, stack.size());
    }
    return stack.size() == 1 ? stack[0] : -2;
}

std::vector<bool> halves_at(const tape::BoundModel& model, const Vec3& local) {
    std::vector<bool> inside;
    for (const Surface& s : model.surfaces) {
        inside.push_back(surface_value(&s, model.expression_ops.data(), local[0], local[1], local[2]) <= 0);
    }
    return inside;
}

Vec3 to_model(const tape::BoundModel& model, const Vec3& local) {
    return {model.origin[0] + model.side * local[0], model.origin[1] + model.side * local[1],
            model.origin[2] + model.side * local[2]};
}

Model rotated_box() {
    Model model;
    const NodeIndex solid = add_box(model, {-1, -0.7, -0.6}, {1, 0.7, 0.6});
    add_region(model, model.add_transform(rotation({0.3, 1, 0.4}, 0.7), solid), "box");
    return model;
}

Model ball() {
    Model model;
    add_region(model, add_ball(model, {0.1, 0.2, 0.3}, 1), "ball");
    return model;
}

Model crossing_cylinders() {
    Model model;
    const NodeIndex first = add_cylinder(model, 1, -3, 3);
    const NodeIndex second =
        model.add_transform(rotation({1, 0, 0}, 1.4), add_cylinder(model, 0.7, -2.7, 2.7));
    const NodeIndex both = unite(model, {first, second});
    add_region(model, model.add_transform(rotation({0.2, 0.5, 1}, 0.6), both), "cylinders");
    return model;
}

Model random_polytope(std::uint64_t seed, int planes) {
    RandomSource random(seed);
    Primitive convex = box({-1.2, -1.2, -1.2}, {1.2, 1.2, 1.2});
    for (int i = 0; i < planes; ++i) {
        Plane plane;
        double square = 0;
        for (double& n : plane.normal) {
            n = random.uniform(-1, 1);
            square += n * n;
        }
        plane.offset = random.uniform(0.5, 1) * std::sqrt(square);
        convex.planes.push_back(plane);
    }
    Model model;
    const NodeIndex solid = model.add_primitive(convex);
    add_region(model,
               model.add_transform(rotation({1, random.uniform(0, 1), 0.3}, random.uniform(0, 3)), solid),
               "polytope");
    return model;
}

Model random_polyhedron(std::uint64_t seed) {
    RandomSource random(seed);
    Model model;
    const auto part = [&] {
        const NodeIndex solid =
            random.chance(0.6)
                ? add_box(model, {-random.uniform(0.4, 1), -random.uniform(0.4, 1), -random.uniform(0.4, 1)},
                          {random.uniform(0.4, 1), random.uniform(0.4, 1), random.uniform(0.4, 1)})
                : model.add_primitive(
                      wedge(random.uniform(0.8, 2), random.uniform(0.8, 2), random.uniform(0.8, 2)));
        Affine map = translation({random.uniform(-0.6, 0.6), random.uniform(-0.6, 0.6), 0});
        if (random.chance(0.7)) {
            map = compose(map,
                          rotation({random.uniform(-1, 1), 1, random.uniform(-1, 1)}, random.uniform(0, 3)));
        }
        return model.add_transform(map, solid);
    };
    NodeIndex root = part();
    const int count = random.integer(1, 4);
    for (int i = 0; i < count; ++i) {
        const NodeIndex next = part();
        root = random.chance(0.5) ? unite(model, {root, next}) : subtract(model, {root, next});
    }
    const bool inclusion = random.chance(0.3);
    if (inclusion) {
        const NodeIndex inner = intersect(model, {root, part()});
        add_region(model, inner, "inner");
    }
    add_region(model, root, "outer");
    return model;
}

Model formula_model(const std::string& formula, double half) {
    Model model;
    Primitive primitive;
    primitive.kind = Primitive::Kind::kExpression;
    primitive.expression = formula;
    add_region(model, model.add_primitive(primitive), "formula");
    model.clip = Box3{{-half, -half, -half}, {half, half, half}};
    return model;
}

}  // namespace mortise::test
