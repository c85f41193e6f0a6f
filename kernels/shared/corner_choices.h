// Whether a leaf has a template, for all choices of its corners that may move. What belongs to a face depends
// on the face's own four corners only, so it is made once for each choice of these.
#ifndef MORTISE_SHARED_CORNER_CHOICES_H
#define MORTISE_SHARED_CORNER_CHOICES_H

#include "leaf_template.h"

#define kMostFaceFacets 3

// A face for one choice of its corners.
typedef struct FaceChoice {
    u32 nodes;    // of its polygon
    u32 no_apex;  // forbidden_apexes
    LoopEdges edges;
    u8 count;  // as in CellBoundary
    u8 mesh;
    u8 facet_count;
    u8 size[kMostFaceFacets];      // nodes of a facet
    u8 facet[kMostFaceFacets][4];  // as face_facet has them
} FaceChoice;

// The faces of one leaf. At first known[] is 0, and apex kNoApex.
typedef struct CornerChoices {
    u32 known[6];  // bit k: the face is known for choice k of its corners, in the order of its frame
    u32 apex;      // of the last cone that was found
    FaceChoice face[6][16];
} CornerChoices;

// Makes a face for corner states and positions p; returns 0 if it has no mesh.
MORTISE_FUNCTION int make_face_choice(u32 inside, u32 on, int f, const double (*p)[3], FaceChoice* face) {
    u8 node[5];
    const int count = face_outline(inside, on, f, node);
    if (count < 0) return 0;
    face->count = (u8)count;
    face->mesh = (u8)face_mesh_of(node, count, inside, p);
    face->nodes = 0;
    for (int i = 0; i < count; ++i) face->nodes |= 1u << node[i];
    face->no_apex = forbidden_apexes(node, count, face->mesh);
    find_loop_edges(inside, f, node, count, &face->edges);
    face->facet_count = 0;
    for (int i = 0; i < kMostFaceFacets; ++i) {
        const int size = polygon_facet(node, count, face->mesh, f, i, face->facet[i]);
        if (size == 0) break;
        face->size[i] = (u8)size;
        face->facet_count = (u8)(i + 1);
    }
    return 1;
}

// Whether all elements are positive that join an apex to the facets of a face.
MORTISE_FUNCTION int sees_face(const FaceChoice* face, const double (*p)[3], int apex) {
    for (int i = 0; i < face->facet_count; ++i) {
        const u8* facet = face->facet[i];
        const int size = face->size[i];
        if (facet_holds(facet, size, apex)) continue;
        for (int k = 0; k < (size == 4 ? 4 : 1); ++k) {
            if (!is_positive_corner(p[facet[k]], p[facet[k + 1 < size ? k + 1 : 0]],
                                    p[facet[k > 0 ? k - 1 : size - 1]], p[apex]))
                return 0;
        }
    }
    return 1;
}

// Whether Γ, with a loop of n nodes, can be divided for an apex: fans first. No facet of it lies on a face of
// the cell, since it is not known yet which faces have volume behind them.
MORTISE_FUNCTION int sees_surface(const u8* loop, int n, const double (*p)[3], int apex) {
    u32 faces[kLargestLoop];
    int place = -1;
    if (n == 0) return 1;
    for (int i = 0; i < n; ++i) {
        faces[i] = node_faces(loop[i]);
        if (loop[i] == apex) place = i;
    }
    for (int first = place >= 0 ? place : 0; first < (place >= 0 ? place + 1 : n); ++first) {
        int valid = 1;
        for (int i = 1; i + 1 < n && valid; ++i) {
            const int d = (first + i) % n;
            const int e = (first + i + 1) % n;
            valid = (faces[first] & faces[d] & faces[e]) == 0 &&
                    (place >= 0 || is_positive_corner(p[loop[e]], p[loop[d]], p[loop[first]], p[apex]));
        }
        if (valid) return 1;
    }
    if (place >= 0) return 0;
    {
        Cone cone;
        cone.elements = 0;
        return divide_surface(loop, n, p, p[apex], 0x3f, 0, &cone) > 0;
    }
}

// Whether best_cone finds a cone. The apex of the last choice is tried first.
MORTISE_FUNCTION int has_cone(const FaceChoice* const* face, const u8* loop, int n, double (*p)[3],
                              u32* last_apex) {
    u32 nodes = 0;
    u32 apexes = 1u << kCellInteriorNode;
    for (int f = 0; f < 6; ++f) nodes |= face[f]->nodes;
    apexes |= nodes;
    for (int f = 0; f < 6; ++f) apexes &= ~face[f]->no_apex;
    for (int i = -1; i <= kCellInteriorNode; ++i) {
        const u32 apex = i < 0 ? *last_apex : (u32)i;
        int valid = apex <= kCellInteriorNode && (apexes >> apex) & 1;
        if (i >= 0 && apex == *last_apex) continue;
        if (valid && apex == kCellInteriorNode) place_interior_node(nodes, p);
        for (int f = 0; f < 6 && valid; ++f) valid = sees_face(face[f], (const double(*)[3])p, (int)apex);
        if (valid && sees_surface(loop, n, (const double(*)[3])p, (int)apex)) {
            *last_apex = apex;
            return 1;
        }
    }
    return 0;
}

// Whether the wedge that a leaf's inside part may be is positive.
MORTISE_FUNCTION int has_wedge(u32 inside, u32 on, const double (*p)[3]) {
    CellBoundary b;
    if (make_boundary(inside, on, p, &b) != kMethodCone) return 0;
    {
        const int axis = wedge_axis(inside, on, &b);
        int n[6];
        if (axis < 0) return 0;
        wedge_nodes(&b, axis, n);
        return row_element_quality(p, 1, n) > 0;
    }
}

// Whether a leaf has a template for given corner states and positions p: one of several choices of corners
// that move, of which `moved` are those among `on` that do. rows_only: leaves without corners on the surface
// take their row, others none.
MORTISE_FUNCTION int has_template(u32 inside, u32 on, u32 moved, double (*p)[3], int rows_only,
                                  CornerChoices* choices) {
    const FaceChoice* face[6];
    const LoopEdges* edges[6];
    u8 loop[kLargestLoop];
    int loop_size;
    int whole = 0;
    if (inside == 0) return on != 0xff;
    for (int f = 0; f < 6; ++f) {
        u32 k = 0;
        for (u32 i = 0; i < 4; ++i) k |= ((moved >> kFaceCorners[f][i]) & 1u) << i;
        if (((choices->known[f] >> k) & 1) == 0) {
            if (!make_face_choice(inside, on, f, (const double(*)[3])p, &choices->face[f][k])) return 0;
            choices->known[f] |= 1u << k;
        }
        face[f] = &choices->face[f][k];
        edges[f] = &face[f]->edges;
        whole += face[f]->count == 4 && face[f]->mesh == kFaceWhole;
    }
    loop_size = link_loop(edges, loop);
    if (loop_size < 0) return 0;
    if (loop_size == 0 && whole == 6) return hexahedron_is_positive((const double(*)[3])p);
    if (on == 0) {
        const TemplateRow row = kTemplateRows[inside];
        return row.shape != 0 && row_is_positive(&row, p);
    }
    if (rows_only) return 0;
    return has_cone(face, loop, loop_size, p, &choices->apex) || has_wedge(inside, on, (const double(*)[3])p);
}

#endif
