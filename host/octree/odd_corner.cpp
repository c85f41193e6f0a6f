#include "host/octree/odd_corner.hpp"

#include <array>

#include "kernels/shared/surface.h"

namespace mortise::octree {

std::size_t odd_corner(const Octree& tree, const tape::BoundModel& model, std::uint64_t leaf, int f) {
    const int level = tree.level_of(leaf);
    std::array<std::uint64_t, 4> code{};
    std::array<const SnappedVertex*, 4> vertex{};
    for (std::size_t i = 0; i < 4; ++i) {
        code[i] = tree.vertex_of(leaf, level, kFaceCorners[f][i]);
        vertex[i] = tree.snapped_at(code[i]);
    }
    const double edge = tree.finest_edge();
    const auto is_on = [&](std::size_t i, std::uint32_t surface) {
        if (vertex[i] != nullptr) return vertex[i]->is_on(surface);
        return surface_sign(&model.surfaces[surface], model.expression_ops.data(),
                            gather_bits(code[i]) * edge, gather_bits(code[i] >> 1) * edge,
                            gather_bits(code[i] >> 2) * edge, Octree::edge_of(level)) == 0;
    };
    for (const SnappedVertex* own : vertex) {
        for (std::size_t k = 0; own != nullptr && k < own->surface_count; ++k) {
            std::size_t off = 0;
            std::size_t odd = 4;
            for (std::size_t i = 0; i < 4; ++i) {
                if (is_on(i, own->surface[k])) continue;
                odd = i;
                ++off;
            }
            if (off == 1) return odd;
        }
    }
    return 4;
}

}  // namespace mortise::octree
