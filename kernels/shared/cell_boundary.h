// The boundary of the solid's part of one simple cell whose corners are inside (I), on the surface (N) or
// outside (O): meshes of its six faces by the face rule, and the loop of Γ, the part that lies on the
// surface.
//
// Node codes as in template_table.h: 0–7 corners, 8–19 the cut on edge (code - 8), 20 the interior node. Only
// edges from I to O are cut. Positions are in cell edges from the cell's minimum corner; corners on the
// surface may be displaced onto it, all by multiples of the lattice step, so differences are exact.
//
// A face mesh is a function of the face alone (invariant 1 of ARCHITECTURE.md): states, positions, the order
// of corners. Face rule, by the polygon that the face's inside part makes:
//   triangles, and the quadrilateral of two I corners and two cuts, stay;
//   five nodes (three corners and two cuts): a fan from the middle corner, which is opposite to the outside
//   one, if it is I; else from the lower one of the two others;
//   four corners stay if they are nearly a square (one I among three N only undisplaced: a pyramid on them
//   would have a flat corner), else, as four nodes with one cut, they are split: through the only I, or the
//   only N among four corners; through both N if these are opposite; otherwise by the diagonal whose worse
//   triangle is the better one.
// So no triangle of a face has all its nodes on the surface, unless all four corners are.
// Faces without I have no inside part, except that four N corners make one: both cells beside it then decide
// by their own I corners whether they have volume there.
#ifndef MORTISE_SHARED_CELL_BOUNDARY_H
#define MORTISE_SHARED_CELL_BOUNDARY_H

#include "lanes.h"
#include "lattice.h"

#define kLargestLoop 8
#define kCellNodes 21
#define kCellInteriorNode 20

// How a face's polygon is meshed. Nodes 0 … count - 1 in the frame's order; splits name the diagonal.
#define kFaceEmpty 0
#define kFaceWhole 1  // five nodes: the fan from the middle corner; splits: from the one before, behind it
#define kFaceSplit02 2
#define kFaceSplit13 3

// Four corners count as a square if they are coplanar and the cosines of their angles stay below 1/4.
// Coplanar: the parallelepiped on three of their edges holds less than this part of the cell. A face some of
// whose corners moved to a surface just above it must not pass, and kSignTolerance is the least that a corner
// moves.
#define kSquareCosineSquared 0.0625
#define kSquareWarp 1e-6

typedef struct CellBoundary {
    u32 nodes;              // set of all nodes of the face meshes
    i32 loop_size;          // of Γ; 0: none; -1: several loops, or one that touches itself or is too long
    u8 count[6];            // nodes of the face's polygon
    u8 mesh[6];             // kFaceEmpty …
    u8 node[6][5];          // in the order of the face's frame
    u8 loop[kLargestLoop];  // counter-clockwise seen from outside the solid
} CellBoundary;

// Faces of the cell that each node lies on; none for the interior node.
MORTISE_TABLE u8 kNodeFaces[kCellNodes] = {0x15, 0x16, 0x19, 0x1a, 0x25, 0x26, 0x29, 0x2a, 0x14, 0x18, 0x24,
                                           0x28, 0x11, 0x12, 0x21, 0x22, 0x05, 0x06, 0x09, 0x0a, 0x00};

// Inside part of face f as a polygon in the order of the face's frame; returns its size, 0 to 5, or -1 where
// two opposite I face two opposite O.
MORTISE_FUNCTION int face_outline(u32 inside, u32 on, int f, u8* node) {
    u32 in_face = 0;
    u32 on_face = 0;
    int count = 0;
    for (int i = 0; i < 4; ++i) {
        const int c = kFaceCorners[f][i];
        in_face |= ((inside >> c) & 1u) << i;
        on_face |= ((on >> c) & 1u) << i;
    }
    if (in_face == 0 && on_face != 15) return 0;
    if (on_face == 0 && (in_face == 5 || in_face == 10)) return -1;
    for (int i = 0; i < 4; ++i) {
        const int next = (i + 1) & 3;
        const u32 outside = ~(in_face | on_face);
        if ((in_face >> i) & 1) {
            node[count++] = kFaceCorners[f][i];
        } else if (((on_face >> i) & 1) && !(((outside >> next) & 1) && ((outside >> ((i + 3) & 3)) & 1))) {
            node[count++] = kFaceCorners[f][i];  // else only its point touches the solid
        }
        if ((((in_face >> i) & 1) && ((outside >> next) & 1)) ||
            (((outside >> i) & 1) && ((in_face >> next) & 1))) {
            node[count++] = (u8)(8 + kFaceEdges[f][i]);
        }
    }
    return count;
}

// Height of a triangle over its longest side, relative to it, squared. The arithmetic is that of the
// certificate (host/cnio/face.cpp), which meets undisplaced faces.
MORTISE_FUNCTION Reals triangle_shape(const Reals* a, const Reals* b, const Reals* c) {
    const LaneVector ab = lane_edge(a, b);
    const LaneVector bc = lane_edge(b, c);
    const LaneVector ac = lane_edge(a, c);
    const LaneVector normal = cross_lanes(ab, ac);
    const Reals square = dot_lanes(ab, ab);
    const Reals other = dot_lanes(bc, bc);
    const Reals last = dot_lanes(ac, ac);
    Reals longest = choose_lanes(other, square, square > other);
    longest = choose_lanes(longest, last, last > longest);
    return dot_lanes(normal, normal) / (longest * longest);
}

// Whether two edges make nearly a right angle.
MORTISE_FUNCTION Flags are_nearly_normal(LaneVector u, LaneVector v) {
    const Reals dot = dot_lanes(u, v);
    return dot * dot < kSquareCosineSquared * (dot_lanes(u, u) * dot_lanes(v, v));
}

// Leaves in which four corners are nearly a square.
MORTISE_NOINLINE LaneSet nearly_squares(const Reals (*p)[3], const u8* n) {
    const LaneVector a = lane_edge(p[n[0]], p[n[1]]);
    const LaneVector b = lane_edge(p[n[1]], p[n[2]]);
    const LaneVector c = lane_edge(p[n[2]], p[n[3]]);
    const LaneVector d = lane_edge(p[n[3]], p[n[0]]);
    return set_of_lanes(are_nearly_normal(a, b) & are_nearly_normal(b, c) & are_nearly_normal(c, d) &
                        are_nearly_normal(d, a) &
                        (mortise_fabs(dot_lanes(cross_lanes(a, b), c)) < kSquareWarp));
}

// Leaves in which four corners lie on the grid.
MORTISE_FUNCTION LaneSet undisplaced(const Reals (*p)[3], const u8* n) {
    LaneSet still = kAllLanes;
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 3; ++j) still &= set_of_lanes(p[n[i]][j] == (double)((n[i] >> j) & 1));
    }
    return still;
}

// Place of the middle corner in a polygon of five nodes.
MORTISE_FUNCTION int pentagon_middle(const u8* n) {
    int middle = 0;
    while (n[(middle + 2) % 5] < 8 || n[(middle + 3) % 5] < 8) ++middle;
    return middle;
}

// Place of the corner from which the facets of a polygon of five nodes fan out.
MORTISE_FUNCTION int pentagon_apex(const u8* n, int mesh) {
    const int middle = pentagon_middle(n);
    return mesh == kFaceWhole ? middle : mesh == kFaceSplit02 ? (middle + 4) % 5 : (middle + 1) % 5;
}

// What corner states alone tell of a polygon's mesh: the mesh, or kFaceByShape, and whether positions may
// make it whole.
#define kFaceByShape 4    // one of the two splits, by the triangles' shapes
#define kFaceIfSquare 8   // whole if nearly square
#define kFaceIfOnGrid 16  // and if its corners lie on the grid

MORTISE_FUNCTION int face_rule(const u8* n, int count, u32 inside) {
    int ins = 0;
    int cuts = 0;
    int in_at = 0;
    int on_at = 0;
    int rule = kFaceByShape;
    if (count == 0) return kFaceEmpty;
    if (count == 5) {
        const int middle = pentagon_middle(n);
        if ((inside >> n[middle]) & 1) return kFaceWhole;
        return n[(middle + 4) % 5] < n[(middle + 1) % 5] ? kFaceSplit02 : kFaceSplit13;
    }
    if (count != 4) return kFaceWhole;
    for (int i = 0; i < 4; ++i) {
        if (n[i] >= 8) {
            ++cuts;
        } else if ((inside >> n[i]) & 1) {
            ++ins;
            in_at = i;
        } else {
            on_at = i;
        }
    }
    if (cuts == 2 || ins == 4) return kFaceWhole;
    if (ins == 1) {
        rule = (in_at & 1) ? kFaceSplit13 : kFaceSplit02;
    } else if (ins == 3 || (cuts == 0 && ins == 2 && ((inside >> n[on_at ^ 2]) & 1) == 0)) {
        rule = (on_at & 1) ? kFaceSplit13 : kFaceSplit02;
    }
    if (cuts == 0) rule |= ins == 1 ? kFaceIfSquare | kFaceIfOnGrid : kFaceIfSquare;
    return rule;
}

// Leaves in which a polygon with four nodes is split by its first diagonal, for the better of the worse
// triangles.
MORTISE_NOINLINE LaneSet better_split02(const u8* n, const Reals (*p)[3]) {
    const Reals first =
        lower_lanes(triangle_shape(p[n[0]], p[n[1]], p[n[2]]), triangle_shape(p[n[0]], p[n[2]], p[n[3]]));
    const Reals second =
        lower_lanes(triangle_shape(p[n[0]], p[n[1]], p[n[3]]), triangle_shape(p[n[1]], p[n[2]], p[n[3]]));
    // Ties go to the first corner of the frame's order.
    int lowest = 0;
    for (int i = 1; i < 4; ++i) lowest = n[i] < n[lowest] ? i : lowest;
    return set_of_lanes((lowest & 1) ? first > second : first >= second);
}

#define kFaceMeshes 3  // kFaceWhole, kFaceSplit02, kFaceSplit13; an empty face has the first, without facets

// Meshes of a face's polygon, whose rule is known: the sets of leaves that have each.
MORTISE_FUNCTION void face_meshes_by(int rule, const u8* n, const Reals (*p)[3], u8* meshes) {
    LaneSet whole = 0;
    LaneSet first;
    if ((rule & kFaceIfSquare) != 0) {
        whole = nearly_squares(p, n);
        if (whole != 0 && (rule & kFaceIfOnGrid) != 0) whole &= undisplaced(p, n);
    } else if (rule == kFaceEmpty || rule == kFaceWhole) {
        whole = kAllLanes;
    }
    if ((rule & kFaceByShape) != 0) {
        first = whole != kAllLanes ? better_split02(n, p) : 0;
    } else {
        first = (rule & 3) == kFaceSplit02 ? kAllLanes : 0;
    }
    meshes[kFaceWhole - kFaceWhole] = (u8)whole;
    meshes[kFaceSplit02 - kFaceWhole] = (u8)(first & ~whole);
    meshes[kFaceSplit13 - kFaceWhole] = (u8)(kAllLanes & ~first & ~whole);
}

// The mesh of one leaf.
MORTISE_FUNCTION int mesh_of_lane(const u8* meshes, u32 lane) {
    return (meshes[0] >> lane) & 1 ? kFaceWhole : (meshes[1] >> lane) & 1 ? kFaceSplit02 : kFaceSplit13;
}

// How many facets a polygon has that is meshed as `mesh` tells.
MORTISE_FUNCTION int facet_count(int count, int mesh) {
    if (mesh == kFaceEmpty || count < 3) return 0;
    return count == 4 && mesh == kFaceWhole ? 1 : count - 2;
}

// Facet i of these (facet_count) of the polygon of face f, as seen from inside the cell, counter-clockwise;
// returns its size.
MORTISE_FUNCTION int polygon_facet(const u8* n, int count, int mesh, int f, int i, u8* facet) {
    int size = 3;
    for (int k = 0; k < 4; ++k) facet[k] = 0;
    if (count == 5) {
        const int apex = pentagon_apex(n, mesh);
        facet[0] = n[apex];
        facet[1] = n[(apex + 1 + i) % 5];
        facet[2] = n[(apex + 2 + i) % 5];
    } else if (mesh == kFaceWhole) {
        size = count;
        for (int k = 0; k < count; ++k) facet[k] = n[k];
    } else {
        const int first = mesh == kFaceSplit02 ? 0 : 1;
        facet[0] = n[first];
        facet[1] = n[(first + 1 + i) & 3];
        facet[2] = n[(first + 2 + i) & 3];
    }
    if (frame_points_outward(f)) {
        const u8 second = facet[1];
        facet[1] = facet[size - 1];
        facet[size - 1] = second;
    }
    return size;
}

MORTISE_FUNCTION int face_facet(const CellBoundary* b, int f, int i, u8* facet) {
    return polygon_facet(b->node[f], b->count[f], b->mesh[f], f, i, facet);
}

MORTISE_FUNCTION int facet_holds(const u8* facet, int size, int code) {
    for (int k = 0; k < size; ++k) {
        if (facet[k] == code) return 1;
    }
    return 0;
}

// What a face's polygon tells of Γ's loop: its edges without an inside corner, chords and edges between two
// N. An edge of the cell is in the loop unless the other face at it has both its ends, too.
typedef struct LoopEdges {
    u32 corners;  // of the polygon
    u8 count;
    u8 from[4];  // as the loop runs
    u8 to[4];
    u8 other[4];  // face; kNoFace: not an edge of the cell
} LoopEdges;

#define kNoFace 6

MORTISE_FUNCTION void find_loop_edges(u32 inside, int f, const u8* node, int count, LoopEdges* edges) {
    const int outward = frame_points_outward(f);
    edges->corners = 0;
    edges->count = 0;
    for (int i = 0; i < count; ++i) {
        const int a = node[i];
        const int c = node[i + 1 < count ? i + 1 : 0];
        const int difference = a ^ c;
        int other = kNoFace;
        if (a < 8) edges->corners |= 1u << a;
        if ((a < 8 && ((inside >> a) & 1)) || (c < 8 && ((inside >> c) & 1))) continue;
        if (a < 8 && c < 8 && (difference & (difference - 1)) == 0) {
            const u32 faces = (u32)kNodeFaces[a] & kNodeFaces[c] & ~(1u << f);
            other = 0;
            while (((faces >> other) & 1) == 0) ++other;
        }
        edges->from[edges->count] = (u8)(outward ? c : a);
        edges->to[edges->count] = (u8)(outward ? a : c);
        edges->other[edges->count++] = (u8)other;
    }
}

// The loop of Γ from the edges of the six faces; returns its size as CellBoundary::loop_size.
MORTISE_FUNCTION int link_loop(const LoopEdges* face, u8* loop) {
    u8 next[kCellInteriorNode];
    u32 has_next = 0;
    int edges = 0;
    for (int f = 0; f < 6; ++f) {
        for (int i = 0; i < face[f].count; ++i) {
            const int from = face[f].from[i];
            const int to = face[f].to[i];
            const int other = face[f].other[i];
            if (other != kNoFace) {
                const u32 both = (1u << from) | (1u << to);
                if ((face[other].corners & both) == both) continue;
            }
            if ((has_next >> from) & 1) return -1;
            has_next |= 1u << from;
            next[from] = (u8)to;
            ++edges;
        }
    }
    if (edges > kLargestLoop) return -1;
    if (edges == 0) return 0;
    int at = 0;
    int size = 0;
    int start;
    while (((has_next >> at) & 1) == 0) ++at;
    start = at;
    do {
        loop[size++] = (u8)at;
        if (((has_next >> at) & 1) == 0) return -1;
        at = next[at];
    } while (at != start && size < edges);
    return at == start && size == edges ? size : -1;
}

// Outlines of all faces and the loop of Γ; face meshes are left to the caller, who knows positions.
MORTISE_FUNCTION void make_outline(u32 inside, u32 on, CellBoundary* b) {
    LoopEdges edges[6];
    b->nodes = 0;
    for (int f = 0; f < 6; ++f) {
        const int count = face_outline(inside, on, f, b->node[f]);
        if (count < 0) {
            b->nodes = 0;
            b->loop_size = -1;
            return;
        }
        b->count[f] = (u8)count;
        for (int i = 0; i < count; ++i) b->nodes |= 1u << b->node[f][i];
        find_loop_edges(inside, f, b->node[f], count, edges + f);
    }
    b->loop_size = link_loop(edges, b->loop);
}

// Axis of the wedge that a cell's inside part is: two opposite triangular faces alike, two faces whole
// quadrilaterals, Γ the third; -1 if it is none. quads: the faces that must be whole.
MORTISE_FUNCTION int wedge_axis(u32 inside, u32 on, const CellBoundary* b, u32* quads) {
    const u32 low_corners[3] = {0x55, 0x33, 0x0f};
    if (b->loop_size != 4) return -1;
    for (int axis = 0; axis < 3; ++axis) {
        const u32 low = low_corners[axis];
        const int step = 1 << axis;
        int count = 0;
        if (b->count[2 * axis] != 3 || b->count[2 * axis + 1] != 3) continue;
        if (((inside & low) << step) != (inside & ~low & 0xff) ||
            ((on & low) << step) != (on & ~low & 0xff)) {
            continue;
        }
        *quads = 0;
        for (int f = 0; f < 6; ++f) {
            if (f / 2 == axis || b->count[f] == 0) continue;
            count += b->count[f] == 4 ? 1 : 4;
            *quads |= 1u << f;
        }
        if (count == 2) return axis;
    }
    return -1;
}

// Nodes of that wedge, right-handed.
MORTISE_FUNCTION void wedge_nodes(const CellBoundary* b, int axis, int* n) {
    const int low = axis == 1 ? 2 * axis + 1 : 2 * axis;
    for (int i = 0; i < 3; ++i) {
        n[i] = b->node[low][i];
        n[3 + i] = b->node[low ^ 1][i];
    }
}

#endif
