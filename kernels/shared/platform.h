// One language for host and device: every header in kernels/shared compiles as C++17 and as OpenCL C 1.2.
//
// Fixed-width scalars only; no bool, size_t, float3 or virtual addresses. A header in this folder may include
// only other headers of this folder. Functions are pure: the same arguments give the same bits on every
// device and on the host, because they use only + - * / sqrt, comparisons and integer operations, which
// OpenCL and IEEE 754 round correctly, and because contraction is off (-ffp-contract=off, FP_CONTRACT OFF).
#ifndef MORTISE_SHARED_PLATFORM_H
#define MORTISE_SHARED_PLATFORM_H

#if defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__)

#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#pragma OPENCL FP_CONTRACT OFF

#define MORTISE_TABLE static __constant
#define MORTISE_GLOBAL __global const
#define MORTISE_FUNCTION static
// Large: compiled once, wherever it is called from. PoCL compiles the text of a kernel three times.
#define MORTISE_NOINLINE static __attribute__((noinline))
#define MORTISE_DEFAULT(value)

typedef char i8;
typedef uchar u8;
typedef short i16;
typedef ushort u16;
typedef int i32;
typedef uint u32;
typedef long i64;
typedef ulong u64;

#define mortise_lowest_bit(x) popcount(((x) & -(x)) - 1u)  // its place; x is an u32, not 0
#define mortise_sqrt(x) sqrt(x)
#define mortise_fabs(x) fabs(x)
#define mortise_rint(x) rint(x)
#define mortise_floor(x) floor(x)

#else

#include <cmath>
#include <cstdint>

#define MORTISE_TABLE inline constexpr
#define MORTISE_GLOBAL const
#define MORTISE_FUNCTION inline
#define MORTISE_NOINLINE inline
#define MORTISE_DEFAULT(value) = value  // of a struct's field

using i8 = std::int8_t;
using u8 = std::uint8_t;
using i16 = std::int16_t;
using u16 = std::uint16_t;
using i32 = std::int32_t;
using u32 = std::uint32_t;
using i64 = std::int64_t;
using u64 = std::uint64_t;

#define mortise_lowest_bit(x) static_cast<u32>(__builtin_ctz(x))
#define mortise_sqrt(x) std::sqrt(x)
#define mortise_fabs(x) std::fabs(x)
#define mortise_rint(x) std::rint(x)
#define mortise_floor(x) std::floor(x)

#endif

#endif
