// Improvement of elements at periodic planes, where holding their facets would leave slivers.
#pragma once

#include "host/pipeline/prepare.hpp"

namespace mortise::pipeline {

/// Improves what is poor at periodic planes as if the solid went on behind them (glue.hpp): facets that two
/// planes have in common become an interface inside, and afterwards both planes take what became of it. So
/// their facets stay the same up to rounding (match_planes). Corners come first, where planes of three pairs
/// meet, then edges, then the planes.
///
/// Uniform trees only. Pairs that cannot be glued are left alone. `options`: as of the improvement that
/// follows, which holds the planes. Returns the number of tetrahedra that were tried.
std::uint64_t improve_planes(const Prepared& prepared, const improve::Options& options, Mesh& mesh);

}  // namespace mortise::pipeline
