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

Points gather(__global const double* points, __global const uint* nodes, uint count, uint first, uint last) {
    double x[WIDTH];
    double y[WIDTH];
    double z[WIDTH];
    for (uint lane = 0; lane < WIDTH; ++lane) {
        const uint element = min(first + lane, last);
        const double3 p = vload3(nodes[(ulong)count * element], points);
        x[lane] = p.x;
        y[lane] = p.y;
        z[lane] = p.z;
    }
    Points gathered;
    gathered.x = LOAD_LANES(x);
    gathered.y = LOAD_LANES(y);
    gathered.z = LOAD_LANES(z);
    return gathered;
}

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
        store(smallest, values + first, elements - first);                               \
    }

void store(lanes_double results, __global float* values, uint left) {
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
