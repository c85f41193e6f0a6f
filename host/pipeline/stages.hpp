// Times and names of the stages of one run.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string_view>

#include "host/common/watch.hpp"
#include "mortise/mesher.hpp"

namespace mortise::pipeline {

/// What a stage's time grows with: nothing, the elements of a mesh, or its cells at the boundary.
enum class Growth { kOnce, kElements, kBoundary };
Growth growth_of(std::string_view stage);

/// Times the stages of one run and reports progress, by the thread that made the object. Throws Interrupted
/// if the caller wants no more.
class Stages {
  public:
    Stages(const MeshOptions& options, MeshReport& report);

    /// Progress is the stage's in the table of stages.cpp, which all are in that a mesh in memory has once.
    void begin(const char* stage);
    /// For stages that come piece by piece.
    void begin(const char* stage, double progress);
    /// Ends the stage; a stage of the same name as an earlier one is added to it.
    void end(std::uint64_t items);

  private:
    const MeshOptions& options_;
    MeshReport& report_;
    const char* stage_ = nullptr;
    const char* told_ = "";  ///< as last reported
    double progress_ = 0;
    std::optional<Watch> watch_;  ///< reports again while a stage takes its time
    std::chrono::steady_clock::time_point wall_;
    double cpu_ = 0;
};

}  // namespace mortise::pipeline
