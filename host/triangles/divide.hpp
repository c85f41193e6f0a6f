// Polyhedra divided into cells that few of their planes cross (kernels/shared/spatial.h).
#pragma once

#include "host/tape/compile.hpp"

namespace mortise::triangles {

struct Division {
    std::uint64_t nodes = 0;     ///< of all octrees
    std::uint64_t formulas = 0;  ///< entries that are a formula
    /// Finest cells with more faces than a formula holds: small ones were left out.
    std::uint64_t crowded = 0;
};

/// Fills model.spatial for a tree whose leaves have levels from `base` >= 1 to `finest`, and makes the tape's
/// spatial words point into it. What a finest cell holds of a polyhedron is exact, but for crowded cells;
/// larger cells are left undivided, so that they must be split, if they hold more than a few faces. The
/// result does not depend on `threads` (0: all cores).
Division divide(tape::BoundModel& model, int base, int finest, int threads);

}  // namespace mortise::triangles
