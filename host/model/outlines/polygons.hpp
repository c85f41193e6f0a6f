// Operations on polygons: normal form, boolean operations, offsets, hulls and sums. Clipper does the work on
// integers, scaled so that rounding stays below 1e-13 of the drawing's size.
#pragma once

#include <clipper.hpp>
#include <vector>

#include "host/model/outlines/contours.hpp"
#include "host/model/outlines/flat_tree.hpp"

namespace mortise::model_reader {

/// Polygons on the lattice, oriented: outer loops counter-clockwise, holes clockwise.
using LatticePaths = ClipperLib::Paths;

/// The lattice for coordinates up to `reach`. Its step is a power of two, so that whole numbers survive.
class PolygonLattice {
  public:
    explicit PolygonLattice(double reach);

    /// Rounds loops, and nothing else.
    LatticePaths rounded(const Contours& loops) const;
    /// Rounds loops, even-odd, and resolves their crossings.
    LatticePaths paths(const Contours& loops) const;
    /// Rounds oriented loops; what they wind around at least once.
    LatticePaths wound_paths(const Contours& loops) const;
    LatticePaths combined(FlatNode::Op op, std::vector<LatticePaths> operands) const;
    /// Back to doubles: each outer loop followed by its holes; what is thinner than the rounding is dropped.
    Contours contours(const LatticePaths& paths) const;
    double step() const { return step_; }

  private:
    double reach_;
    double step_;
};

double signed_area(const std::vector<Vec2>& loop);

/// Even-odd loops as simple loops that do not cross, ordered and oriented as FlatNode::contours, without
/// collinear points. Loops that are simple and apart already keep their coordinates bit for bit.
Contours normalised(const Contours& loops);

/// Oriented loops (the inside on their left) as `normalised`: what they wind around at least once.
Contours wound(const Contours& loops);

enum class OffsetCorner { kRound, kMiter, kChamfer };

/// Moves the outline outwards by `distance` (inwards if negative). Argument and result are normalised.
Contours offset(const Contours& contours, double distance, OffsetCorner corner, int fragments);

/// The convex hull of all points; no loop if they have no area.
Contours convex_hull(const Contours& contours);

/// Minkowski sum of two normalised shapes.
Contours minkowski_sum(const Contours& a, const Contours& b);

/// Outer loops only.
Contours filled(const Contours& contours);

}  // namespace mortise::model_reader
