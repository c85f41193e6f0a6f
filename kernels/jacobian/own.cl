// Scaled Jacobians of the elements of one type, straight from the nodes: one work-item handles WIDTH
// elements.
//
// No loops over nodes and corners and no arrays of them, so that compilers keep the nodes in registers. Reads
// points (x, y, z), each element's nodes and kind; writes values[element]. `cubes`: hexahedra of kind 0 are
// boxes along the axes, whose values are 1, or else their values do not count.
#if LANES == 8
#define WIDTH 8
#else
#define WIDTH 1
#endif
#include "corner_value.h"
#include "shared/corners.h"

#if WIDTH == 8
// Pairs of coordinates, put into lanes in registers. From single ones compilers make gather instructions,
// which take three times as long on some processors; an array of lanes, written one by one and read as a
// whole, waits for the last of them.
typedef double2 Pair __attribute__((aligned(8)));
#define PAIRS(k)                                                                                         \
    __global const double* const at##k = points + 3 * (ulong)nodes[(ulong)count * min(first + k, last)]; \
    const double2 xy##k = *(__global const Pair*)at##k;                                                  \
    const double2 yz##k = *(__global const Pair*)(at##k + 1)
#define IN_LANES(a, b, c, d, e, f, g, h, i) (double8)(a.i, b.i, c.i, d.i, e.i, f.i, g.i, h.i)
static Points gather(__global const double* points, __global const uint* nodes, uint count, uint first,
                     uint last) {
    Points gathered;
    PAIRS(0);
    PAIRS(1);
    PAIRS(2);
    PAIRS(3);
    PAIRS(4);
    PAIRS(5);
    PAIRS(6);
    PAIRS(7);
    gathered.x = IN_LANES(xy0, xy1, xy2, xy3, xy4, xy5, xy6, xy7, x);
    gathered.y = IN_LANES(xy0, xy1, xy2, xy3, xy4, xy5, xy6, xy7, y);
    gathered.z = IN_LANES(yz0, yz1, yz2, yz3, yz4, yz5, yz6, yz7, y);
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

// Whether all elements are boxes along the axes, as most hexahedra are: their values round to 1.
#if WIDTH == 8
#define ALL(condition) all(condition)
#else
#define ALL(condition) (condition)
#endif
#define FLAT(c, i, j, k, l) ((p##i.c == p##j.c) & (p##i.c == p##k.c) & (p##i.c == p##l.c))
#define HEXAHEDRA_ARE_BOXES                                                               \
    ALL(FLAT(x, 0, 3, 4, 7) & FLAT(x, 1, 2, 5, 6) & (p0.x < p1.x) & FLAT(y, 0, 1, 4, 5) & \
        FLAT(y, 3, 2, 7, 6) & (p0.y < p3.y) & FLAT(z, 0, 1, 2, 3) & FLAT(z, 4, 5, 6, 7) & (p0.z < p4.z))

#define HEXAHEDRA_ARE_CUBES (cubes && are_cubes(kinds + first, elements - first))

#define SCALED_JACOBIANS(entry, NODES, ARE_CUBES, ARE_BOXES, CORNERS)                                        \
    MORTISE_KERNEL void entry(__global const double* points, __global const uint* nodes,                     \
                              __global const uchar* kinds, __global float* values, uint elements, int cubes, \
                              uint items) {                                                                  \
        const uint item = get_global_id(0);                                                                  \
        if (item >= items) return;                                                                           \
        const uint first = WIDTH * item;                                                                     \
        lanes_double smallest = 1;                                                                           \
        if (!(ARE_CUBES)) {                                                                                  \
            NODES                                                                                            \
            if (!(ARE_BOXES)) {                                                                              \
                CORNERS(CORNER)                                                                              \
            }                                                                                                \
        }                                                                                                    \
        store(root(smallest), values + first, elements - first);                                             \
    }

// Whether the next elements are of kind 0; at the end they may be looked at one by one.
static int are_cubes(__global const uchar* kinds, uint left) {
#if WIDTH == 8
    return left >= 8 && as_ulong(vload8(0, kinds)) == 0;
#else
    return kinds[0] == 0;
#endif
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

SCALED_JACOBIANS(hexahedron_jacobians, NODES_8(8), HEXAHEDRA_ARE_CUBES, HEXAHEDRA_ARE_BOXES,
                 MORTISE_HEXAHEDRON_CORNERS)
SCALED_JACOBIANS(wedge_jacobians, NODES_6(6), 0, 0, MORTISE_WEDGE_CORNERS)
SCALED_JACOBIANS(pyramid_jacobians, NODES_5(5), 0, 0, MORTISE_PYRAMID_CORNERS)
SCALED_JACOBIANS(tetrahedron_jacobians, NODES_4(4), 0, 0, MORTISE_TETRAHEDRON_CORNERS)
