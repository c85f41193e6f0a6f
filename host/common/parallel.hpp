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

namespace detail {

template <class Run>
[[gnu::noinline]] void run_here(const Run& run) {
    run();
}

/// Runs so far below the caller's variables on the stack that no cache line holds both what run() writes
/// there and what other threads read of the caller's. Where one did, which the start of a process decided,
/// two threads were no faster than one.
template <class Run>
[[gnu::noinline]] void run_apart(const Run& run) {
    volatile unsigned char gap[256];
    gap[0] = 0;
    run_here(run);
    gap[0] = gap[0] + 1;  // so that this is no tail call, which would give the gap back
}

}  // namespace detail

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
    guarded(own_failure, [&] { detail::run_apart([&] { run(0); }); });
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

/// The same for work that needs the chunk's number instead of the thread's: work(chunk, begin, end).
template <class Work>
void parallel_numbered(std::size_t count, std::size_t chunk_size, int threads, const Work& work) {
    parallel_chunks(count, chunk_size, threads,
                    [&](std::size_t begin, std::size_t end, int) { work(begin / chunk_size, begin, end); });
}

}  // namespace mortise
