// Quality of an element at one of its corners: its scaled Jacobian and the sines of its dihedral angles, each
// over what is wanted of it; the smallest, squared. Only + - * / decide.
#ifndef MORTISE_SHARED_CORNER_QUALITY_H
#define MORTISE_SHARED_CORNER_QUALITY_H

#include "lanes.h"

// At corner o with edges to a, b, c (right-handed); `dihedrals`: which of the three edges count. The scales
// are one over the squares of what is wanted: of the scaled Jacobian, and of the sines of acute and obtuse
// angles. -1 where the corner is not positive.
MORTISE_FUNCTION Reals scaled_corner_quality(const Reals* o, const Reals* a, const Reals* b, const Reals* c,
                                             int dihedrals, double jacobian_scale, double acute_scale,
                                             double obtuse_scale) {
    const LaneVector u = lane_edge(o, a);
    const LaneVector v = lane_edge(o, b);
    const LaneVector w = lane_edge(o, c);
    const LaneVector l = cross_lanes(v, w);
    const Reals volume = dot_lanes(u, l);
    const Reals uu = dot_lanes(u, u);
    const Reals vv = dot_lanes(v, v);
    const Reals ww = dot_lanes(w, w);
    const Reals square = volume * volume;
    const Flags positive = volume > 0;
    const Reals inverted = -1;
    Reals worst;
    if (set_of_lanes(positive) == 0) return inverted;
    worst = square / (uu * vv * ww) * jacobian_scale;
    if (dihedrals != 0) {
        const LaneVector m = cross_lanes(w, u);
        const LaneVector n = cross_lanes(u, v);
        const Reals ll = dot_lanes(l, l);
        const Reals mm = dot_lanes(m, m);
        const Reals nn = dot_lanes(n, n);
        const Reals acute = acute_scale;
        const Reals obtuse = obtuse_scale;
        if (dihedrals & 1)  // along u: between u × v and u × w
            worst = lower_lanes(worst,
                                square * uu / (mm * nn) * choose_lanes(obtuse, acute, dot_lanes(m, n) < 0));
        if (dihedrals & 2)
            worst = lower_lanes(worst,
                                square * vv / (nn * ll) * choose_lanes(obtuse, acute, dot_lanes(n, l) < 0));
        if (dihedrals & 4)
            worst = lower_lanes(worst,
                                square * ww / (ll * mm) * choose_lanes(obtuse, acute, dot_lanes(l, m) < 0));
    }
    return choose_lanes(inverted, worst, positive);
}

#endif
