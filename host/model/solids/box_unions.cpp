// See box_unions.hpp.
#include "host/model/solids/box_unions.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "host/model/affine.hpp"
#include "host/model/solids/union_parts.hpp"

namespace mortise::model_reader {
namespace {

constexpr std::size_t kFewestBoxes = 16;
/// Each is compared with all for being inside.
constexpr std::size_t kMostCompared = 2000;
/// Coordinates that agree so far, in units of the largest, are equal: sums of translations are rounded.
constexpr double kSameCoordinate = 1e-13;

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
            if (*value - first > kSameCoordinate * largest) first = *value;
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

}  // namespace

void merge_boxes(Model& model) {
    std::map<std::uint32_t, std::vector<PartMaker>> added;
    std::vector<char> gone(model.nodes.size());
    for (const auto& [root, parts] : union_parts(model)) {
        std::vector<Block> blocks;
        for (const UnionPart& part : parts) {
            const std::optional<Placement> place = placement(part.map);
            if (!place) continue;
            if (const auto block = block_of(model.nodes[part.node], part.node, *place))
                blocks.push_back(*block);
        }
        if (blocks.size() < kFewestBoxes) continue;
        unify(blocks);
        const std::vector<Block> fewer = merged(blocks);
        if (fewer.size() > blocks.size() - blocks.size() / 4) continue;
        for (const Block& block : blocks) gone[block.node] = 1;
        for (const Block& block : fewer) {
            added[root].push_back([block, first = model.nodes[block.node]](Model& result) {
                const auto& [x, y, z] = block.side;
                return result.add_primitive(box({x[0], y[0], z[0]}, {x[1], y[1], z[1]}), first.name,
                                            first.where);
            });
        }
    }
    if (!added.empty()) replace_parts(model, gone, added);
}

}  // namespace mortise::model_reader
