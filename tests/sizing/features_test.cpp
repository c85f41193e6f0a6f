// What is split because the solid is not simple in a leaf, and what is not.
#include <doctest/doctest.h>

#include <cmath>

#include "host/sizing/topology.hpp"
#include "host/triangles/divide.hpp"
#include "tests/mesher/solids.hpp"
#include "tests/sizing/descent.hpp"
#include "tests/tape/bound_models.hpp"
#include "tests/triangles/shapes.hpp"

using namespace mortise;
using namespace mortise::test;

namespace {

/// Bound to the cube [-1, 1]^3: a cell of level 4 has the edge 1/8.
constexpr int kLevel = 4;
constexpr double kCell = 0.125;

tape::BoundModel bind_fixed(const Model& model) { return tape::bind(tape::compile(model), {-1, -1, -1}, 2); }

/// At an odd angle, so that nothing lies on the grid.
tape::BoundModel bind_turned(Model& model, NodeIndex solid) {
    add_region(model, model.add_transform(rotation({0.3, 1, 0.4}, 0.7), solid), "solid");
    return bind_fixed(model);
}

using Counts = std::vector<std::size_t>;
const Counts kNone = {0};

}  // namespace

TEST_CASE("spheres: large ones stay, small ones are split until their radius is a few cells") {
    Model large;
    add_region(large, add_ball(large, {0.01, 0.02, 0.03}, 3 * kCell), "ball");
    CHECK(feature_splits(bind_fixed(large), kLevel) == kNone);

    Model small;
    add_region(small, add_ball(small, {0.01, 0.02, 0.03}, 0.4 * kCell), "ball");
    const Counts counts = feature_splits(bind_fixed(small), kLevel);
    CHECK(counts.front() > 0);
    CHECK(counts.size() >= 3);  // a radius of 1.6 cells two levels below
    CHECK(counts.size() <= 4);
    CHECK(counts.back() == 0);
}

TEST_CASE("a ball between the samples of a node is found") {
    Model model;
    add_region(model, add_ball(model, {0.3 * kCell, 0.25 * kCell, 0.7 * kCell}, 0.05 * kCell), "ball");
    CHECK(feature_splits(bind_fixed(model), kLevel, 1) == Counts{1});
}

TEST_CASE("plates: thick ones stay, thin ones are split until they have a cell across") {
    for (const bool turned : {false, true}) {
        for (const double thickness : {2.5, 0.4}) {
            Model model;
            const NodeIndex plate =
                add_box(model, {-0.6, -0.61, 0.011}, {0.6, 0.59, 0.011 + thickness * kCell});
            if (!turned) add_region(model, plate, "plate");
            const tape::BoundModel bound = turned ? bind_turned(model, plate) : bind_fixed(model);
            const Counts counts = feature_splits(bound, kLevel);
            CAPTURE(turned);
            if (thickness > 2) {
                CHECK(counts == kNone);
            } else {
                CHECK(counts.front() > 80);
                CHECK(counts.size() <= 4);
                CHECK(counts.back() == 0);
            }
        }
    }
}

TEST_CASE("a plate of one cell between grid planes stays") {
    Model model;
    add_region(model, add_box(model, {-0.5, -0.5, 0}, {0.5, 0.5, kCell}), "plate");
    CHECK(feature_splits(bind_fixed(model), kLevel) == kNone);
}

TEST_CASE("a gap between two boxes is split") {
    Model model;
    add_region(model,
               unite(model, {add_box(model, {-0.6, -0.6, -0.6}, {0.01, 0.6, 0.6}),
                             add_box(model, {0.01 + 0.3 * kCell, -0.6, -0.6}, {0.61, 0.6, 0.6})}),
               "both");
    const Counts counts = feature_splits(bind_fixed(model), kLevel);
    CHECK(counts.front() >= 81);
    CHECK(counts.back() == 0);
}

TEST_CASE("two regions side by side: their interface is one sheet, a thin layer is not") {
    for (const double thickness : {0.55, 0.3 * kCell}) {
        Model model;
        add_region(model, add_box(model, {-0.6, -0.6, -0.6}, {0.6, 0.6, 0.02}), "below");
        add_region(model, add_box(model, {-0.6, -0.6, -0.6}, {0.6, 0.6, 0.02 + thickness}), "above");
        const Counts counts = feature_splits(bind_fixed(model), kLevel);
        if (thickness > 0.5)
            CHECK(counts == kNone);
        else
            CHECK(counts.front() >= 81);
        CHECK(counts.back() == 0);
    }
}

TEST_CASE("edges, corners, apexes and cylinder ends stay") {
    Model box;
    CHECK(feature_splits(bind_turned(box, add_box(box, {-0.5, -0.4, -0.3}, {0.5, 0.4, 0.3})), kLevel) ==
          kNone);

    Model cylinder;
    CHECK(feature_splits(bind_turned(cylinder, add_cylinder(cylinder, 3.2 * kCell, -0.5, 0.5)), kLevel) ==
          kNone);

    Model cone;
    CHECK(feature_splits(bind_turned(cone, add_frustum(cone, 0.5, 0, -0.4, 0.3)), kLevel) == kNone);

    // Four, six and eight planes through one point.
    for (const int sides : {4, 5, 6}) {
        Model pyramid;
        Primitive convex;
        for (int i = 0; i < sides; ++i) {
            const double angle = 2 * 3.14159265358979 * i / sides;
            convex.planes.push_back({{std::cos(angle), std::sin(angle), 0.9}, 0.3, ""});
        }
        convex.planes.push_back({{0, 0, -1}, 0.35, ""});
        const NodeIndex solid = pyramid.add_primitive(convex);
        CHECK(feature_splits(bind_turned(pyramid, solid), kLevel) == kNone);
    }
}

TEST_CASE("sharp creases stay: splitting never ends there") {
    Model model;
    Primitive wedge_like;  // 28°
    wedge_like.planes = {{{std::sin(0.25), 0, std::cos(0.25)}, 0, ""},
                         {{std::sin(0.25), 0, -std::cos(0.25)}, 0, ""},
                         {{-1, 0, 0}, 0.6, ""},
                         {{0, 1, 0}, 0.6, ""},
                         {{0, -1, 0}, 0.6, ""}};
    const Counts counts = feature_splits(bind_turned(model, model.add_primitive(wedge_like)), kLevel);
    CHECK(counts.size() <= 2);
    CHECK(counts.back() == 0);
}

TEST_CASE("two creases in a node: a chamfer, a step and a rounded edge smaller than a cell") {
    Model chamfer;
    Primitive convex = box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
    convex.planes.push_back({{1, 1, 0}, 1 - 0.3 * kCell, ""});
    CHECK(feature_splits(bind_turned(chamfer, chamfer.add_primitive(convex)), kLevel).front() > 0);

    Model step;
    const NodeIndex stairs = unite(step, {add_box(step, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.2}),
                                          add_box(step, {-0.5, -0.5, -0.5}, {0.03, 0.5, 0.2 + 0.3 * kCell})});
    const Counts counts = feature_splits(bind_turned(step, stairs), kLevel);
    CHECK(counts.front() > 0);
    CHECK(counts.back() == 0);
}

TEST_CASE("a small hole is split, and only there") {
    Model model;
    const NodeIndex plate = add_box(model, {-0.6, -0.6, -0.3}, {0.6, 0.6, 0.3});
    const NodeIndex hole =
        model.add_transform(translation({0.13, 0.04, 0}), add_cylinder(model, 0.3 * kCell, -1, 1));
    const tape::BoundModel bound = bind_turned(model, subtract(model, {plate, hole}));
    sizing::SizeField field;
    field.features = true;
    const Nodes nodes = nodes_at(bound, kLevel);
    const auto which = sizing::Sizer(bound, field).split_undecided(nodes.nodes, nodes.tapes, kLevel, 1);
    CHECK(count_split(which) > 5);
    // Distance from the hole's axis, turned as the model is.
    const Affine turn = rotation({0.3, 1, 0.4}, 0.7);
    const Vec3 low = apply(turn, {0.13, 0.04, -1});
    const Vec3 high = apply(turn, {0.13, 0.04, 1});
    for (std::size_t i = 0; i < which.size(); ++i) {
        const tape::Cell cell = sizing::cell_of(nodes.nodes[i].morton, kLevel);
        Vec3 off{};
        double along = 0;
        for (std::size_t j = 0; j < 3; ++j) {
            off[j] = 2 * cell.centre[j] - 1 - low[j];
            along += off[j] * (high[j] - low[j]) / 4;
        }
        double square = 0;
        for (std::size_t j = 0; j < 3; ++j) square += std::pow(off[j] - along * (high[j] - low[j]), 2);
        if (which[i] != 0) CHECK(std::sqrt(square) < 1.3 * kCell);
    }
    const Counts counts = feature_splits(bound, kLevel);
    CHECK(counts.size() <= 5);
    CHECK(counts.back() == 0);
}

TEST_CASE("a tangent blend is one sheet") {
    // A box whose end is a half cylinder, and the same with caps.
    Model model;
    const NodeIndex bar = add_box(model, {-0.5, -0.35, -0.3}, {0.05, 0.35, 0.3});
    const NodeIndex end =
        model.add_transform(translation({0.05, 0, 0}), add_cylinder(model, 0.35, -0.3, 0.3));
    CHECK(feature_splits(bind_turned(model, unite(model, {bar, end})), kLevel) == kNone);
    // A fillet: material added in an inner corner.
    Model fillet;
    const NodeIndex ell = unite(fillet, {add_box(fillet, {-0.6, -0.6, -0.5}, {0.6, -0.2, 0.5}),
                                         add_box(fillet, {-0.6, -0.6, -0.5}, {-0.2, 0.6, 0.5})});
    const NodeIndex block = add_box(fillet, {-0.3, -0.3, -0.5}, {0.2, 0.2, 0.5});
    const NodeIndex round =
        fillet.add_transform(translation({0.2, 0.2, 0}), add_cylinder(fillet, 0.4, -1, 1));
    const NodeIndex blend = subtract(fillet, {block, round});
    CHECK(feature_splits(bind_turned(fillet, unite(fillet, {ell, blend})), kLevel) == kNone);
}

TEST_CASE("a cylinder that lies on a plate does not split without end") {
    Model model;
    const NodeIndex plate = add_box(model, {-0.6, -0.6, -0.6}, {0.6, 0.6, -0.2});
    const NodeIndex lying =
        model.add_transform(compose(translation({0, 0, 0.2}), rotation({1, 0, 0}, 1.5707963267948966)),
                            add_cylinder(model, 0.4, -0.5, 0.5));
    const Counts counts = feature_splits(bind_turned(model, unite(model, {plate, lying})), kLevel, 5);
    CHECK(counts.back() < 40);
    CHECK(counts.size() <= 4);
}

TEST_CASE("facets of a smooth surface are one sheet") {
    Model model;
    Primitive prism;
    for (int i = 0; i < 60; ++i) {
        const double angle = 2 * 3.14159265358979 * i / 60;
        prism.planes.push_back({{std::cos(angle), std::sin(angle), 0}, 4 * kCell, ""});
    }
    prism.planes.push_back({{0, 0, 1}, 0.5, ""});
    prism.planes.push_back({{0, 0, -1}, 0.5, ""});
    CHECK(feature_splits(bind_turned(model, model.add_primitive(prism)), kLevel) == kNone);
}

TEST_CASE("walls inside the solid do not count") {
    Model model;
    const NodeIndex both = unite(model, {add_box(model, {-0.6, -0.4, -0.3}, {0.02, 0.4, 0.3}),
                                         add_box(model, {0.0, -0.4, -0.3}, {0.6, 0.4, 0.3})});
    CHECK(feature_splits(bind_turned(model, both), kLevel) == kNone);
}

TEST_CASE("features below the finest leaf are not worth a split") {
    Model model;
    const NodeIndex plate = add_box(model, {-0.6, -0.6, 0}, {0.6, 0.6, 0.05 * kCell});
    const tape::BoundModel bound = bind_turned(model, plate);
    const Nodes nodes = nodes_at(bound, kLevel);
    sizing::SizeField field;
    field.features = true;
    CHECK(count_split(sizing::Sizer(bound, field).split_undecided(nodes.nodes, nodes.tapes, kLevel, 1)) > 0);
    field.finest = std::ldexp(1.0, -kLevel - 3);  // an eighth of a cell
    CHECK(count_split(sizing::Sizer(bound, field).split_undecided(nodes.nodes, nodes.tapes, kLevel, 1)) == 0);
}

TEST_CASE("patches of triangles: by the normals of those in the node") {
    const auto bind_triangles = [](const TriangleSurface& surface, double sharp_angle, const Affine& map) {
        tape::BoundModel bound = bind_fixed(solid_of(surface, sharp_angle, map));
        triangles::divide(bound, kLevel, kLevel, 2);
        return bound;
    };
    const double radius = 3.3 * kCell;
    CHECK(feature_splits(bind_triangles(unit_sphere(4), 30, scaling({radius, radius, radius})), kLevel) ==
          kNone);
    // A lens: two sheets of one patch.
    const double thin = 0.3 * kCell;
    const tape::BoundModel lens =
        bind_triangles(unit_sphere(4), 179, compose(rotation({0.3, 1, 0.4}, 0.7), scaling({0.7, 0.7, thin})));
    CHECK(feature_splits(lens, kLevel, 1).front() > 50);
    // Facets as planes.
    CHECK(feature_splits(
              bind_triangles(l_block(), 0, compose(rotation({0.3, 1, 0.4}, 0.7), scaling({0.2, 0.2, 0.2}))),
              kLevel) == kNone);
}

TEST_CASE("arrangements: which surfaces bound the solid") {
    // s0 ∧ (s1 ∨ ¬s2)
    const std::vector<std::uint32_t> words = {make_literal(0, 0),
                                              make_literal(1, 0),
                                              make_literal(2, 1),
                                              make_operation(kTapeOr, 0, 0),
                                              make_operation(kTapeAnd, 0, 0),
                                              make_operation(kTapeSelectConst, 3, 0)};
    sizing::Arrangement arrangement;
    arrangement.load(words.data(), words.size(), {0, 1, 2}, {0, 0, 0}, {0, 1, 2, 3, 4, 5, 6, 7});
    CHECK(arrangement.is_one_region());
    CHECK(arrangement.orientation(0) == 1);
    CHECK(arrangement.orientation(1) == 1);
    CHECK(arrangement.orientation(2) == -1);
    // Without a point outside s1 and inside s2, what is in the bracket always holds.
    arrangement.load(words.data(), words.size(), {0, 1, 2}, {0, 0, 0}, {0, 1, 2, 3, 6, 7});
    CHECK(arrangement.bounds(0));
    CHECK(!arrangement.bounds(1));
    CHECK(!arrangement.bounds(2));
    arrangement.load(words.data(), words.size(), {0, 1, 2}, {0, -1, 0}, {0, 1, 2, 3});
    CHECK(arrangement.bounds(0));
    CHECK(!arrangement.bounds(1));  // of s2
}
