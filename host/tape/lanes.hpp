// Arithmetic of formulas on many lanes at once, for expression_program.hpp: bounds, values, and values with
// gradients. Each lane gets the bits of expression_bounds, expression_value or expression_sample. The loops
// of frequent operations are written out, so that compilers turn them into vector instructions.
#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/shared/expression_bounds.h"

namespace mortise::tape {

inline constexpr std::size_t kLanes = 128;

struct BoundsLanes {
    struct Block {
        float low[kLanes];
        float high[kLanes];
        std::int32_t partial[kLanes];
        bool is_tame;  ///< numbers, so small that neither they nor their products overflow
    };
    using Input = Interval;

    static void set(Block& block, std::size_t k, Interval value) {
        block.low[k] = value.low;
        block.high[k] = value.high;
        block.partial[k] = value.partial;
    }
    static void set_variable(Block& block, std::size_t k, int, Interval u) { set(block, k, u); }
    static void set_literal(Block& block, std::size_t k, double value) {
        set(block, k, interval_literal(value));
    }
    static void copy(const Block& from, std::size_t i, Block& to, std::size_t k) {
        set(to, k, {from.low[i], from.high[i], from.partial[i]});
    }
    static Interval get(const Block& block, std::size_t k) {
        return {block.low[k], block.high[k], block.partial[k]};
    }
    static void finish(Block& block, std::size_t n);
    static void apply(std::int32_t operation, const Block& a, const Block& b, Block& out, std::size_t n);
};

struct ValueLanes {
    struct Block {
        double value[kLanes];
    };
    using Input = double;

    static void set_variable(Block& block, std::size_t k, int, double u) { block.value[k] = u; }
    static void set_literal(Block& block, std::size_t k, double value) { block.value[k] = value; }
    static void copy(const Block& from, std::size_t i, Block& to, std::size_t k) {
        to.value[k] = from.value[i];
    }
    static void finish(Block&, std::size_t) {}
    static void apply(std::int32_t operation, const Block& a, const Block& b, Block& out, std::size_t n);
};

struct SampleLanes {
    struct Block {
        ValueLanes::Block f;
        double slope[3][kLanes];
    };
    using Input = double;

    static void set_variable(Block& block, std::size_t k, int axis, double u) {
        block.f.value[k] = u;
        for (int j = 0; j < 3; ++j) block.slope[j][k] = j == axis ? 1 : 0;
    }
    static void set_literal(Block& block, std::size_t k, double value) { set_variable(block, k, -1, value); }
    static void copy(const Block& from, std::size_t i, Block& to, std::size_t k) {
        to.f.value[k] = from.f.value[i];
        for (int j = 0; j < 3; ++j) to.slope[j][k] = from.slope[j][i];
    }
    static void finish(Block&, std::size_t) {}
    static void apply(std::int32_t operation, const Block& a, const Block& b, Block& out, std::size_t n);
};

/// As tape::gradient_box in the formula's own frame; sharper by some rounding.
struct GradientLanes {
    struct Block {
        BoundsLanes::Block f;
        BoundsLanes::Block slope[3];
    };
    using Input = Interval;

    static void set_variable(Block& block, std::size_t k, int axis, Interval u) {
        BoundsLanes::set(block.f, k, u);
        for (int j = 0; j < 3; ++j) {
            const float one = j == axis ? 1 : 0;
            BoundsLanes::set(block.slope[j], k, {one, one});
        }
    }
    static void set_literal(Block& block, std::size_t k, double value) {
        set_variable(block, k, -1, interval_literal(value));
    }
    static void copy(const Block& from, std::size_t i, Block& to, std::size_t k) {
        BoundsLanes::copy(from.f, i, to.f, k);
        for (int j = 0; j < 3; ++j) BoundsLanes::copy(from.slope[j], i, to.slope[j], k);
    }
    static void finish(Block& block, std::size_t n) {
        BoundsLanes::finish(block.f, n);
        for (BoundsLanes::Block& slope : block.slope) BoundsLanes::finish(slope, n);
    }
    static void apply(std::int32_t operation, const Block& a, const Block& b, Block& out, std::size_t n);
};

}  // namespace mortise::tape
