// The second half of points.cl, for formulas.
#include "shared/bounds.h"
#include "snio/shared_points.h"

// Takes the points of shared surfaces that a leaf before this one has found.
//
// Reads   the tree, nio, surfaces, near; of candidates and points what find_points has left.
// Writes  candidates[i].near, and the rest of points[i], of simple leaves.
// One work-item handles one leaf.
MORTISE_KERNEL void share_points(TREE_PARAMETERS, __global const TreeNode* nio,
                                 __global const Surface* surfaces, __global SnioCandidate* candidates,
                                 __global SnioPoints* points, __global const uchar* near, int snap,
                                 uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    const Tree tree = TREE_OF_PARAMETERS;
    const uint surface = candidates[item].surface;
    if ((candidates[item].flags & kCandidateSimple) == 0 || !is_shared(surfaces + surface)) return;
    const uint zero = candidates[item].zero;
    const uint cuts = cut_edges(candidates[item].inside, zero);
    const ulong code = nio[item].morton;
    const int level = leaf_level(&tree, code);
    uint all = near[item];
    uint first = 0;
    for (uint c = 0; c < 8 && snap; ++c) {
        if ((zero >> c) & 1) continue;
        const uint d = first_at_corner(&tree, candidates, surface, code, level, c, &first);
        if (d == 7 - c || ((near[first] >> (7 - d)) & 1) == 0) continue;
        all |= 1u << c;
        for (int j = 0; j < 3; ++j) points[item].moved[c][j] = points[first].moved[7 - d][j];
    }
    for (uint e = 0; e < 12; ++e) {
        if (((cuts >> e) & 1) == 0) continue;
        const uint d = first_at_edge(&tree, candidates, surface, code, level, e, &first);
        if (d != 3 - (e & 3)) points[item].root[e] = points[first].root[(e & ~3u) + 3 - d];
    }
    candidates[item].near = (uchar)all;
}
