// What comes before and after the matrix product that takes nodes to edges at corners (host/jacobian): one
// work-item handles one element. Matrices are stored by columns; row e + c · items is coordinate c of element
// e, so that work-items side by side touch memory side by side.
#define WIDTH 1
#include "corner_value.h"

// coordinates: one column for each of the element's `count` nodes.
MORTISE_KERNEL void gather_coordinates(__global const double* points, __global const uint* nodes, uint count,
                                       __global double* coordinates, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    for (uint i = 0; i < count; ++i) {
        const double3 p = vload3(nodes[(ulong)count * item + i], points);
        __global double* column = coordinates + (ulong)i * 3 * items + item;
        column[0] = p.x;
        column[items] = p.y;
        column[2 * (ulong)items] = p.z;
    }
}

// edges: three columns for each corner; values[element]: the scaled Jacobian.
MORTISE_KERNEL void smallest_corner(__global const double* edges, uint corners, __global float* values,
                                    uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    double smallest = 1;
    for (uint i = 0; i < corners; ++i) {
        Points edge[3];
        for (uint j = 0; j < 3; ++j) {
            __global const double* column = edges + (ulong)(3 * i + j) * 3 * items + item;
            edge[j].x = column[0];
            edge[j].y = column[items];
            edge[j].z = column[2 * (ulong)items];
        }
        smallest = smaller(smallest, corner_value(edge[0], edge[1], edge[2]));
    }
    values[item] = (float)root(smallest);
}
