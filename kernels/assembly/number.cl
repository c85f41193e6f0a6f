// Node numbering by ownership, node positions and connectivity (invariant 6 of ARCHITECTURE.md; rule in
// shared/tree.h).
//
// A piece is the leaves of one range [begin, end) of Morton codes, whole words of the bitmaps; kernels run
// over its words or its NIO leaves, from `first` on. Nodes that leaves outside the range own are foreign:
// they are numbered behind the piece's own nodes, by their place in the sorted list `foreign` of (Morton code
// of the owner << 5 | bit).
//
// A leaf's nodes are numbered base[leaf], base[leaf] + 1, …: first the owned bits of its mask, then (CNIO
// leaves) its owned extra nodes. Leaves are indexed by their rank among meshed leaves: IN rank + NIO rank.
// All arrays over leaves but the tree's and `used` hold the piece's leaves only (PieceRange).
#include "assembly/node_ids.h"
#include "shared/bounds.h"
#include "shared/face_plan.h"
#include "shared/leaves_before.h"
#include "shared/snap.h"
#include "shared/snio.h"
#include "shared/template_table.h"
#include "shared/tree.h"
#include "shared/tree_blocks.h"

// Mask of a cell that owns its last corner and nothing else, as cells have behind which all are meshed; the
// bits of a word all of whose cells are like that (tree_blocks.h).
#define kOwnsLast 0x80u
#define kAllInner 0xffffffffu

// The corner of a hexahedron's i-th node, and the reverse.
__constant uchar kHexahedronCorner[8] = {0, 1, 3, 2, 4, 5, 7, 6};

// Mask of the nodes that a leaf owns among those it uses.
MORTISE_NOINLINE uint owned_mask(const Tree* tree, __global const uint* used, ulong code, uint mark,
                                 uint mask) {
    if (!tree->shape.graded) return owned_of_uniform(tree, used, code, mask);
    const int level = (int)(mark & kMarkLevel);
    const uint edge = leaf_edge(tree, level);
    const uint x = gather_bits(code);
    const uint y = gather_bits(code >> 1);
    const uint z = gather_bits(code >> 2);
    uint owned = mask & (1u << kInteriorNodeBit);
    uint bit;
    for (uint c = 0; c < 8; ++c) {
        if (((mask >> c) & 1) && corner_owner(tree, used, code, mark, x, y, z, edge, c, &bit) == code) {
            owned |= 1u << c;
        }
    }
    for (uint e = 0; e < 12; ++e) {
        if (((mask >> (8 + e)) & 1) && own_edge_owner(tree, used, code, level, e, &bit) == code) {
            owned |= 1u << (8 + e);
        }
    }
    return owned;
}

// Owned masks and node counts of all meshed leaves.
//
// Reads the tree, used, extra_counts (owned extra nodes per NIO leaf); writes owned and counts by meshed
// rank. One work-item handles the leaves of one word of the bitmaps.
MORTISE_KERNEL void own_nodes(TREE_PARAMETERS, __global const uint* used, __global const uint* extra_counts,
                              __global uint* owned, __global uint* counts, PieceRange range, uint first,
                              uint items) {
    const uint word = get_global_id(0) + first;
    if (get_global_id(0) >= items) return;
    const Tree tree = TREE_OF_PARAMETERS;
    const uint in = in_bits[word];
    uint rest = in | nio_bits[word];
    uint nio = nio_rank[word];
    uint rank = in_rank[word] + nio;
    uint inner = 0;
    if (!shape.graded && in != 0) {
        TreeBlock block;
        make_block(&tree, word, &block);
        inner = inner_cells(&block);
    }
    if (inner == kAllInner) {
        const uint at = rank - range.first_in - range.first_nio;
        for (uint part = 0; part < 2; ++part) {
            vstore16((uint16)(kOwnsLast), part, owned + at);
            vstore16((uint16)(1), part, counts + at);
        }
        return;
    }
    while (rest != 0) {
        const uint bit = mortise_lowest_bit(rest);
        const int is_in = (in >> bit) & 1;
        uint mask = kOwnsLast;
        if (((inner >> bit) & 1) == 0) {
            mask = owned_mask(&tree, used, word_code(&tree, word) | bit, leaf_mark(&tree, rank),
                              is_in ? 0xffu : used[nio]);
        }
        owned[rank - range.first_in - range.first_nio] = mask;
        counts[rank - range.first_in - range.first_nio] =
            popcount(mask) + (is_in ? 0 : extra_counts[nio - range.first_nio]);
        nio += !is_in;
        ++rank;
        rest &= rest - 1;
    }
}

// Writes one point in model coordinates.
static void store_point(__global double* points, uint id, double4 origin_side, double x, double y, double z) {
    points[3 * (ulong)id] = model_coordinate(origin_side.x, origin_side.w, x);
    points[3 * (ulong)id + 1] = model_coordinate(origin_side.y, origin_side.w, y);
    points[3 * (ulong)id + 2] = model_coordinate(origin_side.z, origin_side.w, z);
}

// The nodes that a leaf owns, which begins at (x, y, z) in edges of its own.
MORTISE_NOINLINE void place_owned(const SnioLeaf* leaf, uint mask, uint id, uint x, uint y, uint z,
                                  double cell, __global const Surface* surfaces,
                                  __global const ExpressionOp* ops, __global double* points,
                                  double4 origin_side) {
    const double unit = cell / (double)kCellUnits;
    for (uint c = 0; c < 8; ++c) {
        double corner[3];
        int displacement[3] = {0, 0, 0};
        if (((mask >> c) & 1) == 0) continue;
        corner[0] = (x + (c & 1)) * cell;
        corner[1] = (y + ((c >> 1) & 1)) * cell;
        corner[2] = (z + (c >> 2)) * cell;
        if ((leaf->displaced >> c) & 1) {
            snap_displacement(surfaces + leaf->surface, ops, corner, cell, displacement);
        }
        store_point(points, id++, origin_side, corner[0] + displacement[0] * unit,
                    corner[1] + displacement[1] * unit, corner[2] + displacement[2] * unit);
    }
    if (leaf->pattern == kPatternCnio) return;
    for (uint e = 0; e < 12; ++e) {
        const uint c = kEdgeCorners[e][0];
        double a[3];
        double b[3];
        if (((mask >> (8 + e)) & 1) == 0) continue;
        a[0] = (x + (c & 1)) * cell;
        a[1] = (y + ((c >> 1) & 1)) * cell;
        a[2] = (z + (c >> 2)) * cell;
        for (uint j = 0; j < 3; ++j) b[j] = a[j] + (e / 4 == j ? cell : 0);
        a[e / 4] += edge_root(surfaces + leaf->surface, ops, a, b) * unit;
        store_point(points, id++, origin_side, a[0], a[1], a[2]);
    }
    if ((mask >> kInteriorNodeBit) & 1) {
        store_point(points, id, origin_side, x * cell + leaf->point[0] * unit,
                    y * cell + leaf->point[1] * unit, z * cell + leaf->point[2] * unit);
    }
}

// Positions of owned grid vertices (all leaves), moved ones on their surface, and of owned roots and interior
// nodes (SNIO leaves).
//
// Reads the tree, nio, leaves, surfaces, ops, owned, base; writes points (three doubles per node). The host
// writes the other nodes of CNIO leaves. One work-item handles one word of the bitmaps.
MORTISE_KERNEL void place_nodes(TREE_PARAMETERS, __global const SnioLeaf* leaves,
                                __global const Surface* surfaces, __global const ExpressionOp* ops,
                                __global const uint* owned, __global const uint* base,
                                __global double* points, double4 origin_side, PieceRange range, uint first,
                                uint items) {
    const uint word = get_global_id(0) + first;
    if (get_global_id(0) >= items) return;
    const Tree tree = TREE_OF_PARAMETERS;
    const uint in = in_bits[word];
    uint rest = in | nio_bits[word];
    uint nio = nio_rank[word];
    uint rank = in_rank[word] + nio;
    const ulong code = word_code(&tree, word);
    const uint low_x = gather_bits(code);
    const uint low_y = gather_bits(code >> 1);
    const uint low_z = gather_bits(code >> 2);
    if (is_plain(in, base + rank - range.first_in - range.first_nio)) {
        const double cell = 1.0 / (double)(1u << shape.level);
        const uint first_id = base[rank - range.first_in - range.first_nio];
        double3 at[4];
        for (uint i = 0; i < 4; ++i) {
            at[i].x = origin_side.x + origin_side.w * ((low_x + i + 1) * cell);
            at[i].y = origin_side.y + origin_side.w * ((low_y + i + 1) * cell);
            at[i].z = origin_side.z + origin_side.w * ((low_z + i + 1) * cell);
        }
        for (uint bit = 0; bit < 32; ++bit) {
            __global double* to = points + 3 * (ulong)(first_id + bit);
            to[0] = at[block_x(bit)].x;
            to[1] = at[block_y(bit)].y;
            to[2] = at[block_z(bit)].z;
        }
        return;
    }
    for (; rest != 0; rest &= rest - 1, ++rank) {
        const uint bit = mortise_lowest_bit(rest);
        const int is_in = (in >> bit) & 1;
        const int level = (int)(leaf_mark(&tree, rank) & kMarkLevel);
        const uint x = (low_x + block_x(bit)) >> (shape.level - level);
        const uint y = (low_y + block_y(bit)) >> (shape.level - level);
        const uint z = (low_z + block_z(bit)) >> (shape.level - level);
        const double cell = 1.0 / (double)(1u << level);
        const uint mask = owned[rank - range.first_in - range.first_nio];
        uint id = base[rank - range.first_in - range.first_nio];
        SnioLeaf leaf;
        if (is_in && mask == kOwnsLast) {  // nearly all of them
            store_point(points, id, origin_side, (x + 1) * cell, (y + 1) * cell, (z + 1) * cell);
            continue;
        }
        leaf.pattern = kPatternCnio;
        leaf.displaced = 0;
        if (!is_in) leaf = leaves[nio++ - range.first_nio];
        place_owned(&leaf, mask, id, x, y, z, cell, surfaces, ops, points, origin_side);
    }
}

// Hexahedra of IN leaves, eight node numbers each, in Morton order among the hexahedra of NIO leaves.
//
// Reads the tree, used, owned, base, hexahedron_offsets (scan of hexahedra per NIO leaf); writes hexahedra.
// One work-item handles one word of the bitmaps.
MORTISE_KERNEL void write_hexahedra(TREE_PARAMETERS, __global const uint* used, __global const uint* owned,
                                    __global const uint* base, __global const uint* hexahedron_offsets,
                                    __global const ulong* foreign, __global uint* hexahedra, PieceRange range,
                                    uint first, uint items) {
    const uint word = get_global_id(0) + first;
    if (get_global_id(0) >= items) return;
    const Tree tree = TREE_OF_PARAMETERS;
    const ulong code = word_code(&tree, word);
    uint rest = in_bits[word];
    uint rank = in_rank[word];
    uint inner = 0;
    uint ids[kBlockReach];
    if (!shape.graded && rest != 0) {
        // Blocks behind come first in Morton order, the one behind along all axes before all others.
        const ulong behind = cell_behind(code, 7);
        TreeBlock block;
        make_block(&tree, word, &block);
        if (behind != kNoOwner && behind >= range.begin) inner = inner_cells(&block);
        if (inner != 0) block_ids(&tree, &block, base, range, ids);
    }
    if (inner == kAllInner) {
        __global uint* out = hexahedra + 8 * (ulong)(rank - range.first_in +
                                                     hexahedron_offsets[nio_rank[word] - range.first_nio]);
        for (uint bit = 0; bit < 32; ++bit) vstore8(block_hexahedron(ids, bit), bit, out);
        return;
    }
    for (; rest != 0; rest &= rest - 1, ++rank) {
        const uint bit = mortise_lowest_bit(rest);
        const uint nio = nio_rank[word] + popcount(nio_bits[word] & ((1u << bit) - 1u));
        __global uint* out =
            hexahedra + 8 * (ulong)(rank - range.first_in + hexahedron_offsets[nio - range.first_nio]);
        if ((inner >> bit) & 1) {
            vstore8(block_hexahedron(ids, bit), 0, out);
        } else {
            uint corners[8];
            find_ids(&tree, used, owned, base, foreign, range, code | bit, nio + rank, 0xff, corners);
            for (uint i = 0; i < 8; ++i) out[i] = corners[kHexahedronCorner[i]];
        }
    }
}

// Elements and facets of a row of the table, at out[type] and `facets`.
MORTISE_NOINLINE void write_row(uint pattern, const uint* ids, __global uint* const* out,
                                __global uint* facets) {
    const uint sizes[4] = {8, 6, 5, 4};
    const TemplateRow row = kTemplateRows[pattern];
    uint at = row.first_node;
    for (int type = 0; type < 4; ++type) {
        for (uint i = 0; i < row.elements[type] * sizes[type]; ++i) out[type][i] = ids[kTemplateNodes[at++]];
    }
    for (uint i = 0; i < 4u * row.facets; ++i) {
        facets[i] = ids[kTemplateFacets[4 * row.first_facet + i]];
    }
}

// Elements of a wedge or a cone, and facets on the faces and the surface of any leaf with a boundary of its
// own.
MORTISE_NOINLINE void write_boundary(__global const FacePlans* plans, const SnioLeaf* leaf, const uint* ids,
                                     __global uint** out, __global uint* facets) {
    const uint inside = leaf->method == kMethodHexahedron ? 0xffu : leaf->pattern;
    CellBoundary boundary;
    int off_loop = 1;
    planned_outline(plans, inside, leaf->on & ~inside, &boundary);
    for (int f = 0; f < 6; ++f) boundary.mesh[f] = (leaf->faces >> (2 * f)) & 3;
    for (int f = 0; f < 6; ++f) {
        const int count = facet_count(boundary.count[f], boundary.mesh[f]);
        for (int i = 0; i < count; ++i) {
            uchar facet[4];
            const int size = face_facet(&boundary, f, i, facet);
            if (leaf->method == kMethodCone && !facet_holds(facet, size, leaf->apex)) {
                __global uint* to = out[size == 4 ? 2 : 3];
                for (int k = 0; k < size; ++k) to[k] = ids[facet[k]];
                to[size] = ids[leaf->apex];
                out[size == 4 ? 2 : 3] = to + size + 1;
            }
            if ((leaf->boundary >> f) & 1) {
                // Outward.
                for (int k = 0; k < 4; ++k) {
                    facets[k] = ids[facet[k < size ? size - 1 - k : 0]];
                }
                facets += 4;
            }
        }
    }
    if (leaf->method == kMethodWedge) {
        int n[6];
        wedge_nodes(&boundary, leaf->apex, n);
        for (int i = 0; i < 6; ++i) out[1][i] = ids[n[i]];
        off_loop = 0;
    }
    for (int i = 0; i < boundary.loop_size; ++i) {
        if (boundary.loop[i] == leaf->apex) off_loop = 0;
    }
    for (uint i = 0; i < leaf->facet_count; ++i) {
        uint n[4];
        for (int k = 0; k < 4; ++k) n[k] = ids[boundary.loop[(leaf->facets[i] >> (4 * k)) & 15]];
        for (int k = 0; k < 4; ++k) facets[k] = n[k];
        facets += 4;
        if (off_loop) {
            const int size = n[3] != n[2] ? 4 : 3;
            __global uint* to = out[size == 4 ? 2 : 3];
            for (int k = 0; k < size; ++k) to[k] = n[size - 1 - k];
            to[size] = ids[leaf->apex];
            out[size == 4 ? 2 : 3] = to + size + 1;
        }
    }
}

// Elements and surface facets of SNIO leaves, in Morton order.
//
// Reads the tree, nio, plans, leaves, used, owned, base, offsets[t * stride + i] of elements of type t before
// leaf i and facet_offsets; writes the node numbers of each type and of the facets. One work-item handles one
// NIO leaf.
MORTISE_KERNEL void write_templates(TREE_PARAMETERS, __global const TreeNode* nio,
                                    __global const FacePlans* plans, __global const SnioLeaf* leaves,
                                    __global const uint* used, __global const uint* owned,
                                    __global const uint* base, __global const uint* offsets,
                                    __global const uint* facet_offsets, __global const ulong* foreign,
                                    __global uint* hexahedra, __global uint* wedges, __global uint* pyramids,
                                    __global uint* tetrahedra, __global uint* facets, PieceRange range,
                                    uint stride, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    const Tree tree = TREE_OF_PARAMETERS;
    const SnioLeaf leaf = leaves[item];
    const ulong morton = nio[item + range.first_nio].morton;
    uint in_before;
    uint ids[21];
    if (leaf.pattern == kPatternCnio || leaf.method == kMethodNothing) return;
    in_before = count_before(&tree, in_bits, in_rank, morton);
    find_ids(&tree, used, owned, base, foreign, range, morton, in_before + range.first_nio + item,
             used[item + range.first_nio], ids);
    __global uint* out[4];
    __global uint* facets_out = facets + 4 * (ulong)facet_offsets[item];
    out[0] = hexahedra + 8 * (ulong)(in_before - range.first_in + offsets[item]);
    out[1] = wedges + 6 * (ulong)offsets[stride + item];
    out[2] = pyramids + 5 * (ulong)offsets[2 * stride + item];
    out[3] = tetrahedra + 4 * (ulong)offsets[3 * stride + item];
    if (leaf.method == kMethodRow) {
        write_row(leaf.pattern, ids, out, facets_out);
        return;
    }
    if (leaf.method == kMethodHexahedron) {
        for (uint i = 0; i < 8; ++i) out[0][i] = ids[kHexahedronCorner[i]];
        if (leaf.boundary == 0) return;
    }
    write_boundary(plans, &leaf, ids, out, facets_out);
}
