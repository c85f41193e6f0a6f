// Why an element is bad: what of the model it touches.
#pragma once

#include "host/tape/compile.hpp"
#include "mortise/quality.hpp"

namespace mortise::report {

/// Fills the causes of the report's worst elements.
void find_causes(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                 const tape::BoundModel& model, const Features& features, QualityReport& report);

}  // namespace mortise::report
