// The bound that decides how far edges may be curved, against the check's own shape functions at 189 points.
#include <array>
#include <cmath>

#include <doctest/doctest.h>

#include "host/common/element_jacobian.hpp"
#include "host/quality/curved.hpp"
#include "host/second_order/jacobian_bound.hpp"
#include "tests/mesher/random_source.hpp"
#include "tests/quality/sample_meshes.hpp"

namespace mortise::second_order {
namespace {

/// An element with random corners near those of the reference and random curves.
struct Bent {
    ElementType type;
    std::array<Vec3, 8> corners{};
    std::array<Vec3, 12> displacements{};

    Bent(ElementType t, test::RandomSource& random, double corner_noise, double bend) : type(t) {
        const Mesh unit = samples::unit_element(t);
        const auto noise = [&](double size) {
            return Vec3{random.uniform(-size, size), random.uniform(-size, size),
                        random.uniform(-size, size)};
        };
        for (std::size_t n = 0; n < unit.node_count(); ++n) {
            const Vec3 moved = noise(corner_noise);
            for (std::size_t j = 0; j < 3; ++j) corners[n][j] = unit.points[3 * n + j] + moved[j];
        }
        const LocalEdges edges = local_edges(t);
        for (int e = 0; e < edges.count; ++e) {
            // Some stay straight, as most edges of a mesh do.
            if (random.chance(0.6)) displacements[static_cast<std::size_t>(e)] = noise(bend);
        }
    }

    quality::JacobianFigures sampled() const {
        quality::Corners points;
        quality::Middles middles;
        const auto vector = [](const Vec3& v) { return quality::Vector{v[0], v[1], v[2]}; };
        for (std::size_t n = 0; n < 8; ++n) points.p[n] = vector(corners[n]);
        const LocalEdges edges = local_edges(type);
        for (int e = 0; e < edges.count; ++e) {
            const auto i = static_cast<std::size_t>(e);
            middles.p[i] =
                0.5 * (points.p[edges.edges[e][0]] + points.p[edges.edges[e][1]]) + vector(displacements[i]);
        }
        return quality::curved_figures(type, points, middles);
    }
};

constexpr std::array<ElementType, 4> kTypes = {ElementType::kHexahedron, ElementType::kWedge,
                                               ElementType::kPyramid, ElementType::kTetrahedron};

/// The check's pyramid has a base of area 4, not 1.
double scale_of(ElementType type) { return type == ElementType::kPyramid ? 4 : 1; }

}  // namespace

TEST_CASE("the bound lies below all samples and close to the lowest") {
    for (const ElementType type : kTypes) {
        test::RandomSource random(7 + static_cast<std::uint64_t>(type));
        double widest = 0;
        int positive = 0;
        for (int i = 0; i < 2000; ++i) {
            const Bent bent(type, random, 0.2, 0.05);
            const double bound = least_jacobian(type, bent.corners.data(), bent.displacements.data());
            const double lowest = scale_of(type) * bent.sampled().minimum;
            CHECK(bound <= lowest + 1e-12);
            widest = std::max(widest, lowest - bound);
            positive += bound > 0;
        }
        CAPTURE(static_cast<int>(type));
        CHECK(widest < 0.6);  // of an element of Jacobian 1; a bound of minus infinity would be one, too
        CHECK(positive > 400);
    }
}

TEST_CASE("straight edges: the bound is that of the corners") {
    for (const ElementType type : kTypes) {
        test::RandomSource random(31);
        for (int i = 0; i < 500; ++i) {
            const Bent bent(type, random, 0.25, 0);
            const double straight = least_straight_jacobian(type, bent.corners.data());
            const std::array<Vec3, 12> none{};
            const double general = least_jacobian(type, bent.corners.data(), none.data());
            CHECK(straight <= scale_of(type) * bent.sampled().minimum + 1e-12);
            if (type == ElementType::kTetrahedron || type == ElementType::kPyramid)
                CHECK(general == doctest::Approx(straight).epsilon(1e-9));
            else
                CHECK(general >= straight - 1e-12);  // of a higher degree, so closer
        }
    }
}

TEST_CASE("the short test of tetrahedra passes none that the samples refuse") {
    test::RandomSource random(5);
    int passed = 0;
    for (int i = 0; i < 5000; ++i) {
        const Bent bent(ElementType::kTetrahedron, random, 0.2, 0.03);
        if (!is_surely_valid(bent.corners.data(), bent.displacements.data(), 0.2)) continue;
        ++passed;
        const double straight = least_straight_jacobian(ElementType::kTetrahedron, bent.corners.data());
        CHECK(bent.sampled().minimum >= 0.2 * straight);
    }
    CHECK(passed > 500);
}

}  // namespace mortise::second_order
