// Chooses the template of each SNIO leaf, now that it is known which vertices move.
#include "shared/bounds.h"
#include "shared/leaf_template.h"
#include "snio/bins.h"

// Neighbour of a leaf across a face: what it means for facets on that face.
//   0: no volume there, and no certificate; 1: volume, or the certificate, which lists facets itself.
static int has_volume(const Tree* tree, __global const SnioCandidate* candidates, __global const uint* vetoes,
                      int level, ulong morton, int f) {
    const Leaf beyond = leaf_beyond(tree, morton, level, f);
    if (beyond.kind != kLeafNio) return beyond.kind == kLeafIn;
    const SnioCandidate candidate = candidates[beyond.index];
    const uint moved = moved_corners(candidate, vetoes_of(vetoes, beyond.index));
    if (!stays_simple(candidate, moved) || (candidate.flags & kCandidatePromoted) != 0) {
        return 1;
    }
    return (candidate.inside & ~(candidate.zero | moved)) != 0;
}

// What `fill` writes.
typedef struct Filled {
    __global SnioLeaf* leaves;
    __global uint* used;
    __global uint* counts;
    __global uint* facet_counts;
    uint stride;
} Filled;

static void write_counts(const Filled* filled, uint item, uint mask, const uint* elements, uint facets) {
    filled->used[item] = mask;
    for (uint t = 0; t < 4; ++t) filled->counts[t * filled->stride + item] = elements[t];
    filled->facet_counts[item] = facets;
}

// A leaf's row of the table, whose interior node lies at `interior`.
static void fill_row(const Filled* filled, uint item, uint inside, uint lane, const Reals* interior,
                     SnioLeaf* leaf) {
    const TemplateRow row = kTemplateRows[inside];
    const int has_interior = row.interior_mean != 0;
    const uint mask = row.corners | ((uint)row.cuts << 8) | (has_interior ? 1u << kInteriorNodeBit : 0u);
    uint elements[4];
    for (int t = 0; t < 4; ++t) elements[t] = row.elements[t];
    for (int j = 0; j < 3 && has_interior; ++j)
        leaf->point[j] = (int)rint(get_lane(interior + j, lane) * kCellUnits);
    write_counts(filled, item, mask, elements, row.facets);
}

// Elements of a cone; *mask gets its interior node.
static void count_cone(const CellBoundary* boundary, const Cones* cones, uint lane, uint* elements,
                       uint* mask) {
    const uint apex = cones->apex[lane];
    int off_loop = 1;
    if (apex == kCellInteriorNode) *mask |= 1u << kInteriorNodeBit;
    // The apex is on all facets of a face or on none (possible_apexes).
    for (int f = 0; f < 6; ++f) {
        const int count = boundary->count[f];
        if (facet_holds(boundary->node[f], count, (int)apex)) continue;
        if (count == 4 && boundary->mesh[f] == kFaceWhole) {
            ++elements[2];
        } else if (count > 0) {
            elements[3] += (uint)count - 2;
        }
    }
    for (int i = 0; i < boundary->loop_size; ++i) {
        if (boundary->loop[i] == apex) off_loop = 0;
    }
    for (uint i = 0; i < cones->facet_count[lane] && off_loop; ++i) {
        const uint facet = cones->facets[lane][i];
        ++elements[((facet >> 12) & 15) != ((facet >> 8) & 15) ? 2 : 3];
    }
}

// A leaf's cone or wedge: all but its boundary.
static void fill_cone(const LeafTemplates* templates, uint lane, uint* elements, uint* mask, SnioLeaf* leaf) {
    const Cones* cones = &templates->cones;
    leaf->apex = cones->apex[lane];
    leaf->facet_count = cones->facet_count[lane];
    for (uint i = 0; i < leaf->facet_count; ++i) leaf->facets[i] = cones->facets[lane][i];
    if (leaf->method == kMethodWedge) {
        elements[1] = 1;
        return;
    }
    count_cone(&templates->boundary, cones, lane, elements, mask);
    for (int j = 0; j < 3 && leaf->apex == kCellInteriorNode; ++j)
        leaf->point[j] = (int)rint(get_lane(cones->point + j, lane) * kCellUnits);
}

// A leaf's template but a row: the nodes' mask, and facets but for those on faces of the cell.
static void fill_others(const Filled* filled, uint item, LeafTemplates* templates, uint lane,
                        SnioLeaf* leaf) {
    const CellBoundary* boundary = &templates->boundary;
    uint elements[4] = {0, 0, 0, 0};
    uint mask = boundary->nodes;
    uint facets = 0;
    take_meshes(templates, lane);
    for (int f = 0; f < 6; ++f) {
        leaf->faces |= (ushort)(boundary->mesh[f] << (2 * f));
        if ((leaf->boundary >> f) & 1) facets += boundary->mesh[f] == kFaceWhole ? 1 : 2;
    }
    if (leaf->method == kMethodHexahedron) {
        elements[0] = 1;
    } else {
        fill_cone(templates, lane, elements, &mask, leaf);
        facets += leaf->facet_count;
    }
    write_counts(filled, item, mask, elements, facets);
}

// Chooses the templates of a bin's leaves, which have inside and outside corners, and empties it.
MORTISE_NOINLINE void fill_bin(Bin* bin, const Chunk* chunk, POINTS_PARAMETERS,
                               __global const FacePlans* plans, int snap, const Filled* filled) {
    const uint inside = bin->states & 0xff;
    Reals p[kCellNodes][3];
    LeafTemplates templates;
    grid_positions(p);
    for (uint lane = 0; lane < kLanes; ++lane) {
        const uint leaf = leaf_of_lane(chunk, bin, lane);
        const Look look = chunk->looks[leaf - chunk->first];  // N corners have moved, or not
        leaf_positions(POINTS_OF(leaf), look.corners, look.cuts, lane, p);
    }
    choose_templates(plans, inside, (bin->states >> 8) & 0xff, bin->states >> 16, p, bin->others, !snap,
                     &templates);
    for (uint lane = 0; lane < bin->count; ++lane) {
        const uint item = leaf_of_lane(chunk, bin, lane);
        SnioLeaf leaf = filled->leaves[item];
        leaf.method = (uchar)templates.method[lane];
        if (leaf.method == kMethodRow) {
            fill_row(filled, item, inside, lane, p[kCellInteriorNode], &leaf);
        } else {
            fill_others(filled, item, &templates, lane, &leaf);
        }
        filled->leaves[item] = leaf;
    }
    bin->count = 0;
}

// What a leaf takes from one that looks like it.
static void copy_template(const Filled* filled, uint from, uint to) {
    const SnioLeaf other = filled->leaves[from];
    SnioLeaf leaf = filled->leaves[to];
    leaf.method = other.method;
    leaf.apex = other.apex;
    leaf.faces = other.faces;
    leaf.facet_count = other.facet_count;
    for (int i = 0; i < kMostSurfaceFacets; ++i) leaf.facets[i] = other.facets[i];
    for (int j = 0; j < 3; ++j) leaf.point[j] = other.point[j];
    filled->leaves[to] = leaf;
    filled->used[to] = filled->used[from];
    for (uint t = 0; t < 4; ++t)
        filled->counts[t * filled->stride + to] = filled->counts[t * filled->stride + from];
    filled->facet_counts[to] = filled->facet_counts[from];
}

// Reads the tree, nio, candidates, vetoes, points, plans; writes leaves[i], used[i] (the node mask of
// shared/tree.h), counts[t * stride + i] elements of type t and facet_counts[i], all zero for CNIO leaves.
// One work-item handles CHUNK leaves.
MORTISE_KERNEL void fill(TREE_PARAMETERS, __global const TreeNode* nio,
                         __global const SnioCandidate* candidates, __global const uint* vetoes,
                         POINTS_PARAMETERS, __global const FacePlans* plans, __global SnioLeaf* leaves,
                         __global uint* used, __global uint* counts, __global uint* facet_counts, uint stride,
                         int snap, uint items) {
    const uint first = CHUNK * get_global_id(0);
    const uint end = first + CHUNK < stride ? first + CHUNK : stride;
    const Tree tree = TREE_OF_PARAMETERS;
    Chunk chunk;
    Filled filled;
    if (get_global_id(0) >= items) return;
    filled.leaves = leaves;
    filled.used = used;
    filled.counts = counts;
    filled.facet_counts = facet_counts;
    filled.stride = stride;
    clear_chunk(&chunk, first);
    for (uint item = first; item < end; ++item) {
        const SnioCandidate candidate = candidates[item];
        const ulong morton = nio[item].morton;
        const int level = leaf_level(&tree, morton);
        const uint displaced = moved_corners(candidate, vetoes_of(vetoes, item));
        const uint on = candidate.zero | displaced;
        const uint inside = candidate.inside & ~on;
        uint elements[4] = {0, 0, 0, 0};
        uint facets = 0;
        uint mask = 0;
        uint facing = 0;
        int is_open = 0;  // has inside and outside corners
        SnioLeaf leaf;
        leaf.surface = candidate.surface;
        leaf.pattern = (ushort)inside;
        leaf.region = candidate.region;
        leaf.on = (uchar)on;
        leaf.displaced = (uchar)displaced;
        leaf.snapped = candidate.snapped;
        for (int j = 0; j < 3; ++j) leaf.padding[j] = 0;
        leaf.method = kMethodNothing;
        leaf.apex = kNoApex;
        leaf.faces = 0;
        leaf.boundary = 0;
        leaf.facet_count = 0;
        for (int i = 0; i < kMostSurfaceFacets; ++i) leaf.facets[i] = 0;
        for (int j = 0; j < 3; ++j) leaf.point[j] = 0;
        for (int f = 0; f < 6; ++f) {
            uint on_face = 0;
            for (int i = 0; i < 4; ++i) on_face += (on >> kFaceCorners[f][i]) & 1;
            if (on_face < 3) continue;
            if (has_volume(&tree, candidates, vetoes, level, morton, f)) {
                facing |= 1u << f;
            } else if (on_face == 4) {
                leaf.boundary |= (uchar)(1u << f);
            }
        }
        if (!stays_simple(candidate, displaced) && (candidate.flags & kCandidatePromoted) == 0) {
            leaf.pattern = kPatternCnio;
            leaf.region = 0;
            leaf.on = 0;
            leaf.boundary = 0;
        } else if ((candidate.flags & kCandidatePromoted) != 0 && (displaced | candidate.snapped) == 0) {
            // As the IN leaf that it was, whatever its corners are.
            leaf.method = kMethodHexahedron;
            for (int f = 0; f < 6; ++f) leaf.faces |= (ushort)(kFaceWhole << (2 * f));
            mask = 0xff;
            elements[0] = 1;
            facets = popcount((uint)leaf.boundary);
        } else if (inside == 0xff) {
            leaf.method = kMethodHexahedron;
            mask = 0xff;
            elements[0] = 1;
        } else if (inside == 0) {
            leaf.boundary = 0;
        } else {
            is_open = 1;
        }
        leaves[item] = leaf;
        if (is_open) {
            Look look;
            Bin* bin;
            look.states = inside | (on << 8) | ((uint)candidate.snapped << 16);
            look.others = facing;
            look.corners = displaced | candidate.snapped;
            look.cuts = cut_edges(inside, on);
            bin = enter_leaf(&chunk, item, look, POINTS);
            if (bin != 0) fill_bin(bin, &chunk, POINTS, plans, snap, &filled);
        } else {
            write_counts(&filled, item, mask, elements, facets);
        }
    }
    for (uint i = 0; i < chunk.bin_count; ++i) {
        if (chunk.bins[i].count != 0) fill_bin(chunk.bins + i, &chunk, POINTS, plans, snap, &filled);
    }
    for (uint item = first; item < end; ++item) {
        const uint like = chunk.like[item - first];
        if (like != NO_PLACE && like != item - first) copy_template(&filled, first + like, item);
    }
}
