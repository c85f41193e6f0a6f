// Scaled Jacobians of the elements of one type, straight from the nodes: one work-item handles WIDTH
// elements.
//
// No loops over nodes and corners and no arrays of them, so that compilers keep the nodes in registers. Reads
// points (x, y, z) and each element's nodes; writes values[element].
#if LANES == 8
#define WIDTH 8
#else
#define WIDTH 1
#endif
#include "corner_value.h"
#include "shared/corners.h"

#if WIDTH == 8
// Straight into lanes: an array of lanes, written one by one and read as a whole, waits for the last of them.
#define LANES_OF(c)                                                                                     \
    (double8)(points[n.s0 + c], points[n.s1 + c], points[n.s2 + c], points[n.s3 + c], points[n.s4 + c], \
              points[n.s5 + c], points[n.s6 + c], points[n.s7 + c])
static Points gather(__global const double* points, __global const uint* nodes, uint count, uint first,
                     uint last) {
    const ulong8 lane = (ulong8)(0, 1, 2, 3, 4, 5, 6, 7);
    const ulong8 at = min((ulong8)first + lane, (ulong8)last) * (ulong)count;
    const ulong8 n = 3 * (ulong8)(nodes[at.s0], nodes[at.s1], nodes[at.s2], nodes[at.s3], nodes[at.s4],
                                  nodes[at.s5], nodes[at.s6], nodes[at.s7]);
    Points gathered;
    gathered.x = LANES_OF(0);
    gathered.y = LANES_OF(1);
    gathered.z = LANES_OF(2);
    return gathered;
}
#else
static Points gather(__global const double* points, __global const uint* nodes, uint count, uint first,
                     uint last) {
    const double3 p = vload3(nodes[(ulong)count * min(first, last)], points);
    Points gathered;
    gathered.x = p.x;
    gathered.y = p.y;
    gathered.z = p.z;
    return gathered;
}
#endif

#define NODE(i, count) const Points p##i = gather(points, nodes + i, count, first, elements - 1);
#define CORNER(node, first, second, third)                                                                   \
    smallest = smaller(smallest, corner_value(difference(p##first, p##node), difference(p##second, p##node), \
                                              difference(p##third, p##node)));

#define SCALED_JACOBIANS(entry, NODES, CORNERS)                                          \
    MORTISE_KERNEL void entry(__global const double* points, __global const uint* nodes, \
                              __global float* values, uint elements, uint items) {       \
        const uint item = get_global_id(0);                                              \
        if (item >= items) return;                                                       \
        const uint first = WIDTH * item;                                                 \
        lanes_double smallest = 1;                                                       \
        NODES                                                                            \
        CORNERS(CORNER)                                                                  \
        store(root(smallest), values + first, elements - first);                         \
    }

static void store(lanes_double results, __global float* values, uint left) {
    if (left >= WIDTH) {
        STORE_LANES(TO_FLOAT(results), values);
    } else {
        float each[WIDTH];
        STORE_LANES(TO_FLOAT(results), each);
        for (uint lane = 0; lane < left; ++lane) values[lane] = each[lane];
    }
}

#define NODES_4(count) NODE(0, count) NODE(1, count) NODE(2, count) NODE(3, count)
#define NODES_5(count) NODES_4(count) NODE(4, count)
#define NODES_6(count) NODES_5(count) NODE(5, count)
#define NODES_8(count) NODES_6(count) NODE(6, count) NODE(7, count)

SCALED_JACOBIANS(hexahedron_jacobians, NODES_8(8), MORTISE_HEXAHEDRON_CORNERS)
SCALED_JACOBIANS(wedge_jacobians, NODES_6(6), MORTISE_WEDGE_CORNERS)
SCALED_JACOBIANS(pyramid_jacobians, NODES_5(5), MORTISE_PYRAMID_CORNERS)
SCALED_JACOBIANS(tetrahedron_jacobians, NODES_4(4), MORTISE_TETRAHEDRON_CORNERS)
