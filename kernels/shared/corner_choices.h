// Whether a leaf has a template, for all choices of its corners that may move. A face depends on its own four
// corners only: on their states, for which its plan is known, and on their positions, which decide between
// the plan's meshes, once for each choice of these corners.
#ifndef MORTISE_SHARED_CORNER_CHOICES_H
#define MORTISE_SHARED_CORNER_CHOICES_H

#include "face_plan.h"
#include "leaf_template.h"

// One face of a leaf for one choice of its corners.
typedef struct FaceChoice {
    MORTISE_GLOBAL FacePlan* plan;
    MORTISE_GLOBAL FaceMeshPlan* mesh;  // not of a face without a polygon
} FaceChoice;

// The faces of one leaf. At first known[] is 0, and apex kNoApex.
typedef struct CornerChoices {
    u32 known[6];  // bit k: the mesh is known for choice k of the face's corners, in the order of its frame
    u32 apex;      // of the last cone that was found
    u32 whole;     // bit f: face f is a quadrilateral that is not split
    u32 failed;    // bit f: face f has no polygon
    u8 mesh[6][16];
    FaceChoice face[6];  // of the last choice, as what follows
    LoopEdges edges[6];
} CornerChoices;

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
MORTISE_FUNCTION int sees_surface(const u8* loop, int n, const double (*p)[3], int apex) {
    u32 faces[kLargestLoop];
    int place = -1;
    if (n == 0) return 1;
    for (int i = 0; i < n; ++i) {
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

// Whether best_cone finds a cone. The apex of the last choice is tried first.
MORTISE_FUNCTION int has_cone(const FaceChoice* face, const u8* loop, int n, double (*p)[3], u32* last_apex) {
    u32 nodes = 0;
    u32 forbidden = 0;
    for (int f = 0; f < 6; ++f) {
        nodes |= face[f].plan->nodes;
        forbidden |= face[f].mesh->no_apex;
    }
    {
        u32 apexes = (nodes | (1u << kCellInteriorNode)) & ~forbidden;
        u32 apex = *last_apex;
        if (apex > kCellInteriorNode || ((apexes >> apex) & 1) == 0)
            apex = apexes != 0 ? mortise_lowest_bit(apexes) : kNoApex;
        while (apexes != 0) {
            int valid = 1;
            if (apex == kCellInteriorNode) place_interior_node(nodes, p);
            for (int f = 0; f < 6 && valid; ++f) valid = sees_face(face[f].mesh, (const double(*)[3])p, apex);
            if (valid && sees_surface(loop, n, (const double(*)[3])p, (int)apex)) {
                *last_apex = apex;
                return 1;
            }
            apexes &= ~(1u << apex);
            if (apexes != 0) apex = mortise_lowest_bit(apexes);
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

// The mesh of a face, by its plan and the positions p.
MORTISE_FUNCTION int mesh_of_plan(MORTISE_GLOBAL FacePlan* plan, u32 inside, const double (*p)[3]) {
    u8 node[5];
    if (plan->count < 4) return kFaceWhole;
    for (int i = 0; i < 5; ++i) node[i] = plan->node[i];
    return face_mesh_of(node, plan->count, inside, p);
}

// Takes what belongs to some faces (bits of `changed`) from their plans.
MORTISE_FUNCTION void choose_faces(MORTISE_GLOBAL FacePlans* plans, u32 inside, u32 on, u32 moved,
                                   u32 changed, const double (*p)[3], CornerChoices* choices) {
    const u64 states = plans->states[inside] + 2 * plans->states[on];
    const u32 moved_corners = plans->corners[moved];
    for (u32 rest = changed; rest != 0; rest &= rest - 1) {
        const u32 f = mortise_lowest_bit(rest);
        const u32 k = (moved_corners >> (4 * f)) & 15;
        MORTISE_GLOBAL FacePlan* plan = &plans->plan[f][(states >> (8 * f)) & 0xff];
        choices->whole &= ~(1u << f);
        choices->failed &= ~(1u << f);
        choices->face[f].plan = plan;
        if (plan->count == kNoPolygon) {
            choices->failed |= 1u << f;
            continue;
        }
        if (((choices->known[f] >> k) & 1) == 0) {
            choices->mesh[f][k] = (u8)mesh_of_plan(plan, inside, p);
            choices->known[f] |= 1u << k;
        }
        choices->face[f].mesh = &plan->mesh[choices->mesh[f][k] - kFaceWhole];
        choices->edges[f] = plan->edges;
        if (plan->count == 4 && choices->mesh[f][k] == kFaceWhole) choices->whole |= 1u << f;
    }
}

// Whether a leaf has a template for given corner states and positions p: one of several choices of corners
// that move, of which `moved` are those among `on` that do. `changed`: the faces that are not as in the last
// choice. rows_only: leaves without corners on the surface take their row, others none.
MORTISE_FUNCTION int has_template(MORTISE_GLOBAL FacePlans* plans, u32 inside, u32 on, u32 moved, u32 changed,
                                  double (*p)[3], int rows_only, CornerChoices* choices) {
    u8 loop[kLargestLoop];
    int loop_size;
    choose_faces(plans, inside, on, moved, changed, (const double(*)[3])p, choices);
    if (inside == 0) return on != 0xff;
    if (choices->failed != 0) return 0;
    loop_size = link_loop(choices->edges, loop);
    if (loop_size < 0) return 0;
    if (loop_size == 0 && choices->whole == 0x3f) return hexahedron_is_positive((const double(*)[3])p);
    if (on == 0) {
        const TemplateRow row = kTemplateRows[inside];
        return row.shape != 0 && row_is_positive(&row, p);
    }
    if (rows_only) return 0;
    return has_cone(choices->face, loop, loop_size, p, &choices->apex) ||
           has_wedge(inside, on, (const double(*)[3])p);
}

#endif
