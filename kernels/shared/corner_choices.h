// Whether a leaf has a template, for all choices of its corners that may move. A face depends on its own four
// corners only: on their states, for which its plan is known, and on their positions, which decide between
// the plan's meshes, once for each choice of these corners.
#ifndef MORTISE_SHARED_CORNER_CHOICES_H
#define MORTISE_SHARED_CORNER_CHOICES_H

#include "leaf_template.h"

// One face of a leaf for one choice of its corners.
typedef struct FaceChoice {
    MORTISE_GLOBAL FacePlan* plan;
    MORTISE_GLOBAL FaceMeshPlan* mesh;  // not of a face without a polygon
} FaceChoice;

// The faces of one leaf. At first known[] is 0, apex and seen_from are kNoApex, and all faces are stale.
typedef struct CornerChoices {
    u32 snapped;    // corners that have moved as SnappedLeaf tells, for all choices
    u32 known[6];   // bit k: the mesh is known for choice k of the face's corners, in the order of its frame
    u32 seen[6];    // the same: whether the apex `seen_from` sees it, which bit 16 + k tells
    u32 seen_from;  // a node's code, + 32 if it has moved
    u32 apex;       // of the last cone that was found
    u32 whole;      // bit f: face f is a quadrilateral that is not split
    u8 mesh[6][16];
    u32 stale;      // bit f: for face f what follows is of an older choice than the last one
    u32 choice[6];  // of the face's corners
    FaceChoice face[6];
} CornerChoices;

// A face none of whose corners has moved is seen from all that is this far inside its plane: its facets are
// flat there, with angles above kRootMargin lattice units at each corner that FaceMeshPlan tells of.
#define kClearHeight 0.125

// Whether all elements are positive that join an apex to the facets of a face.
MORTISE_FUNCTION int sees_face(MORTISE_GLOBAL FaceMeshPlan* mesh, const double (*p)[3], u32 apex) {
    const int count = mesh->count;
    for (int i = 0; i < count; ++i) {
        if ((mesh->facet[i] >> apex) & 1) continue;
        if (!is_positive_corner(p[mesh->corner[i][0]], p[mesh->corner[i][1]], p[mesh->corner[i][2]], p[apex]))
            return 0;
    }
    return 1;
}

// Whether Γ, with a loop of n nodes, can be divided for an apex: fans first. No facet of it lies on a face of
// the cell, since it is not known yet which faces have volume behind them.
MORTISE_FUNCTION int sees_surface(MORTISE_GLOBAL LoopPlan* plan, const double (*p)[3], int apex) {
    const int n = plan->size;
    u8 loop[kLargestLoop];
    u32 faces[kLargestLoop];
    int place = -1;
    if (n == 0) return 1;
    for (int i = 0; i < n; ++i) {
        loop[i] = plan->node[i];
        faces[i] = kNodeFaces[loop[i]];
        if (loop[i] == apex) place = i;
    }
    for (int first = place >= 0 ? place : 0; first < (place >= 0 ? place + 1 : n); ++first) {
        int valid = 1;
        for (int i = 1; i + 1 < n && valid; ++i) {
            const int d = first + i < n ? first + i : first + i - n;
            const int e = d + 1 < n ? d + 1 : 0;
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

// Whether all faces, as they are in the last choice, are seen from an apex of which `moved` tells whether it
// has moved. What is known of a face from the same place is not asked again: most choices differ in others.
MORTISE_FUNCTION int sees_faces(const double (*p)[3], u32 apex, u32 moved, CornerChoices* choices) {
    const u32 from = apex | (((moved >> apex) & 1u) << 5);
    u32 asked = 0;  // faces
    for (int f = 0; f < 6; ++f) {
        const double at = p[apex][f / 2];
        const double height = (f & 1) ? 1 - at : at;
        asked |= (u32)(choices->choice[f] != 0 || !(height > kClearHeight)) << f;
    }
    for (u32 rest = choices->snapped; rest != 0; rest &= rest - 1)
        asked |= kNodeFaces[mortise_lowest_bit(rest)];
    if (apex == kCellInteriorNode) {  // somewhere else each time
        for (; asked != 0; asked &= asked - 1) {
            if (!sees_face(choices->face[mortise_lowest_bit(asked)].mesh, p, apex)) return 0;
        }
        return 1;
    }
    if (choices->seen_from != from) {
        choices->seen_from = from;
        for (int f = 0; f < 6; ++f) choices->seen[f] = 0;
    }
    for (; asked != 0; asked &= asked - 1) {
        const u32 f = mortise_lowest_bit(asked);
        const u32 k = choices->choice[f];
        if (((choices->seen[f] >> k) & 1) == 0)
            choices->seen[f] |= (1u | ((u32)sees_face(choices->face[f].mesh, p, apex) << 16)) << k;
        if (((choices->seen[f] >> (16 + k)) & 1) == 0) return 0;
    }
    return 1;
}

// Whether best_cone finds a cone. The apex of the last choice is tried first.
MORTISE_FUNCTION int has_cone(MORTISE_GLOBAL LoopPlan* loop, u32 moved, double (*p)[3],
                              CornerChoices* choices) {
    u32 nodes = 0;
    u32 forbidden = 0;
    for (int f = 0; f < 6; ++f) {
        nodes |= choices->face[f].plan->nodes;
        forbidden |= choices->face[f].mesh->no_apex;
    }
    {
        u32 apexes = (nodes | (1u << kCellInteriorNode)) & ~forbidden;
        u32 apex = choices->apex;
        if (apex >= kCellInteriorNode || ((apexes >> apex) & 1) == 0)
            apex = apexes != 0 ? mortise_lowest_bit(apexes) : kNoApex;
        while (apexes != 0) {
            if (apex == kCellInteriorNode) place_interior_node(nodes, p);
            if (sees_faces((const double(*)[3])p, apex, moved, choices) &&
                sees_surface(loop, (const double(*)[3])p, (int)apex)) {
                choices->apex = apex;
                return 1;
            }
            apexes &= ~(1u << apex);
            if (apexes != 0) apex = mortise_lowest_bit(apexes);
        }
    }
    return 0;
}

// Whether the wedge that a leaf's inside part may be is positive.
MORTISE_FUNCTION int has_wedge(MORTISE_GLOBAL FacePlans* plans, u32 inside, u32 on, u32 snapped,
                               const double (*p)[3]) {
    CellBoundary b;
    if (make_boundary(plans, inside, on, snapped, p, &b) != kMethodCone) return 0;
    {
        const int axis = wedge_axis(inside, on, &b);
        int n[6];
        if (axis < 0) return 0;
        wedge_nodes(&b, axis, n);
        return wedge_quality(p, n) > 0;
    }
}

// The mesh of a face, by its plan and the positions p; an empty one's is kFaceWhole.
MORTISE_FUNCTION int mesh_of_plan(MORTISE_GLOBAL FacePlan* plan, const double (*p)[3]) {
    const int rule = plan->rule;
    if (rule <= kFaceSplit13) return rule == kFaceEmpty ? kFaceWhole : rule;
    {
        u8 node[4];
        for (int i = 0; i < 4; ++i) node[i] = plan->node[i];
        return face_mesh_by(rule, node, p);
    }
}

// Brings faces up to date; all of them have polygons.
MORTISE_FUNCTION void choose_faces(MORTISE_GLOBAL FacePlans* plans, u32 inside, u32 on, u32 moved,
                                   const double (*p)[3], CornerChoices* choices) {
    const u32 moved_corners = plans->corners[moved];
    double q[kCellNodes][3];
    if (choices->snapped != 0) {
        face_positions(p, choices->snapped, q);
        p = (const double(*)[3])q;
    }
    for (u32 rest = choices->stale; rest != 0; rest &= rest - 1) {
        const u32 f = mortise_lowest_bit(rest);
        const u32 k = (moved_corners >> (4 * f)) & 15;
        MORTISE_GLOBAL FacePlan* plan = plan_of_face(plans, inside, on, f);
        choices->whole &= ~(1u << f);
        choices->choice[f] = k;
        choices->face[f].plan = plan;
        if (((choices->known[f] >> k) & 1) == 0) {
            choices->mesh[f][k] = (u8)mesh_of_plan(plan, p);
            choices->known[f] |= 1u << k;
        }
        choices->face[f].mesh = &plan->mesh[choices->mesh[f][k] - kFaceWhole];
        if (plan->count == 4 && choices->mesh[f][k] == kFaceWhole) choices->whole |= 1u << f;
    }
    choices->stale = 0;
}

// Whether a leaf has a template for given corner states and positions p: one of several choices of corners
// that move, of which `moved` are those among `on` that do. rows_only: leaves without corners on the surface
// take their row, others none.
MORTISE_FUNCTION int has_template(MORTISE_GLOBAL FacePlans* plans, u32 inside, u32 on, u32 moved,
                                  double (*p)[3], int rows_only, CornerChoices* choices) {
    MORTISE_GLOBAL LoopPlan* loop_plan =
        &plans->loop[plans->cell_states[inside] + 2 * plans->cell_states[on]];
    const int loop_size = loop_plan->size;
    if (inside == 0) return on != 0xff;
    if (loop_size == kNoLoop) return 0;
    choose_faces(plans, inside, on, moved, (const double(*)[3])p, choices);
    if (loop_size == 0 && choices->whole == 0x3f) return hexahedron_is_positive((const double(*)[3])p);
    if (on == 0) {
        const TemplateRow row = kTemplateRows[inside];
        return row.shape != 0 && row_is_positive(&row, p);
    }
    if (rows_only) return 0;
    return has_cone(loop_plan, moved, p, choices) ||
           has_wedge(plans, inside, on, choices->snapped, (const double(*)[3])p);
}

#endif
