// Transition cells: meshes of their faces, measures of elements, the table's text.
#include "host/templates/transition.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "host/common/constants.hpp"
#include "host/common/vec3.hpp"
#include "kernels/shared/corners.h"
#include "kernels/shared/lattice.h"
#include "mortise/mesh.hpp"

namespace mortise::templates {
namespace {

using Vector = std::array<double, 3>;

Vector between(std::uint8_t from, std::uint8_t to) {
    const GridPoint a = grid_point(from);
    const GridPoint b = grid_point(to);
    return {double(b[0] - a[0]), double(b[1] - a[1]), double(b[2] - a[2])};
}

/// A corner and the ends of its three edges, right-handed; by type.
#define MORTISE_CORNER(node, first, second, third) {node, first, second, third},
constexpr int kCornersOf[4][8][4] = {{MORTISE_HEXAHEDRON_CORNERS(MORTISE_CORNER)},
                                     {MORTISE_WEDGE_CORNERS(MORTISE_CORNER)},
                                     {MORTISE_PYRAMID_CORNERS(MORTISE_CORNER)},
                                     {MORTISE_TETRAHEDRON_CORNERS(MORTISE_CORNER)}};
#undef MORTISE_CORNER
constexpr int kCornerCount[4] = {8, 6, 4, 4};

std::size_t type_of(int count) { return count == 8 ? 0 : count == 6 ? 1 : count == 5 ? 2 : 3; }

double angle(const Vector& first_normal, const Vector& second_normal) {
    const double cosine = -dot(first_normal, second_normal) /
                          std::sqrt(dot(first_normal, first_normal) * dot(second_normal, second_normal));
    return std::acos(std::clamp(cosine, -1.0, 1.0)) * kDegrees;
}

/// The mesh of one face, as Cell::partition_face makes it; in the face's frame.
void add_face(int f, SplitPattern pattern, std::vector<TransitionElement>& facets) {
    const auto axis = static_cast<std::size_t>(f / 2);
    const auto u_axis = static_cast<std::size_t>(first_other(f / 2));
    const auto v_axis = static_cast<std::size_t>(second_other(f / 2));
    const auto at = [&](int u, int v) {
        GridPoint p{};
        p[axis] = 2 * (f & 1);
        p[u_axis] = u;
        p[v_axis] = v;
        return grid_vertex(p);
    };
    const auto quad = [&facets](std::uint8_t a, std::uint8_t b, std::uint8_t c, std::uint8_t d) {
        facets.push_back({4, {a, b, c, d}});
    };
    const auto triangle = [&facets](std::uint8_t a, std::uint8_t b, std::uint8_t c) {
        facets.push_back({3, {a, b, c}});
    };
    if (((pattern >> (12 + f)) & 1) != 0) {
        for (int v = 0; v < 2; ++v) {
            for (int u = 0; u < 2; ++u) quad(at(u, v), at(u + 1, v), at(u + 1, v + 1), at(u, v + 1));
        }
        return;
    }
    const std::uint8_t corner[4] = {at(0, 0), at(2, 0), at(2, 2), at(0, 2)};
    const std::uint8_t middle[4] = {at(1, 0), at(2, 1), at(1, 2), at(0, 1)};
    unsigned sides = 0;
    for (int e = 0; e < 12; ++e) {
        if (((pattern >> e) & 1) == 0) continue;
        for (unsigned i = 0; i < 4; ++i) {
            if (edge_middle(e) == middle[i]) sides |= 1u << i;
        }
    }
    for (const SplitFacet& facet : split_face(sides)) {
        const auto node = [&](std::size_t k) {
            const std::uint8_t place = facet.place[k];
            return place < 4 ? corner[place] : middle[place - 4];
        };
        if (facet.count == 3)
            triangle(node(0), node(1), node(2));
        else
            quad(node(0), node(1), node(2), node(3));
    }
}

}  // namespace

std::vector<TransitionElement> transition_facets(SplitPattern pattern) {
    std::vector<TransitionElement> facets;
    for (int f = 0; f < 6; ++f) {
        const std::size_t before = facets.size();
        add_face(f, pattern, facets);
        // The frames (y, z), (x, z), (x, y): right-handed with the axis, but for y.
        const bool outward = (f / 2 != 1) == ((f & 1) != 0);
        for (std::size_t i = before; i < facets.size() && !outward; ++i)
            std::reverse(facets[i].node.begin(), facets[i].node.begin() + facets[i].count);
    }
    return facets;
}

std::vector<TransitionElement> transition_cone(SplitPattern pattern) {
    std::vector<TransitionElement> cone = transition_facets(pattern);
    for (TransitionElement& element : cone) {
        std::reverse(element.node.begin(), element.node.begin() + element.count);
        element.node[element.count++] = kGridCentre;
    }
    return cone;
}

TransitionFigures transition_figures(const TransitionElement& element) {
    TransitionFigures figures;
    const std::size_t type = type_of(element.count);
    for (int i = 0; i < kCornerCount[type]; ++i) {
        const int* corner = kCornersOf[type][i];
        const auto edge = [&](int k) {
            return between(element.node[static_cast<std::size_t>(corner[0])],
                           element.node[static_cast<std::size_t>(corner[k])]);
        };
        const Vector a = edge(1), b = edge(2), c = edge(3);
        const Vector ab = cross(a, b), bc = cross(b, c), ca = cross(c, a);
        figures.scaled_jacobian =
            std::min(figures.scaled_jacobian, dot(ab, c) / std::sqrt(dot(a, a) * dot(b, b) * dot(c, c)));
        for (const double degrees : {angle(ab, ca), angle(ab, bc), angle(bc, ca)}) {
            figures.smallest_angle = std::min(figures.smallest_angle, degrees);
            figures.largest_angle = std::max(figures.largest_angle, degrees);
        }
    }
    const LocalFaces faces = local_faces(static_cast<ElementType>(type));
    double volume = 0;
    for (int f = 0; f < faces.count; ++f) {
        const LocalFace& face = faces.faces[f];
        const auto from_first = [&](int i) {
            return between(element.node[0],
                           element.node[static_cast<std::size_t>(face[static_cast<std::size_t>(i)])]);
        };
        for (int i = 1; i < (face[3] < 0 ? 2 : 3); ++i)
            volume += dot(from_first(0), cross(from_first(i), from_first(i + 1)));
    }
    figures.volume = static_cast<int>(std::lround(volume));
    return figures;
}

std::string transition_text(const std::vector<TransitionClass>& classes) {
    std::string rows;
    std::string nodes;
    std::size_t first = 0;
    char buffer[64];
    for (const TransitionClass& row : classes) {
        std::snprintf(buffer, sizeof buffer, "    {0x%05x, %zu, %zu},\n", row.pattern, first,
                      row.elements.size());
        rows += buffer;
        nodes += "    ";
        for (const TransitionElement& element : row.elements) {
            nodes += std::to_string(element.count) + ",";
            for (std::size_t i = 0; i < element.count; ++i) nodes += std::to_string(element.node[i]) + ",";
            nodes += " ";
            first += element.count + std::size_t{1};
        }
        nodes.back() = '\n';
    }
    return "// Templates of transition cells. Written by generate_transitions (host/templates); do not "
           "edit.\n"
           "#pragma once\n\n"
           "#include <cstdint>\n\n"
           "namespace mortise::cnio {\n\n"
           "// clang-format off\n"
           "/// One class of split patterns: its smallest pattern (host/common/cube_grid.hpp), where its "
           "elements\n"
           "/// begin, how many there are.\n"
           "struct TransitionRow {\n    std::uint32_t pattern;\n    std::uint16_t first;\n"
           "    std::uint16_t count;\n};\n"
           "inline constexpr TransitionRow kTransitionRows[] = {\n" +
           rows +
           "};\n\n"
           "/// Number of nodes, then the nodes: vertices of the cube in halves.\n"
           "inline constexpr std::uint8_t kTransitionNodes[] = {\n" +
           nodes + "};\n// clang-format on\n\n}  // namespace mortise::cnio\n";
}

}  // namespace mortise::templates
