// Numbers of several leaves at a time. What is written with them, the choice of templates (cell_boundary.h,
// cone.h, leaf_template.h, corner_choices.h), serves one leaf on the host and on GPUs, and eight whose
// corners have the same states in kernels on a CPU: the same operations in the same order, lane by lane, and
// so the same bits.
//
// A kernel that is to have one lane on all devices defines MORTISE_ONE_LANE before it includes this.
#ifndef MORTISE_SHARED_LANES_H
#define MORTISE_SHARED_LANES_H

#include "platform.h"

// A set of leaves has bit i for lane i.
typedef u32 LaneSet;

#if defined(LANES) && LANES == 8 && !defined(MORTISE_ONE_LANE)

#define kLanes 8
typedef double8 Reals;
typedef long8 Flags;  // what comparisons give; only & and | serve all devices

MORTISE_FUNCTION Reals choose_lanes(Reals no, Reals yes, Flags flags) { return select(no, yes, flags); }
MORTISE_FUNCTION LaneSet set_of_lanes(Flags flags) {
    const long8 bits = flags & (long8)(1, 2, 4, 8, 16, 32, 64, 128);
    const long4 halves = bits.lo | bits.hi;
    const long2 quarters = halves.lo | halves.hi;
    return (LaneSet)(quarters.x | quarters.y);
}
MORTISE_FUNCTION Flags lanes_of_set(LaneSet set) {
    return ((long8)(long)set & (long8)(1, 2, 4, 8, 16, 32, 64, 128)) != 0;
}
MORTISE_FUNCTION void set_lane(Reals* reals, u32 lane, double value) { ((double*)reals)[lane] = value; }
MORTISE_FUNCTION double get_lane(const Reals* reals, u32 lane) { return ((const double*)reals)[lane]; }

#else

#define kLanes 1
typedef double Reals;
typedef int Flags;

MORTISE_FUNCTION Reals choose_lanes(Reals no, Reals yes, Flags flags) { return flags ? yes : no; }
MORTISE_FUNCTION LaneSet set_of_lanes(Flags flags) { return (LaneSet)flags; }
MORTISE_FUNCTION Flags lanes_of_set(LaneSet set) { return (Flags)set; }
MORTISE_FUNCTION void set_lane(Reals* reals, u32 lane, double value) { reals[lane] = value; }
MORTISE_FUNCTION double get_lane(const Reals* reals, u32 lane) { return reals[lane]; }

#endif

#define kAllLanes ((1u << kLanes) - 1)

MORTISE_FUNCTION Reals lower_lanes(Reals a, Reals b) { return choose_lanes(a, b, b < a); }

// Vectors have names for their parts, for compilers keep arrays in memory.
typedef struct LaneVector {
    Reals x;
    Reals y;
    Reals z;
} LaneVector;

MORTISE_FUNCTION LaneVector lane_edge(const Reals* from, const Reals* to) {
    LaneVector edge;
    edge.x = to[0] - from[0];
    edge.y = to[1] - from[1];
    edge.z = to[2] - from[2];
    return edge;
}

MORTISE_FUNCTION Reals dot_lanes(LaneVector u, LaneVector v) { return u.x * v.x + u.y * v.y + u.z * v.z; }

MORTISE_FUNCTION LaneVector cross_lanes(LaneVector u, LaneVector v) {
    LaneVector cross;
    cross.x = u.y * v.z - u.z * v.y;
    cross.y = u.z * v.x - u.x * v.z;
    cross.z = u.x * v.y - u.y * v.x;
    return cross;
}

#endif
