// Functions in versions for registers of several widths, of which the loader takes the one for the machine.
// The bits are the same: nothing is fused.
#pragma once

#include <cstddef>
#include <cstdint>

/// Defines `result name parameters` by a template `name_in<lanes> arguments`, which is always inlined, with
/// as many lanes of 64 bits as registers hold: of comparisons of wider ones GCC makes comparisons of single
/// numbers.
#if defined(__x86_64__) && defined(__gnu_linux__)
#define MORTISE_FOR(machine, lanes, result, name, parameters, arguments) \
    __attribute__((target(machine))) result name parameters { return name##_in<lanes> arguments; }
#define MORTISE_BY_WIDTH(result, name, parameters, arguments)      \
    MORTISE_FOR("default", 2, result, name, parameters, arguments) \
    MORTISE_FOR("avx2", 4, result, name, parameters, arguments)    \
    MORTISE_FOR("avx512f", 8, result, name, parameters, arguments)
#else
#define MORTISE_BY_WIDTH(result, name, parameters, arguments) \
    result name parameters { return name##_in<2> arguments; }
#endif

namespace mortise::lanes {

template <std::size_t kWidth>
struct Types {
    typedef double Doubles __attribute__((vector_size(kWidth * sizeof(double))));
    typedef std::uint32_t Words __attribute__((vector_size(kWidth * sizeof(std::uint32_t))));
};
template <std::size_t kWidth>
using Doubles = typename Types<kWidth>::Doubles;
template <std::size_t kWidth>
using Words = typename Types<kWidth>::Words;

}  // namespace mortise::lanes
