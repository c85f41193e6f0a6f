// Sizes that are wanted: everywhere, on surfaces, in regions, around points, by curvature.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "host/common/constants.hpp"
#include "kernels/shared/tape.h"
#include "tests/mesher/solids.hpp"
#include "tests/sizing/descent.hpp"
#include "tests/tape/bound_models.hpp"

using namespace mortise;
using namespace mortise::test;

namespace {

constexpr double kTwoPi = 6.283185307179586;

/// Leaves' levels when the sizer has its way, at most level 8.
struct Leaf {
    tape::Cell cell;
    int level;
    std::vector<std::uint32_t> tape;
};
std::vector<Leaf> grow(const tape::BoundModel& model, const sizing::SizeField& field) {
    const sizing::Sizer sizer(model, field);
    std::vector<Leaf> leaves;
    for (Nodes nodes = nodes_at(model, 0); !nodes.nodes.empty() && nodes.level <= 8;) {
        const auto which = sizer.split_undecided(nodes.nodes, nodes.tapes, nodes.level, 2);
        for (std::size_t i = 0; i < which.size(); ++i) {
            if (which[i] != 0) continue;
            const auto first = nodes.tapes.begin() + nodes.nodes[i].tape_offset;
            leaves.push_back({sizing::cell_of(nodes.nodes[i].morton, nodes.level),
                              nodes.level,
                              {first, first + nodes.nodes[i].tape_length}});
        }
        nodes = children_of(model, nodes, which);
    }
    return leaves;
}

const tape::BoundModel& ball_model() {
    static const tape::BoundModel model = [] {
        Model ball;
        add_region(ball, add_ball(ball, {0, 0, 0}, 0.8), "ball");
        return tape::bind(tape::compile(ball), {-1, -1, -1}, 2);
    }();
    return model;
}

}  // namespace

TEST_CASE("a cube's Morton code and its place") {
    const tape::Cell root = sizing::cell_of(0, 0);
    CHECK(root.centre[0] == 0.5);
    CHECK(root.half == 0.5);
    const tape::Cell cell = sizing::cell_of(0b101'011, 2);  // x: bits 1, 1; y: 0, 1; z: 1, 0
    CHECK(cell.half == 0.125);
    CHECK(cell.centre[0] == 0.875);
    CHECK(cell.centre[1] == 0.375);
    CHECK(cell.centre[2] == 0.625);
}

TEST_CASE("one size everywhere, met exactly by a level's edge") {
    sizing::SizeField field;
    field.everywhere = 1.0 / 8;
    for (const Leaf& leaf : grow(ball_model(), field)) CHECK(leaf.level == 3);
    field.everywhere = 0.99 / 8;
    for (const Leaf& leaf : grow(ball_model(), field)) CHECK(leaf.level == 4);
}

TEST_CASE("no wish, no split; no nodes, no answer") {
    const sizing::Sizer sizer(ball_model(), {});
    const Nodes nodes = nodes_at(ball_model(), 2);
    CHECK(count_split(sizer.split_undecided(nodes.nodes, nodes.tapes, 2, 0)) == 0);
    CHECK(sizer.split_undecided({}, {}, 5, 3).empty());
    CHECK(sizer.in_size(0, 0, 1) == kInfinity);
}

TEST_CASE("point sources: every leaf keeps its bound, and is no finer than it needs") {
    sizing::SizeField field;
    field.everywhere = 0.25;
    field.sources = {{{0.9, 0.5, 0.5}, 0.01, 0.3}, {{0.1, 0.5, 0.5}, 0.06, 0.1}};
    const sizing::Sizer sizer(ball_model(), field);
    int finest = 0;
    for (const Leaf& leaf : grow(ball_model(), field)) {
        double wish = field.everywhere;
        for (const auto& source : field.sources) {
            double square = 0;
            for (std::size_t j = 0; j < 3; ++j) {
                const double off =
                    std::max(0.0, std::fabs(source.at[j] - leaf.cell.centre[j]) - leaf.cell.half);
                square += off * off;
            }
            wish = std::min(wish, source.size + source.grading * std::sqrt(square));
        }
        CHECK(2 * leaf.cell.half <= wish * 1.000001);
        finest = std::max(finest, leaf.level);
    }
    CHECK(finest == 7);
    CHECK(sizer.in_size(0, 3, 1) < 0.25);
    CHECK(sizer.in_size(0, 0, 1) == doctest::Approx(0.01));
}

TEST_CASE("curvature: leaves per turn") {
    for (const double elements : {12.0, 40.0}) {
        sizing::SizeField field;
        field.everywhere = 0.25;
        field.curvature_elements = elements;
        const double wanted = kTwoPi * 0.4 / elements;
        for (const Leaf& leaf : grow(ball_model(), field)) {
            double square = 0;  // bounds are loose: some undecided nodes are outside
            for (const double c : leaf.cell.centre)
                square += std::pow(std::max(0.0, std::fabs(c - 0.5) - leaf.cell.half), 2);
            if (std::sqrt(square) > 0.4) continue;
            CHECK(2 * leaf.cell.half <= 1.25 * wanted);
            CHECK(2 * leaf.cell.half >= 0.4 * wanted);
        }
    }
    Model box;
    add_region(box, add_box(box, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}), "box");
    sizing::SizeField field;
    field.everywhere = 0.25;
    field.curvature_elements = 100;
    for (const Leaf& leaf : grow(tape::bind(tape::compile(box), {-1, -1, -1}, 2), field))
        CHECK(leaf.level == 2);
}

TEST_CASE("sizes of a .geo file: solids, parts of them, regions") {
    const Model model = parse_model(
        "algebraic3d\n"
        "solid cube = orthobrick (-1, -1, -1; 1, 1, 1);\n"
        "solid cyl = cylinder (0, 0, -2; 0, 0, 2; 0.5) -maxh=0.1;\n"
        "solid inner = cube and cyl -maxh=0.2;\n"
        "solid outer = cube and not cyl;\n"
        "tlo inner;\n"
        "tlo outer -maxh=0.8;\n",
        "geo", "sizes.geo");
    const tape::CompiledModel compiled = tape::compile(model);
    REQUIRE(compiled.surface_size.size() == compiled.surfaces.size());
    for (std::size_t i = 0; i < compiled.surfaces.size(); ++i) {
        // The cube's faces have the size of `inner` where that uses them.
        const bool is_cylinder = compiled.surfaces[i].surface.kind != kSurfacePlane;
        if (is_cylinder)
            CHECK(compiled.surface_size[i] == 0.1);
        else
            CHECK((compiled.surface_size[i] == 0.2 || compiled.surface_size[i] == kInfinity));
    }
    CHECK(compiled.region_size == std::vector<double>{0.1, 0.8});

    const tape::BoundModel bound = tape::bind(compiled, {-2, -2, -2}, 4);
    REQUIRE(bound.surface_size.size() == bound.surfaces.size());
    for (std::size_t i = 0; i < bound.surfaces.size(); ++i)
        CHECK(bound.surface_size[i] == (bound.surfaces[i].kind != kSurfacePlane ? 0.1 / 4 : 0.2 / 4));
    const sizing::SizeField field = sizing::size_field(bound);
    CHECK(field.region == std::vector<double>{0.1 / 4, 0.8 / 4});
    const sizing::Sizer sizer(bound, field);
    CHECK(sizer.in_size(0, 2, 1) == 0.1 / 4);
    CHECK(sizer.in_size(0, 2, 2) == 0.8 / 4);
}

TEST_CASE("a size on surfaces alone is none of the region's") {
    Model model;
    const NodeIndex ball = add_ball(model, {0, 0, 0}, 0.5);
    model.nodes[ball].surface_size = 0.1;
    add_region(model, ball, "ball");
    const tape::CompiledModel compiled = tape::compile(model);
    CHECK(compiled.region_size.front() == std::numeric_limits<double>::infinity());
    const tape::BoundModel bound = tape::bind(compiled, {-1, -1, -1}, 2);
    REQUIRE(bound.surface_size.size() == 1);
    CHECK(bound.surface_size[0] == 0.1 / 2);
}

TEST_CASE("surface and region sizes refine the leaves that hold them") {
    Model model;
    const NodeIndex part = add_ball(model, {0.3, 0, 0}, 0.2);
    model.nodes[part].max_size = 0.05;
    add_region(model, subtract(model, {add_box(model, {-0.7, -0.7, -0.7}, {0.7, 0.7, 0.7}), part}), "rest");
    model.regions.back().max_size = 0.4;
    const tape::BoundModel bound = tape::bind(tape::compile(model), {-1, -1, -1}, 2);
    CHECK(bound.region_size == std::vector<double>{0.2});
    for (const Leaf& leaf : grow(bound, sizing::size_field(bound))) {
        bool on_ball = false;
        for (const std::uint32_t word : leaf.tape) {
            on_ball = on_ball || (tape_operation(word) == kTapeLiteral &&
                                  bound.surfaces[tape_surface(word)].kind == kSurfaceQuadric);
        }
        CHECK(leaf.level >= (on_ball ? 6 : 3));
        CHECK(leaf.level <= 6);
    }
}

TEST_CASE("an undivided polyhedron is no leaf") {
    const std::vector<std::uint32_t> tape = {make_spatial(8, 0), make_operation(kTapeSelectConst, 1, 0)};
    const sizing::Sizer sizer(ball_model(), {});
    CHECK(sizer.split_undecided({{0, 0, 2}}, tape, 0, 1) == std::vector<std::uint8_t>{1});
}

TEST_CASE("the same for any number of threads") {
    const tape::BoundModel model = bind_model(crossing_cylinders(), 6);
    const Nodes nodes = nodes_at(model, 6);
    sizing::SizeField field;
    field.features = true;
    field.curvature_elements = 60;
    field.sources = {{{0.2, 0.3, 0.4}, 0.001, 0.1}};
    const sizing::Sizer sizer(model, field);
    const auto one = sizer.split_undecided(nodes.nodes, nodes.tapes, 6, 1);
    CHECK(count_split(one) > 0);
    CHECK(count_split(one) < one.size());
    CHECK(sizer.split_undecided(nodes.nodes, nodes.tapes, 6, 2) == one);
    CHECK(sizer.split_undecided(nodes.nodes, nodes.tapes, 6, 5) == one);
}
