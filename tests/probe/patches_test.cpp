// Holes and pins narrower than a cell in solids of triangles, where a patch hides them: the mesh must tell.
// The oracle is the Euler characteristic of the mesh's boundary.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "host/common/vec3.hpp"
#include "host/tape/compile.hpp"
#include "host/tape/patch_bounds.hpp"
#include "host/tape/variation.hpp"
#include "kernels/shared/surface.h"
#include "tests/mesher/meshed.hpp"
#include "tests/tape/bound_models.hpp"
#include "tests/triangles/shapes.hpp"

namespace mortise::test {
namespace {

constexpr std::uint32_t kSides = 24;
constexpr double kSharp = 30;

/// Adds a ring of points around (x, y); returns the number of the first.
std::uint32_t add_ring(TriangleSurface& s, double x, double y, double z, double radius) {
    const auto first = static_cast<std::uint32_t>(s.points.size());
    for (std::uint32_t i = 0; i < kSides; ++i) {
        const double angle = 2 * std::acos(-1.0) * i / kSides;
        s.points.push_back({x + radius * std::cos(angle), y + radius * std::sin(angle), z});
    }
    return first;
}

/// Triangles between two rings; counter-clockwise seen from where `low` is inside, or below.
void add_band(TriangleSurface& s, std::uint32_t low, std::uint32_t high) {
    for (std::uint32_t i = 0; i < kSides; ++i) {
        const std::uint32_t next = (i + 1) % kSides;
        s.triangles.push_back({low + i, low + next, high + next});
        s.triangles.push_back({low + i, high + next, high + i});
    }
}

void add_cap(TriangleSurface& s, double x, double y, double z, std::uint32_t ring) {
    const auto middle = static_cast<std::uint32_t>(s.points.size());
    s.points.push_back({x, y, z});
    for (std::uint32_t i = 0; i < kSides; ++i)
        s.triangles.push_back({middle, ring + i, ring + (i + 1) % kSides});
}

/// A disc of radius 7, in cells of edge 1 at level 4, with a hole through it.
TriangleSurface drilled(double x, double y, double thickness, double radius) {
    TriangleSurface s;
    const std::uint32_t low = add_ring(s, 0, 0, 0, 7), high = add_ring(s, 0, 0, thickness, 7);
    const std::uint32_t low_in = add_ring(s, x, y, 0, radius), high_in = add_ring(s, x, y, thickness, radius);
    add_band(s, low, high);
    add_band(s, high, high_in);
    add_band(s, high_in, low_in);
    add_band(s, low_in, low);
    return s;
}

/// The same disc with a pin on it instead.
TriangleSurface pinned(double x, double y, double thickness, double radius, double height) {
    TriangleSurface s;
    const std::uint32_t low = add_ring(s, 0, 0, 0, 7), high = add_ring(s, 0, 0, thickness, 7);
    const std::uint32_t foot = add_ring(s, x, y, thickness, radius);
    const std::uint32_t top = add_ring(s, x, y, thickness + height, radius);
    add_band(s, low, high);
    add_band(s, high, foot);
    add_band(s, foot, top);
    add_cap(s, x, y, thickness + height, top);
    const std::size_t bottom = s.triangles.size();
    add_cap(s, 0, 0, 0, low);
    for (std::size_t t = bottom; t < s.triangles.size(); ++t) std::swap(s.triangles[t][1], s.triangles[t][2]);
    return s;
}

bool tells(const MeshReport& report) {
    for (const MissedFeature& feature : report.missed) {
        if (!feature.kept) return true;
    }
    return report.hinge_edges + report.hinge_nodes > 0;
}

struct Count {
    int wrong = 0, silent = 0, alarms = 0;

    void add(const TriangleSurface& surface, std::int64_t characteristic, bool is_lost_volume) {
        MeshOptions options;
        options.level = 4;
        const Meshed result = mesh_and_check(solid_of(surface, kSharp), options);
        CHECK(result.defects == "");
        const bool is_wrong = result.check.euler_characteristic != characteristic;
        wrong += is_wrong ? 1 : 0;
        silent += is_wrong && !tells(result.report) ? 1 : 0;
        alarms += !is_wrong && !is_lost_volume && tells(result.report) ? 1 : 0;
    }
};

}  // namespace

TEST_CASE("holes narrower than a cell in solids of triangles are kept or told of") {
    std::mt19937 random(2);
    const auto between = [&random](double low, double high) {
        return std::uniform_real_distribution<>(low, high)(random);
    };
    Count holes;
    for (const double radius : {0.15, 0.25, 0.35, 0.45, 0.7, 1.3}) {
        for (int k = 0; k < 8; ++k) {
            CAPTURE(radius);
            CAPTURE(k);
            holes.add(drilled(between(-4, 4), between(-4, 4), between(0.5, 2), radius), 0, false);
        }
    }
    MESSAGE(holes.wrong, " of 48 holes are closed, ", holes.silent, " silently; ", holes.alarms,
            " are right and told of");
    CHECK(holes.wrong > 8);
    CHECK(holes.silent == 0);
    CHECK(holes.alarms <= 2);
}

TEST_CASE("pins narrower than a cell on solids of triangles are kept or told of") {
    std::mt19937 random(3);
    const auto between = [&random](double low, double high) {
        return std::uniform_real_distribution<>(low, high)(random);
    };
    Count pins;
    for (const double radius : {0.15, 0.25, 0.35, 0.45, 0.7, 1.3}) {
        for (int k = 0; k < 6; ++k) {
            CAPTURE(radius);
            CAPTURE(k);
            // One that is gone altogether leaves the characteristic as it is.
            pins.add(pinned(between(-4, 4), between(-4, 4), 1.3, radius, between(2, 4)), 2, radius < 0.5);
        }
    }
    MESSAGE(pins.wrong, " of 36 pins are torn, ", pins.silent, " silently; ", pins.alarms,
            " are right and told of");
    CHECK(pins.wrong > 3);
    CHECK(pins.silent == 0);
    CHECK(pins.alarms == 0);
}

TEST_CASE("bounds of a patch hold in cells of all sizes") {
    const TriangleSurface star = random_star(5, 3, 0.8, 1.2);
    const tape::BoundModel bound = bind_model(solid_of(star, 90), 5);
    REQUIRE(bound.surfaces.size() == 1);
    REQUIRE(bound.surfaces[0].kind == kSurfacePatch);
    const auto sample = [&bound](const Vec3& x) {
        return surface_sample(&bound.surfaces[0], bound.expression_ops.data(), x[0], x[1], x[2]);
    };
    std::mt19937 random(7);
    std::uniform_real_distribution<> unit(0, 1);
    int decided = 0, met = 0, steady = 0;
    for (int i = 0; i < 600; ++i) {
        const tape::Cell cell = {{unit(random), unit(random), unit(random)}, std::ldexp(0.5, -2 - i % 5)};
        const int sign = tape::classify_patch(bound, 0, cell);
        const tape::PatchState state = tape::patch_in(bound, 0, cell);
        const bool meets = state != tape::PatchState::kAbsent;
        decided += sign != 0 ? 1 : 0;
        met += meets ? 1 : 0;
        steady += state == tape::PatchState::kSteady ? 1 : 0;
        CHECK(tape::has_small_variation(bound, 0, cell) == (state != tape::PatchState::kTurning));
        if (sign != 0) CHECK(!meets);
        std::vector<Vec3> normals;
        for (int k = 0; k < 200; ++k) {
            Vec3 x{};
            for (std::size_t j = 0; j < 3; ++j) x[j] = cell.centre[j] + cell.half * (2 * unit(random) - 1);
            const SurfaceSample here = sample(x);
            if (sign != 0) CHECK((here.value < 0) == (sign < 0));
            // Where a point lies as good as on a triangle, the gradient is its normal.
            const double step = here.value / (bound.side * bound.side);
            for (std::size_t j = 0; j < 3; ++j) x[j] -= step * here.gradient[j];
            bool is_in_cell = true;
            for (std::size_t j = 0; j < 3; ++j)
                is_in_cell = is_in_cell && std::fabs(x[j] - cell.centre[j]) < cell.half * 0.999;
            if (!is_in_cell || std::fabs(here.value) > cell.half * bound.side) continue;
            const SurfaceSample there = sample(x);
            if (std::fabs(there.value) > 1e-9) continue;
            REQUIRE(meets);
            normals.push_back({there.gradient[0] / bound.side, there.gradient[1] / bound.side,
                               there.gradient[2] / bound.side});
        }
        if (state != tape::PatchState::kSteady) continue;
        for (const Vec3& normal : normals) CHECK(dot(normal, normals.front()) > -0.03);
    }
    CHECK(decided > 100);
    CHECK(met > 100);
    CHECK(steady > 50);
}

}  // namespace mortise::test
