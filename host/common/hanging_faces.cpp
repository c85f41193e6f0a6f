#include <algorithm>
#include <string>

#include "host/common/edge_middles.hpp"
#include "mortise/error.hpp"
#include "mortise/hanging.hpp"

namespace mortise {

std::vector<HangingFace> hanging_faces(const HangingNodes& nodes) {
    if (nodes.masters.size() != 4 * nodes.size())
        throw Error(ExitCode::kMeshing, "hanging nodes and their masters are of unequal number");
    const EdgeMiddles middles(nodes);
    std::vector<HangingFace> faces;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (nodes.in_edge(i)) continue;
        HangingFace face;
        std::copy_n(nodes.masters.begin() + 4 * static_cast<std::ptrdiff_t>(i), 4, face.whole.begin());
        std::array<NodeId, 4> side{};
        for (std::size_t k = 0; k < 4; ++k) {
            const NodeId a = face.whole[k], b = face.whole[(k + 1) % 4];
            const std::optional<NodeId> middle = middles.between(a, b);
            if (!middle) {
                throw Error(ExitCode::kMeshing, "no hanging node in the middle of nodes " +
                                                    std::to_string(a) + " and " + std::to_string(b) +
                                                    ", an edge of a face that has one in its middle");
            }
            side[k] = *middle;
        }
        for (std::size_t k = 0; k < 4; ++k)
            face.quarters[k] = {face.whole[k], side[k], nodes.node[i], side[(k + 3) % 4]};
        faces.push_back(face);
    }
    return faces;
}

}  // namespace mortise
