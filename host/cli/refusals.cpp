#include "host/cli/refusals.hpp"

#include <algorithm>

#include "host/cli/quality_text.hpp"
#include "mortise/quality.hpp"

namespace mortise::cli {
namespace {

constexpr const char* kNothingWritten =
    "; nothing is written; try another --level, and please report it with the model";

}  // namespace

void refuse_inverted(const MeshFigures& figures) {
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        if (figures.elements[t] == 0 || figures.min_scaled_jacobian[t] > 0) continue;
        throw Error(ExitCode::kMeshing, std::string("the mesh is not valid: the worst scaled Jacobian of ") +
                                            kElementNames[t] + " is " +
                                            short_number(figures.min_scaled_jacobian[t]) + kNothingWritten);
    }
}

void refuse_defects(const CheckReport& check) {
    if (check.valid()) return;
    throw Error(ExitCode::kMeshing,
                "the mesh is not valid: " + describe(check.defects.front()) + kNothingWritten);
}

void refuse_below(const Mesh& mesh, const std::vector<float>& jacobians, double floor) {
    if (floor < 0) return;
    const auto below = std::count_if(jacobians.begin(), jacobians.end(),
                                     [floor](float value) { return static_cast<double>(value) < floor; });
    if (below == 0) return;
    const WorstElement worst = element_quality(mesh, 1).worst.front();
    throw Error(ExitCode::kQuality, "quality floor " + short_number(floor) + " not met: " +
                                        std::to_string(below) + " of " + std::to_string(jacobians.size()) +
                                        " elements are below; the worst is " + describe(worst));
}

}  // namespace mortise::cli
