#include "host/cli/refusals.hpp"

#include <algorithm>

#include "host/cli/quality_text.hpp"
#include "host/cli/text.hpp"
#include "mortise/quality.hpp"

namespace mortise::cli {
namespace {

constexpr const char* kNothingWritten =
    "; nothing is written; try another --level, and please report it with the model";

}  // namespace

void refuse_inverted(const MeshFigures& figures) {
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        if (figures.elements[t] == 0 || figures.min_scaled_jacobian[t] > 0) continue;
        throw Error(ExitCode::kMeshing,
                    std::string("the mesh is not valid: the worst scaled Jacobian of ") + kElementNames[t] +
                        " is " + rounded_text(figures.min_scaled_jacobian[t], 4) + kNothingWritten);
    }
}

bool warn_of_slivers(const MeshFigures& figures, const MeshOptions& options, MeshReport& report) {
    constexpr double kVeryLow = 0.05;
    const auto& lowest = figures.min_scaled_jacobian;
    const double worst = *std::min_element(lowest.begin(), lowest.end());
    if (!options.improve || !(worst < kVeryLow)) return false;
    const std::string place = figures.worst_place ? ", at " + place_text(*figures.worst_place) : "";
    const char* const why =
        report.layers.elements > 0
            ? ": layers narrow to nothing there, or the model has a wall, gap or angle that "
              "is too thin for these cells"
            : ": the model has a wall, gap or angle there that is too thin for these cells; "
              "--refine 2 makes them smaller where that helps";
    report.warnings.push_back("the lowest scaled Jacobian is " + rounded_text(worst, 2) + place + why);
    return true;
}

void refuse_defects(const CheckReport& check) {
    if (check.valid()) return;
    throw Error(ExitCode::kMeshing,
                "the mesh is not valid: " + describe(check.defects.front()) + kNothingWritten);
}

std::string below_floor(const Mesh& mesh, const std::vector<float>& jacobians, double floor) {
    const std::uint64_t below = count_below(jacobians, floor);
    if (below == 0) return {};
    return below_floor(below, jacobians.size(), floor, describe(element_quality(mesh, 1).worst.front()));
}

std::string below_floor(std::uint64_t below, std::uint64_t elements, double floor, const std::string& worst) {
    if (below == 0) return {};
    return "quality floor " + rounded_text(floor, 4) + " not met: " + std::to_string(below) + " of " +
           std::to_string(elements) + " elements are below; the worst is " + worst;
}

std::uint64_t count_below(const std::vector<float>& jacobians, double floor) {
    if (floor < 0) return 0;
    return static_cast<std::uint64_t>(std::count_if(jacobians.begin(), jacobians.end(), [floor](float value) {
        return static_cast<double>(value) < floor;
    }));
}

void refuse_below(const std::string& message) {
    if (!message.empty()) throw Error(ExitCode::kQuality, message);
}

}  // namespace mortise::cli
