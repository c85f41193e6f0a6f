// Times and names of the stages of one run.
#pragma once

#include <chrono>
#include <cstdint>

#include "mortise/mesher.hpp"

namespace mortise::pipeline {

/// Times the stages of one run and reports progress. Throws Error(kMeshing) if the caller wants no more.
class Stages {
  public:
    Stages(const MeshOptions& options, MeshReport& report) : options_(options), report_(report) {}

    void begin(const char* stage, double progress);
    /// Ends the stage; a stage of the same name as an earlier one is added to it.
    void end(std::uint64_t items);

  private:
    const MeshOptions& options_;
    MeshReport& report_;
    const char* stage_ = nullptr;
    std::chrono::steady_clock::time_point wall_;
    double cpu_ = 0;
};

}  // namespace mortise::pipeline
