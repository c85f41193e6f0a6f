// Corners of the element types (node order of mortise/mesh.hpp): a node and its three neighbours in
// right-handed order. The apex of a pyramid, with four edges, is left out: its edges are those of the base's
// corners.
//
// Lists of C(node, first, second, third), for code without loops; `host/jacobian` makes tables of them.
#ifndef MORTISE_SHARED_CORNERS_H
#define MORTISE_SHARED_CORNERS_H

#define MORTISE_HEXAHEDRON_CORNERS(C) \
    C(0, 1, 3, 4)                     \
    C(1, 2, 0, 5)                     \
    C(2, 3, 1, 6)                     \
    C(3, 0, 2, 7)                     \
    C(4, 7, 5, 0)                     \
    C(5, 4, 6, 1)                     \
    C(6, 5, 7, 2)                     \
    C(7, 6, 4, 3)

#define MORTISE_WEDGE_CORNERS(C) \
    C(0, 1, 2, 3)                \
    C(1, 2, 0, 4)                \
    C(2, 0, 1, 5)                \
    C(3, 5, 4, 0)                \
    C(4, 3, 5, 1)                \
    C(5, 4, 3, 2)

#define MORTISE_PYRAMID_CORNERS(C) \
    C(0, 1, 3, 4)                  \
    C(1, 2, 0, 4)                  \
    C(2, 3, 1, 4)                  \
    C(3, 0, 2, 4)

#define MORTISE_TETRAHEDRON_CORNERS(C) \
    C(0, 1, 2, 3)                      \
    C(1, 2, 0, 3)                      \
    C(2, 0, 1, 3)                      \
    C(3, 1, 0, 2)

#endif
