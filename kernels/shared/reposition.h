// Repositioning of one node: where it may lie so that the worst element around it gets better
// (docs/design/improvement.md).
//
// Everything is in box-local coordinates. A node is inside a region, and free, or on one surface, and slides
// on it. A move makes no element around the node worse, but those that are good and stay so. For one lane
// (MORTISE_ONE_LANE in lanes.h).
#ifndef MORTISE_SHARED_REPOSITION_H
#define MORTISE_SHARED_REPOSITION_H

#include "corner_quality.h"
#include "corners.h"
#include "surface.h"

// What improvement calls good: 18 and 155 degrees, a scaled Jacobian of 0.2; no edge of hexahedra, wedges and
// pyramids shorter than 0.35 cells.
#define kRepositionJacobianScale (1.0 / 0.04)
#define kRepositionAcuteScale (1.0 / 0.0954915028125263)  // 1 / sin² 18°
#define kRepositionObtuseScale (1.0 / 0.178606194956727)  // 1 / sin² 155°
#define kRepositionShortestEdge 0.35
// Hexahedra around a node that moves: a scaled Jacobian of 0.8, or what they had.
#define kRepositionHexahedronScale (1.0 / 0.64)
// Quality (squared, 1 is good) up to which nodes move: rounding must not leave it below 1.
#define kRepositionTarget 1.0005
// The worst quality must rise by this factor.
#define kRepositionGain 1.004
// Steps, of the mean distance to the nodes around: the first, and how often it is halved.
#define kRepositionFirstStep 0.25
#define kRepositionHalvings 4
#define kRepositionMostSteps 16
#define kRepositionNewtonSteps 12
// The middle of a facet may be as far from its curved surface as it was, or as this, in cells.
#define kRepositionMostSag 0.1
// Nodes with more elements around them stay.
#define kMostStarElements 64
#define kFreeNode 0xffffffffu    // instead of a surface: the node lies on none
#define kNotMovable 0xffffffffu  // instead of a place among the movable nodes

// Types of StarElement behind those of the elements (mortise/mesh.hpp).
#define kStarTriangle 4u  // facets: of a moving node's surface
#define kStarQuadrilateral 5u

// An element or a facet at a node.
typedef struct StarElement {
    u32 node[8];  // places in the list of nodes
    u32 type;
} StarElement;

typedef struct MovableNode {
    u32 node;      // place in the list of nodes
    u32 first;     // of its star
    u32 elements;  // at the star's beginning
    u32 facets;    // behind them
    u32 surface;   // kFreeNode: free
    u32 padding;
} MovableNode;

// What a node would like.
typedef struct NodeMove {
    double point[3];
    double before;  // quality of its worst element
    u32 wanted;
    u32 padding;
} NodeMove;

typedef struct RepositionScale {
    double cell;      // edge of the finest cell, box-local
    double shortest;  // kRepositionShortestEdge of it, squared; 0 if cells have several sizes
    double units;     // lattice steps per unit of length: a power of two
} RepositionScale;

#define kMostCorners 8
#define MORTISE_ALL_ANGLES(node, first, second, third) {node, first, second, third, 7},
// Per type: a corner, its neighbours, and at which of their edges the angle counts. The last three corners of
// a tetrahedron leave out what others have.
MORTISE_TABLE u8 kQualityCorners[4][kMostCorners][5] = {
    {MORTISE_HEXAHEDRON_CORNERS(MORTISE_ALL_ANGLES)},
    {MORTISE_WEDGE_CORNERS(MORTISE_ALL_ANGLES)},
    {MORTISE_PYRAMID_CORNERS(MORTISE_ALL_ANGLES)},
    {{0, 1, 2, 3, 7}, {1, 2, 0, 3, 5}, {2, 0, 1, 3, 4}, {3, 1, 0, 2, 0}}};
MORTISE_TABLE u8 kQualityCornerCount[4] = {8, 6, 4, 4};
MORTISE_TABLE u8 kStarNodes[6] = {8, 6, 5, 4, 3, 4};

// Quality of an element at its corners beside node `at`, or at all of them (at < 0); less than `floor` may be
// any value below it.
MORTISE_FUNCTION double repositioned_quality(u32 type, int at, const double (*p)[3], double jacobian_scale,
                                             double shortest, double floor) {
    double worst = kMortiseInfinity;
    for (int i = 0; i < kQualityCornerCount[type]; ++i) {
        const int o = kQualityCorners[type][i][0];
        const int a = kQualityCorners[type][i][1];
        const int b = kQualityCorners[type][i][2];
        const int c = kQualityCorners[type][i][3];
        double q;
        if (at >= 0 && at != o && at != a && at != b && at != c) continue;
        q = scaled_corner_quality(p[o], p[a], p[b], p[c], kQualityCorners[type][i][4], jacobian_scale,
                                  kRepositionAcuteScale, kRepositionObtuseScale);
        if (q < worst) worst = q;
        if (!(worst >= floor)) return worst;
        for (int k = 1; k < 4 && type < 3 && shortest > 0; ++k) {
            const double* end = p[kQualityCorners[type][i][k]];
            const double x = end[0] - p[o][0];
            const double y = end[1] - p[o][1];
            const double z = end[2] - p[o][2];
            q = (x * x + y * y + z * z) / shortest;
            if (q < worst) worst = q;
        }
    }
    return worst;
}

// What elements around moving nodes are measured by.
MORTISE_FUNCTION double moved_jacobian_scale(u32 type) {
    return type == 0 ? kRepositionHexahedronScale : kRepositionJacobianScale;
}

// Everything that a search for a node's place looks at.
typedef struct NodeStar {
    MORTISE_GLOBAL StarElement* star;
    MORTISE_GLOBAL double* points;
    MORTISE_GLOBAL Surface* surface;  // of the node, if it has one
    MORTISE_GLOBAL ExpressionOp* ops;
    RepositionScale scale;
    MovableNode node;
} NodeStar;

// Quality of the star's i-th element with the node at x.
MORTISE_FUNCTION double star_element_quality(const NodeStar* s, u32 i, const double* x, double floor) {
    MORTISE_GLOBAL StarElement* e = s->star + s->node.first + i;
    double p[8][3];
    int at = 0;
    for (int k = 0; k < kStarNodes[e->type]; ++k) {
        const int moves = e->node[k] == s->node.node;
        if (moves) at = k;
        for (int j = 0; j < 3; ++j) p[k][j] = moves ? x[j] : s->points[3 * (u64)e->node[k] + j];
    }
    return repositioned_quality(e->type, at, p, moved_jacobian_scale(e->type), s->scale.shortest, floor);
}

// Quality of the worst element with the node at x, at most the target, or something not above `floor`; -1 if
// an element has less than `least`. `refuser`: the element to ask first, and the one that refused.
MORTISE_FUNCTION double star_quality(const NodeStar* s, const double* least, const double* x, double floor,
                                     u32* refuser) {
    double worst = kRepositionTarget;
    const u32 count = s->node.elements;
    for (u32 n = 0; n < count; ++n) {
        const u32 i = n == 0 ? *refuser : n <= *refuser ? n - 1 : n;
        const double q = star_element_quality(s, i, x, least[i]);
        if (q >= least[i] && !(q < worst)) continue;
        if (q >= least[i] && q > floor) {
            worst = q;
            continue;
        }
        *refuser = i;
        return q >= least[i] ? q : -1;
    }
    return worst;
}

// Largest distance of a facet's middle from the surface, to first order, with the node at x.
MORTISE_FUNCTION double star_sag(const NodeStar* s, const double* x) {
    double worst = 0;
    for (u32 i = 0; i < s->node.facets; ++i) {
        MORTISE_GLOBAL StarElement* e = s->star + s->node.first + s->node.elements + i;
        const int count = kStarNodes[e->type];
        double m[3] = {0, 0, 0};
        double square = 0;
        for (int k = 0; k < count; ++k) {
            const int moves = e->node[k] == s->node.node;
            for (int j = 0; j < 3; ++j) m[j] += moves ? x[j] : s->points[3 * (u64)e->node[k] + j];
        }
        for (int j = 0; j < 3; ++j) m[j] /= count;
        const SurfaceSample sample = surface_sample(s->surface, s->ops, m[0], m[1], m[2]);
        for (int j = 0; j < 3; ++j) square += sample.gradient[j] * sample.gradient[j];
        if (!(square > 0 && square < kMortiseInfinity)) return kMortiseInfinity;
        const double sag = mortise_fabs(sample.value) / mortise_sqrt(square);
        if (!(sag <= worst)) worst = sag;
    }
    return worst;
}

// Moves x onto the node's surface; 0 if it does not settle.
MORTISE_FUNCTION int put_on_surface(const NodeStar* s, double* x) {
    const double still = s->scale.cell / 1073741824.0;  // 2^-30 of a cell
    for (int step = 0; step < kRepositionNewtonSteps; ++step) {
        const SurfaceSample sample = surface_sample(s->surface, s->ops, x[0], x[1], x[2]);
        double square = 0;
        for (int j = 0; j < 3; ++j) square += sample.gradient[j] * sample.gradient[j];
        if (!(square > 0 && square < kMortiseInfinity)) return 0;
        for (int j = 0; j < 3; ++j) x[j] -= sample.value / square * sample.gradient[j];
        if (sample.value * sample.value <= still * still * square) return 1;
    }
    return 0;
}

// Two directions along the node's surface, at right angles; 0 if it does not tell.
MORTISE_FUNCTION int tangents(const NodeStar* s, const double* x, double (*t)[3]) {
    const SurfaceSample sample = surface_sample(s->surface, s->ops, x[0], x[1], x[2]);
    double n[3];
    double square = 0;
    int least = 0;
    for (int j = 0; j < 3; ++j) square += sample.gradient[j] * sample.gradient[j];
    if (!(square > 0 && square < kMortiseInfinity)) return 0;
    for (int j = 0; j < 3; ++j) n[j] = sample.gradient[j] / mortise_sqrt(square);
    for (int j = 1; j < 3; ++j) {
        if (mortise_fabs(n[j]) < mortise_fabs(n[least])) least = j;
    }
    {
        // The axis `least`, less its part along n; what is left is at least sqrt(2/3) long.
        const double length = mortise_sqrt(1 - n[least] * n[least]);
        for (int j = 0; j < 3; ++j) t[0][j] = ((j == least ? 1 : 0) - n[least] * n[j]) / length;
    }
    t[1][0] = n[1] * t[0][2] - n[2] * t[0][1];
    t[1][1] = n[2] * t[0][0] - n[0] * t[0][2];
    t[1][2] = n[0] * t[0][1] - n[1] * t[0][0];
    return 1;
}

// Mean distance from the node to the others of its elements.
MORTISE_FUNCTION double star_size(const NodeStar* s, const double* x) {
    double sum = 0;
    u32 count = 0;
    for (u32 i = 0; i < s->node.elements; ++i) {
        MORTISE_GLOBAL StarElement* e = s->star + s->node.first + i;
        for (int k = 0; k < kStarNodes[e->type]; ++k) {
            double square = 0;
            if (e->node[k] == s->node.node) continue;
            for (int j = 0; j < 3; ++j) {
                const double d = s->points[3 * (u64)e->node[k] + j] - x[j];
                square += d * d;
            }
            sum += mortise_sqrt(square);
            ++count;
        }
    }
    return count > 0 ? sum / count : 0;
}

// A better place for the node: steps along the axes, or along its surface, each time the best of them; halved
// where none helps.
MORTISE_FUNCTION NodeMove find_move(const NodeStar* s) {
    NodeMove move;
    double least[kMostStarElements];
    double at[3];
    double best;
    double step;
    double sag;
    u32 refuser = 0;
    int halvings = 0;
    const int slides = s->node.surface != kFreeNode;
    for (int j = 0; j < 3; ++j) at[j] = s->points[3 * (u64)s->node.node + j];
    for (int j = 0; j < 3; ++j) move.point[j] = at[j];
    move.before = kRepositionTarget;
    move.wanted = 0;
    move.padding = 0;
    for (u32 i = 0; i < s->node.elements; ++i) {
        least[i] = star_element_quality(s, i, at, -kMortiseInfinity);
        if (least[i] < move.before) {
            move.before = least[i];
            refuser = i;
        }
        if (least[i] > kRepositionTarget) least[i] = kRepositionTarget;
    }
    if (!(move.before < 1)) return move;
    best = move.before;
    step = kRepositionFirstStep * star_size(s, at);
    sag = slides && s->surface->kind != kSurfacePlane ? star_sag(s, at) : 0;
    if (sag < kRepositionMostSag * s->scale.cell) sag = kRepositionMostSag * s->scale.cell;
    for (int n = 0; n < kRepositionMostSteps && best < kRepositionTarget && halvings <= kRepositionHalvings;
         ++n) {
        double t[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        double from[3];
        int found = 0;
        for (int j = 0; j < 3; ++j) from[j] = move.point[j];
        if (slides && !tangents(s, from, t)) break;
        for (int d = 0; d < (slides ? 8 : 14); ++d) {
            double x[3];
            double q;
            for (int j = 0; j < 3; ++j) x[j] = from[j];
            // Axes, then diagonals.
            for (int k = 0; k < (slides ? 2 : 3); ++k) {
                const int axes = slides ? 4 : 6;
                if (d < axes && d >> 1 != k) continue;
                const double along = ((d < axes ? d : (d - axes) >> k) & 1) ? -step : step;
                for (int j = 0; j < 3; ++j)
                    x[j] += (d < axes ? 1.0 : slides ? 0.7071 : 0.5774) * along * t[k][j];
            }
            if (slides && !put_on_surface(s, x)) continue;
            for (int j = 0; j < 3; ++j) x[j] = mortise_rint(x[j] * s->scale.units) / s->scale.units;
            q = star_quality(s, least, x, best, &refuser);
            if (!(q > best)) continue;
            if (slides && s->surface->kind != kSurfacePlane && !(star_sag(s, x) <= sag)) continue;
            best = q;
            found = 1;
            for (int j = 0; j < 3; ++j) move.point[j] = x[j];
        }
        if (found) continue;
        step *= 0.5;
        ++halvings;
    }
    if (best >= 1 || best > move.before * kRepositionGain) move.wanted = 1;
    return move;
}

// Whether no other node around the i-th movable one goes before it: one that is worse off, or as badly and
// comes first. movable_at: per node its place among the movable ones, or kNotMovable.
MORTISE_FUNCTION int goes_first(MORTISE_GLOBAL StarElement* star, MovableNode node,
                                MORTISE_GLOBAL u32* movable_at, MORTISE_GLOBAL NodeMove* moves, u32 i) {
    for (u32 n = 0; n < node.elements; ++n) {
        MORTISE_GLOBAL StarElement* e = star + node.first + n;
        for (int k = 0; k < kStarNodes[e->type]; ++k) {
            const u32 other = movable_at[e->node[k]];
            if (other == kNotMovable || other == i || moves[other].wanted == 0) continue;
            if (moves[other].before < moves[i].before ||
                (moves[other].before == moves[i].before && other < i))
                return 0;
        }
    }
    return 1;
}

#endif
