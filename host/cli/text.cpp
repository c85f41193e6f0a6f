#include "host/cli/text.hpp"

#include <cstdio>

namespace mortise::cli {
namespace {

constexpr double kWorthTelling = 0.001;  // seconds
/// Improvement of so many seconds, and so large a share of all, is told what to do about.
constexpr double kLongImprovement = 20, kMostOfAll = 0.6;

std::string seconds_text(double seconds) {
    char text[40];
    std::snprintf(text, sizeof text, "%.3f", seconds);
    return text;
}

}  // namespace

std::string list_elements(const std::array<std::uint64_t, kElementTypes>& elements) {
    std::string list;
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        if (elements[t] == 0) continue;
        list += (list.empty() ? "" : ", ") + std::to_string(elements[t]) + " " + kElementNames[t];
    }
    return list.empty() ? "no elements" : list;
}

std::string list_jacobians(const std::array<std::uint64_t, kElementTypes>& elements,
                           const std::array<double, kElementTypes>& jacobians) {
    std::string list;
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        if (elements[t] == 0) continue;
        list += (list.empty() ? "" : ", ") + rounded_text(jacobians[t], 3) + " " + kElementNames[t];
    }
    return list.empty() ? "none" : list;
}

std::string describe(const Defect& defect) {
    return std::to_string(defect.count) + " × " + defect.what + ", first: " + defect.first;
}

std::string touching_text(const CheckReport& report) {
    if (report.parts >= report.components) return "";
    return " (" + std::to_string(report.components - report.parts) +
           " of them hang on others by an edge or a node only)";
}

std::string times_text(const std::vector<StageTime>& stages) {
    double total = 0, improvement = 0;
    std::string list;
    for (const StageTime& stage : stages) {
        total += stage.wall_seconds;
        if (stage.stage == "improve") improvement += stage.wall_seconds;
        if (stage.wall_seconds < kWorthTelling) continue;
        list += (list.empty() ? ": " : ", ") + stage.stage + " " + seconds_text(stage.wall_seconds);
    }
    std::string text = "  time       " + seconds_text(total) + " s" + list + "\n";
    if (improvement > kLongImprovement && improvement > kMostOfAll * total)
        text +=
            "             elements were improved most of the time: walls, struts or gaps are about as wide "
            "as cells; smaller cells may take less time, --no-improve takes none\n";
    return text;
}

}  // namespace mortise::cli
