// Pages of megabytes for what is large.
#pragma once

#include <cstddef>

namespace mortise {

/// Bytes of a large page.
constexpr std::size_t kLargePage = std::size_t{1} << 21;

/// Asks the system for large pages where it hands them out on request only: first writes cost less, and
/// scattered reads find their pages sooner. Nothing depends on it. For memory that nobody uses yet.
void ask_for_large_pages(void* begin, std::size_t bytes);

}  // namespace mortise
