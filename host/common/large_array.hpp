// Large arrays, made by all threads.
#pragma once

#include <cstddef>
#include <vector>

#include "host/common/parallel.hpp"

namespace mortise {

/// values.resize(count) for an empty vector, several times as fast from some megabytes on: the system hands
/// out memory page by page, at the first write to each, and here all threads share these first writes.
/// `spare`: values that may be added later without moving the array; they cost no memory until then.
template <class T>
void resize_large(std::vector<T>& values, std::size_t count, int threads, std::size_t spare = 0) {
    constexpr std::size_t kPage = 4096;
    constexpr std::size_t kChunk = 256;  // pages
    values.reserve(count + spare);
    // Between the vector's end and its capacity: nobody's bytes until resize() writes them.
    auto* const bytes = reinterpret_cast<volatile unsigned char*>(values.data() + values.size());
    const std::size_t pages = (count - values.size()) * sizeof(T) / kPage;
    parallel_chunks(pages, kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t page = begin; page < end; ++page) bytes[page * kPage] = 0;
    });
    values.resize(count);
}

}  // namespace mortise
