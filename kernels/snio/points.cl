// Where simple leaves meet their surface: how far their corners may move onto it, and the roots on their cut
// edges.
//
// Four leaves and more have a corner or an edge in common. Formulas take long to evaluate: the first leaf of
// those that agree about the surface finds the point, the others take it. Points of planes and quadrics are
// found once for a row of leaves where a work-item handles one, else by each leaf, which costs less than
// looking for the first; there corners that move are found eight at a time. Either way points are functions
// of position and surface alone.
#include "shared/bounds.h"
#include "shared/snap.h"
#include "shared/snio.h"
#include "shared/tree.h"
#include "snio/row_points.h"
#include "snio/shared_points.h"

// The points of the leaves from `begin` to `end`.
MORTISE_NOINLINE void find_row(const Tree* tree, __global const TreeNode* nio,
                               __global const Surface* surfaces, __global const ExpressionOp* ops,
                               __global SnioCandidate* candidates, __global SnioPoints* points,
                               __global uchar* near, int snap, uint begin, uint end) {
    const double finest = 1.0 / (double)(1u << tree->shape.level);
#if LANES == 8
    RowCorners corners;
    RowRoots roots;
    clear_keys(&corners.keys);
    clear_keys(&roots.keys);
    for (uint leaf = begin; leaf < end && snap; ++leaf) {
        const SnioCandidate candidate = candidates[leaf];
        if ((candidate.flags & kCandidateSimple) == 0 || !has_lanes(surfaces + candidate.surface)) continue;
        const ulong code = nio[leaf].morton;
        const int level = leaf_level(tree, code);
        uint others = candidate.zero;  // corners that this leaf does not look after
        for (uint c = 0; c < 8 && is_shared(surfaces + candidate.surface); ++c) {
            uint first;
            if (((others >> c) & 1) == 0 &&
                first_at_corner(tree, candidates, candidate.surface, code, level, c, &first) != 7 - c)
                others |= 1u << c;
        }
        add_corners(&corners, leaf - begin, code, leaf_edge(tree, level),
                    point_kind(candidate.surface, level), others);
    }
    move_corners(&corners, surfaces, ops, finest);
#endif
    for (uint leaf = begin; leaf < end; ++leaf) {
        const SnioCandidate candidate = candidates[leaf];
        const ulong code = nio[leaf].morton;
        const int level = leaf_level(tree, code);
        const double cell = 1.0 / (double)(1u << level);
        const double x = (double)gather_bits(code) * finest;
        const double y = (double)gather_bits(code >> 1) * finest;
        const double z = (double)gather_bits(code >> 2) * finest;
        __global const Surface* surface = surfaces + candidate.surface;
        uint found = 0;
        uint first;
        int shared;
        int by_row = 0;
        if ((candidate.flags & kCandidateSimple) == 0) continue;
        shared = is_shared(surface);
#if LANES == 8
        by_row = has_lanes(surface);
        if (by_row && snap) found = take_corners(&corners, leaf - begin, points[leaf].moved);
#endif
        for (uint c = 0; c < 8 && snap && !by_row; ++c) {
            double corner[3];
            int displacement[3];
            if ((candidate.zero >> c) & 1) continue;
            if (shared &&
                first_at_corner(tree, candidates, candidate.surface, code, level, c, &first) != 7 - c)
                continue;
            corner[0] = x + (c & 1) * cell;
            corner[1] = y + ((c >> 1) & 1) * cell;
            corner[2] = z + (c >> 2) * cell;
            if (!snap_displacement(surface, ops, corner, cell, displacement)) continue;
            found |= 1u << c;
            for (int j = 0; j < 3; ++j) points[leaf].moved[c][j] = displacement[j];
        }
        if (shared)
            near[leaf] = (uchar)found;
        else
            candidates[leaf].near = (uchar)found;
        for (uint rest = cut_edges(candidate.inside, candidate.zero); rest != 0; rest &= rest - 1) {
            const uint e = mortise_lowest_bit(rest);
            const int low = kEdgeCorners[e][0];
            double a[3];
            double b[3];
            if (shared &&
                first_at_edge(tree, candidates, candidate.surface, code, level, e, &first) != 3 - (e & 3))
                continue;
            a[0] = x + (low & 1) * cell;
            a[1] = y + ((low >> 1) & 1) * cell;
            a[2] = z + (low >> 2) * cell;
            for (int j = 0; j < 3; ++j) b[j] = a[j] + (e / 4 == (uint)j ? cell : 0);
#if LANES == 8
            if (by_row && !shared) {
                uint is_new;
                const uint index =
                    index_of_point(&roots.keys, vertex_at(first_vertex(code), leaf_edge(tree, level), low),
                                   (point_kind(candidate.surface, level) << 2) | (e / 4), &is_new);
                if (is_new) roots.root[index] = edge_root(surface, ops, a, b);
                points[leaf].root[e] = roots.root[index];
                continue;
            }
#endif
            points[leaf].root[e] = edge_root(surface, ops, a, b);
        }
    }
}

// Finds the points that no leaf before has.
//
// Reads   the tree, nio, surfaces, ops, candidates.
// Writes  points[i] of simple leaves, and their corners of those found here that may move, none if `snap` is
//         not set: candidates[i].near, or near[i] if others share them.
// One work-item handles LEAVES of the `leaves`.
MORTISE_KERNEL void find_points(TREE_PARAMETERS, __global const TreeNode* nio,
                                __global const Surface* surfaces, __global const ExpressionOp* ops,
                                __global SnioCandidate* candidates, __global SnioPoints* points,
                                __global uchar* near, int snap, uint leaves, uint items) {
    const uint begin = LEAVES * get_global_id(0);
    const uint end = begin + LEAVES < leaves ? begin + LEAVES : leaves;
    if (get_global_id(0) >= items) return;
    const Tree tree = TREE_OF_PARAMETERS;
    find_row(&tree, nio, surfaces, ops, candidates, points, near, snap, begin, end);
}
