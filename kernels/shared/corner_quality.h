// Quality of an element at one of its corners: its scaled Jacobian and the sines of its dihedral angles, each
// over what is wanted of it; the smallest, squared. Only + - * / decide.
#ifndef MORTISE_SHARED_CORNER_QUALITY_H
#define MORTISE_SHARED_CORNER_QUALITY_H

#include "platform.h"

// At corner o with edges to a, b, c (right-handed); `dihedrals`: which of the three edges count. The scales
// are one over the squares of what is wanted: of the scaled Jacobian, and of the sines of acute and obtuse
// angles. -1 where the corner is not positive.
MORTISE_FUNCTION double scaled_corner_quality(const double* o, const double* a, const double* b,
                                              const double* c, int dihedrals, double jacobian_scale,
                                              double acute_scale, double obtuse_scale) {
    const double ux = a[0] - o[0];
    const double uy = a[1] - o[1];
    const double uz = a[2] - o[2];
    const double vx = b[0] - o[0];
    const double vy = b[1] - o[1];
    const double vz = b[2] - o[2];
    const double wx = c[0] - o[0];
    const double wy = c[1] - o[1];
    const double wz = c[2] - o[2];
    const double lx = vy * wz - vz * wy;  // v × w
    const double ly = vz * wx - vx * wz;
    const double lz = vx * wy - vy * wx;
    const double volume = ux * lx + uy * ly + uz * lz;
    const double u = ux * ux + uy * uy + uz * uz;
    const double v = vx * vx + vy * vy + vz * vz;
    const double w = wx * wx + wy * wy + wz * wz;
    const double square = volume * volume;
    double worst;
    if (!(volume > 0)) return -1;
    worst = square / (u * v * w) * jacobian_scale;
    if (dihedrals != 0) {
        const double mx = wy * uz - wz * uy;  // w × u
        const double my = wz * ux - wx * uz;
        const double mz = wx * uy - wy * ux;
        const double nx = uy * vz - uz * vy;  // u × v
        const double ny = uz * vx - ux * vz;
        const double nz = ux * vy - uy * vx;
        const double l = lx * lx + ly * ly + lz * lz;
        const double m = mx * mx + my * my + mz * mz;
        const double n = nx * nx + ny * ny + nz * nz;
        double q;
        if (dihedrals & 1) {  // along u: between u × v and u × w
            q = square * u / (m * n) * (mx * nx + my * ny + mz * nz < 0 ? acute_scale : obtuse_scale);
            if (q < worst) worst = q;
        }
        if (dihedrals & 2) {
            q = square * v / (n * l) * (nx * lx + ny * ly + nz * lz < 0 ? acute_scale : obtuse_scale);
            if (q < worst) worst = q;
        }
        if (dihedrals & 4) {
            q = square * w / (l * m) * (lx * mx + ly * my + lz * mz < 0 ? acute_scale : obtuse_scale);
            if (q < worst) worst = q;
        }
    }
    return worst;
}

#endif
