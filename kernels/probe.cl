// Arithmetic of the device on given operands, compared bit by bit with the host's (host/device/probe.cpp),
// and a busy loop by which `mortise doctor` measures how many cores work.
//
// Work mapping: one item takes LANES operands, in the vector form that the other kernels use.

#define JOIN_AGAIN(a, b) a##b
#define JOIN(a, b) JOIN_AGAIN(a, b)
#if LANES == 1
#define LOAD(pointer) (pointer)[item]
#define STORE(value, pointer) (pointer)[item] = (value)
#define WIDE(type) type
#else
#define LOAD(pointer) JOIN(vload, LANES)(item, pointer)
#define STORE(value, pointer) JOIN(vstore, LANES)(value, item, pointer)
#define WIDE(type) JOIN(type, LANES)
#endif

// Reads a, b, c[0, LANES·items); writes eight result arrays, one after the other, `stride` apart, into out.
// (clang-format takes x * y for a pointer)
// clang-format off
#define PROBE(type)                                                                                    \
    MORTISE_KERNEL void probe_##type(global const type* a, global const type* b, global const type* c, \
                                     global type* out, uint stride, uint items) {                      \
        const uint item = get_global_id(0);                                                            \
        if (item >= items) return;                                                                     \
        const WIDE(type) x = LOAD(a);                                                                  \
        const WIDE(type) y = LOAD(b);                                                                  \
        const WIDE(type) z = LOAD(c);                                                                  \
        STORE(x + y, out);                                                                             \
        STORE(x - y, out + stride);                                                                    \
        STORE(x * y, out + 2 * stride);                                                                 \
        STORE(x / y, out + 3 * stride);                                                                \
        STORE(sqrt(x), out + 4 * stride);                                                              \
        STORE(fma(x, y, z), out + 5 * stride);                                                         \
        STORE(x * y + z, out + 6 * stride);                                                             \
        STORE(rint(x), out + 7 * stride);                                                              \
    }
// clang-format on

PROBE(double)
PROBE(float)

// Writes out[0, items): `rounds` steps of a linear congruence each.
MORTISE_KERNEL void probe_busy(global uint* out, uint rounds, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    uint state = item;
    for (uint i = 0; i < rounds; ++i) state = state * 1664525u + 1013904223u;
    out[item] = state;
}
