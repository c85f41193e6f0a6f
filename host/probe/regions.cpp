#include "host/probe/regions.hpp"

#include <algorithm>
#include <cmath>

#include "kernels/shared/surface.h"

namespace mortise::probe {

Leaf Regions::leaf_at_point(const Vec3& x) const {
    const auto cells = static_cast<double>(std::uint64_t{1} << tree_.level);
    std::array<u32, 3> cell{};
    for (std::size_t j = 0; j < 3; ++j)
        cell[j] = static_cast<u32>(std::min(std::max(std::floor(x[j] * cells), 0.0), cells - 1));
    return leaf_at(&view_, morton_encode(cell[0], cell[1], cell[2]));
}

std::int32_t Regions::at(const Vec3& x) {
    const Leaf leaf = leaf_at_point(x);
    if (leaf.kind == kLeafNone) return 0;
    if (leaf.kind == kLeafIn) return octree::in_region(tree_, leaf.code);
    const TreeNode& node = tree_.nio[leaf.index];
    if (node.tape_length == 0) return octree::in_region(tree_, leaf.code);
    const Known& known = load(leaf.index, node);
    signs_.resize(known.surfaces.size());
    for (std::size_t s = 0; s < known.surfaces.size(); ++s) {
        const double value = surface_value(&model_.surfaces[known.surfaces[s]], model_.expression_ops.data(),
                                           x[0], x[1], x[2]);
        signs_[s] = tape::sign_of(value);
    }
    return known.tape.resolve(signs_.data());
}

std::size_t Regions::crossings(const Vec3& a, const Vec3& b) {
    const auto in_leaf_of = [&](const Vec3& place) -> std::ptrdiff_t {
        const Leaf leaf = leaf_at_point(place);
        if (leaf.kind != kLeafNio || tree_.nio[leaf.index].tape_length == 0) return 0;
        const std::vector<std::uint32_t>& surfaces = load(leaf.index, tree_.nio[leaf.index]).surfaces;
        return std::count_if(surfaces.begin(), surfaces.end(), [&](std::uint32_t s) {
            const auto value = [&](const Vec3& x) {
                return surface_value(&model_.surfaces[s], model_.expression_ops.data(), x[0], x[1], x[2]);
            };
            return tape::sign_of(value(a)) != tape::sign_of(value(b));
        });
    };
    return static_cast<std::size_t>(std::max(in_leaf_of(a), in_leaf_of(b)));
}

void Regions::at(const std::vector<Vec3>& points, std::vector<std::int32_t>& regions) {
    regions.resize(points.size());
    by_leaf_.clear();
    for (std::uint32_t k = 0; k < points.size(); ++k) {
        const Leaf leaf = leaf_at_point(points[k]);
        const bool is_undecided = leaf.kind == kLeafNio && tree_.nio[leaf.index].tape_length != 0;
        if (is_undecided)
            by_leaf_.push_back({leaf.index, k});
        else
            regions[k] = leaf.kind == kLeafNone ? 0 : octree::in_region(tree_, leaf.code);
    }
    std::sort(by_leaf_.begin(), by_leaf_.end());
    for (std::size_t begin = 0, end = 0; begin < by_leaf_.size(); begin = end) {
        const std::uint32_t leaf = by_leaf_[begin].first;
        leaf_points_.clear();
        for (; end < by_leaf_.size() && by_leaf_[end].first == leaf; ++end)
            leaf_points_.push_back(points[by_leaf_[end].second]);
        const Known& known = load(leaf, tree_.nio[leaf]);
        values_.resize(std::max(values_.size(), known.surfaces.size()));
        for (std::size_t s = 0; s < known.surfaces.size(); ++s)
            batch_.values(known.surfaces[s], tape::Places(leaf_points_), values_[s]);
        signs_.resize(known.surfaces.size());
        for (std::size_t i = begin; i < end; ++i) {
            for (std::size_t s = 0; s < known.surfaces.size(); ++s)
                signs_[s] = tape::sign_of(values_[s][i - begin]);
            regions[by_leaf_[i].second] = known.tape.resolve(signs_.data());
        }
    }
}

const Regions::Known& Regions::load(std::uint32_t leaf, const TreeNode& node) {
    Known& known = known_[leaf % known_.size()];
    if (known.leaf == leaf) return known;
    const std::uint32_t* words = tree_.tapes.data() + node.tape_offset;
    tape::list_surfaces(words, node.tape_length, known.surfaces);
    known.tape.load(words, node.tape_length, known.surfaces);
    known.leaf = leaf;
    return known;
}

}  // namespace mortise::probe
