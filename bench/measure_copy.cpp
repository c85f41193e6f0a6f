// Copy bandwidth of the machine: what memory traffic alone would cost.
#include <chrono>
#include <cstring>
#include <vector>

#include "bench/workers.hpp"
#include "host/common/parallel.hpp"

namespace mortise::bench {

nlohmann::json measure_copy(const Task& task) {
    const std::vector<char> from(task.bytes, 1);
    std::vector<char> to(task.bytes, 2);
    const auto parts = static_cast<std::size_t>(task.threads);
    const std::size_t part = chunk_count(task.bytes, parts);
    nlohmann::json runs = nlohmann::json::array();
    for (int run = -1; run < task.repeats; ++run) {  // the first one is not counted
        const auto begin = std::chrono::steady_clock::now();
        parallel_chunks(task.bytes, part, task.threads, [&](std::size_t first, std::size_t last, int) {
            std::memcpy(to.data() + first, from.data() + first, last - first);
        });
        const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
        if (run >= 0) runs.push_back({{"seconds", wall.count()}});
    }
    return {{"runs", runs}};
}

}  // namespace mortise::bench
