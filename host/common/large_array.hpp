// Large arrays, made by all threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/common/large_pages.hpp"
#include "host/common/parallel.hpp"

namespace mortise {

/// First writes to the memory that a vector is about to grow into, by all threads: the system hands it out
/// page by page, and zeroes each, at the first write. `spare`: values that may be added later without moving
/// the array; they cost no memory until then.
template <class T>
void touch_large(std::vector<T>& values, std::size_t count, int threads, std::size_t spare = 0) {
    constexpr std::size_t kPage = 4096;
    values.reserve(count + spare);
    // Between the vector's end and its capacity: nobody's bytes until resize() writes them.
    auto* const bytes = reinterpret_cast<volatile unsigned char*>(values.data() + values.size());
    const std::size_t size = (count - values.size()) * sizeof(T);
    ask_for_large_pages(values.data() + values.size(), size);
    // Chunks are large pages: one of which two threads write to is zeroed twice.
    const std::size_t before = reinterpret_cast<std::uintptr_t>(bytes) % kLargePage;
    parallel_chunks(before + size, kLargePage, threads, [&](std::size_t begin, std::size_t end, int) {
        begin = std::max(begin, before) - before;
        end -= std::min(before, end);
        for (std::size_t page = begin; page < end; page += kPage) bytes[page] = 0;
    });
}

/// values.resize(count) for a vector that grows, several times as fast from some megabytes on.
template <class T>
void resize_large(std::vector<T>& values, std::size_t count, int threads, std::size_t spare = 0) {
    touch_large(values, count, threads, spare);
    values.resize(count);
}

/// Gives `values`, empty before, the memory of an array that nobody needs, which the system need not hand out
/// and zero again, if it has room for `count` values and `spare` ones, and for no more than twice as many. Up
/// to `count` of the values that it holds stay. touch_large() or resize_large() is to follow.
template <class T>
void take_memory(std::vector<T>& old, std::size_t count, std::vector<T>& values, std::size_t spare = 0) {
    const std::size_t room = count + spare;
    if (old.capacity() < room || old.capacity() / 2 > room) return;
    values.swap(old);
    if (values.size() > count) values.resize(count);
}

/// Appends lists, in their order; each gives its memory back.
template <class T>
void append_lists(std::vector<std::vector<T>>& lists, int threads, std::vector<T>& values) {
    std::vector<std::size_t> begins;
    std::size_t count = values.size();
    for (const auto& list : lists) {
        begins.push_back(count);
        count += list.size();
    }
    resize_large(values, count, threads);
    parallel_chunks(lists.size(), 1, threads, [&](std::size_t i, std::size_t, int) {
        std::copy(lists[i].begin(), lists[i].end(), values.begin() + static_cast<std::ptrdiff_t>(begins[i]));
        lists[i] = {};
    });
}

}  // namespace mortise
