// Whether leaves have templates, for all choices of their corners that may move. A face depends on its own
// four corners only: on their states, for which its plan is known, and on their positions, which decide
// between the plan's meshes, once for each choice of these corners.
#ifndef MORTISE_SHARED_CORNER_CHOICES_H
#define MORTISE_SHARED_CORNER_CHOICES_H

#include "leaf_template.h"

// The faces of leaves whose corners have the same states. At first known[] is 0, apex and seen_from are
// kNoApex, and all faces are stale.
typedef struct CornerChoices {
    u32 snapped;   // corners that have moved as SnappedLeaf tells, for all choices
    u32 known[6];  // bit k: the meshes are known for choice k of the face's corners, in the order of its
                   // frame
    u8 meshes[6][16][kFaceMeshes];
    u32 seen_from;   // an apex: its code, + 32 if it has moved
    u32 asked[6];    // bit k: it is known which leaves see the face from there with choice k,
    u8 seen[6][16];  // and the set of these
    u32 apex;        // of the last cone that was found
    u32 stale;       // bit f: for face f what follows is of an older choice than the last one
    u32 choice[6];   // of the face's corners
    CellFaces faces;
} CornerChoices;

MORTISE_FUNCTION void forget_choices(u32 snapped, CornerChoices* choices) {
    choices->snapped = snapped;
    choices->apex = choices->seen_from = kNoApex;
    choices->stale = 0x3f;
    for (int f = 0; f < 6; ++f) choices->known[f] = 0;
}

// A face none of whose corners has moved is seen from all that is this far inside its plane: its facets are
// flat there, with angles above kRootMargin lattice units at each corner that FaceMeshPlan tells of.
#define kClearHeight 0.125

// Leaves in which all elements are positive that join an apex to the facets of a face, whichever mesh it has.
MORTISE_NOINLINE LaneSet see_face(MORTISE_GLOBAL FacePlan* plan, const u8* meshes, const Reals (*p)[3],
                                  u32 apex) {
    LaneSet seen = 0;
    for (int m = 0; m < kFaceMeshes; ++m) {
        MORTISE_GLOBAL FaceMeshPlan* mesh = &plan->mesh[m];
        LaneSet positive = meshes[m];
        for (int i = 0; positive != 0 && i < mesh->count; ++i) {
            if ((mesh->facet[i] >> apex) & 1) continue;
            positive &= positive_corners(p[mesh->corner[i][0]], p[mesh->corner[i][1]], p[mesh->corner[i][2]],
                                         p[apex]);
        }
        seen |= positive;
    }
    return seen;
}

// Those of `wanted` in which Γ can be divided for an apex: fans first. No facet of it lies on a face of the
// cell, since it is not known yet which faces have volume behind them.
MORTISE_FUNCTION LaneSet see_surface(MORTISE_GLOBAL LoopPlan* loop, const Reals (*p)[3], u32 apex,
                                     LaneSet wanted) {
    const int n = loop->size;
    LaneSet seen = 0;
    const int place = place_in_loop(loop, apex);
    if (n == 0) return wanted;
    for (int first = place >= 0 ? place : 0; first < (place >= 0 ? place + 1 : n) && seen != wanted;
         ++first) {
        const u32 root = loop->node[first];
        LaneSet positive = wanted;
        for (int i = 1; i + 1 < n && positive != 0; ++i) {
            const int k = first + i < n ? first + i : first + i - n;
            const u32 d = loop->node[k];
            const u32 e = loop->node[k + 1 < n ? k + 1 : 0];
            if ((kNodeFaces[root] & kNodeFaces[d] & kNodeFaces[e]) != 0) positive = 0;
            if (place < 0 && positive != 0) positive &= positive_corners(p[e], p[d], p[root], p[apex]);
        }
        seen |= positive;
    }
    if (place < 0 && seen != wanted) {
        const Reals none = 0;
        Division division;
        seen |= divide_surface(loop, p, p[apex], 0x3f, wanted & ~seen, none, &division);
    }
    return seen;
}

// Those of `wanted` whose faces, as they are in the last choice, are all seen from an apex of which `moved`
// tells whether it has moved. What is known of a face from the same place is not asked again: most choices
// differ in others.
MORTISE_FUNCTION LaneSet see_faces(const Reals (*p)[3], u32 apex, u32 moved, LaneSet wanted,
                                   CornerChoices* choices) {
    const u32 from = apex | (((moved >> apex) & 1u) << 5);
    u32 displaced = 0;  // faces
    for (u32 rest = choices->snapped; rest != 0; rest &= rest - 1)
        displaced |= kNodeFaces[mortise_lowest_bit(rest)];
    if (apex != kCellInteriorNode && choices->seen_from != from) {
        choices->seen_from = from;
        for (int f = 0; f < 6; ++f) choices->asked[f] = 0;
    }
    for (u32 f = 0; f < 6 && wanted != 0; ++f) {
        const u32 k = choices->choice[f];
        if (k == 0 && ((displaced >> f) & 1) == 0) {
            const Reals at = p[apex][f / 2];
            const Reals height = (f & 1) ? 1 - at : at;
            if ((wanted & ~set_of_lanes(height > kClearHeight)) == 0) continue;
        }
        if (apex == kCellInteriorNode) {  // somewhere else each time
            wanted &= see_face(choices->faces.plan[f], choices->faces.meshes[f], p, apex);
            continue;
        }
        if (((choices->asked[f] >> k) & 1) == 0) {
            choices->asked[f] |= 1u << k;
            choices->seen[f][k] = (u8)see_face(choices->faces.plan[f], choices->faces.meshes[f], p, apex);
        }
        wanted &= choices->seen[f][k];
    }
    return wanted;
}

// Those of `wanted` for which best_cones finds a cone. The apex of the last choice is tried first.
MORTISE_FUNCTION LaneSet have_cones(MORTISE_GLOBAL LoopPlan* loop, u32 moved, LaneSet wanted, Reals (*p)[3],
                                    CornerChoices* choices) {
    u32 some;
    LaneSet found = 0;
    {
        u32 apexes = possible_apexes(&choices->faces, &some);
        u32 apex = choices->apex;
        if (apex >= kCellInteriorNode || ((apexes >> apex) & 1) == 0)
            apex = apexes != 0 ? mortise_lowest_bit(apexes) : kNoApex;
        while (apexes != 0 && found != wanted) {
            LaneSet left = wanted & ~found;
            if ((some >> apex) & 1) left = with_apex(&choices->faces, apex, left);
            if (left != 0 && apex == kCellInteriorNode)
                place_interior_node(nodes_of_faces(&choices->faces), p);
            if (left != 0) left = see_faces((const Reals(*)[3])p, apex, moved, left, choices);
            if (left != 0) left = see_surface(loop, (const Reals(*)[3])p, apex, left);
            if (left != 0) choices->apex = apex;
            found |= left;
            apexes &= ~(1u << apex);
            if (apexes != 0) apex = mortise_lowest_bit(apexes);
        }
    }
    return found;
}

// Brings faces up to date; all of them have polygons.
MORTISE_FUNCTION void choose_faces(MORTISE_GLOBAL FacePlans* plans, u32 inside, u32 on, u32 moved,
                                   const Reals (*p)[3], CornerChoices* choices) {
    const u32 moved_corners = plans->corners[moved];
    Reals q[kCellNodes][3];
    if (choices->snapped != 0) {
        face_positions(p, choices->snapped, q);
        p = (const Reals(*)[3])q;
    }
    for (u32 rest = choices->stale; rest != 0; rest &= rest - 1) {
        const u32 f = mortise_lowest_bit(rest);
        const u32 k = (moved_corners >> (4 * f)) & 15;
        choices->choice[f] = k;
        choices->faces.plan[f] = plan_of_face(plans, inside, on, f);
        if (((choices->known[f] >> k) & 1) == 0) {
            choices->known[f] |= 1u << k;
            meshes_of_plan(choices->faces.plan[f], p, choices->meshes[f][k]);
        }
        for (int m = 0; m < kFaceMeshes; ++m) choices->faces.meshes[f][m] = choices->meshes[f][k][m];
    }
    choices->stale = 0;
}

// Those of `wanted` that have a template for given corner states and positions p: one of several choices of
// corners that move, of which `moved` are those among `on` that do. rows_only: leaves without corners on the
// surface take their row, others none.
MORTISE_FUNCTION LaneSet have_templates(MORTISE_GLOBAL FacePlans* plans, u32 inside, u32 on, u32 moved,
                                        LaneSet wanted, Reals (*p)[3], int rows_only,
                                        CornerChoices* choices) {
    MORTISE_GLOBAL LoopPlan* loop = &plans->loop[cell_state(plans, inside, on)];
    const int loop_size = loop->size;
    LaneSet found = 0;
    if (inside == 0) return on != 0xff ? wanted : 0;
    if (loop_size == kNoLoop) return 0;
    choose_faces(plans, inside, on, moved, (const Reals(*)[3])p, choices);
    if (loop_size == 0) {
        const LaneSet whole = with_whole_faces(&choices->faces, 0x3f, wanted);
        if (whole != 0) found = positive_hexahedra((const Reals(*)[3])p) & whole;
        wanted &= ~whole;
    }
    if (wanted == 0) return found;
    if (on == 0) {
        const TemplateRow row = kTemplateRows[inside];
        return row.shape != 0 ? found | positive_rows(&row, wanted, p) : found;
    }
    if (rows_only) return found;
    found |= have_cones(loop, moved, wanted, p, choices);
    if ((wanted & ~found) != 0) {
        CellBoundary b;
        Reals quality;
        int axis;
        planned_outline(plans, inside, on, &b);
        found |= positive_wedges(inside, on, &b, &choices->faces, wanted & ~found, (const Reals(*)[3])p,
                                 &axis, &quality);
    }
    return found;
}

#endif
