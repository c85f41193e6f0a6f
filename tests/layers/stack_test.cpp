// Stacks over one facet, for all ways in which corners may be bare; bounds of Jacobians.
#include <array>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include "host/common/element_jacobian.hpp"
#include "host/layers/stack.hpp"
#include "host/quality/jacobian.hpp"
#include "tests/mesher/random_source.hpp"
#include "tests/quality/sample_meshes.hpp"

namespace mortise::layers {
namespace {

constexpr int kLayers = 3;

/// A facet of the unit square on the plane z = 0, with layers below.
WallFacet unit_facet(std::size_t corners) {
    WallFacet facet;
    facet.node = {0, 1, 2, corners == 3 ? NodeId{2} : NodeId{3}};
    return facet;
}

Vec3 place(const StackNode& node) {
    constexpr std::array<std::array<double, 2>, 4> kCorners = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
    return {kCorners[node.corner][0], kCorners[node.corner][1], -0.1 * node.layer};
}

quality::Corners corners_of(const Vec3* points, std::size_t count) {
    quality::Corners corners;
    for (std::size_t k = 0; k < count; ++k) corners.p[k] = {points[k][0], points[k][1], points[k][2]};
    return corners;
}

}  // namespace

TEST_CASE("stacks fill the room below their facet, whichever corners are bare") {
    for (const std::size_t corners : {std::size_t{3}, std::size_t{4}}) {
        for (unsigned pattern = 0; pattern < 1u << corners; ++pattern) {
            CAPTURE(corners);
            CAPTURE(pattern);
            BareCorners bare{};
            for (std::size_t k = 0; k < 4; ++k)
                bare[k] = (pattern >> (k == 3 && corners == 3 ? 2 : k) & 1) != 0;
            double volume = 0;
            int elements = 0;
            for_stack(unit_facet(corners), bare, kLayers, [&](ElementType type, const StackNodes& nodes) {
                const auto count = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(type)]);
                std::array<Vec3, 8> points{};
                for (std::size_t k = 0; k < count; ++k) {
                    points[k] = place(nodes[k]);
                    if (bare[nodes[k].corner]) CHECK(nodes[k].layer == 0);
                }
                CHECK(least_straight_jacobian(type, points.data()) > 0);
                const quality::JacobianFigures figures =
                    quality::jacobian_figures(type, corners_of(points.data(), count));
                CHECK(figures.positive);
                volume += figures.volume;
                ++elements;
            });
            // Triangles of the facet, as it is cut: depth is linear over each.
            const auto depth = [&](std::size_t k) { return bare[k] ? 0.0 : 0.1 * kLayers; };
            double expected = (depth(0) + depth(1) + depth(2)) / 6;
            if (corners == 4) {
                const auto cut = cut_of(unit_facet(4), bare);
                const std::size_t a = cut.value_or(0);
                const auto at = [&](std::size_t k) { return depth((a + k) % 4); };
                expected = (at(0) + at(1) + at(2)) / 6 + (at(0) + at(2) + at(3)) / 6;
            }
            CHECK(volume == doctest::Approx(expected).epsilon(1e-12));
            CHECK((elements > 0) == (expected > 0));
        }
    }
}

TEST_CASE("the bound of straight elements lies below the oracle's and tells valid ones") {
    for (int t = 0; t < kElementTypes; ++t) {
        const auto type = static_cast<ElementType>(t);
        const Mesh unit = samples::unit_element(type);
        test::RandomSource random(11 + static_cast<std::uint64_t>(t));
        int positive = 0, agreed = 0;
        for (int i = 0; i < 3000; ++i) {
            std::array<Vec3, 8> points{};
            for (std::size_t n = 0; n < unit.node_count(); ++n) {
                for (std::size_t j = 0; j < 3; ++j)
                    points[n][j] = unit.points[3 * n + j] + random.uniform(-0.35, 0.35);
            }
            const double bound = least_straight_jacobian(type, points.data());
            const bool is_valid =
                quality::jacobian_figures(type, corners_of(points.data(), unit.node_count())).positive;
            if (bound > 0) CHECK(is_valid);
            positive += is_valid;
            agreed += is_valid && bound > 0;
        }
        CAPTURE(t);
        CHECK(positive > 500);
        CHECK(agreed > 0.8 * positive);
    }
}

}  // namespace mortise::layers
