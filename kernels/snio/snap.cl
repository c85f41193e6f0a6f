// Decides which grid vertices are moved onto the surface (docs/design/snapping.md).
//
// A vertex may move only if all leaves around it know one surface at most (IN and OUT leaves: none), the same
// one, and if each of them keeps a valid template whichever of its own vertices move. So one pass decides, in
// any order: nothing depends on what another vertex does. Leaves of the certificate never have a moved
// corner. A leaf that needs corners on the surface is meshed by a template only if all leaves around these
// are as sure; else it is one of the certificate's.
//
// IN leaves with a corner on the surface are promoted: they join the NIO leaves, with an empty tape, and get
// a template like them.
#include "shared/bounds.h"
#include "shared/corner_choices.h"
#include "snio/bins.h"

static void veto(__global uint* vetoes, uint leaf, uint corner) {
    atomic_or(vetoes + (leaf >> 2), 1u << (8 * (leaf & 3) + corner));
}

// No leaf of this level around corner c of one of them may move it.
static void veto_vertex(const Tree* tree, const BorderCells* cells, int level, uint c,
                        __global uint* vetoes) {
    for (uint d = 0; d < 8; ++d) {
        const Leaf leaf = leaf_at_corner(tree, cells, c, d);
        if (leaf.kind == kLeafNio && leaf.level == level) veto(vetoes, leaf.index, 7 - d);
    }
}

static void veto_corners(const Tree* tree, ulong own, __global uint* vetoes) {
    const int level = leaf_level(tree, own);
    const BorderCells cells = border_cells(tree, own, level);
    for (uint c = 0; c < 8; ++c) veto_vertex(tree, &cells, level, c, vetoes);
}

// Vetoes vertices that may not move for what the leaves around them are, and marks IN leaves to be promoted.
// A vertex between leaves of different levels does not move. The first leaf of a surface around a vertex
// looks after it for all of that surface and level.
//
// Reads the tree and candidates; sets bits of `vetoes` and `promoted` (atomics, order does not matter). One
// work-item handles one NIO leaf.
MORTISE_KERNEL void mark_vertices(TREE_PARAMETERS, __global const TreeNode* nio,
                                  __global const SnioCandidate* candidates, __global uint* vetoes,
                                  __global uint* promoted, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    const Tree tree = TREE_OF_PARAMETERS;
    const SnioCandidate candidate = candidates[item];
    const ulong own = nio[item].morton;
    const int level = leaf_level(&tree, own);
    const BorderCells cells = border_cells(&tree, own, level);
    const uint corners = (candidate.flags & kCandidateSimple) ? candidate.near | candidate.zero : 0;
    for (uint c = 0; c < 8; ++c) {
        Leaf in_leaves[8];
        uint in_count = 0;
        int allowed = 1;
        int is_first = 1;
        if (((corners >> c) & 1) == 0) continue;
        for (uint d = 0; d < 8 && is_first; ++d) {
            Leaf leaf;
            if (d == 7 - c) continue;  // this one
            leaf = leaf_at_corner(&tree, &cells, c, d);
            if (leaf.kind != kLeafNone && leaf.level != level) {
                allowed = 0;
            } else if (leaf.kind == kLeafIn) {
                in_leaves[in_count++] = leaf;
            } else if (leaf.kind == kLeafNio) {
                const SnioCandidate other = candidates[leaf.index];
                const int is_like =
                    (other.flags & kCandidateSimple) != 0 && other.surface == candidate.surface;
                allowed = allowed && is_like && other.region == candidate.region;
                is_first = !(is_like && d < 7 - c && (((other.near | other.zero) >> (7 - d)) & 1) != 0);
            }
        }
        if (!is_first) continue;
        if (!allowed) veto_vertex(&tree, &cells, level, c, vetoes);
        if (!allowed && ((candidate.zero >> c) & 1) == 0) continue;
        for (uint i = 0; i < in_count; ++i) {
            atomic_or(promoted + in_leaves[i].word, 1u << (uint)(in_leaves[i].code & 31));
        }
    }
}

// The bitmaps with promoted leaves moved from IN to NIO. One work-item handles one word.
MORTISE_KERNEL void promote_words(__global const uint* in_bits, __global const uint* nio_bits,
                                  __global const uint* promoted, __global uint* new_in_bits,
                                  __global uint* new_nio_bits, uint items) {
    const uint word = get_global_id(0);
    if (word >= items) return;
    new_nio_bits[word] = nio_bits[word] | promoted[word];
    new_in_bits[word] = in_bits[word] & ~promoted[word];
}

// Leaves and candidates of the new NIO bitmap, in Morton order.
//
// Reads the tree as it was (its NIO bitmap and rank; IN leaves are not looked at), the new bitmap and rank,
// the old lists and vetoes; writes new_nio, new_candidates, point_of, and promoted_points of leaves that are
// promoted: the others keep their points where they are. A promoted leaf takes surface, region and its
// corners from the old leaves around it; if these are not of one surface it is not simple, and keeps its
// corners. One work-item handles one word.
MORTISE_KERNEL void promote_leaves(TREE_PARAMETERS, __global const uint* new_nio_bits,
                                   __global const uint* new_nio_rank, __global const TreeNode* nio,
                                   __global const SnioCandidate* candidates,
                                   __global const SnioPoints* points, __global const uint* vetoes,
                                   __global TreeNode* new_nio, __global SnioCandidate* new_candidates,
                                   __global uint* point_of, __global SnioPoints* promoted_points,
                                   uint items) {
    const uint word = get_global_id(0);
    if (word >= items) return;
    const Tree tree = TREE_OF_PARAMETERS;
    uint to = new_nio_rank[word];
    uint from = nio_rank[word];
    for (uint rest = new_nio_bits[word]; rest != 0; rest &= rest - 1, ++to) {
        const uint bit = mortise_lowest_bit(rest);
        const ulong own = word_code(&tree, word) | bit;
        TreeNode node;
        SnioCandidate candidate;
        int mixed = 0;
        if ((nio_bits[word] >> bit) & 1) {
            node = nio[from];
            candidate = candidates[from];
            candidate.near &= ~(uchar)vetoes_of(vetoes, from);
            point_of[to] = from++;
        } else {
            const int level = leaf_level(&tree, own);
            const BorderCells cells = border_cells(&tree, own, level);
            __global SnioPoints* own_points = promoted_points + (to - from);
            point_of[to] = kPromotedPoints | (to - from);
            node.morton = own;
            node.tape_offset = 0;
            node.tape_length = 0;
            candidate.surface = kNoCandidateSurface;
            candidate.region = 0;
            candidate.inside = 0xff;
            candidate.zero = 0;
            candidate.near = 0;
            candidate.flags = kCandidateSimple | kCandidatePromoted;
            candidate.needed = 0;
            candidate.snapped = 0;
            // The places around: beside this leaf along the axes of `across`, on the high side along
            // those of `high`.
            for (uint place = 0; place < 64; ++place) {
                const uint across = place >> 3;
                const uint high = place & 7;
                const uint along = 7 & ~across;
                Leaf leaf;
                SnioCandidate other;
                uint on;
                if (across == 0 || (high & along) != 0) continue;
                // Corner c of this one is 7 - d of the other.
                leaf = leaf_at_corner(&tree, &cells, high, along | high);
                if (leaf.kind != kLeafNio || leaf.level != level) continue;
                other = candidates[leaf.index];
                if ((other.flags & kCandidateSimple) == 0) continue;
                other.near &= ~(uchar)vetoes_of(vetoes, leaf.index);
                on = other.zero | other.near;
                for (uint c = 0; c < 8 && on != 0; ++c) {
                    const uint theirs = c ^ across;
                    if ((c & across) != high || ((on >> theirs) & 1) == 0) continue;
                    if (candidate.surface == kNoCandidateSurface) {
                        candidate.surface = other.surface;
                        candidate.region = other.region;
                    }
                    if (candidate.surface != other.surface) mixed = 1;
                    candidate.zero |= ((other.zero >> theirs) & 1u) << c;
                    if (((other.near >> theirs) & 1) == 0) continue;
                    candidate.near |= 1u << c;
                    for (int j = 0; j < 3; ++j) own_points->moved[c][j] = points[leaf.index].moved[theirs][j];
                }
            }
            candidate.inside = (uchar)(0xff & ~candidate.zero);
            if (mixed) candidate.flags = kCandidatePromoted;
        }
        new_nio[to] = node;
        new_candidates[to] = candidate;
    }
}

// What leaves around vertices that snap beside complex leaves need to know, complex ones apart, after
// promotion.
//
// Reads   snapped, point_of; writes candidates and points. One work-item handles one leaf of `snapped`.
MORTISE_KERNEL void snap_corners_of(__global const SnappedLeaf* snapped, __global const uint* point_of,
                                    __global SnioCandidate* candidates, __global SnioPoints* found,
                                    __global SnioPoints* promoted_points, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    const uint leaf = snapped[item].leaf;
    const uint corners = snapped[item].snapped;
    __global SnioPoints* points = POINTS_OF(leaf);
    candidates[leaf].snapped = (uchar)corners;
    candidates[leaf].near &= ~(uchar)corners;
    if (snapped[item].region != 0) {
        candidates[leaf].region = snapped[item].region;
        if (snapped[item].surface != kNoCandidateSurface) {
            // Which surface a corner moves onto is told by the leaf's.
            if (candidates[leaf].near != 0 && candidates[leaf].surface != snapped[item].surface)
                candidates[leaf].flags |= kCandidateTorn;
            candidates[leaf].surface = snapped[item].surface;
        }
    }
    for (uint rest = corners; rest != 0; rest &= rest - 1) {
        const uint c = mortise_lowest_bit(rest);
        for (int j = 0; j < 3; ++j) points->moved[c][j] = snapped[item].moved[c][j];
    }
}

// Whether a leaf's subsets are to be tested, and what decides about them.
static int is_to_test(const SnioCandidate candidate) {
    if ((candidate.flags & kCandidateTorn) != 0) return 0;
    return (candidate.flags & kCandidateSimple) != 0 && (candidate.needed & ~candidate.near) == 0;
}
static Look look_of_candidate(const SnioCandidate candidate) {
    Look look;
    look.states = candidate.inside | ((uint)candidate.zero << 8) | ((uint)candidate.near << 16) |
                  ((uint)candidate.needed << 24);
    look.others = candidate.flags | ((uint)candidate.snapped << 8);
    look.corners = candidate.near | candidate.snapped;
    look.cuts = cut_edges(candidate.inside, candidate.zero);
    return look;
}

// Finds the flags of a bin's leaves, and empties it: kCandidateSimple if one has a template as it is,
// kCandidateSafe if it has one whichever of its near corners move, all that it needs among them.
MORTISE_NOINLINE void test_bin(Bin* bin, const Chunk* chunk, POINTS_PARAMETERS,
                               __global const FacePlans* plans, int snap, uchar* flags) {
    const uint inside = bin->states & 0xff;
    const uint zero = (bin->states >> 8) & 0xff;
    const uint near = (bin->states >> 16) & 0xff;
    const uint needed = bin->states >> 24;
    const uint before = bin->others & 0xff;
    const uint snapped = bin->others >> 8;
    const uint cuts = cut_edges(inside, zero);
    uint others[8];
    uint count = 0;
    uint subset = needed;
    LaneSet simple = kAllLanes;
    LaneSet safe = kAllLanes;
    Reals p[kCellNodes][3];
    Reals moved[8][3];
    CornerChoices choices;
    grid_positions(p);
    for (uint rest = near & ~needed; rest != 0; rest &= rest - 1) others[count++] = mortise_lowest_bit(rest);
    for (uint lane = 0; lane < kLanes; ++lane) {
        __global const SnioPoints* points = POINTS_OF(leaf_of_lane(chunk, bin, lane));
        leaf_positions(points, needed | snapped, cuts, lane, p);
        for (uint i = 0; i < count; ++i) {
            for (int j = 0; j < 3; ++j) set_lane(&moved[i][j], lane, moved_coordinate(points, others[i], j));
        }
    }
    forget_choices(snapped, &choices);
    // All subsets of `near` that hold `needed`, this one first; each differs from the one before in one
    // corner.
    for (uint i = 0;;) {
        const uint on = zero | subset;
        LaneSet valid = have_templates(plans, inside & ~on, on, subset, safe, p, !snap, &choices);
        if (subset == 0) {
            if ((before & kCandidatePromoted) != 0) valid = safe;
            simple = valid;
        }
        safe &= valid;
        if (++i >> count != 0 || safe == 0) break;
        const uint changed = mortise_lowest_bit(i);
        const uint c = others[changed];
        const int is_moved = ((subset ^= 1u << c) >> c) & 1;
        for (int j = 0; j < 3; ++j) {
            p[c][j] = (double)((c >> j) & 1);
            if (is_moved) p[c][j] = moved[changed][j];
        }
        choices.stale |= kNodeFaces[c];
    }
    for (uint lane = 0; lane < bin->count; ++lane) {
        const uint kept = (simple >> lane) & 1 ? before : before & ~(uint)kCandidateSimple;
        flags[bin->leaf[lane]] = (uchar)(kept | ((safe >> lane) & 1 ? (uint)kCandidateSafe : 0u));
    }
    bin->count = 0;
}

// Tests all simple leaves. The corners of one that is not safe stay, in all leaves around them.
//
// Reads the tree, nio, points, plans; reads and writes candidates; sets bits of `vetoes`. One work-item
// handles CHUNK leaves.
MORTISE_KERNEL void test_subsets(TREE_PARAMETERS, __global const TreeNode* nio, POINTS_PARAMETERS,
                                 __global SnioCandidate* candidates, __global const FacePlans* plans,
                                 __global uint* vetoes, int snap, uint leaves, uint items) {
    const uint first = CHUNK * get_global_id(0);
    const uint end = first + CHUNK < leaves ? first + CHUNK : leaves;
    const Tree tree = TREE_OF_PARAMETERS;
    Chunk chunk;
    uchar flags[CHUNK];
    if (get_global_id(0) >= items) return;
    clear_chunk(&chunk, first);
    for (uint leaf = first; leaf < end; ++leaf) {
        const SnioCandidate candidate = candidates[leaf];
        if (is_to_test(candidate)) {
            Bin* bin = enter_leaf(&chunk, leaf, look_of_candidate(candidate), POINTS);
            if (bin != 0) test_bin(bin, &chunk, POINTS, plans, snap, flags);
        }
    }
    for (uint i = 0; i < chunk.bin_count; ++i) {
        if (chunk.bins[i].count != 0) test_bin(chunk.bins + i, &chunk, POINTS, plans, snap, flags);
    }
    for (uint leaf = first; leaf < end; ++leaf) {
        const SnioCandidate candidate = candidates[leaf];
        const uint like = chunk.like[leaf - first];
        const uint tested = like != NO_PLACE ? flags[like] : candidate.flags;
        if (tested != candidate.flags) candidates[leaf].flags = (uchar)tested;
        if ((tested & kCandidateSafe) == 0 && candidate.near != 0)
            veto_corners(&tree, nio[leaf].morton, vetoes);
    }
}

// Whether every corner that a safe leaf needs moves: all leaves around it are safe, and need nothing else.
// These then find the same.
static int has_needed(const Tree* tree, __global const TreeNode* nio,
                      __global const SnioCandidate* candidates, uint index) {
    const uint needed = candidates[index].needed;
    const ulong own = nio[index].morton;
    const BorderCells cells = border_cells(tree, own, leaf_level(tree, own));
    for (uint c = 0; c < 8; ++c) {
        if (((needed >> c) & 1) == 0) continue;
        for (uint d = 0; d < 8; ++d) {
            const Leaf leaf = leaf_at_corner(tree, &cells, c, d);
            SnioCandidate other;
            uint same = 0;
            if (leaf.kind != kLeafNio) continue;
            other = candidates[leaf.index];
            if ((other.flags & kCandidateSafe) == 0) return 0;
            if (other.needed == 0) continue;
            // Corner k of that leaf, which has the vertex as its corner 7 - d, as a corner of this one.
            for (uint k = 0; k < 8; ++k) {
                int in_this = 1;
                uint here = 0;
                if (((other.needed >> k) & 1) == 0) continue;
                for (uint j = 0; j < 3; ++j) {
                    const int at = (int)((c >> j) & 1) + (int)((k >> j) & 1) - (int)(((7 - d) >> j) & 1);
                    in_this = in_this && (at == 0 || at == 1);
                    here |= (uint)(at & 1) << j;
                }
                if (!in_this) return 0;
                same |= 1u << here;
            }
            if (same != needed) return 0;
        }
    }
    return 1;
}

// Leaves that need what does not move keep all their corners.
//
// Reads the tree and candidates; sets bits of `vetoes`. One work-item handles one NIO leaf.
MORTISE_KERNEL void veto_needs(TREE_PARAMETERS, __global const TreeNode* nio,
                               __global const SnioCandidate* candidates, __global uint* vetoes, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    if (candidates[item].needed != 0 && (candidates[item].flags & kCandidateSafe) != 0) {
        const Tree tree = TREE_OF_PARAMETERS;
        if (!has_needed(&tree, nio, candidates, item)) veto_corners(&tree, nio[item].morton, vetoes);
    }
}
