// Which template a leaf gets: the whole cell, a row of the table, a wedge, or a cone.
#ifndef MORTISE_SHARED_LEAF_TEMPLATE_H
#define MORTISE_SHARED_LEAF_TEMPLATE_H

#include "cone.h"
#include "snio.h"
#include "template_table.h"
#include "tree.h"

// A cone instead of a row or wedge must be better by this.
#define kConeGain 1.2

// What choose_templates finds for some leaves whose corners have the same states.
typedef struct LeafTemplates {
    i32 method[kLanes];     // kMethodNothing …; -1: no valid template
    CellBoundary boundary;  // of all, but for the meshes of faces
    CellFaces faces;        // with these; plans only where there is a cone or wedge
    Cones cones;            // kMethodCone; kMethodWedge: apex is the axis
} LeafTemplates;

// The displacement of corner c once it has moved, along axis j, as below.
MORTISE_FUNCTION double moved_coordinate(MORTISE_GLOBAL SnioPoints* points, u32 c, int j) {
    return (double)((c >> j) & 1) + (double)points->moved[c][j] / (double)kCellUnits;
}

// Node positions in cell edges, from the leaf's minimum corner: first those of all corners on the grid, then
// corners in `displaced` and cuts of the edges in `cuts` of one leaf; of others nothing. Exact: multiples of
// the lattice step.
MORTISE_FUNCTION void grid_positions(Reals (*p)[3]) {
    for (int c = 0; c < 8; ++c) {
        for (int j = 0; j < 3; ++j) p[c][j] = (double)((c >> j) & 1);
    }
}
MORTISE_FUNCTION void leaf_positions(MORTISE_GLOBAL SnioPoints* points, u32 displaced, u32 cuts, u32 lane,
                                     Reals (*p)[3]) {
    for (u32 rest = displaced; rest != 0; rest &= rest - 1) {
        const u32 c = mortise_lowest_bit(rest);
        for (int j = 0; j < 3; ++j) set_lane(&p[c][j], lane, moved_coordinate(points, c, j));
    }
    for (u32 rest = cuts; rest != 0; rest &= rest - 1) {
        const u32 e = mortise_lowest_bit(rest);
        const u32 low = kEdgeCorners[e][0];
        for (u32 j = 0; j < 3; ++j) {
            const double at =
                j == e / 4 ? (double)points->root[e] / (double)kCellUnits : (double)((low >> j) & 1);
            set_lane(&p[8 + e][j], lane, at);
        }
    }
}

// Corner i of an element of a type: its local nodes and the ends of its three edges, right-handed.
MORTISE_FUNCTION void element_corner(int type, int i, int* n) {
    n[0] = i;
    if (type == 3) {
        n[1] = (i + 1) & 3;
        n[2] = (i & 1) ? (i + 3) & 3 : (i + 2) & 3;
        n[3] = (i & 1) ? (i + 2) & 3 : (i + 3) & 3;
    } else if (type == 2) {
        n[1] = (i + 1) & 3;
        n[2] = (i + 3) & 3;
        n[3] = 4;
    } else {
        const int ring = type == 1 ? 3 : 4;
        const int top = i >= ring;
        const int at = top ? i - ring : i;
        const int after = (at + 1) % ring;
        const int before = (at + ring - 1) % ring;
        n[1] = top ? ring + before : after;
        n[2] = top ? ring + after : before;
        n[3] = top ? at : ring + at;
    }
}

// Worst corner of a wedge, pyramid or tetrahedron, or of a hexahedron of which one face moved: there the
// Jacobian is linear along the four parallel edges, so its corners decide.
MORTISE_FUNCTION Reals row_element_quality(const Reals (*p)[3], int type, const int* nodes) {
    Reals worst = kGoodQuality * 16;
    const int corners = type == 0 ? 8 : type == 1 ? 6 : 4;
    for (int i = 0; i < corners; ++i) {
        int n[4];
        element_corner(type, i, n);
        worst = lower_lanes(
            worst, corner_quality(p[nodes[n[0]]], p[nodes[n[1]]], p[nodes[n[2]]], p[nodes[n[3]]], 7));
    }
    return worst;
}

// Leaves in which a wedge with positive corners can be divided into tetrahedra along any diagonals of its
// quadrilaterals, as meshes of tetrahedra and improvement do it: each division has its corners, and one
// tetrahedron with an edge from triangle to triangle and a node more of each, on either side of it.
MORTISE_FUNCTION LaneSet wedges_divide(const Reals (*p)[3], const int* nodes) {
    LaneSet divide = kAllLanes;
    for (int i = 0; i < 3 && divide != 0; ++i) {
        const int next = i < 2 ? i + 1 : 0;
        const int last = i > 0 ? i - 1 : 2;
        const Reals* low = p[nodes[i]];
        const Reals* high = p[nodes[3 + i]];
        divide &= positive_corners(low, p[nodes[next]], p[nodes[3 + last]], high);
        divide &= positive_corners(low, p[nodes[3 + next]], p[nodes[last]], high);
    }
    return divide;
}

// Quality of a wedge; <= 0 if it is not positive, or not however it is divided.
MORTISE_FUNCTION Reals wedge_quality(const Reals (*p)[3], const int* nodes) {
    const Reals none = -1;
    const Reals quality = row_element_quality(p, 1, nodes);
    if (set_of_lanes(quality > 0) == 0) return none;
    return choose_lanes(none, quality, lanes_of_set(set_of_lanes(quality > 0) & wedges_divide(p, nodes)));
}

// Places the interior node of a row of the table.
MORTISE_FUNCTION void place_row_node(const TemplateRow* row, Reals (*p)[3]) {
    if (row->interior_mean != 0) {
        place_interior_node(row->interior_mean, p);
    } else {
        for (int j = 0; j < 3; ++j) p[kCellInteriorNode][j] = 0;
    }
}

// Quality of a row of the table; <= 0 if an element is not positive.
MORTISE_FUNCTION Reals row_quality(const TemplateRow* row, const Reals (*p)[3]) {
    const int sizes[4] = {8, 6, 5, 4};
    u32 at = row->first_node;
    Reals worst = kGoodQuality;
    for (int type = 0; type < 4; ++type) {
        for (int i = 0; i < row->elements[type]; ++i) {
            int n[8];
            for (int k = 0; k < sizes[type]; ++k) n[k] = kTemplateNodes[at++];
            worst = lower_lanes(worst, row_element_quality(p, type, n));
            if (set_of_lanes(worst > 0) == 0) return worst;
        }
    }
    return worst;
}

// Those of `wanted` in which every element of a row of the table is positive.
MORTISE_FUNCTION LaneSet positive_rows(const TemplateRow* row, LaneSet wanted, Reals (*p)[3]) {
    const int sizes[4] = {8, 6, 5, 4};
    u32 at = row->first_node;
    place_row_node(row, p);
    for (int type = 0; type < 4; ++type) {
        const int corners = type == 0 ? 8 : type == 1 ? 6 : type == 2 ? 4 : 1;
        for (int i = 0; i < row->elements[type]; ++i) {
            for (int k = 0; k < corners && wanted != 0; ++k) {
                int n[4];
                element_corner(type, k, n);
                for (int j = 0; j < 4; ++j) n[j] = kTemplateNodes[at + (u32)n[j]];
                wanted &= positive_corners(p[n[0]], p[n[1]], p[n[2]], p[n[3]]);
            }
            at += (u32)sizes[type];
        }
    }
    return wanted;
}

// Leaves in which the Jacobian of the whole cell is positive everywhere: its columns are convex combinations
// of the four edges along each axis, so all products of one edge of each decide.
MORTISE_NOINLINE LaneSet positive_hexahedra(const Reals (*p)[3]) {
    LaneVector e[12];
    LaneSet positive = kAllLanes;
    for (int i = 0; i < 12; ++i) e[i] = lane_edge(p[kEdgeCorners[i][0]], p[kEdgeCorners[i][1]]);
    for (int k = 0; k < 16 && positive != 0; ++k) {
        const LaneVector normal = cross_lanes(e[4 + (k & 3)], e[8 + (k >> 2)]);
        positive &= set_of_lanes((dot_lanes(e[0], normal) > kLeastRelativeVolume) &
                                 (dot_lanes(e[1], normal) > kLeastRelativeVolume) &
                                 (dot_lanes(e[2], normal) > kLeastRelativeVolume) &
                                 (dot_lanes(e[3], normal) > kLeastRelativeVolume));
    }
    return positive;
}

// Positions with corners in `snapped` back on the grid: what face meshes are chosen by, since the certificate
// (host/cnio), which meshes the leaves beside, moves these corners last.
MORTISE_FUNCTION void face_positions(const Reals (*p)[3], u32 snapped, Reals (*q)[3]) {
    for (int n = 0; n < kCellInteriorNode; ++n) {
        for (int j = 0; j < 3; ++j) {
            q[n][j] = p[n][j];
            if (n < 8 && ((snapped >> n) & 1) != 0) q[n][j] = (double)((n >> j) & 1);
        }
    }
}

// Outlines and face meshes of leaves, and the sets of these with each method that they tell.
typedef struct Outlined {
    LaneSet nothing;
    LaneSet hexahedra;
    LaneSet none;  // no template
} Outlined;

MORTISE_FUNCTION Outlined make_boundaries(MORTISE_GLOBAL FacePlans* plans, u32 inside, u32 on, u32 snapped,
                                          const Reals (*p)[3], CellBoundary* b, CellFaces* faces) {
    Outlined result;
    LaneSet whole;
    Reals q[kCellNodes][3];
    result.nothing = result.hexahedra = result.none = 0;
    b->nodes = 0;
    b->loop_size = 0;
    // All corners on the surface, and volume between them: no template tells where it is.
    if (inside == 0) {
        *(on != 0xff ? &result.nothing : &result.none) = kAllLanes;
        return result;
    }
    planned_outline(plans, inside, on, b);
    if (b->loop_size < 0) {
        result.none = kAllLanes;
        return result;
    }
    if (snapped != 0) face_positions(p, snapped, q);
    for (u32 f = 0; f < 6; ++f) {
        faces->plan[f] = plan_of_face(plans, inside, on, f);
        meshes_of_plan(faces->plan[f], snapped != 0 ? (const Reals(*)[3])q : p, faces->meshes[f]);
    }
    if (b->loop_size > 0) return result;
    whole = with_whole_faces(faces, 0x3f, kAllLanes);
    if (whole == 0) return result;
    result.hexahedra = positive_hexahedra(p) & whole;
    result.none = whole & ~result.hexahedra;
    return result;
}

MORTISE_FUNCTION void set_methods(LeafTemplates* result, LaneSet leaves, i32 method) {
    for (LaneSet rest = leaves; rest != 0; rest &= rest - 1)
        result->method[mortise_lowest_bit(rest)] = method;
}

// Those of `wanted` whose inside part is a positive wedge; *axis and *quality get the wedge's, if there is
// one.
MORTISE_FUNCTION LaneSet positive_wedges(u32 inside, u32 on, const CellBoundary* b, const CellFaces* faces,
                                         LaneSet wanted, const Reals (*p)[3], int* axis, Reals* quality) {
    u32 quads = 0;
    int n[6];
    *axis = wedge_axis(inside, on, b, &quads);
    if (*axis < 0) return 0;
    wanted = with_whole_faces(faces, quads, wanted);
    if (wanted == 0) return 0;
    wedge_nodes(b, *axis, n);
    *quality = wedge_quality(p, n);
    return wanted & set_of_lanes(*quality > 0);
}

// Gives those of `wanted` their row of the table, or a wedge if they are one and it is positive; returns
// their quality, -1 for none. Places the interior node of a row.
MORTISE_FUNCTION Reals choose_rows_or_wedges(u32 inside, u32 on, LaneSet wanted, Reals (*p)[3],
                                             LeafTemplates* result) {
    const Reals none = -1;
    Reals quality = none;
    int axis;
    LaneSet wedges;
    if (on == 0) {
        const TemplateRow row = kTemplateRows[inside];
        set_methods(result, wanted, kMethodRow);
        place_row_node(&row, p);
        return row_quality(&row, (const Reals(*)[3])p);
    }
    wedges = positive_wedges(inside, on, &result->boundary, &result->faces, wanted, (const Reals(*)[3])p,
                             &axis, &quality);
    set_methods(result, wedges, kMethodWedge);
    for (LaneSet rest = wedges; rest != 0; rest &= rest - 1) {
        const u32 lane = mortise_lowest_bit(rest);
        result->cones.apex[lane] = (u8)axis;
        result->cones.facet_count[lane] = 1;
        result->cones.facets[lane][0] = (u16)(0 | (1 << 4) | (2 << 8) | (3 << 12));
    }
    return choose_lanes(none, quality, lanes_of_set(wedges));
}

// The best templates of leaves that have_templates (corner_choices.h) finds; snapped: corners that have
// moved as SnappedLeaf tells; facing: faces beyond which there is volume. Leaves p[kCellInteriorNode] where
// the node of a row is.
MORTISE_FUNCTION void choose_templates(MORTISE_GLOBAL FacePlans* plans, u32 inside, u32 on, u32 snapped,
                                       Reals (*p)[3], u32 facing, int rows_only, LeafTemplates* result) {
    const CellBoundary* b = &result->boundary;
    const Outlined outlined =
        make_boundaries(plans, inside, on, snapped, (const Reals(*)[3])p, &result->boundary, &result->faces);
    LaneSet wanted = kAllLanes & ~(outlined.nothing | outlined.hexahedra | outlined.none);
    Reals found;
    Reals row_node[3];
    Cones cones;
    set_methods(result, kAllLanes, -1);
    set_methods(result, outlined.nothing, kMethodNothing);
    set_methods(result, outlined.hexahedra, kMethodHexahedron);
    if (wanted == 0) return;
    found = choose_rows_or_wedges(inside, on, wanted, p, result);
    wanted &= ~set_of_lanes(found >= kWorthNoNode);
    if (wanted == 0 || (on == 0 && rows_only)) return;
    for (int j = 0; j < 3; ++j) row_node[j] = p[kCellInteriorNode][j];
    for (u32 f = 0; f < 6; ++f) facing |= b->count[f] > 0 ? 1u << f : 0;  // covered by the face's mesh
    best_cones(&result->faces, &plans->loop[cell_state(plans, inside, on)], p, facing, wanted, &cones);
    for (int j = 0; j < 3; ++j) {
        result->cones.point[j] = cones.point[j];
        p[kCellInteriorNode][j] = row_node[j];
    }
    for (LaneSet rest = wanted & set_of_lanes(cones.quality > 0); rest != 0; rest &= rest - 1) {
        const u32 lane = mortise_lowest_bit(rest);
        if (get_lane(&cones.quality, lane) < get_lane(&found, lane) * kConeGain) continue;
        result->method[lane] = kMethodCone;
        take_cone(&cones, lane, &result->cones);
    }
}

// The meshes of a leaf's faces, into the boundary of all.
MORTISE_FUNCTION void take_meshes(LeafTemplates* found, u32 lane) {
    CellBoundary* b = &found->boundary;
    for (int f = 0; f < 6; ++f)
        b->mesh[f] = (u8)(b->count[f] == 0 ? kFaceEmpty : mesh_of_lane(found->faces.meshes[f], lane));
}

#endif
