// The quality report for people and as JSON. JSON names are append-only.
#pragma once

#include <string>

#include "host/cli/documents.hpp"
#include "mortise/quality.hpp"

namespace mortise::cli {

/// At most about forty lines. `features`: of the same mesh, or null.
std::string quality_text(const QualityReport& report, const Features* features = nullptr);
Json quality_document(const QualityReport& report, const Features* features = nullptr);

/// "tetrahedron 17 at (0.1, 0.2, 0.3), scaled Jacobian 0.01".
std::string describe(const WorstElement& element);

}  // namespace mortise::cli
