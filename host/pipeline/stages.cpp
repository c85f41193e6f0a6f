#include "host/pipeline/stages.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <string_view>

namespace mortise::pipeline {
namespace {

/// A stage, and how far a run is when it begins.
struct Step {
    const char* stage;
    double progress;
};

/// In their order; between "classify" and "merge" pieces are made, between 0.4 and 0.9.
constexpr std::array<Step, 25> kSteps = {{
    {"compile", 0},          {"polyhedra", 0.01}, {"device", 0.02},     {"octree", 0.05},
    {"probe", 0.28},         {"overlaps", 0.29},  {"classify", 0.3},    {"snap", 0.31},
    {"extract", 0.33},       {"merge", 0.9},      {"reposition", 0.91}, {"planes", 0.925},
    {"improve", 0.93},       {"periodic", 0.945}, {"tetrahedra", 0.95}, {"raise", 0.952},
    {"hanging", 0.954},      {"names", 0.9545},   {"layers", 0.9547},   {"faces", 0.955},
    {"features", 0.96},      {"quality", 0.97},   {"films", 0.98},      {"jacobians", 0.99},
    {"second order", 0.995},
}};

constexpr bool ascends() {
    for (std::size_t i = 1; i < kSteps.size(); ++i) {
        if (kSteps[i].progress <= kSteps[i - 1].progress) return false;
    }
    return true;
}
static_assert(ascends());

double process_seconds() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

Stages::Stages(const MeshOptions& options, MeshReport& report) : options_(options), report_(report) {
    if (options.progress) watch_.emplace([this] { return options_.progress(told_, progress_); });
}

void Stages::begin(const char* stage) {
    const std::string_view name = stage;
    const auto step =
        std::find_if(kSteps.begin(), kSteps.end(), [name](const Step& known) { return known.stage == name; });
    begin(stage, step == kSteps.end() ? progress_ : step->progress);
}

void Stages::begin(const char* stage, double progress) {
    end(0);
    told_ = stage;
    progress_ = std::max(progress_, progress);  // some stages come again
    if (options_.progress && !options_.progress(stage, progress_)) {
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
