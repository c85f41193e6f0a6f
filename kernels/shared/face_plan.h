// What the states of a face's four corners tell of it, whatever their positions: its polygon, and the facets
// of each mesh that the polygon may have; and what those of a cell's eight tell of Γ: its loop. The host
// makes all of them once (host/snio/face_plans.cpp) from the functions of cell_boundary.h.
#ifndef MORTISE_SHARED_FACE_PLAN_H
#define MORTISE_SHARED_FACE_PLAN_H

#include "cell_boundary.h"

#define kFaceStates 81    // of four corners, three each
#define kCellStates 6561  // of eight
#define kMostFaceCorners 4
#define kNoPolygon 255

// A mesh of a face: where a facet's edges meet that an apex sees. One corner of each triangle, four of a
// quadrilateral.
typedef struct FaceMeshPlan {
    u32 no_apex;  // forbidden_apexes
    u8 count;     // of corners
    u8 padding[3];
    u32 facet[kMostFaceCorners];     // the set of nodes of the corner's facet
    u8 corner[kMostFaceCorners][4];  // its node, the next and the one before; the facet's size
} FaceMeshPlan;

typedef struct FacePlan {
    u32 nodes;  // of the polygon: the set of them
    u8 count;   // and in order; kNoPolygon: two opposite I face two opposite O
    u8 node[5];
    u8 rule;  // face_rule
    u8 padding;
    FaceMeshPlan mesh[kFaceMeshes];
} FacePlan;

#define kNoLoop 255

// The loop of Γ as link_loop makes it; size kNoLoop: several, or one that touches itself or is too long, or a
// face without a polygon.
typedef struct LoopPlan {
    u8 size;
    u8 node[kLargestLoop];
} LoopPlan;

typedef struct FacePlans {
    u64 states[256];       // of a set of corners: byte f is the sum of 3^i over corners i of face f's frame
    u32 corners[256];      // the same: bits 4 f to 4 f + 3 are the corners of face f's frame
    u32 cell_states[256];  // the same: the sum of 3^c over the corners c
    FacePlan plan[6][kFaceStates];  // state: sum of I corners + 2 (sum of N corners)
    LoopPlan loop[kCellStates];     // by the cell's state
} FacePlans;

// Nodes of a face's polygon from which no cone has its facets: those that are not on all of them, and any
// where they are not triangles.
MORTISE_FUNCTION u32 forbidden_apexes(const u8* n, int count, int mesh) {
    u32 on_face = 0;
    u32 allowed = 0;
    for (int i = 0; i < count; ++i) on_face |= 1u << n[i];
    if (count == 5) {
        allowed = 1u << n[pentagon_apex(n, mesh)];
    } else if (mesh == kFaceSplit02) {
        allowed = (1u << n[0]) | (1u << n[2]);
    } else if (mesh == kFaceSplit13) {
        allowed = (1u << n[1]) | (1u << n[3]);
    } else if (count == 3) {
        allowed = on_face;
    }
    return on_face & ~allowed;
}

MORTISE_FUNCTION void make_face_mesh_plan(const u8* node, int count, int mesh, int f, FaceMeshPlan* plan) {
    plan->no_apex = forbidden_apexes(node, count, mesh);
    plan->count = 0;
    for (int i = 0; i < facet_count(count, mesh); ++i) {
        u8 facet[4];
        const int size = polygon_facet(node, count, mesh, f, i, facet);
        u32 set = 0;
        for (int k = 0; k < size; ++k) set |= 1u << facet[k];
        for (int k = 0; k < (size == 4 ? 4 : 1); ++k) {
            u8* corner = plan->corner[plan->count];
            plan->facet[plan->count++] = set;
            corner[0] = facet[k];
            corner[1] = facet[k + 1 < size ? k + 1 : 0];
            corner[2] = facet[k > 0 ? k - 1 : size - 1];
            corner[3] = (u8)size;
        }
    }
}

// The facet whose corner i is the next: its nodes, counter-clockwise seen from inside the cell, and their
// number.
MORTISE_FUNCTION u32 mesh_facet(MORTISE_GLOBAL FaceMeshPlan* mesh, u32 i, u8* facet) {
    const u32 size = mesh->corner[i][3];
    for (u32 k = 0; k < size; ++k) facet[k] = size == 4 ? mesh->corner[i + k][0] : mesh->corner[i][k];
    return size;
}

// Of face f, for sets of the cell's corners; only those of the face matter. `edges`: of a face with a
// polygon, for link_loop.
MORTISE_FUNCTION void make_face_plan(u32 inside, u32 on, int f, FacePlan* plan, LoopEdges* edges) {
    u8 node[5];
    const int count = face_outline(inside, on, f, node);
    plan->count = (u8)(count < 0 ? kNoPolygon : count);
    if (count < 0) return;
    plan->rule = (u8)face_rule(node, count, inside);
    for (int i = 0; i < count; ++i) {
        plan->node[i] = node[i];
        plan->nodes |= 1u << node[i];
    }
    find_loop_edges(inside, f, node, count, edges);
    make_face_mesh_plan(node, count, count > 0 ? kFaceWhole : kFaceEmpty, f, &plan->mesh[0]);
    if (count < 4) return;
    make_face_mesh_plan(node, count, kFaceSplit02, f, &plan->mesh[1]);
    make_face_mesh_plan(node, count, kFaceSplit13, f, &plan->mesh[2]);
}

// The plan of face f.
MORTISE_FUNCTION MORTISE_GLOBAL FacePlan* plan_of_face(MORTISE_GLOBAL FacePlans* plans, u32 inside, u32 on,
                                                       u32 f) {
    const u64 states = plans->states[inside] + 2 * plans->states[on];
    return &plans->plan[f][(states >> (8 * f)) & 0xff];
}

// The state of a cell.
MORTISE_FUNCTION u32 cell_state(MORTISE_GLOBAL FacePlans* plans, u32 inside, u32 on) {
    return plans->cell_states[inside] + 2 * plans->cell_states[on];
}

// Place of a node in a loop, -1 if it is not on it.
MORTISE_FUNCTION int place_in_loop(MORTISE_GLOBAL LoopPlan* loop, u32 node) {
    int place = -1;
    for (int i = 0; i < loop->size; ++i) place = loop->node[i] == node ? i : place;
    return place;
}

// What make_outline makes.
MORTISE_FUNCTION void planned_outline(MORTISE_GLOBAL FacePlans* plans, u32 inside, u32 on, CellBoundary* b) {
    MORTISE_GLOBAL LoopPlan* loop = &plans->loop[cell_state(plans, inside, on)];
    b->nodes = 0;
    b->loop_size = loop->size == kNoLoop ? -1 : (i32)loop->size;
    if (b->loop_size < 0) return;
    for (int i = 0; i < kLargestLoop; ++i) b->loop[i] = loop->node[i];
    for (int f = 0; f < 6; ++f) {
        MORTISE_GLOBAL FacePlan* plan = plan_of_face(plans, inside, on, (u32)f);
        b->count[f] = plan->count;
        for (int i = 0; i < 5; ++i) b->node[f][i] = plan->node[i];
        b->nodes |= plan->nodes;
    }
}

// The faces of leaves whose corners have the same states.
typedef struct CellFaces {
    MORTISE_GLOBAL FacePlan* plan[6];
    u8 meshes[6][kFaceMeshes];  // the sets of leaves that have each mesh
} CellFaces;

// Meshes of a face with a polygon, by its plan and the positions p.
MORTISE_FUNCTION void meshes_of_plan(MORTISE_GLOBAL FacePlan* plan, const Reals (*p)[3], u8* meshes) {
    u8 node[4];
    for (int i = 0; i < 4; ++i) node[i] = plan->node[i];
    face_meshes_by(plan->rule, node, p, meshes);
}

// Apexes that some leaf may have: nodes whose cones have the facets of all faces, which lie off a face or on
// all its facets if these are triangles, and the interior node. *some gets those that not all leaves may have
// (with_apex).
MORTISE_FUNCTION u32 possible_apexes(const CellFaces* faces, u32* some) {
    u32 nodes = 1u << kCellInteriorNode;
    u32 never = 0;
    *some = 0;
    for (int f = 0; f < 6; ++f) {
        u32 all = ~0u;
        nodes |= faces->plan[f]->nodes;
        for (int m = 0; m < kFaceMeshes; ++m) {
            if (faces->meshes[f][m] == 0) continue;
            *some |= faces->plan[f]->mesh[m].no_apex;
            all &= faces->plan[f]->mesh[m].no_apex;
        }
        never |= all;
    }
    return nodes & ~never;
}

// Nodes of all faces.
MORTISE_FUNCTION u32 nodes_of_faces(const CellFaces* faces) {
    u32 nodes = 0;
    for (int f = 0; f < 6; ++f) nodes |= faces->plan[f]->nodes;
    return nodes;
}

// Those of `wanted` in which the faces f in `which` are quadrilaterals that are not split.
MORTISE_FUNCTION LaneSet with_whole_faces(const CellFaces* faces, u32 which, LaneSet wanted) {
    for (u32 rest = which; rest != 0; rest &= rest - 1) {
        const u32 f = mortise_lowest_bit(rest);
        wanted &= faces->plan[f]->count == 4 ? faces->meshes[f][0] : 0u;
    }
    return wanted;
}

// Those of `wanted` that may have an apex, by the meshes of their faces.
MORTISE_FUNCTION LaneSet with_apex(const CellFaces* faces, u32 apex, LaneSet wanted) {
    for (u32 f = 0; f < 6; ++f) {
        for (int m = 0; m < kFaceMeshes; ++m) {
            const LaneSet leaves = faces->meshes[f][m];
            if (leaves != 0 && ((faces->plan[f]->mesh[m].no_apex >> apex) & 1) != 0) wanted &= ~leaves;
        }
    }
    return wanted;
}

#endif
