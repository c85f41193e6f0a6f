#include "host/cli/text.hpp"

#include <cstdio>

namespace mortise::cli {

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

}  // namespace mortise::cli
