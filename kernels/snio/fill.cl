// Chooses the template of each SNIO leaf, now that it is known which vertices move.
#include "shared/bounds.h"
#include "shared/leaf_template.h"
#include "snio/alike.h"

// Neighbour of a leaf across a face: what it means for facets on that face.
//   0: no volume there, and no certificate; 1: volume, or the certificate, which lists facets itself.
static int has_volume(const Tree* tree, __global const SnioCandidate* candidates, __global const uint* vetoes,
                      int level, ulong morton, int f) {
    int direction[3] = {0, 0, 0};
    Leaf beyond;
    direction[f / 2] = (f & 1) ? 1 : -1;
    beyond = leaf_beside(tree, morton, level, direction);
    if (beyond.kind != kLeafNio) return beyond.kind == kLeafIn;
    {
        const SnioCandidate candidate = candidates[beyond.index];
        const uint moved = moved_corners(candidate, vetoes_of(vetoes, beyond.index));
        if (!stays_simple(candidate, moved) || (candidate.flags & kCandidatePromoted) != 0) {
            return 1;
        }
        return (candidate.inside & ~(candidate.zero | moved)) != 0;
    }
}

// The template of a leaf with inside and outside corners, once for all that look like it.
typedef struct Choice {
    LeafTemplate found;
    int interior[3];  // in lattice units
} Choice;

MORTISE_NOINLINE void choose(__global const FacePlans* plans, __global const SnioPoints* points,
                             const Look look, uint facing, int snap, Choice* choice) {
    const uint inside = look.states & 0xff;
    const uint on = (look.states >> 8) & 0xff;
    const uint snapped = look.states >> 16;
    double p[kCellNodes][3];
    leaf_positions(points, look.corners, look.cuts, p);
    choose_template(plans, inside, on, snapped, p, facing, !snap, &choice->found);
    for (int j = 0; j < 3; ++j) {
        choice->interior[j] = 0;
        if (choice->found.method == kMethodRow && kTemplateRows[inside].interior_mean != 0)
            choice->interior[j] = (int)rint(p[kCellInteriorNode][j] * kCellUnits);
        if (choice->found.method == kMethodCone && choice->found.cone.apex == kCellInteriorNode)
            choice->interior[j] = (int)rint(choice->found.cone.point[j] * kCellUnits);
    }
}

// Elements of a leaf with a chosen template; the mask of its nodes and its facets, but for those on faces of
// the cell, are in *mask and *facets.
MORTISE_NOINLINE void take(const Choice* choice, uint inside, SnioLeaf* leaf, uint* elements, uint* mask,
                           uint* facets) {
    const CellBoundary* boundary = &choice->found.boundary;
    const Cone* cone = &choice->found.cone;
    leaf->method = (uchar)choice->found.method;
    for (int j = 0; j < 3; ++j) leaf->point[j] = choice->interior[j];
    if (leaf->method == kMethodRow) {
        const TemplateRow row = kTemplateRows[inside];
        *mask = row.corners | ((uint)row.cuts << 8) | (row.interior_mean != 0 ? 1u << kInteriorNodeBit : 0u);
        for (int t = 0; t < 4; ++t) elements[t] = row.elements[t];
        *facets = row.facets;
        return;
    }
    *mask = boundary->nodes;
    for (int f = 0; f < 6; ++f) {
        leaf->faces |= (ushort)(boundary->mesh[f] << (2 * f));
        if ((leaf->boundary >> f) & 1) *facets += boundary->mesh[f] == kFaceWhole ? 1 : 2;
    }
    if (leaf->method == kMethodHexahedron) {
        elements[0] = 1;
        return;
    }
    leaf->apex = (uchar)cone->apex;
    leaf->facet_count = (uchar)cone->facet_count;
    *facets += cone->facet_count;
    for (uint i = 0; i < cone->facet_count; ++i) leaf->facets[i] = cone->facets[i];
    if (leaf->method == kMethodWedge) {
        elements[1] = 1;
        return;
    }
    {
        int off_loop = 1;
        if (cone->apex == kCellInteriorNode) *mask |= 1u << kInteriorNodeBit;
        // The apex is on all facets of a face or on none (possible_apexes).
        for (int f = 0; f < 6; ++f) {
            const int count = boundary->count[f];
            if (facet_holds(boundary->node[f], count, (int)cone->apex)) continue;
            if (count == 4 && boundary->mesh[f] == kFaceWhole) {
                ++elements[2];
            } else if (count > 0) {
                elements[3] += (uint)count - 2;
            }
        }
        for (int i = 0; i < boundary->loop_size; ++i) {
            if (boundary->loop[i] == cone->apex) off_loop = 0;
        }
        for (uint i = 0; i < cone->facet_count && off_loop; ++i) {
            const uint facet = cone->facets[i];
            ++elements[((facet >> 12) & 15) != ((facet >> 8) & 15) ? 2 : 3];
        }
    }
}

// Reads the tree, nio, candidates, vetoes, points, plans; writes leaves[i], used[i] (the node mask of
// shared/tree.h), counts[t * stride + i] elements of type t and facet_counts[i], all zero for CNIO leaves.
// One work-item handles LEAVES leaves.
MORTISE_KERNEL void fill(TREE_PARAMETERS, __global const TreeNode* nio,
                         __global const SnioCandidate* candidates, __global const uint* vetoes,
                         POINTS_PARAMETERS, __global const FacePlans* plans, __global SnioLeaf* leaves,
                         __global uint* used, __global uint* counts, __global uint* facet_counts, uint stride,
                         int snap, uint items) {
    const uint first = LEAVES * get_global_id(0);
    const Tree tree = TREE_OF_PARAMETERS;
    Seen seen[PLACES];
    Choice choices[PLACES];
    if (get_global_id(0) >= items) return;
    for (uint i = 0; i < PLACES; ++i) seen[i].known = 0;
    for (uint item = first; item < first + LEAVES && item < stride; ++item) {
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
            __global const SnioPoints* points = POINTS_OF(item);
            Look look;
            uint at;
            look.states = inside | (on << 8) | ((uint)candidate.snapped << 16);
            look.others = facing;
            look.corners = displaced | candidate.snapped;
            look.cuts = cut_edges(inside, on);
            at = place_of_look(look, points);
            if (!looks_like(look, points, seen + at)) {
                seen[at].points = points;
                seen[at].look = look;
                seen[at].known = 1;
                choose(plans, points, look, facing, snap, choices + at);
            }
            take(choices + at, inside, &leaf, elements, &mask, &facets);
        }
        leaves[item] = leaf;
        used[item] = mask;
        for (int t = 0; t < 4; ++t) counts[t * stride + item] = elements[t];
        facet_counts[item] = facets;
    }
}
