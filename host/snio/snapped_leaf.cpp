#include "host/snio/classify.hpp"
#include "host/snio/face_plans.hpp"
#include "kernels/shared/corner_choices.h"
#include "kernels/shared/surface.h"

namespace mortise::snio {
namespace {

constexpr double kLeastQuality = 1e-6;  ///< of a cone (kernels/shared/cone.h)

}  // namespace

Keeps keeps_template(const tape::BoundModel& model, const octree::Octree& tree,
                     const SnioCandidate& candidate, const SnappedLeaf& leaf) {
    if ((candidate.flags & kCandidateSimple) == 0) return Keeps::kNothing;
    if (candidate.needed != 0) return Keeps::kPerhaps;
    const std::uint64_t code = tree.nio[leaf.leaf].morton;
    const double cell = octree::Octree::edge_of(tree.level_of(code));
    const u32 cuts = cut_edges(candidate.inside, candidate.zero);
    SnioPoints points{};
    for (int c = 0; c < 8; ++c) std::copy(leaf.moved[c], leaf.moved[c] + 3, points.moved[c]);
    for (u32 rest = cuts; rest != 0; rest &= rest - 1) {
        const u32 e = mortise_lowest_bit(rest);
        const u32 low = kEdgeCorners[e][0];
        double a[3];
        double b[3];
        for (u32 j = 0; j < 3; ++j) {
            a[j] = gather_bits(code >> j) * tree.finest_edge() + ((low >> j) & 1u) * cell;
            b[j] = a[j] + (e / 4 == j ? cell : 0);
        }
        points.root[e] = edge_root(&model.surfaces[candidate.surface], model.expression_ops.data(), a, b);
    }
    double p[kCellNodes][3];
    grid_positions(p);
    leaf_positions(&points, leaf.snapped, cuts, 0, p);
    CornerChoices choices;
    forget_choices(leaf.snapped, &choices);
    const u32 inside = candidate.inside & ~u32{candidate.zero};
    if (have_templates(&face_plans(), inside, candidate.zero, 0, kAllLanes, p, 0, &choices) == 0)
        return Keeps::kNothing;
    if (inside == 0) return Keeps::kTemplate;
    // Nodes that should be on one plane may lie on both sides of it by their rounding.
    LeafTemplates found;
    choose_templates(&face_plans(), inside, candidate.zero, leaf.snapped, p, 0, 0, &found);
    const bool is_flat = found.method[0] == kMethodCone && !(found.cones.quality > kLeastQuality);
    return is_flat ? Keeps::kNothing : Keeps::kTemplate;
}

bool stays_hexahedron(const SnappedLeaf& leaf) {
    double p[8][3];
    for (u32 c = 0; c < 8; ++c) {
        const bool moves = ((leaf.snapped >> c) & 1) != 0;
        for (u32 j = 0; j < 3; ++j)
            p[c][j] = ((c >> j) & 1u) + (moves ? leaf.moved[c][j] / static_cast<double>(kCellUnits) : 0);
    }
    return positive_hexahedra(p) != 0;
}

}  // namespace mortise::snio
