// Decompositions of a simple cell's inside part into a cone: every facet of its boundary (cell_boundary.h)
// that does not hold the apex, joined to it. The apex is a node of the boundary or one new node inside.
//
// Triangles become tetrahedra and quadrilaterals pyramids. Γ is divided by diagonals so that the worst
// element over it is best; from an apex on Γ it is a fan.
//
// Quality of an element: over its scaled Jacobian / 0.15 and the sines of its dihedral angles over those of
// 15° (acute) and 160° (obtuse), the smallest, squared; 1 or more where it meets the targets, <= 0 where it
// is not positive. Only + - * / decide.
#ifndef MORTISE_SHARED_CONE_H
#define MORTISE_SHARED_CONE_H

#include "corner_quality.h"
#include "face_plan.h"

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

// Cones of some leaves.
typedef struct Cones {
    Reals quality;   // of the worst element; <= 0: no valid cone
    Reals point[3];  // of the interior node, if it is the apex
    u8 apex[kLanes];
    u8 facet_count[kLanes];                  // of Γ
    u16 facets[kLanes][kMostSurfaceFacets];  // places in the loop, four bits each from the lowest; triangles
                                             // repeat the last
} Cones;

// One leaf's cone, but for its point.
MORTISE_FUNCTION void take_cone(const Cones* from, u32 lane, Cones* to) {
    set_lane(&to->quality, lane, get_lane(&from->quality, lane));
    to->apex[lane] = from->apex[lane];
    to->facet_count[lane] = from->facet_count[lane];
    for (u32 i = 0; i < from->facet_count[lane]; ++i) to->facets[lane][i] = from->facets[lane][i];
}

// scaled_corner_quality for these targets.
MORTISE_NOINLINE Reals corner_quality(const Reals* o, const Reals* a, const Reals* b, const Reals* c,
                                      int dihedrals) {
    return scaled_corner_quality(o, a, b, c, dihedrals, kJacobianScale, kAcuteScale, kObtuseScale);
}

// Quality of the tetrahedron or pyramid over a facet that is counter-clockwise seen from the apex; where it
// is not above `floor` for one of `wanted`, it may be any value that is not.
MORTISE_NOINLINE Reals cone_element_quality(const Reals (*p)[3], const u8* facet, int size, const Reals* apex,
                                            LaneSet wanted, Reals floor) {
    const Reals* a = p[facet[0]];
    const Reals* b = p[facet[1]];
    const Reals* c = p[facet[2]];
    Reals worst;
    if (size == 3) {
        worst = corner_quality(a, b, c, apex, 7);
        if ((set_of_lanes(worst > floor) & wanted) == 0) return worst;
        worst = lower_lanes(worst, corner_quality(b, c, a, apex, 5));  // edges b–c and b–apex
        if ((set_of_lanes(worst > floor) & wanted) == 0) return worst;
        worst = lower_lanes(worst, corner_quality(c, a, b, apex, 4));
        return lower_lanes(worst, corner_quality(apex, a, c, b, 0));
    }
    worst = kGoodQuality * 16;
    for (int i = 0; i < 4; ++i) {
        worst = lower_lanes(
            worst, corner_quality(p[facet[i]], p[facet[(i + 1) & 3]], p[facet[(i + 3) & 3]], apex, 7));
        if ((set_of_lanes(worst > floor) & wanted) == 0) return worst;
    }
    return worst;
}

// How Γ, with a loop of nodes, is divided between two of its places: by a triangle or a quadrilateral to one
// or two places between them.
typedef struct Division {
    Reals quality[kLargestLoop][kLargestLoop];
    u8 places[kLargestLoop][kLargestLoop][kLanes];  // the first, and the last times 16
} Division;

// Divides Γ for an apex off it: dynamic programming over chains of the loop. facing: faces of the cell on
// which no facet of Γ may lie. Returns those of `wanted` for which all elements are better than `floor`.
MORTISE_NOINLINE LaneSet divide_surface(MORTISE_GLOBAL LoopPlan* loop, const Reals (*p)[3], const Reals* apex,
                                        u32 facing, LaneSet wanted, Reals floor, Division* division) {
    const int n = loop->size;
    const Reals none = -1;
    u8 node[kLargestLoop];
    u32 faces[kLargestLoop];
    for (int i = 0; i < n; ++i) {
        node[i] = loop->node[i];
        faces[i] = kNodeFaces[node[i]] & facing;
    }
    for (int i = 0; i + 1 < n; ++i) division->quality[i][i + 1] = kGoodQuality;
    for (int length = 2; length < n; ++length) {
        for (int i = 0; i + length < n; ++i) {
            const int j = i + length;
            Reals here = none;
            // k == l: a triangle. Quadrilaterals first: fewer elements win ties.
            for (int quads = length > 2 ? 1 : 0; quads >= 0; --quads) {
                for (int k = i + 1; k < j; ++k) {
                    const int last = quads ? j - 1 : k;
                    for (int l = quads ? k + 1 : k; l <= last; ++l) {
                        u8 facet[4];
                        const Reals least = choose_lanes(floor, here, here > floor);
                        Reals q = lower_lanes(division->quality[i][k], division->quality[l][j]);
                        LaneSet better;
                        if (quads) q = lower_lanes(q, division->quality[k][l]);
                        better = set_of_lanes(q > least) & wanted;
                        if (better == 0 || (faces[i] & faces[k] & faces[l] & faces[j]) != 0) continue;
                        // Seen from the apex.
                        facet[0] = node[j];
                        facet[1] = node[l];
                        facet[2] = quads ? node[k] : node[i];
                        facet[3] = node[i];
                        q = lower_lanes(q, cone_element_quality(p, facet, 3 + quads, apex, better, least));
                        better &= set_of_lanes(q > least);
                        here = choose_lanes(here, q, lanes_of_set(better));
                        for (; better != 0; better &= better - 1)
                            division->places[i][j][mortise_lowest_bit(better)] = (u8)(k | (l << 4));
                    }
                }
            }
            division->quality[i][j] = here;
        }
    }
    return set_of_lanes(division->quality[0][n - 1] > floor) & wanted;
}

// The facets of a division of a loop of n nodes; returns their number.
MORTISE_FUNCTION u8 facets_of_division(const Division* division, int n, u32 lane, u16* facets) {
    u8 stack[2 * kLargestLoop];
    u8 count = 0;
    int top = 0;
    stack[top++] = (u8)((n - 1) << 4);
    while (top > 0) {
        const int chain = stack[--top];
        const int i = chain & 15;
        const int j = chain >> 4;
        if (j - i < 2) continue;
        const int k = division->places[i][j][lane] & 15;
        const int l = division->places[i][j][lane] >> 4;
        facets[count++] =
            (u16)(k == l ? i | (k << 4) | (j << 8) | (j << 12) : i | (k << 4) | (l << 8) | (j << 12));
        stack[top++] = (u8)(i | (k << 4));
        if (k != l) stack[top++] = (u8)(k | (l << 4));
        stack[top++] = (u8)(l | (j << 4));
    }
    return count;
}

// The mean of some nodes.
MORTISE_FUNCTION void place_interior_node(u32 nodes, Reals (*p)[3]) {
    double count = 0;
    Reals x = 0;
    Reals y = 0;
    Reals z = 0;
    for (u32 rest = nodes; rest != 0; rest &= rest - 1) {
        const Reals* at = (const Reals*)p[mortise_lowest_bit(rest)];
        x += at[0];
        y += at[1];
        z += at[2];
        count += 1;
    }
    p[kCellInteriorNode][0] = x / count;
    p[kCellInteriorNode][1] = y / count;
    p[kCellInteriorNode][2] = z / count;
}

// Leaves in which the corner o of an element with edges to a, b, c is positive.
MORTISE_NOINLINE LaneSet positive_corners(const Reals* o, const Reals* a, const Reals* b, const Reals* c) {
    const LaneVector u = lane_edge(o, a);
    const LaneVector v = lane_edge(o, b);
    const LaneVector w = lane_edge(o, c);
    const Reals volume = dot_lanes(u, cross_lanes(v, w));
    const LaneSet clear = set_of_lanes(volume > kClearVolume);
    if (clear == kAllLanes) return clear;
    return clear | set_of_lanes((volume > 0) & (volume * volume >
                                                kLeastRelativeVolume * kLeastRelativeVolume *
                                                    (dot_lanes(u, u) * dot_lanes(v, v) * dot_lanes(w, w))));
}

// Joins the facets of all faces to an apex that is not on them. Returns those of `wanted` where all elements
// are better than `floor`; *worst gets the worst one's quality.
MORTISE_FUNCTION LaneSet join_faces(const CellFaces* faces, const Reals (*p)[3], u32 apex, LaneSet wanted,
                                    Reals floor, Reals* worst) {
    for (u32 f = 0; f < 6 && wanted != 0; ++f) {
        for (int m = 0; m < kFaceMeshes; ++m) {
            MORTISE_GLOBAL FaceMeshPlan* mesh = &faces->plan[f]->mesh[m];
            const LaneSet leaves = faces->meshes[f][m];
            for (u32 i = 0, size = 0; i < mesh->count && (leaves & wanted) != 0; i += size == 4 ? 4 : 1) {
                u8 facet[4];
                Reals q;
                size = mesh_facet(mesh, i, facet);
                if (((mesh->facet[i] >> apex) & 1) != 0) continue;
                q = lower_lanes(*worst,
                                cone_element_quality(p, facet, (int)size, p[apex], leaves & wanted, floor));
                *worst = leaves == kAllLanes ? q : choose_lanes(*worst, q, lanes_of_set(leaves));
                wanted &= set_of_lanes(*worst > floor);
            }
        }
    }
    return wanted;
}

// The fan of Γ from a place of its loop; returns how many facets it has, or -1 if one lies on a face in
// `facing`.
MORTISE_FUNCTION int fan_facets(MORTISE_GLOBAL LoopPlan* loop, int place, u32 facing, u16* facets) {
    const int n = loop->size;
    int count = 0;
    for (int i = 1; i + 1 < n; ++i) {
        const int k = place + i < n ? place + i : place + i - n;
        const int l = k + 1 < n ? k + 1 : 0;
        const u32 faces = kNodeFaces[loop->node[place]] & kNodeFaces[loop->node[k]];
        if ((faces & kNodeFaces[loop->node[l]] & facing) != 0) return -1;
        facets[count++] = (u16)(place | (k << 4) | (l << 8) | (l << 12));
    }
    return count;
}

// Gives those of `wanted` their cone from one apex where all its elements are better than `floor`, which is
// not below the quality of what they have.
MORTISE_NOINLINE LaneSet make_cones(const CellFaces* faces, MORTISE_GLOBAL LoopPlan* loop,
                                    const Reals (*p)[3], u32 apex, u32 facing, LaneSet wanted, Reals floor,
                                    Cones* cones) {
    const int n = loop->size;
    Reals worst = kGoodQuality;
    Division division;
    u16 fan[kMostSurfaceFacets];
    int fan_size = 0;
    const int place = place_in_loop(loop, apex);
    if (place >= 0) fan_size = fan_facets(loop, place, facing, fan);
    if (fan_size < 0) return 0;
    wanted = join_faces(faces, p, apex, wanted, floor, &worst);
    if (wanted != 0 && n > 0 && place < 0) {
        wanted = divide_surface(loop, p, p[apex], facing, wanted, floor, &division);
        worst = lower_lanes(worst, division.quality[0][n - 1]);
    }
    for (LaneSet rest = wanted; rest != 0; rest &= rest - 1) {
        const u32 lane = mortise_lowest_bit(rest);
        cones->apex[lane] = (u8)apex;
        if (n > 0 && place < 0) {
            cones->facet_count[lane] = facets_of_division(&division, n, lane, cones->facets[lane]);
        } else {
            cones->facet_count[lane] = (u8)fan_size;
            for (int i = 0; i < fan_size; ++i) cones->facets[lane][i] = fan[i];
        }
    }
    cones->quality = choose_lanes(cones->quality, worst, lanes_of_set(wanted));
    return wanted;
}

// What a cone must be better than: the one before, if it is one.
MORTISE_FUNCTION Reals least_quality(const Cones* cones) {
    const Reals none = 0;
    return choose_lanes(none, cones->quality, cones->quality > 0);
}

// Cones from interior nodes, which move along the axes as long as the worst element gets better; the steps
// halve. Those that are better than what the leaves have replace it, and p[kCellInteriorNode] is theirs.
MORTISE_FUNCTION void move_cones(const CellFaces* faces, MORTISE_GLOBAL LoopPlan* loop, Reals (*p)[3],
                                 u32 facing, LaneSet wanted, Cones* cones) {
    Reals* at = p[kCellInteriorNode];
    Cones best;
    best.quality = -1;
    make_cones(faces, loop, (const Reals(*)[3])p, kCellInteriorNode, facing, wanted, least_quality(&best),
               &best);
    for (double step = kFirstMove; step > kLastMove; step /= 2) {
        for (int k = 0; k < 6; ++k) {
            const Reals old = at[k >> 1];
            const Reals next = old + ((k & 1) ? step : -step);
            LaneSet better;
            at[k >> 1] = next;
            better = make_cones(faces, loop, (const Reals(*)[3])p, kCellInteriorNode, facing, wanted,
                                least_quality(&best), &best);
            at[k >> 1] = choose_lanes(old, next, lanes_of_set(better));
        }
    }
    for (LaneSet rest = set_of_lanes(best.quality > cones->quality) & wanted; rest != 0; rest &= rest - 1)
        take_cone(&best, mortise_lowest_bit(rest), cones);
}

// The best cone of each leaf of `wanted`, from the nodes first; from an interior node where none of these is
// good, which moves if that is short of the targets, too. Positions of the boundary's nodes are given;
// p[kCellInteriorNode] is scratch. facing: faces of the cell on which no facet of Γ may lie: those that have
// a mesh, or volume beyond.
MORTISE_FUNCTION void best_cones(const CellFaces* faces, MORTISE_GLOBAL LoopPlan* loop, Reals (*p)[3],
                                 u32 facing, LaneSet wanted, Cones* cones) {
    u32 some;
    const u32 apexes = possible_apexes(faces, &some);
    cones->quality = -1;
    for (u32 lane = 0; lane < kLanes; ++lane) {
        cones->apex[lane] = kNoApex;
        cones->facet_count[lane] = 0;
    }
    for (int j = 0; j < 3; ++j) p[kCellInteriorNode][j] = 0;
    for (u32 rest = apexes; rest != 0; rest &= rest - 1) {
        const u32 apex = mortise_lowest_bit(rest);
        LaneSet left = wanted & ~set_of_lanes(cones->quality >= kGoodQuality);
        if (apex == kCellInteriorNode) {
            left &= ~set_of_lanes(cones->quality >= kWorthNoNode);
            if (left != 0) place_interior_node(nodes_of_faces(faces), p);
        }
        if ((some >> apex) & 1) left = with_apex(faces, apex, left);
        if (left == 0) continue;
        make_cones(faces, loop, (const Reals(*)[3])p, apex, facing, left, least_quality(cones), cones);
    }
    wanted &= set_of_lanes((cones->quality > 0) & (cones->quality < kMeetsTargets));
    if (wanted != 0) move_cones(faces, loop, p, facing, wanted, cones);
    for (int j = 0; j < 3; ++j) cones->point[j] = p[kCellInteriorNode][j];
}

#endif
