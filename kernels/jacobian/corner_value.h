// The scaled Jacobian at one corner of each of several elements, from its three edges: the determinant over
// the product of their lengths; 0 for an edge without length. Corners give its square, with the sign, so that
// there is one root in an element, not two at each corner, which took half of the time.
//
// Own vector operations instead of OpenCL's: dot() and length() may contract, and the two ways (own.cl,
// product.cl) and the host's check must round alike.
#ifndef MORTISE_JACOBIAN_CORNER_VALUE_H
#define MORTISE_JACOBIAN_CORNER_VALUE_H

#pragma OPENCL EXTENSION cl_khr_fp64 : enable

// WIDTH elements side by side in one work-item; defined by the file that includes this one.
#if WIDTH == 8
typedef double8 lanes_double;
typedef float8 lanes_float;
#define LOAD_LANES(array) vload8(0, array)
#define STORE_LANES(values, array) vstore8(values, 0, array)
#define CHOOSE(condition, yes, no) select(no, yes, condition)
#define TO_FLOAT(values) convert_float8(values)
#else
typedef double lanes_double;
typedef float lanes_float;
#define LOAD_LANES(array) ((array)[0])
#define STORE_LANES(values, array) (array)[0] = (values)
#define CHOOSE(condition, yes, no) ((condition) ? (yes) : (no))
#define TO_FLOAT(values) ((float)(values))
#endif

typedef struct Points {
    lanes_double x;
    lanes_double y;
    lanes_double z;
} Points;

static Points difference(Points a, Points b) {
    Points d;
    d.x = a.x - b.x;
    d.y = a.y - b.y;
    d.z = a.z - b.z;
    return d;
}

static lanes_double square(Points v) { return v.x * v.x + v.y * v.y + v.z * v.z; }

static lanes_double corner_value(Points a, Points b, Points c) {
    const lanes_double determinant =
        (a.y * b.z - a.z * b.y) * c.x + (a.z * b.x - a.x * b.z) * c.y + (a.x * b.y - a.y * b.x) * c.z;
    const lanes_double squares = square(a) * square(b) * square(c);
    const lanes_double zero = 0;
    return CHOOSE(squares > zero, determinant * fabs(determinant) / squares, zero);
}

// The scaled Jacobian of which corner_value gives the square.
static lanes_double root(lanes_double value) {
    const lanes_double size = sqrt(fabs(value));
    const lanes_double zero = 0;
    return CHOOSE(value < zero, -size, size);
}

static lanes_double smaller(lanes_double a, lanes_double b) { return CHOOSE(b < a, b, a); }

#endif
