// Loops over index ranges on host threads, for work whose result must not depend on who does what.
//
// The range is cut into chunks of a fixed size, which threads take in any order. Work that writes only to
// results of its own chunk, combined in chunk order afterwards, is deterministic.
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "host/common/watch.hpp"

namespace mortise {

/// Threads to use: `wanted`, or all cores if it is 0.
inline int thread_count(int wanted) {
    if (wanted > 0) return wanted;
    static const int cores =  // asking reads a file of the system
        static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    return cores;
}

inline std::size_t chunk_count(std::size_t count, std::size_t chunk_size) {
    return (count + chunk_size - 1) / chunk_size;
}

/// Calls work(begin, end, thread) once for every chunk of [0, count), thread < thread_count(threads). The
/// first exception is rethrown here. A watched run (watch.hpp) is looked after between chunks.
template <class Work>
void parallel_chunks(std::size_t count, std::size_t chunk_size, int threads, const Work& work) {
    const std::size_t chunks = chunk_count(count, chunk_size);
    std::atomic<std::size_t> next{0};
    std::mutex mutex;  // of what follows
    std::exception_ptr failure, own_failure;
    std::size_t running = 0;
    std::condition_variable ended;
    Watch* const watch = Watch::current();
    const auto guarded = [&](std::exception_ptr& caught, const auto& body) {
        try {
            body();
        } catch (...) {
            const std::lock_guard<std::mutex> lock(mutex);
            if (!caught) caught = std::current_exception();
            next = chunks;
        }
    };
    const auto run = [&](int thread) {
        for (std::size_t chunk = next++; chunk < chunks; chunk = next++) {
            if (watch != nullptr) watch->look();
            const std::size_t begin = chunk * chunk_size;
            work(begin, std::min(count, begin + chunk_size), thread);
        }
    };
    const auto help = [&](int thread) {
        const Watch::Helper helper(watch);
        guarded(failure, [&] { run(thread); });
        const std::lock_guard<std::mutex> lock(mutex);
        --running;
        ended.notify_one();
    };
    const auto helpers = std::min<std::size_t>(static_cast<std::size_t>(thread_count(threads)), chunks);
    std::vector<std::thread> pool;
    for (std::size_t t = 1; t < helpers; ++t) {
        const std::lock_guard<std::mutex> lock(mutex);
        try {
            pool.emplace_back(help, static_cast<int>(t));
            ++running;
        } catch (const std::exception&) {
            break;  // no more threads to be had: the ones that run do the work
        }
    }
    guarded(own_failure, [&] { run(0); });
    if (watch != nullptr) {
        std::unique_lock<std::mutex> lock(mutex);
        while (!ended.wait_for(lock, Watch::kInterval, [&] { return running == 0; })) {
            lock.unlock();
            guarded(own_failure, [&] { watch->look(); });
            lock.lock();
        }
    }
    for (std::thread& thread : pool) thread.join();
    // What stopped the run says more than that helpers were stopped.
    if (own_failure) std::rethrow_exception(own_failure);
    if (failure) std::rethrow_exception(failure);
}

/// The same on all cores, for work that needs the chunk's number: body(chunk, begin, end).
template <class Body>
void parallel_chunks(std::size_t count, std::size_t chunk_size, const Body& body) {
    parallel_chunks(count, chunk_size, 0,
                    [&](std::size_t begin, std::size_t end, int) { body(begin / chunk_size, begin, end); });
}

}  // namespace mortise
