// Local formulas of polyhedra against winding numbers, and patches against their definition.
#include <doctest/doctest.h>

#include <cmath>

#include "host/tape/reference.hpp"
#include "host/triangles/divide.hpp"
#include "host/triangles/winding.hpp"
#include "tests/mesher/random_source.hpp"
#include "tests/mesher/solids.hpp"
#include "tests/model/membership.hpp"
#include "tests/tape/bound_models.hpp"
#include "tests/triangles/shapes.hpp"

namespace mortise::test {
namespace {

/// Random points where the divided model and the membership oracle differ; points within `margin` of a change
/// of the oracle's answer do not count.
int count_differences(const Model& model, int level, int points, double margin, std::uint64_t seed) {
    tape::BoundModel bound = bind_model(model, level);
    triangles::divide(bound, level, level, 2);
    RandomSource random(seed);
    int differences = 0;
    for (int i = 0; i < points; ++i) {
        const Vec3 local = {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
        const Vec3 x = to_model(bound, local);
        const auto expected = static_cast<std::int32_t>(region_at(model, x));
        if (tape::region_at(bound, local[0], local[1], local[2]) == expected) continue;
        bool near = false;
        for (int axis = 0; axis < 3 && !near; ++axis) {
            for (const double step : {-margin, margin}) {
                Vec3 y = x;
                y[static_cast<std::size_t>(axis)] += step;
                near = near || static_cast<std::int32_t>(region_at(model, y)) != expected;
            }
        }
        if (!near) ++differences;
    }
    return differences;
}

double distance_to_triangles(const TriangleSurface& surface, const Vec3& x) {
    // By sampling each triangle finely: an upper bound that converges, independent of closest-point formulas.
    constexpr int kSteps = 24;
    double least = 1e300;
    for (const auto& t : surface.triangles) {
        for (int i = 0; i <= kSteps; ++i) {
            for (int k = 0; i + k <= kSteps; ++k) {
                double squared = 0;
                for (std::size_t j = 0; j < 3; ++j) {
                    const double a = static_cast<double>(i) / kSteps;
                    const double b = static_cast<double>(k) / kSteps;
                    const double p = (1 - a - b) * surface.points[t[0]][j] + a * surface.points[t[1]][j] +
                                     b * surface.points[t[2]][j];
                    squared += (p - x[j]) * (p - x[j]);
                }
                least = std::min(least, squared);
            }
        }
    }
    return std::sqrt(least);
}

}  // namespace

TEST_CASE("exact formulas: the L block, mirrored and turned") {
    for (const Affine& map : {kIdentity, scaling({-1, 1, 2}), rotation({1, 2, 3}, 0.7)}) {
        const Model model = solid_of(l_block(), 0, map);
        for (const int level : {1, 3, 5}) {
            CAPTURE(level);
            CHECK(count_differences(model, level, 4000, 1e-9, 7) == 0);
        }
    }
}

TEST_CASE("exact formulas: random stars, alone and in set operations") {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        CAPTURE(seed);
        Model model = solid_of(random_star(seed, 1, 0.4, 1.6), 0);
        if (seed % 3 == 1) {
            const auto ball = add_ball(model, {0.3, 0.2, 0.1}, 0.7);
            model.regions[0].root = subtract(model, {ball, model.regions[0].root});
        } else if (seed % 3 == 2) {
            const auto box = add_box(model, {-0.5, -0.6, -0.7}, {0.8, 0.9, 1.0});
            model.regions[0].root = subtract(model, {model.regions[0].root, box});
        }
        CHECK(count_differences(model, 4, 4000, 1e-6, seed) == 0);
    }
}

TEST_CASE("open and overlapping surfaces: the winding number decides") {
    // One triangle of 512 missing; and two blocks that overlap, as one soup.
    TriangleSurface open = unit_sphere(3);
    open.triangles.erase(open.triangles.begin() + 100);
    CHECK(count_differences(solid_of(open, 0), 4, 3000, 0.02, 3) == 0);
    TriangleSurface soup = l_block();
    const TriangleSurface other = prism({{-1, -1}, {2, -1}, {2, 2}, {-1, 2}}, 0.5);
    for (auto t : other.triangles) {
        for (auto& corner : t) corner += static_cast<std::uint32_t>(soup.points.size());
        soup.triangles.push_back(t);
    }
    soup.points.insert(soup.points.end(), other.points.begin(), other.points.end());
    CHECK(count_differences(solid_of(soup, 0), 5, 4000, 1e-6, 4) == 0);
}

TEST_CASE("the division does not depend on threads, and pays no heed to what is far") {
    const Model model = solid_of(random_star(5, 2, 0.7, 1.3), 0);
    tape::BoundModel one = bind_model(model, 5);
    tape::BoundModel four = one;
    triangles::divide(one, 5, 5, 1);
    triangles::divide(four, 5, 5, 4);
    CHECK(one.spatial == four.spatial);
    CHECK(one.tape == four.tape);
    // A cube's few planes are one formula at the root: eight entries, no node below.
    tape::BoundModel cube = bind_model(solid_of(prism({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, 1), 0), 6);
    CHECK(triangles::divide(cube, 6, 6, 1).nodes == 1);
}

TEST_CASE("bounds beside polyhedra are found where surfaces do not tell") {
    Model model = solid_of(l_block(), 0);
    CsgNode turned;  // a cylinder whose caps lie along no axis
    turned.op = CsgNode::Op::kTransform;
    turned.map = rotation({1, 2, 3}, 0.7);
    turned.children = {add_cylinder(model, 0.5, -4, 4)};
    const auto cylinder = model.add(turned);
    model.regions[0].root = unite(model, {model.regions[0].root, cylinder});
    const Box3 box = tape::find_bounds(tape::compile(model), "test");
    for (std::size_t j = 0; j < 3; ++j) {
        CHECK(box.max[j] - box.min[j] > 3);
        CHECK(box.max[j] - box.min[j] < 9);
    }
}

TEST_CASE("winding numbers of a closed surface are whole") {
    const TriangleSurface star = random_star(9, 3, 0.8, 1.2);
    const triangles::WindingNumber winding(star);
    RandomSource random(2);
    for (int i = 0; i < 2000; ++i) {
        const glm::dvec3 x(random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5));
        const double at = winding.at(x);
        CHECK(std::fabs(at - std::round(at)) < 0.05);
        if (glm::length(x) < 0.6) CHECK(std::round(at) == 1);
        if (glm::length(x) > 1.25) CHECK(std::round(at) == 0);
    }
}

TEST_CASE("a smooth closed surface is one patch: the signed distance") {
    const TriangleSurface star = random_star(11, 2, 0.9, 1.1);
    const Model model = solid_of(star, 90);
    const tape::BoundModel bound = bind_model(model, 5);
    REQUIRE(bound.surfaces.size() == 1);
    REQUIRE(bound.surfaces[0].kind == kSurfacePatch);
    RandomSource random(3);
    for (int i = 0; i < 200; ++i) {
        const Vec3 local = {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
        const Vec3 x = to_model(bound, local);
        const SurfaceSample sample =
            surface_sample(&bound.surfaces[0], bound.expression_ops.data(), local[0], local[1], local[2]);
        const double distance = distance_to_triangles(star, x);
        CHECK(std::fabs(sample.value) <= distance + 1e-12);
        CHECK(std::fabs(sample.value) >= distance - 0.02);
        if (distance > 0.02) CHECK((sample.value < 0) == (region_at(model, x) == 1));
        // The gradient is that of a distance, in model units per box-local unit.
        double length = 0;
        for (const double d : sample.gradient) length += d * d;
        CHECK(std::sqrt(length) == doctest::Approx(bound.side).epsilon(1e-9));
    }
}

TEST_CASE("beyond its rim a patch goes on without a jump") {
    // A round post: caps, and one patch for 32 sides.
    std::vector<std::array<double, 2>> outline;
    for (int i = 0; i < 32; ++i) {
        outline.push_back({std::cos(i * 0.19634954084936207), std::sin(i * 0.19634954084936207)});
    }
    const Model model = solid_of(prism(outline, 2, true), 25);
    const tape::BoundModel bound = bind_model(model, 5);
    REQUIRE(bound.surfaces.size() == 3);
    for (const Surface& surface : bound.surfaces) {
        if (surface.kind != kSurfacePatch) continue;
        // On and beyond the sides, around the whole post, f changes by no more than one goes (and is a
        // distance along the post).
        constexpr int kSteps = 4000;
        for (const double z : {-0.3, -0.1, 0.7, 2.1}) {
            for (const double r : {0.9, 0.99, 1.0, 1.05}) {
                double before = 0;
                for (int i = 0; i <= kSteps; ++i) {
                    const double angle = 2 * std::acos(-1.0) * i / kSteps;
                    const Vec3 x = {r * std::cos(angle), r * std::sin(angle), z};
                    Vec3 local;
                    for (std::size_t j = 0; j < 3; ++j) local[j] = (x[j] - bound.origin[j]) / bound.side;
                    const double value =
                        surface_value(&surface, bound.expression_ops.data(), local[0], local[1], local[2]);
                    if (i > 0) CHECK(std::fabs(value - before) < 0.002);
                    CHECK(std::fabs(value - (r - 1)) < 0.012);
                    before = value;
                }
            }
        }
    }
}

}  // namespace mortise::test
