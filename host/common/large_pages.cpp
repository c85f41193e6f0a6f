#include "host/common/large_pages.hpp"

#include <cstdint>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace mortise {

void ask_for_large_pages(void* begin, std::size_t bytes) {
#if defined(MADV_HUGEPAGE)
    const auto at = reinterpret_cast<std::uintptr_t>(begin);
    const std::uintptr_t first = (at + kLargePage - 1) / kLargePage * kLargePage;
    const std::uintptr_t last = (at + bytes) / kLargePage * kLargePage;
    if (first >= last) return;
    // Refused by systems without such pages, which is as good.
    static_cast<void>(madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE));
#else
    static_cast<void>(begin);
    static_cast<void>(bytes);
#endif
}

}  // namespace mortise
