// What classification tells of each NIO leaf: meshed by which template, or left to the certificate.
#ifndef MORTISE_SHARED_SNIO_H
#define MORTISE_SHARED_SNIO_H

#include "lattice.h"

// Leaves that one work-item handles where the device is a CPU: that have points in common
// (snio/row_points.h), and that are binned by topology (snio/bins.h).
#define kLeavesInRow 64
#define kLeavesInChunk 512

#define kPatternCnio 256  // SnioLeaf::pattern of a leaf that the certificate meshes

// SnioLeaf::method.
#define kMethodNothing 0     // no inside corner, or the certificate
#define kMethodHexahedron 1  // all eight corners
#define kMethodRow 2         // row `pattern` of template_table.h
#define kMethodCone 3        // cone.h
#define kMethodWedge 4       // between two triangular faces

// One leaf. Corners that are neither inside nor on the surface are outside.
typedef struct SnioLeaf {
    u32 surface;     // the one surface; undefined for CNIO
    u16 pattern;     // bit c: corner c is inside; kPatternCnio
    u16 region;      // of the inside
    u8 on;           // bit c: corner c is on the surface
    u8 displaced;    // bit c: corner c was moved there
    u8 method;       // kMethodNothing …
    u8 apex;         // of the cone: node code; of the wedge: its axis
    u16 faces;       // two bits per face: its mesh (cell_boundary.h)
    u8 boundary;     // bit f: face f, all of whose corners are on the surface, is boundary, and listed here
    u8 facet_count;  // of Γ
    u8 snapped;      // bit c: corner c was moved as SnappedLeaf tells
    u8 padding[3];
    u16 facets[6];  // of Γ, for cones and wedges: cone.h
    i32 point[3];   // of the interior node of a cone, in lattice units
} SnioLeaf;

#define kNoCandidateSurface 0xffffffffu

// What is known of a leaf before vertices are snapped.
typedef struct SnioCandidate {
    u32 surface;
    u16 region;
    u8 inside;   // bit c: the side of corner c is the region; means nothing where `zero` is set
    u8 zero;     // bit c: corner c is on the surface where it is
    u8 near;     // bit c: corner c may be moved onto the surface
    u8 flags;    // kCandidate…
    u8 needed;   // bit c: simple only if corner c, which is not in `zero`, is moved
    u8 snapped;  // bit c: corner c is moved as SnappedLeaf tells
} SnioCandidate;

// Corners of a leaf that are snapped beside complex leaves (host/snapping): before the others, and whatever
// these do. On their surface, if it is the leaf's, they are in SnioCandidate::zero.
typedef struct SnappedLeaf {
    u32 leaf;
    u32 surface;      // of an IN leaf: which one a face of it lies on; kNoCandidateSurface: none is known to
    u16 region;       // of an IN leaf; else 0
    u8 zero;          // bit c: corner c is on the leaf's surface; none of an IN leaf
    u8 snapped;       // bit c: corner c moves
    i32 moved[8][3];  // as SnioPoints, of those in `snapped`
} SnappedLeaf;

// Where a simple leaf meets its surface. What is neither near nor cut is undefined.
typedef struct SnioPoints {
    i32 moved[8][3];  // displacement of corner c, if it is near, in lattice units
    i32 root[12];     // on edge e, if it is cut, in lattice units from the edge's low corner
} SnioPoints;

// Place of a leaf's points: among those of the leaves that were found first, or with this bit among those of
// promoted ones.
#define kPromotedPoints 0x80000000u

#define kCandidateSimple 1    // one surface, and a template for the corners as they are
#define kCandidateSafe 2      // a template whichever of the `near` corners are moved
#define kCandidatePromoted 4  // was an IN leaf
#define kCandidateTorn 8      // promoted for one surface, and has a face on another: no `near` corner moves

// Corners that may not move after all, whatever their leaves' `near` says: a bit for each, eight to a leaf.
// Each leaf around a vertex takes the bits of all of them; the order does not matter.
MORTISE_FUNCTION u32 vetoes_of(MORTISE_GLOBAL u32* vetoes, u32 leaf) {
    return (vetoes[leaf >> 2] >> (8 * (leaf & 3))) & 0xffu;
}

// Corners that move, once all vetoes are known.
MORTISE_FUNCTION u32 moved_corners(SnioCandidate candidate, u32 vetoes) {
    return (candidate.flags & kCandidateSafe) != 0 ? candidate.near & ~vetoes : 0;
}

// Whether a leaf has a template, now that it is known which of its corners move.
MORTISE_FUNCTION int stays_simple(SnioCandidate candidate, u32 moved) {
    return (candidate.flags & kCandidateSimple) != 0 && (candidate.needed & ~moved) == 0;
}

// Whether a leaf beyond face f, if it is simple, has these corners of the face on the same sides.
MORTISE_FUNCTION int sides_agree(u32 inside, u32 outside, SnioCandidate beyond, i32 f) {
    if ((beyond.flags & kCandidateSimple) == 0) return 1;
    for (int i = 0; i < 4; ++i) {
        const u32 here = kFaceCorners[f][i];
        const u32 there = here ^ (1u << (f / 2));
        const u32 other = ((u32)beyond.inside >> there) & 1;
        if ((((u32)beyond.zero >> there) & 1) != 0) continue;
        if ((((other != 0 ? outside : inside) >> here) & 1) != 0) return 0;
    }
    return 1;
}

// Edges between an inside and an outside corner.
MORTISE_FUNCTION u32 cut_edges(u32 inside, u32 on) {
    u32 cuts = 0;
    for (int e = 0; e < 12; ++e) {
        const int a = kEdgeCorners[e][0];
        const int b = kEdgeCorners[e][1];
        if (((on >> a) & 1) == 0 && ((on >> b) & 1) == 0 && (((inside >> a) ^ (inside >> b)) & 1) != 0) {
            cuts |= 1u << e;
        }
    }
    return cuts;
}

#endif
