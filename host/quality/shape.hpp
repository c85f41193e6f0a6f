// Shape of single elements: scaled Jacobian and dihedral angles, both taken corner by corner.
//
// A corner is a node with its three edges in right-handed order. The apex of a pyramid, with four edges, is
// left out: its four edges and faces are seen from the base corners already.
//
// Dihedral angle: at both ends of every edge, the angle between the planes of the two faces there; the plane
// of a quadrilateral face at a corner is the one through its two edges at that corner. For tetrahedra and for
// plane faces this is the usual dihedral angle. Where an edge or face is degenerate there is no angle.
#pragma once

#include "host/quality/vector.hpp"

namespace mortise::quality {

struct ShapeFigures {
    double scaled_jacobian =
        1;                   ///< smallest corner triple product of unit edges; 0 for an edge without length
    double min_cosine = 1;   ///< cosine of the largest dihedral angle
    double max_cosine = -1;  ///< cosine of the smallest dihedral angle
};

/// Throws Error(kMeshing) if elements have arrays of wrong lengths or name nodes that are not there: what
/// shapes take for granted.
void require_elements(const Mesh& mesh);

ShapeFigures shape_figures(ElementType type, const Corners& corners);

/// Most dihedral angles of one element: a hexahedron's, three at each corner.
inline constexpr int kMostAngles = 24;

/// Cosines of all dihedral angles of an element, degenerate ones left out; returns how many.
int dihedral_cosines(ElementType type, const Corners& corners, double* cosines);

/// The scaled Jacobian alone.
double scaled_jacobian(ElementType type, const Corners& corners);

}  // namespace mortise::quality
