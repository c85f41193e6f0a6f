// Search for the best decomposition of a simple boundary cell and of its complement, with shared surface.
//
// For every dissection of the surface loop into triangles and quads: the best decomposition without a new
// node (tiling.hpp), and cones from one interior node, at the mean of each set of four or more nodes that the
// pattern's own symmetries leave unchanged. The dissection is chosen for the worse of pattern and complement.
// Inner quads may be bilinear: both sides use the same one.
#pragma once

#include <vector>

#include "host/templates/measure.hpp"
#include "host/templates/pattern.hpp"

namespace mortise::templates {

/// Quality over sampled cut positions; per sample, the worst element counts.
struct Score {
    double positive = 0;        ///< share of samples with every element positive everywhere
    double worst_jacobian = 0;  ///< scaled Jacobian: smallest, and 1 % quantile
    double low_jacobian = 0;
    double worst_angle = 0;  ///< min(smallest, 180 - largest dihedral), degrees: smallest, and 1 % quantile
    double low_angle = 0;
    double smallest_dihedral = 0;  ///< over all samples, degrees
    double largest_dihedral = 0;
};

struct Template {
    std::vector<Element> elements;  ///< by type: hexahedra, wedges, pyramids, tetrahedra
    NodeSet interior_mean = 0;      ///< the interior node is the mean of these nodes; 0: not used
    std::vector<Facet> surface;     ///< outward; its loop's dissection
    Score score;
};

struct TemplatePair {
    Template inside;      ///< of the pattern
    Template complement;  ///< of its complement; the same surface facets, reversed
};

bool is_separable(Pattern pattern);

/// Sampled cut positions by which templates are measured: uniform planes for a separable pattern, else
/// independent cuts in [0.2, 0.8]. A pattern and its complement have the same cuts.
std::vector<Positions> measured_positions(Pattern pattern, std::uint64_t seed, int count);

/// Copies the positions with the interior node placed, and measures.
Score measure(const Template& candidate, const std::vector<Positions>& positions);

/// All facets of the inside part's boundary: face meshes and surface.
std::vector<Facet> inside_boundary(Pattern pattern, const std::vector<Facet>& surface);

/// Precondition: is_simple(pattern).
TemplatePair find_templates(Pattern pattern);

}  // namespace mortise::templates
