// Rounds of repositioning: every movable node looks for a better place, then those move that no other around
// them goes before. So each element has one node at most that moves in a round, and what a round does depends
// on neither the order nor the number of work-items.
#define MORTISE_ONE_LANE
#include "shared/reposition.h"

// Where nodes want to move.
//
// Reads   movable, star, points, surfaces, ops, rests[i]: not 0 if nothing around the node has changed since
// it was tried. Writes  moves[i], and rests[i]: 1. One work-item handles one movable node.
MORTISE_KERNEL void propose(__global const MovableNode* movable, __global const StarElement* star,
                            __global const double* points, __global const Surface* surfaces,
                            __global const ExpressionOp* ops, RepositionScale scale, __global uchar* rests,
                            __global NodeMove* moves, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    NodeStar s;
    if (rests[item] != 0) {
        moves[item].wanted = 0;
        return;
    }
    rests[item] = 1;
    s.star = star;
    s.points = points;
    s.ops = ops;
    s.scale = scale;
    s.node = movable[item];
    s.surface = s.node.surface != kFreeNode ? surfaces + s.node.surface : 0;
    moves[item] = find_move(&s);
}

// Moves the nodes that go first.
//
// Reads   movable, star, moves; movable_at: per node its place among the movable ones, or kNotMovable.
// Writes  points of nodes that move, moved[i]: 1 if it ever did; rests: 0 for all movable nodes around them,
//         and for those that did not move though they wanted to.
// One work-item handles one movable node.
MORTISE_KERNEL void settle(__global const MovableNode* movable, __global const StarElement* star,
                           __global const uint* movable_at, __global const NodeMove* moves,
                           __global double* points, __global uchar* rests, __global uchar* moved,
                           uint items) {
    const uint item = get_global_id(0);
    if (item >= items || moves[item].wanted == 0) return;
    const MovableNode node = movable[item];
    rests[item] = 0;
    if (!goes_first(star, node, movable_at, moves, item)) return;
    for (int j = 0; j < 3; ++j) points[3 * (ulong)node.node + j] = moves[item].point[j];
    moved[item] = 1;
    for (uint i = 0; i < node.elements; ++i) {
        __global const StarElement* e = star + node.first + i;
        for (int k = 0; k < kStarNodes[e->type]; ++k) {
            const uint other = movable_at[e->node[k]];
            if (other != kNotMovable) rests[other] = 0;
        }
    }
}
