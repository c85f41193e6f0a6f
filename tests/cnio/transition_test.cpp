// Templates of transition cells, for all patterns of split faces and edges: positive plane-faced elements
// that fill the cube, whose outer facets are the meshes of the cube's faces.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "host/cnio/transition.hpp"
#include "host/quality/jacobian.hpp"
#include "host/quality/shape.hpp"
#include "host/templates/transition.hpp"

using namespace mortise;

namespace {

ElementType type_of(int count) {
    return count == 8   ? ElementType::kHexahedron
           : count == 6 ? ElementType::kWedge
           : count == 5 ? ElementType::kPyramid
                        : ElementType::kTetrahedron;
}

using Loop = std::vector<int>;

/// A facet's nodes from the lowest on, in their order: opposite sides have opposite loops.
Loop loop_of(const Loop& nodes) {
    Loop loop = nodes;
    std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
    return loop;
}
Loop reversed(Loop loop) {
    std::reverse(loop.begin() + 1, loop.end());
    return loop;
}

bool is_plane(const Loop& loop) {
    if (loop.size() == 3) return true;
    int edge[3][3];
    const GridPoint origin = grid_point(loop[0]);
    for (int i = 0; i < 3; ++i) {
        const GridPoint p = grid_point(loop[static_cast<std::size_t>(i + 1)]);
        for (std::size_t j = 0; j < 3; ++j) edge[i][j] = p[j] - origin[j];
    }
    return edge[0][0] * (edge[1][1] * edge[2][2] - edge[1][2] * edge[2][1]) -
               edge[0][1] * (edge[1][0] * edge[2][2] - edge[1][2] * edge[2][0]) +
               edge[0][2] * (edge[1][0] * edge[2][1] - edge[1][1] * edge[2][0]) ==
           0;
}

}  // namespace

TEST_CASE("transition cells: every pattern is filled, within the limits, by no more elements than the cone") {
    std::vector<cnio::TransitionElement> elements;
    std::size_t patterns = 0;
    std::size_t total = 0;
    std::size_t in_cones = 0;
    quality::ShapeFigures worst;
    for (SplitPattern pattern = 0; pattern < 1u << kSplitBits; ++pattern) {
        cnio::transition_elements(pattern, elements);
        CAPTURE(pattern);
        if (!is_split_pattern(pattern)) {
            CHECK(elements.empty());
            continue;
        }
        ++patterns;
        REQUIRE(!elements.empty());
        std::map<Loop, int> open;  // facets of one element, outward
        double volume = 0;
        for (const cnio::TransitionElement& element : elements) {
            const ElementType type = type_of(element.count);
            quality::Corners corners;
            for (std::size_t i = 0; i < static_cast<std::size_t>(element.count); ++i) {
                const GridPoint p = grid_point(element.node[i]);
                corners.p[i] = {double(p[0]), double(p[1]), double(p[2])};
            }
            const quality::JacobianFigures jacobian = quality::jacobian_figures(type, corners);
            CHECK(jacobian.positive);
            volume += jacobian.volume;
            const quality::ShapeFigures shape = quality::shape_figures(type, corners);
            worst.scaled_jacobian = std::min(worst.scaled_jacobian, shape.scaled_jacobian);
            worst.min_cosine = std::min(worst.min_cosine, shape.min_cosine);
            worst.max_cosine = std::max(worst.max_cosine, shape.max_cosine);
            const LocalFaces faces = local_faces(type);
            for (int f = 0; f < faces.count; ++f) {
                Loop loop;
                for (const int n : faces.faces[f]) {
                    if (n >= 0) loop.push_back(element.node[static_cast<std::size_t>(n)]);
                }
                loop = loop_of(loop);
                CHECK(is_plane(loop));
                if (open.erase(reversed(loop)) == 0) CHECK(++open[loop] == 1);
            }
        }
        CHECK(std::abs(volume - 8) < 1e-12);
        const auto facets = templates::transition_facets(pattern);
        CHECK(open.size() == facets.size());
        for (const templates::TransitionElement& facet : facets) {
            Loop loop(facet.node.begin(), facet.node.begin() + facet.count);
            CHECK(open.count(loop_of(loop)) == 1);
        }
        CHECK(elements.size() <= facets.size());
        total += elements.size();
        in_cones += facets.size();
    }
    CHECK(worst.scaled_jacobian >= templates::kTransitionScaledJacobian);
    CHECK(worst.max_cosine <= std::cos(templates::kTransitionSmallestAngle * 0.017453292519943295));
    CHECK(worst.min_cosine >= std::cos(templates::kTransitionLargestAngle * 0.017453292519943295));
    MESSAGE(patterns << " patterns, " << total << " elements instead of " << in_cones
                     << "; worst scaled Jacobian " << worst.scaled_jacobian << ", cosines of dihedral angles "
                     << worst.min_cosine << " to " << worst.max_cosine);
}

TEST_CASE("transition cells: the commonest classes") {
    const auto count = [](SplitPattern pattern) {
        std::vector<cnio::TransitionElement> elements;
        cnio::transition_elements(pattern, elements);
        return elements.size();
    };
    const auto faces = [](std::initializer_list<int> split) {
        SplitPattern pattern = 0;
        for (const int f : split) {
            pattern |= 1u << (12 + f);
            for (int e = 0; e < 12; ++e) {
                if (grid_point(edge_middle(e))[static_cast<std::size_t>(f / 2)] == 2 * (f & 1))
                    pattern |= 1u << e;
            }
        }
        return pattern;
    };
    CHECK(count(0) == 1);
    CHECK(count(1) == 10);                         // one edge
    CHECK(count(faces({0})) == 17);                // one face
    CHECK(count(faces({0, 1})) == 4);              // two opposite faces: four hexahedra
    CHECK(count(faces({0, 2})) == 20);             // two faces that meet
    CHECK(count(faces({0, 2, 4})) == 24);          // three around a corner
    CHECK(count(faces({0, 1, 2, 3, 4, 5})) == 8);  // all
}
