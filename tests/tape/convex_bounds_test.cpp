// Boxes by linear programs: optima against all vertices, boxes against points of the solids.
#include <doctest/doctest.h>

#include <cmath>
#include <optional>

#include "host/tape/convex_bounds.hpp"
#include "host/tape/linear_program.hpp"
#include "tests/mesher/random_models.hpp"
#include "tests/mesher/random_source.hpp"
#include "tests/mesher/solids.hpp"
#include "tests/model/membership.hpp"

using namespace mortise;
using namespace mortise::test;

namespace {

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The farthest of all points where three planes meet that are in all half-spaces.
std::optional<double> farthest_vertex(const std::vector<tape::HalfSpace>& all, const Vec3& direction) {
    std::optional<double> best;
    for (std::size_t a = 0; a < all.size(); ++a) {
        for (std::size_t b = a + 1; b < all.size(); ++b) {
            for (std::size_t c = b + 1; c < all.size(); ++c) {
                const Vec3 bc = cross(all[b].normal, all[c].normal);
                const Vec3 ca = cross(all[c].normal, all[a].normal);
                const Vec3 ab = cross(all[a].normal, all[b].normal);
                const double volume = dot(all[a].normal, bc);
                if (std::fabs(volume) < 1e-9) continue;
                Vec3 x{};
                for (std::size_t j = 0; j < 3; ++j) {
                    x[j] = (all[a].offset * bc[j] + all[b].offset * ca[j] + all[c].offset * ab[j]) / volume;
                }
                bool inside = true;
                for (const tape::HalfSpace& plane : all)
                    inside = inside && dot(plane.normal, x) <= plane.offset + 1e-7;
                if (inside) best = std::max(best.value_or(-1e300), dot(direction, x));
            }
        }
    }
    return best;
}

Vec3 random_direction(RandomSource& random) {
    Vec3 n{};
    double length = 0;
    while (length < 0.1) {
        for (double& x : n) x = random.uniform(-1, 1);
        length = std::sqrt(dot(n, n));
    }
    for (double& x : n) x /= length;
    return n;
}

bool is_empty(const Box3& box) { return box.min[0] > box.max[0]; }

bool holds(const Box3& box, const Vec3& at) {
    bool inside = true;
    for (std::size_t j = 0; j < 3; ++j) inside = inside && box.min[j] <= at[j] && at[j] <= box.max[j];
    return inside;
}

Box3 convex_bounds_of(const Model& model) { return tape::convex_bounds(tape::compile(model)); }

}  // namespace

TEST_CASE("the farthest point is the farthest vertex") {
    std::size_t bounded = 0, impossible = 0;
    for (std::uint64_t seed = 1; seed <= 600; ++seed) {
        CAPTURE(seed);
        RandomSource random(seed);
        std::vector<tape::HalfSpace> all;
        const int count = random.integer(1, 14);
        // Every third set has parallel planes and several through one point.
        for (int i = 0; i < count; ++i) {
            const bool again = seed % 3 == 0 && i > 0 && random.chance(0.4);
            Vec3 normal = again ? all.back().normal : random_direction(random);
            if (again && random.chance(0.5)) {
                for (double& n : normal) n = -n;
            }
            all.push_back({normal, seed % 3 == 0 && random.chance(0.5) ? 0.5 : random.uniform(-0.4, 1)});
        }
        const Vec3 direction = random_direction(random);
        const std::optional<Vec3> end = tape::farthest(all, direction);
        // The cube makes vertices of what has no end.
        for (std::size_t j = 0; j < 3; ++j) {
            for (const double sign : {-1.0, 1.0}) {
                Vec3 axis{};
                axis[j] = sign;
                all.push_back({axis, tape::kFarthest});
            }
        }
        const std::optional<double> expected = farthest_vertex(all, direction);
        REQUIRE(end.has_value() == expected.has_value());
        if (!end) {
            ++impossible;
            continue;
        }
        const double reached = dot(direction, *end);
        if (std::fabs(*expected) < 100) ++bounded;
        CHECK(std::fabs(reached - *expected) <= 1e-6 * std::max(1.0, std::fabs(*expected)));
        for (const tape::HalfSpace& plane : all)
            CHECK(dot(plane.normal, *end) <= plane.offset + 1e-6 * std::max(1.0, std::fabs(reached)));
    }
    CHECK(bounded >= 150);
    CHECK(impossible >= 50);
}

TEST_CASE("boxes by linear programs hold the solids") {
    std::size_t finite = 0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        CAPTURE(seed);
        const RandomModel source = seed % 5 == 0 ? make_random_hulls(seed) : make_random_model(seed);
        tape::CompiledModel compiled;
        Box3 known;
        try {
            compiled = tape::compile(source.model);
            known = tape::find_bounds(compiled, "model.csg");
        } catch (const Error&) {
            continue;  // empty
        }
        const Box3 box = tape::convex_bounds(compiled);
        REQUIRE(!is_empty(box));
        RandomSource random(seed);
        bool is_finite = true;
        for (std::size_t j = 0; j < 3; ++j) is_finite = is_finite && box.max[j] - box.min[j] < 1e100;
        if (is_finite) ++finite;
        for (int i = 0; i < 1000; ++i) {
            Vec3 at{};
            for (std::size_t j = 0; j < 3; ++j)
                at[j] = known.min[j] + random.uniform(-0.01, 1.01) * (known.max[j] - known.min[j]);
            if (!holds(box, at)) CHECK(region_at(source.model, at) == 0);
        }
    }
    CHECK(finite >= 150);
}

TEST_CASE("boxes by linear programs are tight at flat sides and see what has no end") {
    const Affine tilt = compose(scaling({1, 1.4, 0.4}), rotation({1, 2, 0.5}, 1.1));
    const auto tilted = [&](auto add) {
        Model model;
        add_region(model, model.add_transform(tilt, add(model)), "part");
        return model;
    };
    const Box3 cube = convex_bounds_of(tilted([](Model& model) {
        return add_box(model, {-1, -2, 0}, {3, 1, 2});
    }));
    Box3 expected{{1e9, 1e9, 1e9}, {-1e9, -1e9, -1e9}};
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 at = apply(tilt, {(corner & 1) != 0 ? 3.0 : -1.0, (corner & 2) != 0 ? 1.0 : -2.0,
                                     (corner & 4) != 0 ? 2.0 : 0.0});
        for (std::size_t j = 0; j < 3; ++j) {
            expected.min[j] = std::min(expected.min[j], at[j]);
            expected.max[j] = std::max(expected.max[j], at[j]);
        }
    }
    for (std::size_t j = 0; j < 3; ++j) {
        const double room = 0.01 * (expected.max[j] - expected.min[j]);
        CHECK(cube.min[j] <= expected.min[j]);
        CHECK(cube.max[j] >= expected.max[j]);
        CHECK(cube.min[j] >= expected.min[j] - room);
        CHECK(cube.max[j] <= expected.max[j] + room);
    }
    // A double cone between two planes; without one of them it has no end.
    const auto cone_box = [&](bool cut) {
        return convex_bounds_of(tilted([cut](Model& model) {
            Primitive cone;
            cone.kind = Primitive::Kind::kDoubleCone;
            cone.slope = 0.5;
            Primitive planes;
            planes.planes.push_back({{0, 0, 1}, 3, ""});
            if (cut) planes.planes.push_back({{0, 0, -1}, 2, ""});
            return intersect(model, {model.add_primitive(cone), model.add_primitive(planes)});
        }));
    };
    const Box3 cut = cone_box(true);
    for (std::size_t j = 0; j < 3; ++j) CHECK(cut.max[j] - cut.min[j] < 10);
    const Box3 endless = cone_box(false);
    CHECK(std::isinf(endless.max[0] - endless.min[0]));
    // Two half-spaces that have no point in common.
    CHECK(is_empty(convex_bounds_of(tilted([](Model& model) {
        Primitive apart;
        apart.planes = {{{0, 0, 1}, -1, ""}, {{0, 0, -1}, -1, ""}};
        return model.add_primitive(apart);
    }))));
}

/// Random model 70267: its flat parts fill so many cells that bisection ended before it saw them end.
TEST_CASE("a flat cone and a plate, tilted, have a box") {
    Model model;
    Primitive flat;  // nine times as wide as high
    flat.kind = Primitive::Kind::kCone;
    flat.radius = -36;
    flat.slope = -9;
    Primitive ends;
    ends.planes = {{{0, 0, -1}, 5, ""}, {{0, 0, 1}, -4, ""}};
    const NodeIndex cone = intersect(model, {model.add_primitive(flat), model.add_primitive(ends)});
    const Affine tilt = {0.0964, -1.465, 0.0005, 0, 0.3727, 0.0467, 0.3912, 0, -1.016, -0.1219, 0.1435, 0};
    add_region(model, model.add_transform(tilt, unite(model, {cone, add_box(model, {0, -9, -9}, {9, 9, 9})})),
               "pair");
    const Box3 box = tape::find_bounds(tape::compile(model), "model.csg");
    for (std::size_t j = 0; j < 3; ++j) CHECK(box.max[j] - box.min[j] < 40);
    RandomSource random(3);
    for (int i = 0; i < 5000; ++i) {
        Vec3 at{};
        for (double& x : at) x = random.uniform(-40, 40);
        if (!holds(box, at)) CHECK(region_at(model, at) == 0);
    }
}
