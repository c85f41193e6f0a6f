// What a mesh that is made part by part (MeshOptions::memory) may take.
#pragma once

#include <cstdint>

#include "mortise/mesher.hpp"

namespace mortise::pipeline {

inline constexpr const char* kBoundaryCells = "the cells at the boundary";

/// Memory that this process has now, bytes; 0 if the system does not tell.
std::uint64_t memory_now();

/// Throws Error(kDevice) if `needed` is more than the options allow.
void check_memory(std::uint64_t needed, const char* what, const MeshOptions& options);

}  // namespace mortise::pipeline
