// Loops over index ranges on all cores, for work whose result must not depend on the number of threads.
//
// The range is cut into chunks of a fixed size; threads take chunks in any order. A body that writes only to
// results of its own chunk, which the caller then combines in chunk order, is deterministic.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace mortise::quality {

inline std::size_t chunk_count(std::size_t count, std::size_t chunk_size) {
    return (count + chunk_size - 1) / chunk_size;
}

/// Calls body(chunk, begin, end) once for every chunk of [0, count). The first exception is rethrown here.
template <class Body>
void parallel_chunks(std::size_t count, std::size_t chunk_size, const Body& body) {
    const std::size_t chunks = chunk_count(count, chunk_size);
    std::atomic<std::size_t> next{0};
    std::exception_ptr failure;
    std::mutex failure_mutex;
    const auto work = [&] {
        try {
            for (std::size_t chunk = next++; chunk < chunks; chunk = next++) {
                const std::size_t begin = chunk * chunk_size;
                body(chunk, begin, std::min(count, begin + chunk_size));
            }
        } catch (...) {
            const std::lock_guard<std::mutex> lock(failure_mutex);
            if (!failure) failure = std::current_exception();
            next = chunks;
        }
    };
    const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
    std::vector<std::thread> threads;
    for (std::size_t i = 1; i < std::min(cores, chunks); ++i) {
        try {
            threads.emplace_back(work);
        } catch (const std::exception&) {
            break;  // no more threads to be had: the ones that run do the work
        }
    }
    work();
    for (std::thread& thread : threads) thread.join();
    if (failure) std::rethrow_exception(failure);
}

}  // namespace mortise::quality
