// Decompositions of a simple cell's inside part into a cone: every facet of its boundary (cell_boundary.h)
// that does not hold the apex, joined to it. The apex is a node of the boundary or one new node inside.
//
// Triangles become tetrahedra and quadrilaterals pyramids. Γ is divided by diagonals so that the worst
// element over it is best; from an apex on Γ it is a fan. The decompositions without a new node that
// quality.md lists are all of this kind, for the diagonals that its cells had.
//
// Quality of an element: over its scaled Jacobian / 0.15 and the sines of its dihedral angles over those of
// 15° (acute) and 160° (obtuse), the smallest, squared; 1 or more where it meets the targets, <= 0 where it
// is not positive. Only + - * / decide.
#ifndef MORTISE_SHARED_CONE_H
#define MORTISE_SHARED_CONE_H

#include "cell_boundary.h"
#include "corner_quality.h"

#define kJacobianScale (1.0 / 0.0225)
#define kAcuteScale (1.0 / 0.0669872981077807)  // 1 / sin² 15°
#define kObtuseScale (1.0 / 0.116977778440511)  // 1 / sin² 160°
// An element counts as positive if the triple product of three edges is above this times their lengths.
#define kLeastRelativeVolume 1e-9
// Above that whatever the lengths, which are below 3 between nodes of a cell.
#define kClearVolume 1e-6
// Better than this is not distinguished.
#define kGoodQuality 4.0
// A cone from an interior node is tried only below this.
#define kWorthNoNode 2.25
// The interior node moves only below this, by steps from the first to the last, in cell edges.
#define kMeetsTargets 1.0
#define kFirstMove 0.125
#define kLastMove 0.01
#define kMostSurfaceFacets (kLargestLoop - 2)
#define kNoApex 255

typedef struct Cone {
    double quality;   // of the worst element; <= 0: no valid cone
    double point[3];  // of the interior node, if it is the apex
    i32 elements;
    u32 apex;                        // node code; kNoApex: none
    u32 facet_count;                 // of Γ
    u16 facets[kMostSurfaceFacets];  // places in the loop, four bits each from the lowest; triangles repeat
                                     // the last
} Cone;

// scaled_corner_quality for these targets.
MORTISE_FUNCTION double corner_quality(const double* o, const double* a, const double* b, const double* c,
                                       int dihedrals) {
    return scaled_corner_quality(o, a, b, c, dihedrals, kJacobianScale, kAcuteScale, kObtuseScale);
}

// Quality of the tetrahedron or pyramid over a facet that is counter-clockwise seen from the apex; less than
// `floor` may be any value below it.
MORTISE_FUNCTION double cone_element_quality(const double (*p)[3], const u8* facet, int size,
                                             const double* apex, double floor) {
    const double* a = p[facet[0]];
    const double* b = p[facet[1]];
    const double* c = p[facet[2]];
    double worst;
    if (size == 3) {
        double q;
        worst = corner_quality(a, b, c, apex, 7);
        if (!(worst > floor)) return worst;
        q = corner_quality(b, c, a, apex, 5);  // edges b–c and b–apex
        if (q < worst) worst = q;
        if (!(worst > floor)) return worst;
        q = corner_quality(c, a, b, apex, 4);
        if (q < worst) worst = q;
        q = corner_quality(apex, a, c, b, 0);
        return q < worst ? q : worst;
    }
    worst = kGoodQuality * 16;
    for (int i = 0; i < 4; ++i) {
        const double q = corner_quality(p[facet[i]], p[facet[(i + 1) & 3]], p[facet[(i + 3) & 3]], apex, 7);
        if (q < worst) worst = q;
        if (!(worst > floor)) return worst;
    }
    return worst;
}

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

// Nodes whose cones have the facets of all faces: a node lies off a face, or on all its facets and these are
// triangles.
MORTISE_FUNCTION u32 possible_apexes(const CellBoundary* b) {
    u32 apexes = b->nodes | (1u << kCellInteriorNode);
    for (int f = 0; f < 6; ++f) apexes &= ~forbidden_apexes(b->node[f], b->count[f], b->mesh[f]);
    return apexes;
}

// Divides Γ, with a loop of n nodes, for an apex off it: dynamic programming over chains of the loop. facing:
// faces of the cell on which no facet of Γ may lie. Writes facets and elements; returns the quality, at most
// kGoodQuality.
MORTISE_FUNCTION double divide_surface(const u8* loop, int n, const double (*p)[3], const double* apex,
                                       u32 facing, double floor, Cone* cone) {
    double best[kLargestLoop][kLargestLoop];
    u8 choice[kLargestLoop][kLargestLoop];
    u32 faces[kLargestLoop];
    for (int i = 0; i < n; ++i) faces[i] = kNodeFaces[loop[i]] & facing;
    for (int i = 0; i + 1 < n; ++i) best[i][i + 1] = kGoodQuality;
    for (int length = 2; length < n; ++length) {
        for (int i = 0; i + length < n; ++i) {
            const int j = i + length;
            double here = -1;
            u8 chosen = 0;
            // k == l: a triangle. Quadrilaterals first: fewer elements win ties.
            for (int quads = length > 2 ? 1 : 0; quads >= 0; --quads) {
                for (int k = i + 1; k < j; ++k) {
                    const int last = quads ? j - 1 : k;
                    for (int l = quads ? k + 1 : k; l <= last; ++l) {
                        u8 facet[4];
                        double q = best[i][k] < best[l][j] ? best[i][k] : best[l][j];
                        if (quads && best[k][l] < q) q = best[k][l];
                        if (!(q > here) || !(q > floor)) continue;
                        if ((faces[i] & faces[k] & faces[l] & faces[j]) != 0) continue;
                        // Seen from the apex.
                        facet[0] = loop[j];
                        facet[1] = loop[l];
                        facet[2] = quads ? loop[k] : loop[i];
                        facet[3] = loop[i];
                        {
                            const double element =
                                cone_element_quality(p, facet, 3 + quads, apex, here > floor ? here : floor);
                            if (element < q) q = element;
                        }
                        if (q > here) {
                            here = q;
                            chosen = (u8)(k | (l << 4));
                        }
                    }
                }
            }
            if (!(here > floor)) here = -1;
            best[i][j] = here;
            choice[i][j] = chosen;
        }
    }
    if (!(best[0][n - 1] > floor)) return -1;
    {
        u8 stack[2 * kLargestLoop];
        int top = 0;
        stack[top++] = (u8)((n - 1) << 4);
        cone->facet_count = 0;
        while (top > 0) {
            const int chain = stack[--top];
            const int i = chain & 15;
            const int j = chain >> 4;
            if (j - i < 2) continue;
            {
                const int k = choice[i][j] & 15;
                const int l = choice[i][j] >> 4;
                cone->facets[cone->facet_count++] =
                    (u16)(k == l ? i | (k << 4) | (j << 8) | (j << 12) : i | (k << 4) | (l << 8) | (j << 12));
                stack[top++] = (u8)(i | (k << 4));
                if (k != l) stack[top++] = (u8)(k | (l << 4));
                stack[top++] = (u8)(l | (j << 4));
            }
        }
        cone->elements += (i32)cone->facet_count;
    }
    return best[0][n - 1];
}

#define kMostCellFacets 18

// The facets of all faces.
typedef struct CellFacets {
    u32 count;
    u32 nodes[kMostCellFacets];  // the set of them
    u8 size[kMostCellFacets];
    u8 facet[kMostCellFacets][4];
} CellFacets;

MORTISE_FUNCTION void list_facets(const CellBoundary* b, CellFacets* facets) {
    facets->count = 0;
    for (int f = 0; f < 6; ++f) {
        const int count = facet_count(b->count[f], b->mesh[f]);
        for (int i = 0; i < count; ++i) {
            u8* facet = facets->facet[facets->count];
            const int size = face_facet(b, f, i, facet);
            u32 nodes = 0;
            for (int k = 0; k < size; ++k) nodes |= 1u << facet[k];
            facets->size[facets->count] = (u8)size;
            facets->nodes[facets->count++] = nodes;
        }
    }
}

// The cone from one apex; kept only if its quality is above `floor`.
MORTISE_FUNCTION double make_cone(const CellBoundary* b, const CellFacets* facets, const double (*p)[3],
                                  int apex, u32 facing, double floor, Cone* cone) {
    double worst = kGoodQuality;
    int place = -1;
    cone->elements = 0;
    cone->facet_count = 0;
    cone->apex = (u32)apex;
    for (int i = 0; i < b->loop_size; ++i) place = b->loop[i] == apex ? i : place;
    for (u32 i = 0; i < facets->count; ++i) {
        if ((facets->nodes[i] >> apex) & 1) continue;
        {
            const double q = cone_element_quality(p, facets->facet[i], facets->size[i], p[apex], floor);
            if (q < worst) worst = q;
        }
        ++cone->elements;
        if (!(worst > floor)) return -1;
    }
    if (place >= 0) {
        for (int i = 1; i + 1 < b->loop_size; ++i) {
            const int k = place + i < b->loop_size ? place + i : place + i - b->loop_size;
            const int l = k + 1 < b->loop_size ? k + 1 : 0;
            if ((kNodeFaces[apex] & kNodeFaces[b->loop[k]] & kNodeFaces[b->loop[l]] & facing) != 0) return -1;
            cone->facets[cone->facet_count++] = (u16)(place | (k << 4) | (l << 8) | (l << 12));
        }
    } else if (b->loop_size > 0) {
        const double q = divide_surface(b->loop, b->loop_size, p, p[apex], facing, floor, cone);
        if (q < worst) worst = q;
    }
    return worst;
}

// The mean of some nodes.
MORTISE_FUNCTION void place_interior_node(u32 nodes, double (*p)[3]) {
    double count = 0;
    double x = 0;
    double y = 0;
    double z = 0;
    for (u32 rest = nodes; rest != 0; rest &= rest - 1) {
        const double* at = p[mortise_lowest_bit(rest)];
        x += at[0];
        y += at[1];
        z += at[2];
        count += 1;
    }
    p[kCellInteriorNode][0] = x / count;
    p[kCellInteriorNode][1] = y / count;
    p[kCellInteriorNode][2] = z / count;
}

MORTISE_FUNCTION int is_positive_corner(const double* o, const double* a, const double* b, const double* c) {
    const double ux = a[0] - o[0];
    const double uy = a[1] - o[1];
    const double uz = a[2] - o[2];
    const double vx = b[0] - o[0];
    const double vy = b[1] - o[1];
    const double vz = b[2] - o[2];
    const double wx = c[0] - o[0];
    const double wy = c[1] - o[1];
    const double wz = c[2] - o[2];
    const double volume = ux * (vy * wz - vz * wy) + uy * (vz * wx - vx * wz) + uz * (vx * wy - vy * wx);
    if (volume > kClearVolume) return 1;
    return volume > 0 &&
           volume * volume > kLeastRelativeVolume * kLeastRelativeVolume *
                                 ((ux * ux + uy * uy + uz * uz) * (vx * vx + vy * vy + vz * vz) *
                                  (wx * wx + wy * wy + wz * wz));
}

// The cone from the interior node, which moves along the axes as long as the worst element gets better; the
// steps halve.
MORTISE_FUNCTION Cone moved_cone(const CellBoundary* b, const CellFacets* facets, double (*p)[3],
                                 u32 facing) {
    double* at = p[kCellInteriorNode];
    Cone best;
    best.quality = make_cone(b, facets, (const double(*)[3])p, kCellInteriorNode, facing, 0, &best);
    for (double step = kFirstMove; step > kLastMove; step /= 2) {
        for (int k = 0; k < 6; ++k) {
            const double old = at[k >> 1];
            Cone cone;
            at[k >> 1] = old + ((k & 1) ? step : -step);
            cone.quality = make_cone(b, facets, (const double(*)[3])p, kCellInteriorNode, facing,
                                     best.quality > 0 ? best.quality : 0, &cone);
            if (cone.quality > best.quality) {
                best = cone;
            } else {
                at[k >> 1] = old;
            }
        }
    }
    return best;
}

// The best cone of the cell, from the nodes first; from an interior node where none of these is good, which
// moves if that is short of the targets, too. Positions of the boundary's nodes are given;
// p[kCellInteriorNode] is scratch. facing: faces of the cell on which no facet of Γ may lie: those that have
// a mesh, or volume beyond.
MORTISE_FUNCTION Cone best_cone(const CellBoundary* b, double (*p)[3], u32 facing) {
    Cone best;
    best.quality = -1;
    best.apex = kNoApex;
    best.elements = 0;
    best.facet_count = 0;
    const u32 apexes = possible_apexes(b);
    CellFacets facets;
    list_facets(b, &facets);
    for (int j = 0; j < 3; ++j) p[kCellInteriorNode][j] = 0;
    for (int code = 0; code <= kCellInteriorNode; ++code) {
        Cone cone;
        if (((apexes >> code) & 1) == 0) continue;
        if (code == kCellInteriorNode) {
            if (best.quality >= kWorthNoNode) break;
            place_interior_node(b->nodes, p);
        }
        cone.quality = make_cone(b, &facets, (const double(*)[3])p, code, facing,
                                 best.quality > 0 ? best.quality : 0, &cone);
        if (cone.quality > best.quality ||
            (cone.quality == best.quality && cone.quality > 0 && cone.elements < best.elements)) {
            best = cone;
        }
        if (best.quality >= kGoodQuality) break;
    }
    if (best.quality > 0 && best.quality < kMeetsTargets) {
        const Cone moved = moved_cone(b, &facets, p, facing);
        if (moved.quality > best.quality) best = moved;
    }
    for (int j = 0; j < 3; ++j) best.point[j] = p[kCellInteriorNode][j];
    return best;
}

#endif
