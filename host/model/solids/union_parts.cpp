// See union_parts.hpp.
#include "host/model/solids/union_parts.hpp"

#include <utility>

#include "host/model/affine.hpp"

namespace mortise::model_reader {
namespace {

using Op = CsgNode::Op;

constexpr std::uint32_t kNone = static_cast<std::uint32_t>(-1);

}  // namespace

std::map<std::uint32_t, std::vector<UnionPart>> union_parts(const Model& model) {
    std::vector<std::uint32_t> parents(model.nodes.size());
    for (const CsgNode& node : model.nodes) {
        for (const std::uint32_t child : node.children) ++parents[child];
    }
    for (const Region& region : model.regions) ++parents[region.root];
    std::vector<std::uint32_t> top(model.nodes.size(), kNone);
    std::vector<Affine> maps(model.nodes.size(), kIdentity);
    std::map<std::uint32_t, std::vector<UnionPart>> parts;
    // Parents come after their children.
    for (auto i = static_cast<std::uint32_t>(model.nodes.size()); i-- > 0;) {
        const CsgNode& node = model.nodes[i];
        if (node.max_size != 0 || node.surface_size != 0 || node.bounds) continue;
        if (node.op == Op::kUnion) {
            if (top[i] == kNone) top[i] = i;
        } else if (top[i] == kNone) {
            continue;
        } else if (node.op == Op::kTransform) {
            maps[i] = compose(maps[i], node.map);
        } else {
            if (node.op == Op::kPrimitive || node.op == Op::kIntersection)
                parts[top[i]].push_back({i, maps[i]});
            continue;
        }
        for (const std::uint32_t child : node.children) {
            if (parents[child] != 1) continue;
            top[child] = top[i];
            maps[child] = maps[i];
        }
    }
    return parts;
}

void replace_parts(Model& model, const std::vector<char>& gone,
                   const std::map<std::uint32_t, std::vector<PartMaker>>& added) {
    Model result;
    result.nodes.reserve(model.nodes.size());
    std::vector<std::uint32_t> renamed(model.nodes.size(), kNone);
    for (std::uint32_t i = 0; i < model.nodes.size(); ++i) {
        if (gone[i] != 0) continue;
        CsgNode node = model.nodes[i];
        const bool had_children = !node.children.empty();
        std::vector<std::uint32_t> children;
        for (const std::uint32_t child : node.children) {
            if (renamed[child] != kNone) children.push_back(renamed[child]);
        }
        const auto found = added.find(i);
        if (found != added.end()) {
            for (const PartMaker& make : found->second) children.push_back(make(result));
        }
        // Nodes that held nothing but what is gone.
        if (had_children && children.empty()) continue;
        node.children = std::move(children);
        renamed[i] = result.add(std::move(node));
    }
    for (Region& region : model.regions) region.root = renamed[region.root];
    model.nodes = std::move(result.nodes);
}

}  // namespace mortise::model_reader
