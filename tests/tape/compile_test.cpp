// Compiling and binding: the tape against the model's definition, stack depth, merging, names, boxes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "host/tape/reference.hpp"
#include "tests/mesher/random_models.hpp"
#include "tests/mesher/random_source.hpp"
#include "tests/mesher/solids.hpp"
#include "tests/model/membership.hpp"
#include "tests/tape/bound_models.hpp"

using namespace mortise;
using namespace mortise::test;

namespace {

std::size_t depth_of(const tape::BoundModel& model) {
    std::size_t deepest = 0;
    run_tape(model.tape.data(), model.tape.size(), halves_at(model, {0.5, 0.5, 0.5}), &deepest);
    return deepest;
}

std::size_t surface_count(const Model& model) { return bind_model(model, 4).surfaces.size(); }

/// Two solids in a union.
template <class Add>
Model pair_of(Add add, const Affine& map) {
    Model model;
    const NodeIndex first = add(model);
    add_region(model, unite(model, {first, model.add_transform(map, add(model))}), "pair");
    return model;
}

}  // namespace

TEST_CASE("random models: the tape gives the region that the tree of solids defines") {
    std::size_t inside = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        const RandomModel source = make_random_model(seed);
        CAPTURE(seed);
        CAPTURE(source.style);
        tape::BoundModel model;
        try {
            model = bind_model(source.model, 4);
        } catch (const Error& error) {
            CHECK(std::string(error.what()).find("empty") != std::string::npos);
            continue;
        }
        CHECK(depth_of(model) <= kTapeStack);
        RandomSource random(seed);
        int wrong = 0;
        for (int i = 0; i < 10000; ++i) {
            const Vec3 local = {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
            const std::size_t expected = region_at(source.model, to_model(model, local));
            const auto found = tape::region_at(model, local[0], local[1], local[2]);
            wrong += static_cast<std::size_t>(found) != expected ? 1 : 0;
            inside += expected > 0 ? 1 : 0;
        }
        CHECK(wrong == 0);
    }
    CHECK(inside > 20000);
}

TEST_CASE("deep nestings keep the stack low and the meaning") {
    // Balls in a row, as chains a - (b - (c - …)), ((a - b) - c) - …, and mixtures of all operations.
    constexpr int kDepth = 10000;
    for (int shape = 0; shape < 4; ++shape) {
        RandomSource random(static_cast<std::uint64_t>(shape));
        Model model;
        std::vector<int> operation;  // 0 union, 1 intersection, 2 chain - ball, 3 ball - chain
        std::vector<double> centre;
        NodeIndex chain = add_box(model, {-1, -1, -1}, {1, 1, 1});
        for (int i = 0; i < kDepth; ++i) {
            const double x = random.uniform(-1, 1);
            const NodeIndex ball = add_ball(model, {x, 0, 0}, 0.25);
            const int chosen = shape == 0 ? 2 : shape == 1 ? 3 : random.integer(shape == 2 ? 2 : 0, 3);
            const std::vector<NodeIndex> parts =
                chosen == 3 ? std::vector<NodeIndex>{ball, chain} : std::vector<NodeIndex>{chain, ball};
            chain = chosen == 0   ? unite(model, parts)
                    : chosen == 1 ? intersect(model, parts)
                                  : subtract(model, parts);
            centre.push_back(x);
            operation.push_back(chosen);
        }
        add_region(model, intersect(model, {chain, add_box(model, {-2, -2, -2}, {2, 2, 2})}), "chain");
        const tape::CompiledModel compiled = tape::compile(model);
        std::size_t deepest = 0;
        std::vector<bool> halves(compiled.surfaces.size(), false);
        run_tape(compiled.tape.data(), compiled.tape.size(), halves, &deepest);
        CAPTURE(shape);
        CHECK(deepest <= 20);
        for (int k = 0; k < 20; ++k) {
            const Vec3 at = {random.uniform(-1.3, 1.3), random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3)};
            bool expected = std::fabs(at[0]) <= 1 && std::fabs(at[1]) <= 1 && std::fabs(at[2]) <= 1;
            for (std::size_t i = 0; i < centre.size(); ++i) {
                const double dx = at[0] - centre[i];
                const bool in_ball = dx * dx + at[1] * at[1] + at[2] * at[2] <= 0.0625;
                switch (operation[i]) {
                    case 0: expected = expected || in_ball; break;
                    case 1: expected = expected && in_ball; break;
                    case 2: expected = expected && !in_ball; break;
                    default: expected = in_ball && !expected;
                }
            }
            for (std::size_t s = 0; s < halves.size(); ++s) {
                halves[s] = surface_value(&compiled.surfaces[s].surface, nullptr, at[0], at[1], at[2]) <= 0;
            }
            CHECK(run_tape(compiled.tape.data(), compiled.tape.size(), halves) == (expected ? 1 : 0));
        }
    }
}

TEST_CASE("a balanced tree of 4096 solids keeps the stack low") {
    Model model;
    std::vector<NodeIndex> row;
    for (int i = 0; i < 4096; ++i) row.push_back(add_ball(model, {0.1 * i, 0, 0}, 1));
    for (int round = 0; row.size() > 1; ++round) {
        std::vector<NodeIndex> next;
        for (std::size_t i = 0; i < row.size(); i += 2) {
            next.push_back(round % 2 == 0 ? unite(model, {row[i], row[i + 1]})
                                          : subtract(model, {row[i], row[i + 1]}));
        }
        row = std::move(next);
    }
    add_region(model, row[0], "tree");
    const tape::CompiledModel compiled = tape::compile(model);
    std::size_t deepest = 0;
    run_tape(compiled.tape.data(), compiled.tape.size(), std::vector<bool>(4096, false), &deepest);
    CHECK(deepest <= 14);
}

TEST_CASE("equal surfaces are merged, whichever way they face; others are not") {
    const auto box_at = [](Model& model) { return add_box(model, {0, 0, 0}, {1, 1, 1}); };
    const auto cylinder = [](Model& model) { return add_cylinder(model, 0.5, -1, 1); };
    const auto frustum = [](Model& model) { return add_frustum(model, 1, 0.5, -1, 1); };
    const auto ring = [](Model& model) { return add_torus(model, 1, 0.25); };
    CHECK(surface_count(pair_of(box_at, kIdentity)) == 6);
    // Face to face: one plane shared back to back, four flush.
    CHECK(surface_count(pair_of(box_at, translation({1, 0, 0}))) == 7);
    CHECK(surface_count(pair_of(box_at, translation({1, 0, 1e-6}))) == 9);
    CHECK(surface_count(pair_of(box_at, translation({1e-6, 1e-6, 1e-6}))) == 12);
    CHECK(surface_count(pair_of(cylinder, translation({0, 0, 2}))) == 4);
    CHECK(surface_count(pair_of(cylinder, rotation({0, 0, 1}, 0.8))) == 3);
    CHECK(surface_count(pair_of(cylinder, translation({1e-6, 0, 0}))) == 4);
    CHECK(surface_count(pair_of(frustum, kIdentity)) == 3);
    CHECK(surface_count(pair_of(frustum, rotation({0, 0, 1}, 1.1))) == 3);
    CHECK(surface_count(pair_of(frustum, translation({0, 1e-6, 0}))) == 4);
    CHECK(surface_count(pair_of(ring, kIdentity)) == 1);
    CHECK(surface_count(pair_of(ring, translation({0, 0, 1e-6}))) == 2);

    // A hole of the same radius as its plug.
    Model plugged;
    const NodeIndex block = add_box(plugged, {-2, -2, -1}, {2, 2, 1});
    const NodeIndex holed = subtract(plugged, {block, add_cylinder(plugged, 1, -5, 5)});
    add_region(plugged, unite(plugged, {holed, add_cylinder(plugged, 1, -1, 1)}), "plugged");
    const tape::BoundModel model = bind_model(plugged, 4);
    CHECK(model.surfaces.size() == 9);
    RandomSource random(4);
    for (int i = 0; i < 2000; ++i) {
        const Vec3 local = {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
        const auto found = tape::region_at(model, local[0], local[1], local[2]);
        CHECK(static_cast<std::size_t>(found) == region_at(plugged, to_model(model, local)));
    }
}

TEST_CASE("surfaces are named after the innermost named solid and the side") {
    Model model;
    const NodeIndex block = model.add_primitive(box({0, 0, 0}, {1, 1, 1}), "block");
    const NodeIndex hole = model.add_primitive(sphere(0.3));
    const NodeIndex tool = model.add_operation(CsgNode::Op::kUnion, {hole}, "tool");
    add_region(model, subtract(model, {block, tool, model.add_primitive(torus(1, 0.2))}), "part");
    const Box3 clip = {{-3, -3, -3}, {3, 3, 0.5}};
    const tape::CompiledModel compiled = tape::compile(model, &clip);
    const std::set<std::string> names(compiled.surface_names.begin(), compiled.surface_names.end());
    for (const char* expected : {"block_xmin", "block_zmax", "tool", "torus1", "box_zmax", "box_xmin"}) {
        CAPTURE(expected);
        CHECK(names.count(expected) == 1);
    }
    CHECK(names.size() == compiled.surface_names.size());
    CHECK(compiled.region_names == std::vector<std::string>{"part"});
}

TEST_CASE("boxes of the file and of the caller cut the solid") {
    Model model;
    add_region(model, add_ball(model, {0, 0, 0}, 1), "ball");
    model.clip = Box3{{-5, -5, -0.5}, {5, 5, 5}};
    const Box3 box = {{0.25, -5, -5}, {5, 5, 5}};
    const tape::CompiledModel compiled = tape::compile(model, &box);
    const Box3 bounds = tape::find_bounds(compiled, "m");
    CHECK(bounds.min[0] == doctest::Approx(0.25));
    CHECK(bounds.min[2] == doctest::Approx(-0.5));
    const tape::BoundModel bound = tape::bind(compiled, {-2, -2, -2}, 4);
    const auto region = [&](double x, double y, double z) {
        return tape::region_at(bound, (x + 2) / 4, (y + 2) / 4, (z + 2) / 4);
    };
    CHECK(region(0.5, 0, 0) == 1);
    CHECK(region(0, 0, 0) == 0);
    CHECK(region(0.5, 0, -0.6) == 0);
}

TEST_CASE("bounds hold the solid, tightly where they are searched for, and say what is missing") {
    const auto bounds_of = [](const Model& model) {
        return tape::find_bounds(tape::compile(model), "model.csg");
    };
    for (std::uint64_t seed = 1; seed <= 80; ++seed) {
        const RandomModel source = make_random_model(seed);
        CAPTURE(seed);
        try {
            const Box3 box = bounds_of(source.model);
            RandomSource random(seed);
            for (int i = 0; i < 2000; ++i) {
                Vec3 at{};
                bool outside = false;
                for (std::size_t j = 0; j < 3; ++j) {
                    const double size = box.max[j] - box.min[j];
                    at[j] = box.min[j] + size * random.uniform(-0.5, 1.5);
                    outside = outside || at[j] < box.min[j] || at[j] > box.max[j];
                }
                if (outside) CHECK(region_at(source.model, at) == 0);
            }
        } catch (const Error& error) {
            CHECK(std::string(error.what()).find("empty") != std::string::npos);
        }
    }
    // Found by search: a tetrahedron of oblique half-spaces, x + y + z <= 1, x - y >= -1, …
    Model oblique;
    const double normals[4][3] = {{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
    Primitive planes;
    for (const auto& n : normals) planes.planes.push_back({{n[0], n[1], n[2]}, 1, ""});
    add_region(oblique, oblique.add_primitive(planes), "tetrahedron");
    const Box3 box = bounds_of(oblique);
    for (std::size_t j = 0; j < 3; ++j) {
        CHECK(box.min[j] <= -1);
        CHECK(box.max[j] >= 1);
        CHECK(box.max[j] - box.min[j] < 2 * 1.25);
    }
    // A cone from its apex down, tilted.
    Model tilted;
    const NodeIndex cone = add_frustum(tilted, 1, 0, 0, 3);
    add_region(tilted, tilted.add_transform(rotation({1, 0, 0}, 0.5), cone), "cone");
    const Box3 around = bounds_of(tilted);
    CHECK(around.min[0] <= -1);
    CHECK(around.max[0] >= 1);
    CHECK(around.max[0] - around.min[0] < 2 * 1.25);
    const auto message = [&](const Model& model) {
        try {
            bounds_of(model);
        } catch (const Error& error) {
            CHECK(error.code() == ExitCode::kInput);
            return std::string(error.what());
        }
        return std::string();
    };
    Model half;
    add_region(half, half.add_primitive(half_space({0, 0, 0}, {0, 0.6, 0.8})), "half");
    CHECK(message(half).find("no end of the solid was found along") != std::string::npos);
    Model pipe;
    add_region(pipe, pipe.add_primitive(infinite_cylinder(1)), "pipe");
    CHECK(message(pipe).find("no end of the solid was found along z within ") != std::string::npos);
    // Formulas: those that have no end, and those whose values hide it.
    const auto told = [&](const std::string& formula, const std::string& part) {
        CAPTURE(formula);
        Model model;
        Primitive primitive;
        primitive.kind = Primitive::Kind::kExpression;
        primitive.expression = formula;
        add_region(model, model.add_primitive(primitive), "formula");
        const std::string text = message(model);
        CAPTURE(text);
        CHECK(text.find(part) != std::string::npos);
        CHECK(text.find("cut it with --box") != std::string::npos);
    };
    for (const char* const endless : {"x^2 + y^2 - 1", "exp(x^2 + y^2) - 3", "x^2 + y^2 + sin(z) - 2"})
        told(endless, "no end of the solid was found along z within 10000 of the origin; cut it with --box");
    for (const char* const overflowing :
         {"x^2 + y^2 + z^2 - 1 + 0 * exp(x^4)", "exp(1000 * x) - exp(1000 + 0 * x) + y^2 + z^2",
          "exp(x^2 + y^2 + z^2) / exp(x^2) - 3"})
        told(overflowing, "a formula has no finite value 10000 from the origin along x (as where exp");
    Model apart;
    add_region(apart,
               intersect(apart, {add_box(apart, {0, 0, 0}, {1, 1, 1}), add_box(apart, {2, 0, 0}, {3, 1, 1})}),
               "apart");
    CHECK(message(apart).find("empty") != std::string::npos);
    Model slabs;
    const NodeIndex low = slabs.add_primitive(half_space({0, 0, 0}, {1, 1, 1}));
    const NodeIndex high = slabs.add_primitive(half_space({1, 1, 1}, {-1, -1, -1}));
    const NodeIndex side = slabs.add_primitive(half_space({0, 0, 0}, {1, -1, 0}));
    add_region(slabs, intersect(slabs, {low, high, side}), "slabs");
    CHECK(!message(slabs).empty());
}

TEST_CASE("a tree that is too large without sharing is refused at once with its place") {
    std::string text = "algebraic3d\nsolid a0 = sphere(0,0,0;1);\n";
    for (int i = 1; i <= 60; ++i) {
        const std::string before = "a" + std::to_string(i - 1);
        text += "solid a" + std::to_string(i) + " = " + before + " or " + before + ";\n";
    }
    const auto refusal_of = [&](const std::string& region) {
        try {
            tape::compile(parse_model(text + "tlo " + region + ";", "geo", "many.geo"));
        } catch (const Error& error) {
            CHECK(error.code() == ExitCode::kInput);
            return std::string(error.what());
        }
        return std::string();
    };
    CHECK(refusal_of("a60").find("many.geo:27:1: the solid has more than 16777216 surfaces") == 0);
    CHECK(refusal_of("a10").empty());
}

TEST_CASE("surfaces within the merge distance everywhere are one, with the right sign") {
    const double distance = 1e-6;  // of the root cube
    const auto count = [&](const Model& model, double merge) {
        const tape::CompiledModel compiled = tape::compile(model);
        return tape::bind(compiled, {-4, -4, -4}, 8, {merge, 0}).surfaces.size();
    };
    const auto box = [](Model& m) { return add_box(m, {-1, -1, -1}, {1, 1, 1}); };
    const auto ball = [](Model& m) { return add_ball(m, {0.3, 0.1, -0.2}, 1.1); };
    const auto rod = [](Model& m) { return add_cylinder(m, 0.7, -2, 2); };
    for (const double shift : {0.3, 3.0}) {
        CAPTURE(shift);
        const double by = shift * distance * 8;  // in model units
        const bool merges = shift < 1;
        const Affine along = {1, 0, 0, by, 0, 1, 0, by, 0, 0, 1, by};
        CHECK(count(pair_of(box, along), 0) == 12);
        CHECK(count(pair_of(box, along), distance) == (merges ? 6 : 12));
        CHECK(count(pair_of(ball, along), 0) == 2);
        CHECK(count(pair_of(ball, along), distance) == (merges ? 1 : 2));
        CHECK(count(pair_of(rod, along), 0) == 6);
        CHECK(count(pair_of(rod, along), distance) == (merges ? 3 : 6));
    }
    // A turn by an angle that moves the cube's far end by more than the distance keeps planes apart.
    CHECK(count(pair_of(box, rotation({0, 0, 1}, 1e-5)), distance) > 6);

    // Two boxes with a gap between them far below the distance become one: the planes cancel.
    Model gap;
    const NodeIndex left = add_box(gap, {-1, -1, -1}, {0, 1, 1});
    const NodeIndex right = add_box(gap, {1e-7, -1, -1}, {1, 1, 1});
    add_region(gap, unite(gap, {left, right}), "both");
    const tape::CompiledModel compiled = tape::compile(gap);
    const tape::BoundModel apart = tape::bind(compiled, {-4, -4, -4}, 8);
    const tape::BoundModel merged = tape::bind(compiled, {-4, -4, -4}, 8, {distance, 0});
    CHECK(apart.surfaces.size() == 8);
    CHECK(merged.surfaces.size() == 7);
    CHECK(merged.nearly_equal == 1);
    const double middle[3] = {0.5 + 0.5e-7 / 8, 0.5, 0.5};
    CHECK(tape::region_at(apart, middle[0], middle[1], middle[2]) == 0);
    CHECK(tape::region_at(merged, 0.5 + 1e-6, 0.5, 0.5) == 1);
    CHECK(tape::region_at(merged, 0.5 - 1e-6, 0.5, 0.5) == 1);
    CHECK(tape::region_at(merged, 0.5, 0.7, 0.5) == 0);
}
