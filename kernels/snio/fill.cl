// Chooses the template of each SNIO leaf, now that it is known which vertices move.
#include "shared/bounds.h"
#include "shared/leaf_template.h"

// Neighbour of a leaf across a face: what it means for facets on that face.
//   0: no volume there, and no certificate; 1: volume, or the certificate, which lists facets itself.
static int has_volume(const Tree* tree, __global const SnioCandidate* candidates, __global const uchar* moved,
                      int level, ulong morton, int f) {
    int direction[3] = {0, 0, 0};
    Leaf beyond;
    direction[f / 2] = (f & 1) ? 1 : -1;
    beyond = leaf_beside(tree, morton, level, direction);
    if (beyond.kind != kLeafNio) return beyond.kind == kLeafIn;
    {
        const SnioCandidate candidate = candidates[beyond.index];
        if (!stays_simple(candidate, moved[beyond.index]) || (candidate.flags & kCandidatePromoted) != 0) {
            return 1;
        }
        return (candidate.inside & ~(candidate.zero | moved[beyond.index])) != 0;
    }
}

// Reads the tree, nio, candidates, moved, points; writes leaves[i], used[i] (the node mask of
// shared/tree.h), counts[t * stride + i] elements of type t and facet_counts[i], all zero for CNIO leaves.
// One work-item handles one leaf.
MORTISE_KERNEL void fill(TREE_PARAMETERS, __global const TreeNode* nio,
                         __global const SnioCandidate* candidates, __global const uchar* moved,
                         __global const SnioPoints* points, __global SnioLeaf* leaves, __global uint* used,
                         __global uint* counts, __global uint* facet_counts, uint stride, int snap,
                         uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    {
        const Tree tree = TREE_OF_PARAMETERS;
        const SnioCandidate candidate = candidates[item];
        const ulong morton = nio[item].morton;
        const int level = leaf_level(&tree, morton);
        const uint displaced = moved[item];
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
            if (has_volume(&tree, candidates, moved, level, morton, f)) {
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
        } else if ((candidate.flags & kCandidatePromoted) != 0 && displaced == 0) {
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
            double p[kCellNodes][3];
            LeafTemplate found;
            leaf_positions(points + item, displaced, cut_edges(inside, on), p);
            choose_template(inside, on, p, facing, !snap, &found);
            leaf.method = (uchar)found.method;
            if (found.method == kMethodRow) {
                const TemplateRow row = kTemplateRows[inside];
                mask = row.corners | ((uint)row.cuts << 8) |
                       (row.interior_mean != 0 ? 1u << kInteriorNodeBit : 0u);
                for (int t = 0; t < 4; ++t) elements[t] = row.elements[t];
                facets = row.facets;
                for (int j = 0; j < 3; ++j) {
                    if (row.interior_mean != 0)
                        leaf.point[j] = (int)rint(p[kCellInteriorNode][j] * kCellUnits);
                }
            } else {
                mask = found.boundary.nodes;
                for (int f = 0; f < 6; ++f) {
                    leaf.faces |= (ushort)(found.boundary.mesh[f] << (2 * f));
                    if ((leaf.boundary >> f) & 1) facets += found.boundary.mesh[f] == kFaceWhole ? 1 : 2;
                }
                if (found.method == kMethodHexahedron) {
                    elements[0] = 1;
                } else if (found.method == kMethodWedge) {
                    leaf.apex = (uchar)found.cone.apex;
                    leaf.facet_count = 1;
                    leaf.facets[0] = found.cone.facets[0];
                    elements[1] = 1;
                    facets += 1;
                } else {
                    int off_loop = 1;
                    leaf.apex = (uchar)found.cone.apex;
                    leaf.facet_count = (uchar)found.cone.facet_count;
                    facets += found.cone.facet_count;
                    if (found.cone.apex == kCellInteriorNode) {
                        mask |= 1u << kInteriorNodeBit;
                        for (int j = 0; j < 3; ++j)
                            leaf.point[j] = (int)rint(found.cone.point[j] * kCellUnits);
                    }
                    for (int f = 0; f < 6; ++f) {
                        for (int i = 0; i < 3; ++i) {
                            uchar facet[4];
                            const int size = face_facet(&found.boundary, f, i, facet);
                            if (size == 0) break;
                            if (!facet_holds(facet, size, (int)found.cone.apex))
                                ++elements[size == 4 ? 2 : 3];
                        }
                    }
                    for (int i = 0; i < found.boundary.loop_size; ++i) {
                        if (found.boundary.loop[i] == found.cone.apex) off_loop = 0;
                    }
                    for (uint i = 0; i < found.cone.facet_count; ++i) {
                        const uint facet = found.cone.facets[i];
                        leaf.facets[i] = (ushort)facet;
                        if (off_loop) ++elements[((facet >> 12) & 15) != ((facet >> 8) & 15) ? 2 : 3];
                    }
                }
            }
        }
        leaves[item] = leaf;
        used[item] = mask;
        for (int t = 0; t < 4; ++t) counts[t * stride + item] = elements[t];
        facet_counts[item] = facets;
    }
}
