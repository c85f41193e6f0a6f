// Functions in versions for wider registers, of which the loader takes the one for the machine. The bits are
// the same: nothing is fused.
#pragma once

#if defined(__x86_64__) && defined(__gnu_linux__)
#if defined(__clang__) || __GNUC__ < 12
#define MORTISE_WIDE __attribute__((target_clones("default", "avx2", "avx512f")))
#else  // the last one also multiplies 64-bit integers
#define MORTISE_WIDE __attribute__((target_clones("default", "avx2", "avx512f", "arch=x86-64-v4")))
#endif
#else
#define MORTISE_WIDE
#endif
