#include "host/pipeline/stages.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <string_view>

namespace mortise::pipeline {
namespace {

/// A stage, how far a run is when it begins, and what its time grows with.
struct Step {
    const char* stage;
    double progress;
    Growth growth;
};

/// In their order; between "extract" and "merge" pieces are made, between 0.4 and 0.9.
constexpr std::array<Step, 26> kSteps = {{
    {"compile", 0, Growth::kOnce},          {"polyhedra", 0.01, Growth::kBoundary},
    {"device", 0.02, Growth::kOnce},        {"octree", 0.05, Growth::kBoundary},
    {"probe", 0.28, Growth::kBoundary},     {"overlaps", 0.29, Growth::kBoundary},
    {"classify", 0.3, Growth::kBoundary},   {"snap", 0.31, Growth::kBoundary},
    {"extract", 0.33, Growth::kBoundary},   {"assemble", 0.4, Growth::kElements},
    {"merge", 0.9, Growth::kElements},      {"reposition", 0.91, Growth::kBoundary},
    {"planes", 0.925, Growth::kBoundary},   {"improve", 0.93, Growth::kBoundary},
    {"periodic", 0.945, Growth::kBoundary}, {"tetrahedra", 0.95, Growth::kElements},
    {"raise", 0.952, Growth::kBoundary},    {"hanging", 0.954, Growth::kBoundary},
    {"names", 0.9545, Growth::kBoundary},   {"layers", 0.9547, Growth::kBoundary},
    {"faces", 0.955, Growth::kElements},    {"features", 0.96, Growth::kBoundary},
    {"quality", 0.97, Growth::kBoundary},   {"films", 0.98, Growth::kBoundary},
    {"jacobians", 0.99, Growth::kElements}, {"second order", 0.995, Growth::kElements},
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

/// Null for stages that are no step of every run.
const Step* find_step(std::string_view stage) {
    const auto step = std::find_if(kSteps.begin(), kSteps.end(),
                                   [stage](const Step& known) { return known.stage == stage; });
    return step == kSteps.end() ? nullptr : &*step;
}

}  // namespace

Growth growth_of(std::string_view stage) {
    const Step* const step = find_step(stage);
    return step == nullptr ? Growth::kBoundary : step->growth;
}

Stages::Stages(const MeshOptions& options, MeshReport& report) : options_(options), report_(report) {
    if (options.progress) watch_.emplace([this] { return options_.progress(told_, progress_); });
}

void Stages::begin(const char* stage) {
    const Step* const step = find_step(stage);
    begin(stage, step == nullptr ? progress_ : step->progress);
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
