#include "host/sizing/sizing.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/constants.hpp"
#include "host/common/parallel.hpp"
#include "host/common/watch.hpp"
#include "host/sizing/hints.hpp"
#include "host/sizing/thin.hpp"
#include "host/sizing/topology.hpp"
#include "host/tape/local_tape.hpp"
#include "kernels/shared/expression_bounds.h"
#include "kernels/shared/lattice.h"
#include "kernels/shared/tape.h"

namespace mortise::sizing {
namespace {

constexpr double kRounding = 1e-9;  ///< relative: a size that is an edge of a level is met by that level

double wish(const std::vector<double>& sizes, std::size_t index) {
    return index < sizes.size() ? sizes[index] : kInfinity;
}

}  // namespace

SizeField size_field(const tape::BoundModel& model) {
    SizeField field;
    field.surface = model.surface_size;
    field.region = model.region_size;
    return field;
}

tape::Cell cell_of(std::uint64_t morton, int level) {
    tape::Cell cell{};
    cell.half = std::ldexp(0.5, -level);
    for (int j = 0; j < 3; ++j) cell.centre[j] = (2.0 * gather_bits(morton >> j) + 1) * cell.half;
    return cell;
}

Sizer::Sizer(const tape::BoundModel& model, const SizeField& field) : model_(model), field_(field) {}

double Sizer::size_in(const tape::Cell& cell) const {
    double size = field_.everywhere;
    for (const SizeField::Source& source : field_.sources) {
        double square = 0;
        for (std::size_t j = 0; j < 3; ++j) {
            const double off = std::max(0.0, std::fabs(source.at[j] - cell.centre[j]) - cell.half);
            square += off * off;
        }
        size = std::min(size, source.size + source.grading * std::sqrt(square));
    }
    if (!field_.formula.empty()) {
        Interval x[3];
        for (std::size_t j = 0; j < 3; ++j) {
            const double centre = model_.origin[j] + model_.side * cell.centre[j];
            const double half = model_.side * cell.half;
            const double low = std::clamp(centre - half, field_.within.min[j], field_.within.max[j]);
            const double high = std::clamp(centre + half, field_.within.min[j], field_.within.max[j]);
            x[j] = make_interval(static_cast<float>(low), static_cast<float>(high));
        }
        const Interval wanted = expression_bounds(field_.formula.data(),
                                                  static_cast<u32>(field_.formula.size()), x[0], x[1], x[2]);
        // Nothing that is no number passes the comparison.
        size = std::min(size, wanted.low > 0 ? static_cast<double>(wanted.low) / model_.side : 0.0);
    }
    return size;
}

bool Sizer::splits_in(std::uint64_t morton, int level, std::uint16_t region) const {
    return std::ldexp(1.0, -level) > in_size(morton, level, region) * (1 + kRounding);
}

double Sizer::smallest() const {
    double size = size_in(cell_of(0, 0));
    for (const double surface : field_.surface) size = std::min(size, surface);
    for (const double region : field_.region) size = std::min(size, region);
    for (const SizeField::Meeting& meeting : field_.meetings) size = std::min(size, meeting.size);
    for (const SizeField::Gap& gap : field_.gaps) size = std::min(size, gap.least);
    return size;
}

double Sizer::in_size(std::uint64_t morton, int level, std::uint16_t region) const {
    const tape::Cell cell = cell_of(morton, level);
    double size = size_in(cell);
    for (const SizeField::Gap& gap : field_.gaps) size = std::min(size, gap_size(model_, gap, cell));
    return region == 0 ? size : std::min(size, wish(field_.region, region - std::size_t{1}));
}

/// By sizes alone.
bool Sizer::is_too_large(const std::uint32_t* words, std::size_t length, const tape::Cell& cell) const {
    double size = size_in(cell);
    const auto add_region = [&](std::int32_t region) {
        if (region > 0) size = std::min(size, wish(field_.region, static_cast<std::size_t>(region) - 1));
    };
    for (std::size_t i = 0; i < length; ++i) {
        const std::uint32_t word = words[i];
        switch (tape_operation(word)) {
            case kTapeLiteral: size = std::min(size, wish(field_.surface, tape_surface(word))); break;
            case kTapeSelectConst: add_region(tape_otherwise(word)); [[fallthrough]];
            case kTapeSelect: add_region(tape_region(word)); break;
            default: break;
        }
    }
    const double edge = 2 * cell.half;
    if (edge > size * (1 + kRounding)) return true;
    if (field_.meetings.empty() && field_.gaps.empty()) return false;
    std::vector<std::uint32_t> here;
    tape::list_surfaces(words, length, here);
    for (const SizeField::Meeting& meeting : field_.meetings) {
        if (edge > meeting.size * (1 + kRounding) && meet_in(model_, meeting, here, cell)) return true;
    }
    return std::any_of(field_.gaps.begin(), field_.gaps.end(), [&](const SizeField::Gap& gap) {
        return (holds_one(here, gap.a) || holds_one(here, gap.b)) &&
               edge > gap_size(model_, gap, cell) * (1 + kRounding);
    });
}

std::vector<std::uint8_t> Sizer::split_undecided(const std::vector<TreeNode>& nodes,
                                                 const std::vector<std::uint32_t>& tapes, int level,
                                                 int threads) const {
    constexpr std::size_t kChunk = 256;
    std::vector<std::uint8_t> which(nodes.size(), 0);
    const bool curved = field_.curvature_elements > 0;
    std::vector<Topology> views(static_cast<std::size_t>(thread_count(threads)),
                                Topology(model_, field_.finest));
    std::vector<std::vector<SheetTrace>> traces(chunk_count(nodes.size(), kChunk));
    std::vector<std::uint32_t> trace_counts(nodes.size(), 0);
    parallel_chunks(nodes.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int thread) {
        Topology& view = views[static_cast<std::size_t>(thread)];
        for (std::size_t i = begin; i < end; ++i) {
            keep_watch();
            const std::uint32_t* words = tapes.data() + nodes[i].tape_offset;
            const std::size_t length = nodes[i].tape_length;
            const tape::Cell cell = cell_of(nodes[i].morton, level);
            const bool undivided = std::any_of(words, words + length, [](std::uint32_t word) {
                return tape_operation(word) == kTapeSpatial;
            });
            bool split = undivided || is_too_large(words, length, cell);
            if (!split && (curved || field_.features)) {
                view.load(words, length, cell);
                split = (field_.features && !view.is_simple()) ||
                        (curved && view.turn() > kTurn / field_.curvature_elements);
                if (field_.features) {
                    auto& list = traces[begin / kChunk];
                    for (const Sheet& s : view.sheets())
                        list.push_back({s.surface, s.flat, s.orientation, s.foot, s.normal});
                    trace_counts[i] = static_cast<std::uint32_t>(view.sheets().size());
                }
            }
            which[i] = split ? 1 : 0;
        }
    });
    if (field_.features &&
        std::is_sorted(nodes.begin(), nodes.end(),
                       [](const TreeNode& a, const TreeNode& b) { return a.morton < b.morton; })) {
        SheetTraces sheets;
        for (const std::uint32_t count : trace_counts) sheets.begin.push_back(sheets.begin.back() + count);
        for (const auto& list : traces) sheets.trace.insert(sheets.trace.end(), list.begin(), list.end());
        const double edge = std::ldexp(1.0, -level);
        mark_thin(
            nodes, level, sheets, field_.finest > 0 ? 0.5 * field_.finest : edge / 256,
            [&views](std::uint32_t a, std::uint32_t b, const tape::Cell& cell, int thread) {
                return views[static_cast<std::size_t>(thread)].meet_near(a, b, cell);
            },
            threads, which);
    }
    return which;
}

}  // namespace mortise::sizing
