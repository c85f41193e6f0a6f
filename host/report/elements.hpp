// Shapes of elements: histograms, quantiles, and the worst ones.
#pragma once

#include "mortise/quality.hpp"

namespace mortise::report {

/// Fills shapes, angles and worst elements (without causes).
void report_elements(const Mesh& mesh, int worst, int threads, QualityReport& report);

}  // namespace mortise::report
