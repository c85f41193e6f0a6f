#include "host/cli/kernels_ahead.hpp"

#include <algorithm>
#include <exception>
#include <thread>

#include "host/cli/signals.hpp"
#include "host/cli/worker_pool.hpp"
#include "mortise/error.hpp"

namespace mortise::cli {

std::size_t build_in_processes(KernelBuilder& builder, int threads, Progress& progress) {
    const std::size_t count = builder.needed();
    if (count == 0) return 0;
    progress.show("compile kernels, once", 0);
    std::size_t told = 0;
    std::size_t built = 0;
    const auto build = [&](std::size_t i) -> std::string {
        end_silently_on_signals();
        try {
            builder.build(i);
            return "built";
        } catch (const std::exception&) {
            return {};
        }
    };
    const auto done = [&](std::size_t, const std::string& result, int) {
        built += result.empty() ? 0 : 1;
        progress.show("compile kernels, once", static_cast<double>(++told) / static_cast<double>(count));
    };
    const auto cores = std::max(1u, std::thread::hardware_concurrency());
    const std::size_t jobs = threads > 0 ? static_cast<std::size_t>(threads) : cores;
    try {
        run_in_processes(count, std::min(jobs, count), build, done);
    } catch (const Error&) {
        return built;  // no process to be had
    }
    if (built == count) builder.finish();
    return built;
}

std::size_t build_kernels_ahead(const MeshOptions& options, Progress& progress) {
    KernelBuilder builder(options.device, options.work_group_size);
    return build_in_processes(builder, options.threads, progress);
}

}  // namespace mortise::cli
