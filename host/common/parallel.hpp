// Loops over index ranges on host threads, for work whose result must not depend on who does what.
//
// The range is cut into chunks of a fixed size, which threads take in any order. Work that writes only to
// results of its own chunk, combined in chunk order afterwards, is deterministic.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace mortise {

/// Threads to use: `wanted`, or all cores if it is 0.
inline int thread_count(int wanted) {
    if (wanted > 0) return wanted;
    return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

inline std::size_t chunk_count(std::size_t count, std::size_t chunk_size) {
    return (count + chunk_size - 1) / chunk_size;
}

/// Calls work(begin, end, thread) once for every chunk of [0, count), thread < thread_count(threads). The
/// first exception is rethrown here.
template <class Work>
void parallel_chunks(std::size_t count, std::size_t chunk_size, int threads, const Work& work) {
    const std::size_t chunks = chunk_count(count, chunk_size);
    std::atomic<std::size_t> next{0};
    std::exception_ptr failure;
    std::mutex failure_mutex;
    const auto run = [&](int thread) {
        try {
            for (std::size_t chunk = next++; chunk < chunks; chunk = next++) {
                const std::size_t begin = chunk * chunk_size;
                work(begin, std::min(count, begin + chunk_size), thread);
            }
        } catch (...) {
            const std::lock_guard<std::mutex> lock(failure_mutex);
            if (!failure) failure = std::current_exception();
            next = chunks;
        }
    };
    const auto helpers = std::min<std::size_t>(static_cast<std::size_t>(thread_count(threads)), chunks);
    std::vector<std::thread> pool;
    for (std::size_t t = 1; t < helpers; ++t) {
        try {
            pool.emplace_back(run, static_cast<int>(t));
        } catch (const std::exception&) {
            break;  // no more threads to be had: the ones that run do the work
        }
    }
    run(0);
    for (std::thread& thread : pool) thread.join();
    if (failure) std::rethrow_exception(failure);
}

/// The same on all cores, for work that needs the chunk's number: body(chunk, begin, end).
template <class Body>
void parallel_chunks(std::size_t count, std::size_t chunk_size, const Body& body) {
    parallel_chunks(count, chunk_size, 0,
                    [&](std::size_t begin, std::size_t end, int) { body(begin / chunk_size, begin, end); });
}

}  // namespace mortise
