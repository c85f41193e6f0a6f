// What classification tells of each NIO leaf: meshed by which template, or left to the certificate.
#ifndef MORTISE_SHARED_SNIO_H
#define MORTISE_SHARED_SNIO_H

#include "platform.h"

#define kPatternCnio 256  // SnioLeaf::pattern of a leaf that the certificate meshes

typedef struct SnioLeaf {
    u32 surface;  // the one surface; undefined for CNIO
    u16 pattern;  // bit c: corner c is inside; 0: nothing, 255: a whole hexahedron; kPatternCnio
    u16 region;   // of the inside
} SnioLeaf;

#endif
