// Where simple leaves meet their surface: how far their corners may move onto it, and the roots on their cut
// edges.
//
// Formulas take long to evaluate, and four leaves and more have a corner or an edge in common: the first of
// those that agree about the surface finds the point, the others take it. A plane or quadric is evaluated
// again by each leaf, which costs less than looking for the first. Either way points are functions of
// position and surface alone.
#include "shared/bounds.h"
#include "shared/snap.h"
#include "shared/snio.h"
#include "shared/tree.h"
#include "snio/shared_points.h"
#include "snio/snap_lanes.h"

// Finds the points that no leaf before this one has.
//
// Reads   the tree, nio, surfaces, ops, candidates.
// Writes  points[i] of simple leaves, and their corners of those found here that may move, none if `snap` is
//         not set: candidates[i].near, or near[i] if others share them.
// One work-item handles one leaf.
MORTISE_KERNEL void find_points(TREE_PARAMETERS, __global const TreeNode* nio,
                                __global const Surface* surfaces, __global const ExpressionOp* ops,
                                __global SnioCandidate* candidates, __global SnioPoints* points,
                                __global uchar* near, int snap, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    {
        const Tree tree = TREE_OF_PARAMETERS;
        const SnioCandidate candidate = candidates[item];
        const ulong code = nio[item].morton;
        const int level = leaf_level(&tree, code);
        const double finest = 1.0 / (double)(1u << shape.level);
        const double cell = 1.0 / (double)(1u << level);
        const double x = (double)gather_bits(code) * finest;
        const double y = (double)gather_bits(code >> 1) * finest;
        const double z = (double)gather_bits(code >> 2) * finest;
        __global const Surface* surface = surfaces + candidate.surface;
        const int shared = is_shared(surface);
        const uint cuts = cut_edges(candidate.inside, candidate.zero);
        uint found = 0;
        uint first;
        int by_lanes = 0;
        if ((candidate.flags & kCandidateSimple) == 0) return;
#if LANES == 8
        by_lanes = has_lanes(surface);
        if (by_lanes && snap)
            found = snap_corners(surface, x, y, z, cell, ~(uint)candidate.zero & 0xff, points[item].moved);
#endif
        for (uint c = 0; c < 8 && snap && !by_lanes; ++c) {
            double corner[3];
            int displacement[3];
            if ((candidate.zero >> c) & 1) continue;
            if (shared &&
                first_at_corner(&tree, candidates, candidate.surface, code, level, c, &first) != 7 - c)
                continue;
            corner[0] = x + (c & 1) * cell;
            corner[1] = y + ((c >> 1) & 1) * cell;
            corner[2] = z + (c >> 2) * cell;
            if (!snap_displacement(surface, ops, corner, cell, displacement)) continue;
            found |= 1u << c;
            for (int j = 0; j < 3; ++j) points[item].moved[c][j] = displacement[j];
        }
        if (shared)
            near[item] = (uchar)found;
        else
            candidates[item].near = (uchar)found;
        for (uint e = 0; e < 12; ++e) {
            const int low = kEdgeCorners[e][0];
            double a[3];
            double b[3];
            if (((cuts >> e) & 1) == 0) continue;
            if (shared &&
                first_at_edge(&tree, candidates, candidate.surface, code, level, e, &first) != 3 - (e & 3))
                continue;
            a[0] = x + (low & 1) * cell;
            a[1] = y + ((low >> 1) & 1) * cell;
            a[2] = z + (low >> 2) * cell;
            for (int j = 0; j < 3; ++j) b[j] = a[j] + (e / 4 == (uint)j ? cell : 0);
            points[item].root[e] = edge_root(surface, ops, a, b);
        }
    }
}
