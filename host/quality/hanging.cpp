// Hanging nodes by themselves; facets.cpp matches the faces that have them with elements.
#include <algorithm>
#include <cmath>

#include "host/quality/passes.hpp"
#include "host/quality/vector.hpp"
#include "mortise/error.hpp"

namespace mortise::quality {
namespace {

constexpr double kInMiddle = 1e-9;  ///< of the distance between two masters

/// Why the masters of hanging node i cannot be its masters; empty if they can.
std::string fault(const Mesh& mesh, std::size_t i) {
    const HangingNodes& hanging = mesh.hanging;
    const NodeId* master = hanging.masters.data() + 4 * i;
    if (i > 0 && hanging.node[i - 1] >= hanging.node[i]) return "not in ascending order";
    const bool in_edge = hanging.in_edge(i);
    if (in_edge && master[1] != master[3]) return "neither the ends of an edge nor the corners of a face";
    for (int a = 0; a < (in_edge ? 2 : 4); ++a) {
        if (std::binary_search(hanging.node.begin(), hanging.node.end(), master[a]))
            return "master " + std::to_string(master[a]) + " hangs itself";
        for (int b = 0; b < a; ++b) {
            if (master[a] == master[b]) return "master " + std::to_string(master[a]) + " named twice";
        }
    }
    return {};
}

}  // namespace

std::vector<HangingFace> check_hanging(const Mesh& mesh, DefectLog& log) {
    const HangingNodes& hanging = mesh.hanging;
    for (std::size_t i = 0; i < hanging.size(); ++i) {
        const auto text = [&](const std::string& what) {
            return "node " + std::to_string(hanging.node[i]) + " at " + point_text(mesh, hanging.node[i]) +
                   what;
        };
        const std::string why = fault(mesh, i);
        if (!why.empty()) {
            log.add(DefectKind::kHangingNode, [&] { return text(": " + why); });
            continue;
        }
        const NodeId* master = hanging.masters.data() + 4 * i;
        Vector sum;
        for (int k = 0; k < 4; ++k) sum = sum + point_of(mesh, master[k]);
        const double reach = length(point_of(mesh, master[1]) - point_of(mesh, master[0]));
        const double off = length(point_of(mesh, hanging.node[i]) - 0.25 * sum);
        if (!(off <= kInMiddle * reach))
            log.add(DefectKind::kHangingPlace, [&] { return text(": off by " + number_text(off)); });
    }
    if (log.count(DefectKind::kHangingNode) != 0) return {};
    try {
        return hanging_faces(hanging);
    } catch (const Error& error) {
        log.add(DefectKind::kHangingNode, [&] { return std::string(error.what()); });
        return {};
    }
}

}  // namespace mortise::quality
