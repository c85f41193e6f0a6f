// Patches: smooth surfaces given by triangles, as signed distances.
//
// f(x) is the distance to the closest triangle, negative behind it. Where triangles are equally close (an
// edge or vertex in common), the one that x sees least edge-on tells the side (Bærentzen & Aanæs 2005 prove
// it for angle-weighted normals; this rule agrees with them at edges and needs no normals). Beyond the rim f
// goes on along normals interpolated between the rim's corners, so that it is continuous where it is zero,
// and two patches that meet at a crease cut each other there as other surfaces do.
//
// Data, an arena of doubles: nodes of a bounding volume hierarchy, eight numbers each (low corner, high
// corner, a, b), the root first; b < 0: a is the second child, the first one follows its parent; else b
// triangles from triangle a on. Triangles are ten numbers: corners counter-clockwise from outside, and
// kPatchRim… bits.
#ifndef MORTISE_SHARED_PATCH_H
#define MORTISE_SHARED_PATCH_H

#include "platform.h"

#include "expression.h"

#if defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__)
typedef double patch_number;
#else
typedef double patch_number __attribute__((may_alias));  // lies in the expressions' arena
#endif

#define kPatchNode 8
#define kPatchTriangle 22
#define kPatchRimEdge 1    // << k: edge from corner k to corner k + 1 has no neighbour in the patch
#define kPatchRimVertex 8  // << k: corner k is on the rim
#define kPatchStack 64
#define kPatchTie 1e-9  // relative difference of squared distances that counts as none

typedef struct PatchHit {
    double squared;    // distance
    double to[3];      // from the closest point to x
    double normal[3];  // of its triangle; on the rim interpolated, not of unit length
    double facing;     // squared distance to its plane: how little edge-on it is seen
    i32 rim;           // whether the closest point lies on the rim
} PatchHit;

MORTISE_FUNCTION double patch_dot(const double* a, const double* b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Squared distance from x to a node's box.
MORTISE_FUNCTION double patch_box_distance(MORTISE_GLOBAL patch_number* node, const double* x) {
    double sum = 0;
    for (int j = 0; j < 3; ++j) {
        const double below = node[j] - x[j];
        const double above = x[j] - node[3 + j];
        const double d = below > 0 ? below : above > 0 ? above : 0;
        sum += d * d;
    }
    return sum;
}

// Replaces `best` if the triangle is closer to x, or as close and seen less edge-on.
MORTISE_FUNCTION void patch_try_triangle(MORTISE_GLOBAL patch_number* t, const double* x, PatchHit* best) {
    double ab[3];
    double ac[3];
    double ax[3];
    double s = 0;  // closest point a + s ab + r ac
    double r = 0;
    i32 on = 0;     // kPatchRim… bit of the edge or vertex it lies on
    double height;  // over the triangle's plane
    for (int j = 0; j < 3; ++j) {
        ab[j] = t[3 + j] - t[j];
        ac[j] = t[6 + j] - t[j];
        ax[j] = x[j] - t[j];
    }
    height = t[10] * ax[0] + t[11] * ax[1] + t[12] * ax[2];
    if (height * height > best->squared * (1 + kPatchTie)) return;
    {
        const double bb = patch_dot(ab, ab);
        const double cc = patch_dot(ac, ac);
        const double bc = patch_dot(ab, ac);
        const double bx = patch_dot(ab, ax);
        const double cx = patch_dot(ac, ax);
        const double area = bb * cc - bc * bc;
        const double u = bx * cc - cx * bc;  // barycentric coordinates of the foot, times `area`
        const double v = cx * bb - bx * bc;
        if (area > 0 && u >= 0 && v >= 0 && u + v <= area) {
            s = u / area;
            r = v / area;
        } else {
            // The closest point of the three edges.
            double least = kMortiseInfinity;
            for (int edge = 0; edge < 3; ++edge) {
                // a to b, b to c, c to a as p + q·(direction), in coordinates (s, r).
                const double length2 = edge == 0 ? bb : edge == 1 ? bb + cc - 2 * bc : cc;
                const double along = edge == 0 ? bx : edge == 1 ? cx - bx + bb - bc : cc - cx;
                double q = length2 > 0 ? along / length2 : 0;
                double trial_s;
                double trial_r;
                double squared;
                q = q < 0 ? 0 : q > 1 ? 1 : q;
                trial_s = edge == 0 ? q : edge == 1 ? 1 - q : 0;
                trial_r = edge == 0 ? 0 : edge == 1 ? q : 1 - q;
                squared = trial_s * trial_s * bb + trial_r * trial_r * cc + 2 * trial_s * trial_r * bc -
                          2 * trial_s * bx - 2 * trial_r * cx;
                if (squared < least) {
                    least = squared;
                    s = trial_s;
                    r = trial_r;
                    on = q == 0   ? kPatchRimVertex << edge
                         : q == 1 ? kPatchRimVertex << ((edge + 1) % 3)
                                  : kPatchRimEdge << edge;
                }
            }
        }
    }
    double to[3];
    double squared;
    for (int j = 0; j < 3; ++j) to[j] = ax[j] - s * ab[j] - r * ac[j];
    squared = patch_dot(to, to);
    if (squared > best->squared * (1 + kPatchTie)) return;
    const double facing = height * height;
    if (squared >= best->squared * (1 - kPatchTie) && facing <= best->facing) return;
    best->squared = squared;
    best->facing = facing;
    best->rim = ((i32)t[9] & on) != 0;
    for (int j = 0; j < 3; ++j) {
        best->to[j] = to[j];
        best->normal[j] = best->rim ? (1 - s - r) * t[13 + j] + s * t[16 + j] + r * t[19 + j] : t[10 + j];
    }
}

// Value and gradient at x of the patch whose nodes start at `nodes` and triangles at `triangles`. Closer than
// `near` the direction to the closest point is rounding.
MORTISE_NOINLINE double patch_sample(MORTISE_GLOBAL patch_number* nodes,
                                     MORTISE_GLOBAL patch_number* triangles, double near, const double* x,
                                     double* gradient) {
    PatchHit hit;
    u32 open[kPatchStack];
    int top = 0;
    hit.squared = kMortiseInfinity;
    hit.facing = -1;
    hit.rim = 0;
    for (int j = 0; j < 3; ++j) hit.to[j] = hit.normal[j] = 0;
    open[0] = 0;
    while (top >= 0) {
        const u32 index = open[top--];
        MORTISE_GLOBAL patch_number* node = nodes + kPatchNode * index;
        if (patch_box_distance(node, x) > hit.squared * (1 + kPatchTie)) continue;
        if (node[7] < 0) {
            const u32 first = index + 1;
            const u32 second = (u32)node[6];
            const int second_closer = patch_box_distance(nodes + kPatchNode * second, x) <
                                      patch_box_distance(nodes + kPatchNode * first, x);
            open[++top] = second_closer ? first : second;
            open[++top] = second_closer ? second : first;
        } else {
            const u32 begin = (u32)node[6];
            for (u32 t = begin; t < begin + (u32)node[7]; ++t) {
                patch_try_triangle(triangles + kPatchTriangle * t, x, &hit);
            }
        }
    }
    const double distance = mortise_sqrt(hit.squared);
    const double length = mortise_sqrt(patch_dot(hit.normal, hit.normal));
    const double height = length > 0 ? patch_dot(hit.normal, hit.to) / length : distance;
    // On the surface and beyond the rim along the normal; elsewhere the distance.
    const int flat = hit.rim || distance <= near || mortise_fabs(height) >= distance * (1 - 1e-12);
    const double side = height < 0 ? -1 : 1;
    for (int j = 0; j < 3; ++j) {
        gradient[j] = !flat ? side * hit.to[j] / distance : length > 0 ? hit.normal[j] / length : 0;
    }
    return flat ? height : side * distance;
}

#endif
