// What kernels do on a CPU, eight lanes at a time and once for leaves that look alike, gives what they give
// one by one, as on a GPU.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <string>

#include "host/snio/classify.hpp"
#include "host/snio/face_plans.hpp"
#include "host/tape/compile.hpp"
#include "kernels/shared/snap.h"
#include "mortise/model.hpp"

namespace mortise {
namespace {

device::Device device_with(int lanes) {
    device::DeviceOptions options;
    options.lanes = lanes;
    return device::Device("", options);
}

constexpr Vec3 kOrigin = {-1.53, -1.47, -1.49};
constexpr double kSide = 3;
constexpr int kLevel = 5;

snio::Classification classify(device::Device& device, const Model& model, bool snap) {
    const tape::BoundModel bound = tape::bind(tape::compile(model), kOrigin, kSide);
    octree::DeviceTree on_device;
    octree::Octree tree = octree::build(device, bound, kLevel, &on_device);
    return snio::classify(device, tree, on_device, true, snap);
}

template <class T>
bool are_same(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

/// A primitive within a box, both turned about an axis through the origin and shifted, or upright.
Model solid(const Primitive& primitive, std::mt19937_64* random = nullptr) {
    Model model;
    auto node =
        model.add_operation(CsgNode::Op::kIntersection,
                            {model.add_primitive(primitive),
                             model.add_primitive(box({-1.013, -1.02, -0.737}, {0.971, 0.933, 0.809}))});
    if (random != nullptr) {
        const auto between = [random](double low, double high) {
            return low + (high - low) * static_cast<double>((*random)() >> 11) * 0x1p-53;
        };
        const double a = between(0, 6.28), b = between(0, 6.28);
        const double ca = std::cos(a), sa = std::sin(a), cb = std::cos(b), sb = std::sin(b);
        node = model.add_transform({ca * cb, -sa, ca * sb, between(-0.1, 0.1), sa * cb, ca, sa * sb,
                                    between(-0.1, 0.1), -sb, 0, cb, between(-0.1, 0.1)},
                                   node);
    }
    model.regions.push_back({"solid", node, 0, {}});
    return model;
}

/// Formulas with all operations that lanes know, and some that go lane by lane.
Primitive expression(const std::string& text) {
    Primitive primitive;
    primitive.kind = Primitive::Kind::kExpression;
    primitive.expression = text;
    return primitive;
}

/// The cells' vertices are by less than `part` of a cell farther from its faces than others' may move.
Model box_beside_grid_planes(double part) {
    const double cell = std::ldexp(kSide, -kLevel);
    const double apart = kVertexSnapDistance + part;
    Vec3 low{}, high{};
    for (std::size_t j = 0; j < 3; ++j) {
        low[j] = kOrigin[j] + (5 + apart) * cell;
        high[j] = kOrigin[j] + (26 - apart) * cell;
    }
    Model model;
    model.regions.push_back({"solid", model.add_primitive(box(low, high)), 0, {}});
    return model;
}

/// A cylinder and a ball of five cells around vertices: some corners lie on them as they are, others move
/// there, in leaves whose corners have the same states.
Model through_vertices() {
    const double cell = std::ldexp(kSide, -kLevel);
    Model model;
    std::vector<std::uint32_t> nodes;
    for (const int at : {9, 21}) {
        const auto primitive = model.add_primitive(at == 9 ? infinite_cylinder(5 * cell) : sphere(5 * cell));
        Vec3 centre = kOrigin;
        for (double& x : centre) x += at * cell;
        nodes.push_back(
            model.add_transform({1, 0, 0, centre[0], 0, 1, 0, centre[1], 0, 0, 1, centre[2]}, primitive));
    }
    const auto both = model.add_operation(CsgNode::Op::kUnion, nodes);
    const auto box_node = model.add_primitive(box({-1.2, -1.2, -1.2}, {1.2, 1.2, 1.2}));
    model.regions.push_back(
        {"solid", model.add_operation(CsgNode::Op::kIntersection, {both, box_node}), 0, {}});
    return model;
}

}  // namespace

TEST_CASE("leaves are classified alike with eight lanes and with one") {
    device::Device wide = device_with(8);
    device::Device narrow = device_with(1);
    std::mt19937_64 random(83);
    std::vector<std::pair<std::string, Model>> models;
    models.push_back({"box along the grid", solid(sphere(5))});
    models.push_back({"cylinder along the grid", solid(infinite_cylinder(0.873))});
    models.push_back({"box beside grid planes", box_beside_grid_planes(0.01)});
    models.push_back({"through vertices", through_vertices()});
    for (int i = 0; i < 4; ++i) {
        models.push_back({"ball", solid(sphere(0.6 + 0.1 * i), &random)});
        models.push_back({"box", solid(sphere(5), &random)});
        models.push_back({"cylinder", solid(infinite_cylinder(0.3 + 0.1 * i), &random)});
        models.push_back({"cone", solid(cone(0.6, 0.5), &random)});
        models.push_back({"torus", solid(torus(0.6, 0.3), &random)});
    }
    for (const char* text :
         {"sin(5*x)*cos(5*y) + sin(5*y)*cos(5*z) + sin(5*z)*cos(5*x) - 0.3", "abs(x) + abs(y) + abs(z) - 0.9",
          "max(x^2 + y^2 - 0.5, min(sin(9*x), z/(1.3 + y)) - 0.7)", "sqrt(x^2 + y^2 + 0.1) - exp(-z) + 0.2*y",
          "sin(12*x)/x + 4*(y^2 + z^2) - 2", "sqrt(x) + y^2 + z^2 - 0.8",
          "atan2(y, x) + log(1.5 + z) - 0.4*tan(x*y)"}) {
        for (std::mt19937_64* const turned : {static_cast<std::mt19937_64*>(nullptr), &random})
            models.push_back({text, solid(expression(text), turned)});
    }
    std::size_t leaves = 0;
    for (const auto& [name, model] : models) {
        CAPTURE(name);
        for (const bool snap : {true, false}) {
            CAPTURE(snap);
            const snio::Classification a = classify(wide, model, snap);
            const snio::Classification b = classify(narrow, model, snap);
            CHECK(are_same(a.leaves, b.leaves));
            CHECK(are_same(a.used, b.used));
            CHECK(are_same(a.facets, b.facets));
            CHECK(a.cnio == b.cnio);
            for (std::size_t t = 0; t < kElementTypes; ++t) CHECK(are_same(a.elements[t], b.elements[t]));
            leaves += a.leaves.size();
        }
    }
    MESSAGE(leaves, " leaves");
    CHECK(leaves > 50000);
}

TEST_CASE("plans of faces: states are those of the corners, facets cover the polygon") {
    const FacePlans& plans = snio::face_plans();
    int polygons = 0;
    for (std::size_t f = 0; f < 6; ++f) {
        std::array<bool, kFaceStates> seen{};
        for (u32 inside = 0; inside < 256; ++inside) {
            for (u32 on = 0; on < 256; ++on) {
                if ((inside & on) != 0) continue;
                const auto state = static_cast<std::size_t>(
                    ((plans.states[inside] + 2 * plans.states[on]) >> (8 * f)) & 0xff);
                REQUIRE(state < kFaceStates);
                if (seen[state]) continue;
                seen[state] = true;
                std::size_t digits = 0;
                for (std::size_t i = 4; i-- > 0;) {
                    const u32 corner = kFaceCorners[f][i];
                    digits = 3 * digits + ((inside >> corner) & 1) + 2 * ((on >> corner) & 1);
                }
                CHECK(state == digits);
                const FacePlan& plan = plans.plan[f][state];
                if (plan.count == kNoPolygon || plan.count < 3) continue;
                ++polygons;
                // Each mesh's facets together have n - 2 triangles, a quadrilateral counting as two, and all
                // the polygon's nodes.
                for (int mesh = 0; mesh < (plan.count < 4 ? 1 : kFaceMeshes); ++mesh) {
                    const FaceMeshPlan& facets = plan.mesh[mesh];
                    u32 nodes = 0;
                    int quarters = 0;
                    for (int i = 0; i < facets.count; ++i) {
                        const u32 set = facets.facet[i];
                        nodes |= set;
                        quarters += __builtin_popcount(set) == 4 ? 2 : 4;
                        for (int k = 0; k < 3; ++k) CHECK(((set >> facets.corner[i][k]) & 1) == 1);
                    }
                    CHECK(nodes == plan.nodes);
                    CHECK(quarters == 4 * (plan.count - 2));
                }
            }
        }
        CHECK(std::all_of(seen.begin(), seen.end(), [](bool is) { return is; }));
    }
    MESSAGE(polygons, " polygons");
}

}  // namespace mortise
