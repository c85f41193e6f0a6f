#include "host/tape/reference.hpp"

#include <algorithm>
#include <cmath>

#include "host/tape/local_tape.hpp"
#include "kernels/shared/expression_bounds.h"
#include "kernels/shared/spatial.h"

namespace mortise::tape {
namespace {

constexpr double kSumSlack = 1e-12;  ///< far above the rounding of the sums below, far below a cell

struct SumRange {
    double low;
    double high;
};

SumRange square_of(SumRange a) {
    const double p = a.low * a.low;
    const double q = a.high * a.high;
    if (a.low <= 0 && a.high >= 0) return {0, std::max(p, q)};
    return {std::min(p, q), std::max(p, q)};
}

int decide(double low, double high) {
    const double slack = kSumSlack * (1 + std::fabs(low) + std::fabs(high));
    if (low - slack > 0) return 1;
    if (high + slack < 0) return -1;
    return 0;
}

/// Which child of its parent the cell is, in Morton order.
std::uint32_t child_slot(const Cell& cell) {
    std::uint32_t slot = 0;
    for (int j = 0; j < 3; ++j) {
        const double index = (cell.centre[j] - cell.half) / (2 * cell.half);
        slot |= (static_cast<std::uint32_t>(std::llround(index)) & 1u) << j;
    }
    return slot;
}

bool is_apart(const Box3& box, const Cell& cell) {
    bool apart = false;
    for (std::size_t j = 0; j < 3; ++j) {
        const double reach = cell.half + kSumSlack;
        apart = apart || box.min[j] > cell.centre[j] + reach || box.max[j] < cell.centre[j] - reach;
    }
    return apart;
}

/// Appends what stands for a spatial word in a child (kernels/shared/spatial.h).
void expand_spatial(const BoundModel& model, std::uint32_t word, std::uint32_t slot,
                    std::vector<std::uint32_t>& words, std::vector<std::int32_t>& states) {
    const std::uint32_t negated = tape_negated(word);
    const std::uint32_t entry = model.spatial[tape_surface(word) + slot];
    const std::uint32_t place = entry & ~kSpatialFormula;
    if (entry <= kSpatialIn) {
        words.push_back(word);
        states.push_back(static_cast<std::int32_t>(entry ^ negated));
    } else if (entry == place) {
        words.push_back(make_spatial(place, negated));
        states.push_back(kUnknown);
    } else {
        for (std::uint32_t i = 0; i < model.spatial[place]; ++i) {
            const std::uint32_t copied = model.spatial[place + 1 + i];
            words.push_back(negated != 0 ? negate_word(copied) : copied);
            states.push_back(kUnknown);
        }
    }
}

/// f is convex: its tangent plane at the centre bounds it from below, and its gradient, which turns slowly,
/// from above. `w`: half ranges of u in the cell.
int classify_rounded(const Surface& s, const ExpressionOp* ops, const Cell& cell, const double* u,
                     const double* w) {
    double value = 0;
    double g[3];
    double reach = 0;
    double round = 0;
    if (s.form[2] >= kRoundedRevolution) {
        const SumRange x = square_of({u[0] - w[0], u[0] + w[0]});
        const SumRange y = square_of({u[1] - w[1], u[1] + w[1]});
        const double low = std::sqrt(x.low + y.low);
        const double high = std::sqrt(x.high + y.high);
        const double middle[3] = {(low + high) / 2, 0, u[2]};
        value = rounded_sample(ops + s.first_op, middle, g);
        reach = std::fabs(g[0]) * (high - low) / 2 + std::fabs(g[2]) * w[2];
        round = std::hypot((high - low) / 2, w[2]);
    } else {
        value = rounded_sample(ops + s.first_op, u, g);
        for (int j = 0; j < 3; ++j) {
            reach += cell.half * std::fabs(g[0] * s.map[j] + g[1] * s.map[4 + j] + g[2] * s.map[8 + j]);
        }
        round = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    }
    const double slack = kSumSlack * (s.form[3] + std::fabs(u[0]) + std::fabs(u[1]) + std::fabs(u[2]));
    const double room = s.form[0] + value - round;
    const double above = room > 0 ? std::min(round, reach + round * round / room / 2) : round;
    return decide(value - reach - slack, value + above + slack);
}

}  // namespace

int classify_surface(const BoundModel& model, std::uint32_t index, const Cell& cell) {
    const Surface& s = model.surfaces[index];
    if (s.kind == kSurfacePatch) return 0;  // in a tape only where it passes
    double u[3];
    double w[3];
    surface_frame(&s, cell.centre[0], cell.centre[1], cell.centre[2], u);
    for (int i = 0; i < 3; ++i) {
        w[i] =
            cell.half * (std::fabs(s.map[4 * i]) + std::fabs(s.map[4 * i + 1]) + std::fabs(s.map[4 * i + 2]));
    }
    if (s.kind == kSurfacePlane) return decide(u[0] - w[0], u[0] + w[0]);
    if (s.kind == kSurfaceRounded) return classify_rounded(s, model.expression_ops.data(), cell, u, w);
    if (s.kind == kSurfaceQuadric || (s.kind == kSurfaceCone && u[2] + w[2] < 0)) {
        // Exact Taylor form about the centre: the linear part and the squares are bounded apart.
        double form[4] = {s.form[0], s.form[1], s.form[2], s.form[3]};
        if (s.kind == kSurfaceCone) {
            form[0] = form[1] = 1;
            form[2] = -1;
            form[3] = 0;
        }
        double value = form[3];
        double linear[3] = {0, 0, 0};
        double below = 0;
        double above = 0;
        for (int i = 0; i < 3; ++i) {
            value += form[i] * u[i] * u[i];
            for (int j = 0; j < 3; ++j) linear[j] += 2 * form[i] * u[i] * s.map[4 * i + j];
            (form[i] < 0 ? below : above) += form[i] * w[i] * w[i];
        }
        const double spread =
            cell.half * (std::fabs(linear[0]) + std::fabs(linear[1]) + std::fabs(linear[2]));
        return decide(value - spread + below, value + spread + above);
    }
    const SumRange r[3] = {
        {u[0] - w[0], u[0] + w[0]}, {u[1] - w[1], u[1] + w[1]}, {u[2] - w[2], u[2] + w[2]}};
    if (s.kind == kSurfaceExpression) {
        Interval x[3];
        for (int i = 0; i < 3; ++i) {
            x[i] = make_interval(static_cast<float>(r[i].low), static_cast<float>(r[i].high));
        }
        const Interval f =
            expression_bounds(model.expression_ops.data() + s.first_op, s.op_count, x[0], x[1], x[2]);
        return interval_sign(f);
    }
    const SumRange a = square_of(r[0]);
    const SumRange b = square_of(r[1]);
    const SumRange radial{std::sqrt(a.low + b.low), std::sqrt(a.high + b.high)};
    if (s.kind == kSurfaceCone) return decide(radial.low + r[2].low, radial.high + r[2].high);
    const SumRange ring = square_of({radial.low - s.form[0], radial.high - s.form[0]});
    const SumRange height = square_of(r[2]);
    return decide(ring.low + height.low + s.form[3], ring.high + height.high + s.form[3]);
}

std::int32_t prune(const std::vector<std::uint32_t>& tape, const std::vector<std::int32_t>& states,
                   std::vector<std::uint32_t>* pruned) {
    struct Entry {
        std::int32_t value;
        std::size_t begin;  ///< where its code starts; known values have none
    };
    std::vector<Entry> stack;
    std::vector<std::uint32_t> out;
    for (std::size_t i = 0; i < tape.size(); ++i) {
        const std::uint32_t word = tape[i];
        const std::uint32_t operation = tape_operation(word);
        if (operation == kTapeLiteral || operation == kTapeSpatial) {
            stack.push_back({states[i], out.size()});
            if (states[i] == kUnknown) out.push_back(word);
            continue;
        }
        const Entry top = stack.back();
        stack.pop_back();
        if (operation == kTapeSelectConst) {
            const std::int32_t value = combine_select(tape_otherwise(word), top.value, tape_region(word));
            if (value == kUnknown)
                out.push_back(word);
            else
                out.resize(top.begin);
            stack.push_back({value, top.begin});
            continue;
        }
        Entry& first = stack.back();
        std::int32_t value;
        bool emits = first.value == kUnknown && top.value == kUnknown;
        std::uint32_t emitted = word;
        if (operation == kTapeSelect) {
            value = combine_select(first.value, top.value, tape_region(word));
            if (first.value != kUnknown && top.value == kUnknown) {
                emits = true;
                emitted = make_operation(kTapeSelectConst, tape_region(word), first.value);
            }
        } else {
            value = operation == kTapeAnd ? combine_and(first.value, top.value)
                                          : combine_or(first.value, top.value);
        }
        if (value != kUnknown)
            out.resize(first.begin);
        else if (emits)
            out.push_back(emitted);
        first.value = value;
    }
    if (pruned != nullptr) *pruned = std::move(out);
    return stack.back().value;
}

std::int32_t classify_cell(const BoundModel& model, const std::vector<std::uint32_t>& tape, const Cell& cell,
                           std::vector<std::uint32_t>* pruned) {
    std::vector<std::uint32_t> words;
    std::vector<std::int32_t> states;
    for (const std::uint32_t word : tape) {
        if (tape_operation(word) == kTapeSpatial && cell.half < 0.5 && !model.spatial.empty()) {
            expand_spatial(model, word, child_slot(cell), words, states);
        } else {
            words.push_back(word);
            const bool outside = tape_operation(word) == kTapeSpatial && model.spatial.empty() &&
                                 is_apart(model.polyhedra[tape_surface(word)].bounds, cell);
            states.push_back(outside ? static_cast<std::int32_t>(tape_negated(word)) : kUnknown);
        }
    }
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (tape_operation(words[i]) != kTapeLiteral) continue;
        const int sign = classify_surface(model, tape_surface(words[i]), cell);
        if (sign != 0) states[i] = (sign < 0) != (tape_negated(words[i]) != 0) ? 1 : 0;
    }
    return prune(words, states, pruned);
}

std::int32_t region_at(const BoundModel& model, double x, double y, double z) {
    std::vector<std::uint32_t> words = model.tape;
    std::vector<std::int32_t> states(words.size(), kUnknown);
    const double point[3] = {x, y, z};
    // Cell by cell down to the formulas that hold around the point.
    Cell cell{{0.5, 0.5, 0.5}, 0.5};
    const auto is_open = [&](std::size_t i) {
        return tape_operation(words[i]) == kTapeSpatial && states[i] == kUnknown;
    };
    for (bool open = true; open;) {
        open = false;
        cell.half *= 0.5;
        for (int j = 0; j < 3; ++j) cell.centre[j] += point[j] < cell.centre[j] ? -cell.half : cell.half;
        std::vector<std::uint32_t> next;
        std::vector<std::int32_t> next_states;
        for (std::size_t i = 0; i < words.size(); ++i) {
            if (is_open(i)) {
                expand_spatial(model, words[i], child_slot(cell), next, next_states);
                open = true;
            } else {
                next.push_back(words[i]);
                next_states.push_back(states[i]);
            }
        }
        words = std::move(next);
        states = std::move(next_states);
    }
    for (std::size_t i = 0; i < words.size(); ++i) {
        if (tape_operation(words[i]) != kTapeLiteral) continue;
        const double value =
            surface_value(&model.surfaces[tape_surface(words[i])], model.expression_ops.data(), x, y, z);
        states[i] = (value <= 0) != (tape_negated(words[i]) != 0) ? 1 : 0;
    }
    return prune(words, states, nullptr);
}

std::int32_t evaluate_signs(const std::uint32_t* tape, std::size_t length, const std::uint32_t* surfaces,
                            std::size_t surface_count, const std::int8_t* signs) {
    std::int32_t stack[kTapeStack];
    int top = -1;
    for (std::size_t i = 0; i < length; ++i) {
        const std::uint32_t word = tape[i];
        const std::uint32_t operation = tape_operation(word);
        if (operation == kTapeLiteral) {
            const std::uint32_t* found =
                std::lower_bound(surfaces, surfaces + surface_count, tape_surface(word));
            const bool listed = found != surfaces + surface_count && *found == tape_surface(word);
            const std::int8_t sign = listed ? signs[found - surfaces] : std::int8_t{0};
            stack[++top] = sign == 0 ? kUnknown : ((sign < 0) != (tape_negated(word) != 0) ? 1 : 0);
        } else if (operation == kTapeSpatial) {
            stack[++top] = kUnknown;
        } else if (operation == kTapeSelectConst) {
            stack[top] = combine_select(tape_otherwise(word), stack[top], tape_region(word));
        } else {
            const std::int32_t b = stack[top--];
            const std::int32_t a = stack[top];
            stack[top] = operation == kTapeAnd  ? combine_and(a, b)
                         : operation == kTapeOr ? combine_or(a, b)
                                                : combine_select(a, b, tape_region(word));
        }
    }
    return stack[top];
}

std::int32_t resolve_signs(const std::uint32_t* tape, std::size_t length, const std::uint32_t* surfaces,
                           std::size_t surface_count, const std::int8_t* signs) {
    constexpr std::size_t kMaxCases = 8;
    const std::int32_t direct = evaluate_signs(tape, length, surfaces, surface_count, signs);
    if (direct != kUnknown) return direct;
    // Only surfaces of this tape matter, and it may name some that are not listed.
    std::vector<std::uint32_t> all;
    list_surfaces(tape, length, all);
    std::vector<std::int8_t> trial(all.size(), 0);
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const std::uint32_t* found = std::lower_bound(surfaces, surfaces + surface_count, all[i]);
        if (found != surfaces + surface_count && *found == all[i]) trial[i] = signs[found - surfaces];
        if (trial[i] == 0) open.push_back(i);
    }
    if (open.size() > kMaxCases) return kUnknown;
    std::int32_t common = kUnknown;
    for (std::size_t choice = 0; choice < (std::size_t{1} << open.size()); ++choice) {
        for (std::size_t k = 0; k < open.size(); ++k) trial[open[k]] = ((choice >> k) & 1) != 0 ? 1 : -1;
        const std::int32_t value = evaluate_signs(tape, length, all.data(), all.size(), trial.data());
        if (choice == 0)
            common = value;
        else if (value != common)
            return kUnknown;
    }
    return common;
}

}  // namespace mortise::tape
