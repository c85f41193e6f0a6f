// Data of surfaces that are no formulas, in the arena of expressions.
#pragma once

#include <cstring>
#include <vector>

#include "kernels/shared/surface.h"

namespace mortise::tape {

/// Appends numbers and notes in the surface where they are.
inline void append_numbers(const std::vector<double>& numbers, std::vector<ExpressionOp>& arena,
                           Surface& surface) {
    const std::size_t bytes = numbers.size() * sizeof(double);
    const std::size_t operations = (bytes + sizeof(ExpressionOp) - 1) / sizeof(ExpressionOp);
    surface.first_op = static_cast<u32>(arena.size());
    surface.op_count = static_cast<u32>(operations);
    arena.resize(arena.size() + operations);
    std::memcpy(static_cast<void*>(arena.data() + surface.first_op), numbers.data(), bytes);
}

}  // namespace mortise::tape
