// Geometry and quality of template elements at sampled cut positions.
//
// Quality: scaled Jacobian = the smallest corner triple product of unit edges, not normalised, a pyramid's
// apex left out (a regular tetrahedron: 0.707). Dihedral angles are taken at each end of each element edge,
// between the planes of that edge and the next edge of each of its two faces; for planar faces, the usual
// angle. Random numbers are our own generator, without libm, so that results do not depend on the platform.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/common/random.hpp"
#include "host/templates/pattern.hpp"

namespace mortise::templates {

using mortise::Random;

using Point = std::array<double, 3>;
using Positions = std::array<Point, kNodeCodes>;

/// Half-space normal . x < offset.
struct Plane {
    Point normal{};
    double offset = 0;
};

/// Cuts nearer to an end of their edge than this are moved to it, in sampled planes.
inline constexpr double kCutMargin = 1e-3;

/// A plane that cuts the pattern off: normal uniform over the directions for which such a plane exists,
/// offset uniform over its interval. Precondition: the pattern is separable by a plane.
Plane random_plane(Pattern pattern, Random& random);

/// As random_plane, but the offset's distance to an end of its interval is log-uniform over six decades.
Plane extreme_plane(Pattern pattern, Random& random);

/// Corner and cut positions for one plane; cuts are clipped to [margin, 1 - margin].
Positions plane_positions(Pattern pattern, const Plane& plane, double margin);

/// Corner and cut positions with independent cuts, uniform in [low, high].
Positions independent_positions(Pattern pattern, double low, double high, Random& random);

Point mean(const Positions& positions, NodeSet nodes);

double scaled_jacobian(const Element& element, const Positions& positions);

/// The element's Jacobian is positive everywhere: by its Bernstein coefficients, a sufficient condition that
/// is also necessary for pyramids and tetrahedra. Rejects coefficients that are only rounding noise.
bool is_positive(const Element& element, const Positions& positions);

/// Smallest and largest cosine of the dihedral angles.
struct Cosines {
    double smallest = 1;
    double largest = -1;
};
Cosines dihedral_cosines(const Element& element, const Positions& positions);

/// Signed volume of the solid that the facets close, quads bilinear.
double enclosed_volume(const std::vector<Facet>& facets, const Positions& positions);

double degrees(double cosine);

}  // namespace mortise::templates
