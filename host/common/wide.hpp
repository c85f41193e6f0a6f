// Functions in versions for wider registers, of which the loader takes the one for the machine. The bits are
// the same: nothing is fused.
#pragma once

#if defined(__x86_64__) && defined(__gnu_linux__)
#define MORTISE_WIDE __attribute__((target_clones("default", "avx2", "avx512f")))
#else
#define MORTISE_WIDE
#endif
