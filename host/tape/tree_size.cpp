#include "host/tape/tree_size.hpp"

#include <algorithm>
#include <string>
#include <vector>

namespace mortise::tape {

std::string start_of(const Model& model, std::uint32_t node) {
    const SourceLocation where = node < model.nodes.size() ? model.nodes[node].where : SourceLocation{};
    if (where.line == 0) return model.source + ": ";
    return model.source + ":" + std::to_string(where.line) + ":" + std::to_string(where.column) + ": ";
}

void refuse_large_trees(const Model& model, std::size_t most) {
    std::vector<char> used(model.nodes.size(), 0);
    for (const Region& region : model.regions) used[region.root] = 1;
    for (std::size_t node = model.nodes.size(); node-- > 0;) {
        if (used[node] == 0) continue;
        for (const std::uint32_t child : model.nodes[node].children) used[child] = 1;
    }
    std::vector<double> surfaces(model.nodes.size(), 0);
    for (std::uint32_t node = 0; node < surfaces.size(); ++node) {
        const CsgNode& here = model.nodes[node];
        if (here.op == CsgNode::Op::kPrimitive)
            surfaces[node] = static_cast<double>(std::max<std::size_t>(1, here.primitive.planes.size()));
        for (const std::uint32_t child : here.children) surfaces[node] += surfaces[child];
        if (used[node] == 0 || surfaces[node] <= static_cast<double>(most)) continue;
        throw Error(ExitCode::kInput, start_of(model, node) + "the solid has more than " +
                                          std::to_string(most) +
                                          " surfaces, counted for each use of a part; use parts less often");
    }
}

}  // namespace mortise::tape
