// The tape: the solid as a function of its surfaces' signs, a postfix program of 32-bit words.
//
// A stack machine over small integers. Literals push 1 (inside the surface's half) or 0. And/or combine two
// of them. Select turns a truth value into a region number: 0 is outside, 1, 2, … are the model's regions.
// Evaluated on intervals, an entry may also be unknown; a pruned tape keeps only what is unknown on its cell.
// Complements are pushed down to the literals by the compiler. Operation numbers are append-only.
#ifndef MORTISE_SHARED_TAPE_H
#define MORTISE_SHARED_TAPE_H

#include "platform.h"

#define kTapeLiteral 0      // bits 0–27: surface; bit 28: negated (true outside)
#define kTapeAnd 1          // a b → a ∧ b
#define kTapeOr 2           // a b → a ∨ b
#define kTapeSelect 3       // rest a → a ? k : rest, k in bits 0–11
#define kTapeSelectConst 4  // a → a ? k : v, k in bits 0–11, v in bits 12–23
#define kTapeSpatial 5      // bits 0–27: place in the spatial table; bit 28: negated (spatial.h)

#define kTapeStack 40    // deepest stack that the compiler emits
#define kSpatialStack 8  // deepest stack of a formula in the spatial table
#define kRegionBits 12   // of a region's number
#define kMaxRegions ((1 << kRegionBits) - 1)
#define kMostTapeWords 0xc0000000u  // of all tapes: counting ends here, before it wraps
#define kUnknown (-1)

MORTISE_FUNCTION u32 tape_operation(u32 word) { return word >> 29; }
MORTISE_FUNCTION u32 tape_surface(u32 word) { return word & 0x0fffffffu; }
MORTISE_FUNCTION u32 tape_negated(u32 word) { return (word >> 28) & 1u; }
MORTISE_FUNCTION i32 tape_region(u32 word) { return (i32)(word & 0xfffu); }
MORTISE_FUNCTION i32 tape_otherwise(u32 word) { return (i32)((word >> 12) & 0xfffu); }

MORTISE_FUNCTION u32 make_literal(u32 surface, u32 negated) { return surface | (negated << 28); }
MORTISE_FUNCTION u32 make_spatial(u32 place, u32 negated) {
    return ((u32)kTapeSpatial << 29) | place | (negated << 28);
}
MORTISE_FUNCTION u32 make_operation(u32 operation, i32 region, i32 otherwise) {
    return (operation << 29) | (u32)region | ((u32)otherwise << 12);
}

// Three-valued and / or / select on 0, 1, region numbers and kUnknown.
MORTISE_FUNCTION i32 combine_and(i32 a, i32 b) {
    if (a == 0 || b == 0) return 0;
    return (a == 1 && b == 1) ? 1 : kUnknown;
}
MORTISE_FUNCTION i32 combine_or(i32 a, i32 b) {
    if (a == 1 || b == 1) return 1;
    return (a == 0 && b == 0) ? 0 : kUnknown;
}
MORTISE_FUNCTION i32 combine_select(i32 otherwise, i32 a, i32 region) {
    if (a == 1) return region;
    if (a == 0) return otherwise;
    return otherwise == region ? region : kUnknown;
}

#endif
