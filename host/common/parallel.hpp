// A loop over chunks on host threads. Results must not depend on which thread runs a chunk.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace mortise {

inline int thread_count(int wanted) {
    if (wanted > 0) return wanted;
    return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

/// Calls work(begin, end, thread) for consecutive chunks of [0, count). Rethrows the first exception.
template <class Work>
void parallel_chunks(std::size_t count, std::size_t chunk, int threads, const Work& work) {
    std::atomic<std::size_t> next{0};
    std::exception_ptr failure;
    std::mutex guard;
    const auto run = [&](int thread) {
        try {
            for (;;) {
                const std::size_t begin = next.fetch_add(chunk);
                if (begin >= count) return;
                work(begin, std::min(count, begin + chunk), thread);
            }
        } catch (...) {
            const std::lock_guard<std::mutex> lock(guard);
            if (!failure) failure = std::current_exception();
            next = count;
        }
    };
    std::vector<std::thread> pool;
    const int others = count > chunk ? thread_count(threads) - 1 : 0;
    for (int t = 1; t <= others; ++t) pool.emplace_back(run, t);
    run(0);
    for (std::thread& thread : pool) thread.join();
    if (failure) std::rethrow_exception(failure);
}

}  // namespace mortise
