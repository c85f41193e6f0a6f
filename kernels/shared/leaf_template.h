// Which template a leaf gets: the whole cell, a row of the table, a wedge, or a cone.
#ifndef MORTISE_SHARED_LEAF_TEMPLATE_H
#define MORTISE_SHARED_LEAF_TEMPLATE_H

#include "face_plan.h"
#include "snio.h"
#include "template_table.h"
#include "tree.h"

// A cone instead of a row or wedge must be better by this.
#define kConeGain 1.2

// What choose_template finds.
typedef struct LeafTemplate {
    i32 method;  // kMethodNothing …; -1: no valid template
    CellBoundary boundary;
    Cone cone;  // kMethodCone; kMethodWedge: apex is the axis
} LeafTemplate;

// Where corner c is once it has moved, as below.
MORTISE_FUNCTION void moved_position(MORTISE_GLOBAL SnioPoints* points, u32 c, double* at) {
    for (int j = 0; j < 3; ++j)
        at[j] = (double)((c >> j) & 1) + (double)points->moved[c][j] / (double)kCellUnits;
}

// Node positions in cell edges, from the leaf's minimum corner: corners, those in `displaced` moved, and cuts
// of the edges in `cuts`; of others nothing. Exact: multiples of the lattice step.
MORTISE_FUNCTION void leaf_positions(MORTISE_GLOBAL SnioPoints* points, u32 displaced, u32 cuts,
                                     double (*p)[3]) {
    for (int c = 0; c < 8; ++c) {
        for (int j = 0; j < 3; ++j) p[c][j] = (double)((c >> j) & 1);
    }
    for (u32 rest = displaced; rest != 0; rest &= rest - 1) {
        const u32 c = mortise_lowest_bit(rest);
        moved_position(points, c, p[c]);
    }
    for (u32 rest = cuts; rest != 0; rest &= rest - 1) {
        const u32 e = mortise_lowest_bit(rest);
        const u32 low = kEdgeCorners[e][0];
        for (int j = 0; j < 3; ++j) p[8 + e][j] = (double)((low >> j) & 1);
        p[8 + e][e / 4] = (double)points->root[e] / (double)kCellUnits;
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
MORTISE_FUNCTION double row_element_quality(const double (*p)[3], int type, const int* nodes) {
    double worst = kGoodQuality * 16;
    const int corners = type == 0 ? 8 : type == 1 ? 6 : 4;
    for (int i = 0; i < corners; ++i) {
        int n[4];
        double q;
        element_corner(type, i, n);
        q = corner_quality(p[nodes[n[0]]], p[nodes[n[1]]], p[nodes[n[2]]], p[nodes[n[3]]], 7);
        if (q < worst) worst = q;
    }
    return worst;
}

// Whether a wedge with positive corners can be divided into tetrahedra along any diagonals of its
// quadrilaterals, as meshes of tetrahedra and improvement do it: each division has its corners, and one
// tetrahedron with an edge from triangle to triangle and a node more of each, on either side of it.
MORTISE_FUNCTION int wedge_divides(const double (*p)[3], const int* nodes) {
    for (int i = 0; i < 3; ++i) {
        const int next = i < 2 ? i + 1 : 0;
        const int last = i > 0 ? i - 1 : 2;
        const double* low = p[nodes[i]];
        const double* high = p[nodes[3 + i]];
        if (!is_positive_corner(low, p[nodes[next]], p[nodes[3 + last]], high) ||
            !is_positive_corner(low, p[nodes[3 + next]], p[nodes[last]], high))
            return 0;
    }
    return 1;
}

// Quality of a wedge; <= 0 if it is not positive, or not however it is divided.
MORTISE_FUNCTION double wedge_quality(const double (*p)[3], const int* nodes) {
    const double quality = row_element_quality(p, 1, nodes);
    return quality > 0 && wedge_divides(p, nodes) ? quality : -1;
}

// Places the interior node of a row of the table.
MORTISE_FUNCTION void place_row_node(const TemplateRow* row, double (*p)[3]) {
    if (row->interior_mean != 0) {
        place_interior_node(row->interior_mean, p);
    } else {
        for (int j = 0; j < 3; ++j) p[kCellInteriorNode][j] = 0;
    }
}

// Quality of a row of the table; <= 0 if an element is not positive.
MORTISE_FUNCTION double row_quality(const TemplateRow* row, const double (*p)[3]) {
    const int sizes[4] = {8, 6, 5, 4};
    u32 at = row->first_node;
    double worst = kGoodQuality;
    for (int type = 0; type < 4; ++type) {
        for (int i = 0; i < row->elements[type]; ++i) {
            int n[8];
            double q;
            for (int k = 0; k < sizes[type]; ++k) n[k] = kTemplateNodes[at++];
            q = row_element_quality(p, type, n);
            if (q < worst) worst = q;
            if (!(worst > 0)) return -1;
        }
    }
    return worst;
}

// Whether every element of a row of the table is positive.
MORTISE_FUNCTION int row_is_positive(const TemplateRow* row, double (*p)[3]) {
    const int sizes[4] = {8, 6, 5, 4};
    u32 at = row->first_node;
    place_row_node(row, p);
    for (int type = 0; type < 4; ++type) {
        const int corners = type == 0 ? 8 : type == 1 ? 6 : type == 2 ? 4 : 1;
        for (int i = 0; i < row->elements[type]; ++i) {
            for (int k = 0; k < corners; ++k) {
                int n[4];
                element_corner(type, k, n);
                for (int j = 0; j < 4; ++j) n[j] = kTemplateNodes[at + n[j]];
                if (!is_positive_corner(p[n[0]], p[n[1]], p[n[2]], p[n[3]])) return 0;
            }
            at += sizes[type];
        }
    }
    return 1;
}

// Whether the Jacobian of the whole cell is positive everywhere: its columns are convex combinations of the
// four edges along each axis, so all products of one edge of each decide.
MORTISE_FUNCTION int hexahedron_is_positive(const double (*p)[3]) {
    double e[12][3];
    for (int i = 0; i < 12; ++i) {
        for (int j = 0; j < 3; ++j) e[i][j] = p[kEdgeCorners[i][1]][j] - p[kEdgeCorners[i][0]][j];
    }
    for (int k = 0; k < 16; ++k) {
        const double* u = e[4 + (k & 3)];
        const double* v = e[8 + (k >> 2)];
        const double x = u[1] * v[2] - u[2] * v[1];
        const double y = u[2] * v[0] - u[0] * v[2];
        const double z = u[0] * v[1] - u[1] * v[0];
        int positive = 1;
        for (int i = 0; i < 4; ++i)
            positive &= e[i][0] * x + e[i][1] * y + e[i][2] * z > kLeastRelativeVolume;
        if (!positive) return 0;
    }
    return 1;
}

// The same where corners in `snapped` have not moved: what face meshes are chosen by, since the certificate
// (host/cnio), which meshes the leaves beside, moves these corners last.
MORTISE_FUNCTION void face_positions(const double (*p)[3], u32 snapped, double (*q)[3]) {
    for (int n = 0; n < kCellInteriorNode; ++n) {
        for (int j = 0; j < 3; ++j)
            q[n][j] = n < 8 && ((snapped >> n) & 1) ? (double)((n >> j) & 1) : p[n][j];
    }
}

// Outlines and face meshes of a leaf. Returns the method if they tell it: kMethodNothing, kMethodHexahedron,
// -1 for none; else kMethodCone.
MORTISE_FUNCTION int make_boundary(MORTISE_GLOBAL FacePlans* plans, u32 inside, u32 on, u32 snapped,
                                   const double (*p)[3], CellBoundary* b) {
    int whole = 0;
    double q[kCellNodes][3];
    b->nodes = 0;
    b->loop_size = 0;
    // All corners on the surface, and volume between them: no template tells where it is.
    if (inside == 0) return on != 0xff ? kMethodNothing : -1;
    planned_outline(plans, inside, on, b);
    if (b->loop_size < 0) return -1;
    if (snapped != 0) face_positions(p, snapped, q);
    for (int f = 0; f < 6; ++f) {
        b->mesh[f] = (u8)face_mesh_by(plan_of_face(plans, inside, on, (u32)f)->rule, b->node[f],
                                      snapped != 0 ? (const double(*)[3])q : p);
        whole += b->count[f] == 4 && b->mesh[f] == kFaceWhole;
    }
    if (b->loop_size > 0 || whole < 6) return kMethodCone;
    return hexahedron_is_positive(p) ? kMethodHexahedron : -1;
}

// The best template of a leaf for which has_template (corner_choices.h) holds; snapped: corners that have
// moved as SnappedLeaf tells; facing: faces beyond which there is volume.
MORTISE_FUNCTION void choose_template(MORTISE_GLOBAL FacePlans* plans, u32 inside, u32 on, u32 snapped,
                                      double (*p)[3], u32 facing, int rows_only, LeafTemplate* result) {
    CellBoundary* b = &result->boundary;
    Cone cone;
    double found = -1;
    result->method = make_boundary(plans, inside, on, snapped, (const double(*)[3])p, b);
    if (result->method != kMethodCone) return;
    result->method = -1;
    if (on == 0) {
        const TemplateRow row = kTemplateRows[inside];
        result->method = kMethodRow;
        place_row_node(&row, p);
        if (rows_only) return;
        found = row_quality(&row, (const double(*)[3])p);
    } else {
        const int axis = wedge_axis(inside, on, b);
        if (axis >= 0) {
            int n[6];
            wedge_nodes(b, axis, n);
            found = wedge_quality((const double(*)[3])p, n);
            if (found > 0) result->method = kMethodWedge;
            result->cone.apex = (u32)axis;
            result->cone.facet_count = 1;
            result->cone.facets[0] = (u16)(0 | (1 << 4) | (2 << 8) | (3 << 12));
        }
    }
    if (found >= kWorthNoNode) return;
    {
        // Scratch of the interior node.
        double row_node[3];
        for (int j = 0; j < 3; ++j) row_node[j] = p[kCellInteriorNode][j];
        for (int f = 0; f < 6; ++f) facing |= b->count[f] > 0 ? 1u << f : 0;  // covered by the face's mesh
        cone = best_cone(b, p, facing);
        for (int j = 0; j < 3; ++j) p[kCellInteriorNode][j] = row_node[j];
    }
    if (cone.quality > 0 && !(cone.quality < found * kConeGain)) {
        result->method = kMethodCone;
        result->cone = cone;
    }
}

#endif
