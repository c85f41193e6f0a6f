// See box_unions.hpp.
#include "host/model/solids/box_unions.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "host/model/affine.hpp"

namespace mortise::model_reader {
namespace {

using Op = CsgNode::Op;

constexpr std::uint32_t kNone = static_cast<std::uint32_t>(-1);
constexpr std::size_t kFewest = 16;
/// Each is compared with all for being inside.
constexpr std::size_t kMostCompared = 2000;
/// Coordinates that agree so far, in units of the largest, are equal: sums of translations are rounded.
constexpr double kSame = 1e-13;

/// A box and the first node that it comes from.
struct Block {
    std::array<std::array<double, 2>, 3> side{};
    std::uint32_t node = 0;
};

/// x -> scale·x + shift with positive scales.
struct Placement {
    Vec3 scale = {1, 1, 1};
    Vec3 shift{};
};

std::optional<Placement> placement(const Affine& map) {
    Placement result;
    for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t j = 0; j < 3; ++j) {
            if (j != k && map[4 * k + j] != 0) return {};
        }
        if (!(map[5 * k] > 0)) return {};
        result.scale[k] = map[5 * k];
        result.shift[k] = map[4 * k + 3];
    }
    return result;
}

/// The sides if the primitive has the planes of box().
std::optional<Block> block_of(const CsgNode& node, std::uint32_t index, const Placement& place) {
    const std::vector<Plane>& planes = node.primitive.planes;
    if (node.primitive.kind != Primitive::Kind::kConvex || planes.size() != 6 || node.name.empty()) return {};
    Block block;
    block.node = index;
    for (std::size_t i = 0; i < 6; ++i) {
        Vec3 normal{};
        normal[i / 2] = i % 2 == 0 ? -1 : 1;
        if (planes[i].normal != normal) return {};
        const double at = i % 2 == 0 ? -planes[i].offset : planes[i].offset;
        block.side[i / 2][i % 2] = place.scale[i / 2] * at + place.shift[i / 2];
    }
    return block;
}

/// Gives coordinates that agree one value.
void unify(std::vector<Block>& blocks) {
    for (std::size_t k = 0; k < 3; ++k) {
        std::vector<double*> values;
        double largest = 0;
        for (Block& block : blocks) {
            for (double& value : block.side[k]) {
                values.push_back(&value);
                largest = std::max(largest, std::fabs(value));
            }
        }
        std::sort(values.begin(), values.end(), [](const double* a, const double* b) { return *a < *b; });
        double first = *values[0];
        for (double* value : values) {
            if (*value - first > kSame * largest) first = *value;
            *value = first;
        }
    }
}

/// Joins boxes that touch or overlap along an axis and agree in the other two.
void join_along(std::size_t axis, std::vector<Block>& blocks) {
    const std::size_t u = (axis + 1) % 3;
    const std::size_t v = (axis + 2) % 3;
    std::sort(blocks.begin(), blocks.end(), [&](const Block& a, const Block& b) {
        return std::tie(a.side[u], a.side[v], a.side[axis], a.node) <
               std::tie(b.side[u], b.side[v], b.side[axis], b.node);
    });
    std::vector<Block> joined;
    for (const Block& block : blocks) {
        if (!joined.empty()) {
            Block& last = joined.back();
            if (last.side[u] == block.side[u] && last.side[v] == block.side[v] &&
                block.side[axis][0] <= last.side[axis][1]) {
                last.side[axis][1] = std::max(last.side[axis][1], block.side[axis][1]);
                last.node = std::min(last.node, block.node);
                continue;
            }
        }
        joined.push_back(block);
    }
    blocks = std::move(joined);
}

bool is_inside(const Block& a, const Block& b) {
    for (std::size_t k = 0; k < 3; ++k) {
        if (a.side[k][0] < b.side[k][0] || a.side[k][1] > b.side[k][1]) return false;
    }
    return true;
}

void drop_inner(std::vector<Block>& blocks) {
    if (blocks.size() > kMostCompared) return;
    std::vector<Block> kept;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        bool inside = false;
        for (std::size_t j = 0; j < blocks.size() && !inside; ++j) {
            // Equal ones were joined.
            inside = j != i && is_inside(blocks[i], blocks[j]);
        }
        if (!inside) kept.push_back(blocks[i]);
    }
    blocks = std::move(kept);
}

/// The same union of fewer boxes: the best of joining along x, y or z first.
std::vector<Block> merged(const std::vector<Block>& blocks) {
    std::vector<Block> best = blocks;
    for (std::size_t first = 0; first < 3; ++first) {
        std::vector<Block> next = blocks;
        for (std::size_t before = next.size() + 1; next.size() < before;) {
            before = next.size();
            for (std::size_t k = 0; k < 3; ++k) join_along((first + k) % 3, next);
            drop_inner(next);
        }
        if (next.size() < best.size()) best = std::move(next);
    }
    std::sort(best.begin(), best.end(), [](const Block& a, const Block& b) {
        return std::tie(a.node, a.side) < std::tie(b.node, b.side);
    });
    return best;
}

/// By the topmost union: its boxes.
std::map<std::uint32_t, std::vector<Block>> boxes_of_unions(const Model& model) {
    std::vector<std::uint32_t> parents(model.nodes.size());
    for (const CsgNode& node : model.nodes) {
        for (const std::uint32_t child : node.children) ++parents[child];
    }
    for (const Region& region : model.regions) ++parents[region.root];
    std::vector<std::uint32_t> top(model.nodes.size(), kNone);
    std::vector<Placement> places(model.nodes.size());
    std::map<std::uint32_t, std::vector<Block>> boxes;
    // Parents come after their children.
    for (auto i = static_cast<std::uint32_t>(model.nodes.size()); i-- > 0;) {
        const CsgNode& node = model.nodes[i];
        if (node.max_size != 0 || node.surface_size != 0 || node.bounds) continue;
        if (node.op == Op::kPrimitive && top[i] != kNone) {
            if (const auto block = block_of(node, i, places[i])) boxes[top[i]].push_back(*block);
            continue;
        }
        Placement place = places[i];
        if (node.op == Op::kUnion) {
            if (top[i] == kNone) top[i] = i;
        } else if (node.op == Op::kTransform && top[i] != kNone) {
            const auto below = placement(node.map);
            if (!below) continue;
            for (std::size_t k = 0; k < 3; ++k) {
                place.shift[k] += place.scale[k] * below->shift[k];
                place.scale[k] *= below->scale[k];
            }
        } else {
            continue;
        }
        for (const std::uint32_t child : node.children) {
            if (parents[child] != 1) continue;
            top[child] = top[i];
            places[child] = place;
        }
    }
    return boxes;
}

}  // namespace

void merge_boxes(Model& model) {
    std::map<std::uint32_t, std::vector<Block>> unions;
    std::vector<char> gone(model.nodes.size());
    for (auto& [root, blocks] : boxes_of_unions(model)) {
        if (blocks.size() < kFewest) continue;
        unify(blocks);
        std::vector<Block> fewer = merged(blocks);
        if (fewer.size() > blocks.size() - blocks.size() / 4) continue;
        for (const Block& block : blocks) gone[block.node] = 1;
        unions[root] = std::move(fewer);
    }
    if (unions.empty()) return;

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
        const auto found = unions.find(i);
        if (found != unions.end()) {
            for (const Block& block : found->second) {
                const auto& [x, y, z] = block.side;
                const CsgNode& first = model.nodes[block.node];
                children.push_back(result.add_primitive(box({x[0], y[0], z[0]}, {x[1], y[1], z[1]}),
                                                        first.name, first.where));
            }
        }
        // Nodes that held nothing but boxes.
        if (had_children && children.empty()) continue;
        node.children = std::move(children);
        renamed[i] = result.add(std::move(node));
    }
    for (Region& region : model.regions) region.root = renamed[region.root];
    model.nodes = std::move(result.nodes);
}

}  // namespace mortise::model_reader
