#include "tests/sizing/descent.hpp"

#include <algorithm>

namespace mortise::test {

Nodes children_of(const tape::BoundModel& model, const Nodes& parents,
                  const std::vector<std::uint8_t>& which) {
    Nodes result;
    result.level = parents.level + 1;
    for (std::size_t i = 0; i < parents.nodes.size(); ++i) {
        if (which[i] == 0) continue;
        const TreeNode& parent = parents.nodes[i];
        const auto first = parents.tapes.begin() + parent.tape_offset;
        const std::vector<std::uint32_t> tape(first, first + parent.tape_length);
        for (std::uint64_t child = 0; child < 8; ++child) {
            const std::uint64_t morton = 8 * parent.morton + child;
            std::vector<std::uint32_t> pruned;
            if (tape::classify_cell(model, tape, sizing::cell_of(morton, result.level), &pruned) != kUnknown)
                continue;
            result.nodes.push_back({morton, static_cast<std::uint32_t>(result.tapes.size()),
                                    static_cast<std::uint32_t>(pruned.size())});
            result.tapes.insert(result.tapes.end(), pruned.begin(), pruned.end());
        }
    }
    return result;
}

Nodes nodes_at(const tape::BoundModel& model, int level) {
    Nodes result;
    result.nodes.push_back({0, 0, static_cast<std::uint32_t>(model.tape.size())});
    result.tapes = model.tape;
    while (result.level < level)
        result = children_of(model, result, std::vector<std::uint8_t>(result.nodes.size(), 1));
    return result;
}

std::vector<std::size_t> feature_splits(const tape::BoundModel& model, int level, int levels) {
    sizing::SizeField field;
    field.features = true;
    const sizing::Sizer sizer(model, field);
    std::vector<std::size_t> counts;
    Nodes nodes = nodes_at(model, level);
    while (static_cast<int>(counts.size()) < levels) {
        const auto which = sizer.split_undecided(nodes.nodes, nodes.tapes, nodes.level, 2);
        counts.push_back(count_split(which));
        if (counts.back() == 0) break;
        nodes = children_of(model, nodes, which);
    }
    return counts;
}

std::size_t count_split(const std::vector<std::uint8_t>& which) {
    return static_cast<std::size_t>(std::count(which.begin(), which.end(), 1));
}

}  // namespace mortise::test
