#include "host/pipeline/stages.hpp"

#include <algorithm>
#include <ctime>

namespace mortise::pipeline {
namespace {

double process_seconds() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

Stages::Stages(const MeshOptions& options, MeshReport& report) : options_(options), report_(report) {
    if (options.progress) watch_.emplace([this] { return options_.progress(told_, progress_); });
}

void Stages::begin(const char* stage, double progress) {
    end(0);
    told_ = stage;
    progress_ = progress;
    if (options_.progress && !options_.progress(stage, progress)) {
        throw Interrupted();
    }
    stage_ = stage;
    wall_ = std::chrono::steady_clock::now();
    cpu_ = process_seconds();
}

void Stages::end(std::uint64_t items) {
    if (stage_ == nullptr) return;
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - wall_;
    const double cpu = process_seconds() - cpu_;
    const auto known = std::find_if(report_.stages.begin(), report_.stages.end(),
                                    [this](const StageTime& time) { return time.stage == stage_; });
    if (known == report_.stages.end()) {
        report_.stages.push_back({stage_, wall.count(), cpu, items});
    } else {
        known->wall_seconds += wall.count();
        known->cpu_seconds += cpu;
        known->items += items;
    }
    stage_ = nullptr;
}

}  // namespace mortise::pipeline
