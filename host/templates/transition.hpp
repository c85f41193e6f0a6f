// Templates of transition cells: a cube in one region beside finer cells, some of its faces split into
// quarters, some of its edges at their middles.
//
// The faces' meshes are those of host/cnio/face.cpp, which both cells share. For each class of patterns under
// the 48 symmetries, a search finds the fewest hexahedra, wedges, pyramids and tetrahedra that fill the cube,
// with plane faces, no node but those of the faces and the centre, and no element worse than the limits
// below. Where none is found, the cone from the centre stays.
//
// A tiling is recognised by its facets alone: if all elements are positive, those inside the cube pair up,
// and what is left is the cube's own surface, then the elements cover each point once.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/common/cube_grid.hpp"

namespace mortise::templates {

/// Limits of a transition element, unwarped: those of the cone from the centre, so that no template is worse
/// than it. A sphere has 17.4 elements in each such leaf, of the cone 17.9; with limits of 26 to 144 degrees
/// and 0.23 it would have 12.7, with all that improvement takes for good 11.7.
inline constexpr double kTransitionScaledJacobian = 0.258;
inline constexpr double kTransitionSmallestAngle = 29.9;
inline constexpr double kTransitionLargestAngle = 125.4;

/// Nodes are vertices of the cube in halves, in the order of mesh.hpp; the number of nodes tells the type.
struct TransitionElement {
    std::uint8_t count = 0;
    std::array<std::uint8_t, 8> node{};
};

struct TransitionClass {
    SplitPattern pattern = 0;  ///< the smallest of the class
    std::vector<TransitionElement> elements;
    bool is_fewest = false;  ///< proved by the search
};

/// Facets of the cube's faces as node lists, counter-clockwise seen from outside.
std::vector<TransitionElement> transition_facets(SplitPattern pattern);

/// A pyramid or tetrahedron from each of them to the centre.
std::vector<TransitionElement> transition_cone(SplitPattern pattern);

struct TransitionFigures {
    double scaled_jacobian = 1;
    double smallest_angle = 180;  ///< dihedral, degrees
    double largest_angle = 0;
    int volume = 0;  ///< six times, in cubes of half an edge; exact for plane faces
};
TransitionFigures transition_figures(const TransitionElement& element);

/// All 227 classes, ascending by pattern.
std::vector<TransitionClass> build_transitions();

/// The table as C++ source (host/cnio/transition_table.hpp).
std::string transition_text(const std::vector<TransitionClass>& classes);

}  // namespace mortise::templates
