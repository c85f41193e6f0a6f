#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>

#include "mortise/error.hpp"
#include "mortise/hanging.hpp"

namespace mortise {
namespace {

std::uint64_t edge_key(NodeId a, NodeId b) { return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b); }

}  // namespace

std::vector<HangingFace> hanging_faces(const HangingNodes& nodes) {
    if (nodes.masters.size() != 4 * nodes.size())
        throw Error(ExitCode::kMeshing, "hanging nodes and their masters are of unequal number");
    std::vector<std::pair<std::uint64_t, NodeId>> middles;
    std::size_t count = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const NodeId* master = nodes.masters.data() + 4 * i;
        count += !nodes.in_edge(i);
        if (nodes.in_edge(i)) middles.emplace_back(edge_key(master[0], master[1]), nodes.node[i]);
    }
    std::sort(middles.begin(), middles.end());
    const auto middle = [&](NodeId a, NodeId b) {
        const auto found =
            std::lower_bound(middles.begin(), middles.end(), std::make_pair(edge_key(a, b), NodeId{0}));
        if (found == middles.end() || found->first != edge_key(a, b))
            throw Error(ExitCode::kMeshing, "no hanging node in the middle of nodes " + std::to_string(a) +
                                                " and " + std::to_string(b) +
                                                ", an edge of a face that has one in its middle");
        return found->second;
    };
    std::vector<HangingFace> faces;
    faces.reserve(count);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (nodes.in_edge(i)) continue;
        HangingFace face;
        std::copy_n(nodes.masters.data() + 4 * i, 4, face.whole.begin());
        std::array<NodeId, 4> side{};
        for (std::size_t k = 0; k < 4; ++k) side[k] = middle(face.whole[k], face.whole[(k + 1) % 4]);
        for (std::size_t k = 0; k < 4; ++k)
            face.quarters[k] = {face.whole[k], side[k], nodes.node[i], side[(k + 3) % 4]};
        faces.push_back(face);
    }
    return faces;
}

}  // namespace mortise
