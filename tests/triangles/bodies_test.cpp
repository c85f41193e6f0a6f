// Files that hold several bodies, which cross: their union, as clean as that of single files.
#include <doctest/doctest.h>

#include <cmath>

#include "host/common/constants.hpp"
#include "host/common/vec3.hpp"
#include "host/tape/bodies.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_source.hpp"
#include "tests/triangles/shapes.hpp"

namespace mortise::test {
namespace {

void append(TriangleSurface& soup, TriangleSurface other, const Vec3& by) {
    const auto first = static_cast<std::uint32_t>(soup.points.size());
    for (Vec3 p : other.points) soup.points.push_back({p[0] + by[0], p[1] + by[1], p[2] + by[2]});
    for (auto t : other.triangles) soup.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

TriangleSurface block(double size) { return prism({{0, 0}, {size, 0}, {size, size}, {0, size}}, size); }

/// Around the origin.
TriangleSurface post(int sides, double radius, double height) {
    std::vector<std::array<double, 2>> outline;
    for (int i = 0; i < sides; ++i)
        outline.push_back({radius * std::cos(kTurn * i / sides), radius * std::sin(kTurn * i / sides)});
    return prism(outline, height);
}

TriangleSurface hollow_block() {
    TriangleSurface hollow = block(3);
    TriangleSurface inner = block(1);
    for (auto& t : inner.triangles) std::swap(t[1], t[2]);
    append(hollow, inner, {1, 1, 1});
    return hollow;
}

/// The winding number of a closed surface at a point, by the solid angles of its triangles.
double winding(const TriangleSurface& surface, const Vec3& at) {
    double sum = 0;
    for (const auto& t : surface.triangles) {
        const Vec3 a = difference(surface.points[t[0]], at), b = difference(surface.points[t[1]], at),
                   c = difference(surface.points[t[2]], at);
        const double la = length(a), lb = length(b), lc = length(c);
        sum += 2 * std::atan2(dot(a, cross(b, c)),
                              la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
    }
    return sum / (2 * kTurn);
}

std::size_t parts_of(const TriangleSurface& surface) {
    return tape::split_bodies({surface, std::vector<std::uint32_t>(surface.triangles.size(), 0)}).size();
}

}  // namespace

TEST_CASE("a block and a post through it in one file") {
    for (const int sides : {24, 48, 200}) {
        for (const double along : {5.0, 5.123}) {
            CAPTURE(sides);
            CAPTURE(along);
            TriangleSurface soup = block(10);
            append(soup, post(sides, 2, 20), {along, 4.777, -5});
            const Meshed meshed = mesh_and_check(solid_of(soup, 40), 5);
            CHECK(meshed.defects.empty());
            CHECK(meshed.report.dropped_features == 0);
            CHECK(meshed.report.hinge_edges == 0);
            CHECK(meshed.check.euler_characteristic == 2);
            CHECK(worst_jacobian(meshed.check) > 0.15);
            const double post_area = 0.5 * sides * 4 * std::sin(kTurn / sides);
            CHECK(meshed.check.volume ==
                  doctest::Approx(1000 + 10 * post_area).epsilon(4e-3));  // flat facets
        }
    }
}

TEST_CASE("bodies whose boxes touch are kept apart, in as few parts as that takes") {
    TriangleSurface soup = block(1);
    CHECK(parts_of(soup) == 1);
    append(soup, block(1), {5, 0, 0});
    CHECK(parts_of(soup) == 1);  // far apart
    append(soup, block(1), {0.5, 0.5, 0.5});
    CHECK(parts_of(soup) == 2);
    append(soup, block(1), {5.5, 0.5, 0.5});
    CHECK(parts_of(soup) == 2);
    append(soup, block(1), {0.75, 0.25, 0.6});
    CHECK(parts_of(soup) == 3);
}

TEST_CASE("random rugged bodies that cross: the volume of their union") {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        CAPTURE(seed);
        RandomSource random(seed);
        TriangleSurface soup;
        for (std::uint64_t i = 0; i < 4; ++i)
            append(soup, random_star(10 * seed + i, 1, 0.8, 1.1),
                   {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)});
        REQUIRE(parts_of(soup) > 1);
        const Meshed meshed = mesh_and_check(solid_of(soup, 0), 5);
        CHECK(meshed.defects.empty());
        int inside = 0;
        constexpr int kSamples = 20000;
        for (int i = 0; i < kSamples; ++i) {
            const Vec3 at = {random.uniform(-2.2, 2.2), random.uniform(-2.2, 2.2), random.uniform(-2.2, 2.2)};
            inside += winding(soup, at) > 0.5;
        }
        // Four standard deviations are 2 to 3 %.
        const double volume = std::pow(4.4, 3) * inside / kSamples;
        CHECK(meshed.check.volume == doctest::Approx(volume).epsilon(0.03));
    }
}

TEST_CASE("what is no union of closed bodies stays as it is") {
    CHECK(parts_of(hollow_block()) == 1);
    TriangleSurface open = block(3);
    append(open, block(1), {2.5, 1, 1});
    open.triangles.pop_back();
    CHECK(parts_of(open) == 1);
}

TEST_CASE("a cavity stays hollow, and bodies that only share a face are one solid") {
    CHECK(mesh_and_check(solid_of(hollow_block(), 40), 4).check.volume == doctest::Approx(26));
    TriangleSurface pair = block(2);
    append(pair, block(2), {2, 0, 0});
    const Meshed meshed = mesh_and_check(solid_of(pair, 40), 4);
    CHECK(meshed.defects.empty());
    CHECK(meshed.check.volume == doctest::Approx(16));
    CHECK(meshed.check.components == 1);
}

}  // namespace mortise::test
