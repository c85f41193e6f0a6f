// Sorting on host threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

#include "host/common/parallel.hpp"

namespace mortise {

/// Sorts as std::sort. Values that `less` does not tell apart must be equal, or their order depends on the
/// threads. Threads sort parts, which are merged in pairs.
template <class T, class Less = std::less<T>>
void parallel_sort(std::vector<T>& values, int threads, Less less = Less()) {
    constexpr std::size_t kWorthThreads = 8192;
    const std::size_t count = values.size();
    std::size_t parts = 1;
    while (parts < static_cast<std::size_t>(thread_count(threads)) && count / parts > kWorthThreads)
        parts *= 2;
    const auto at = [&](std::size_t part) {
        return values.begin() + static_cast<std::ptrdiff_t>(count * part / parts);
    };
    parallel_chunks(parts, 1, threads,
                    [&](std::size_t part, std::size_t, int) { std::sort(at(part), at(part + 1), less); });
    for (std::size_t width = 1; width < parts; width *= 2) {
        parallel_chunks(parts / (2 * width), 1, threads, [&](std::size_t pair, std::size_t, int) {
            const std::size_t first = 2 * width * pair;
            std::inplace_merge(at(first), at(first + width), at(first + 2 * width), less);
        });
    }
}

}  // namespace mortise
