#include "host/sizing/sheets.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/vec3.hpp"
#include "host/tape/local_tape.hpp"
#include "host/tape/patch_bounds.hpp"
#include "host/tape/singular_point.hpp"
#include "host/tape/variation.hpp"

namespace mortise::sizing {
namespace {

/// Faces of models often lie on grid planes: what stays in this margin of the node belongs to its neighbour.
constexpr double kDrawnIn = 1 - 1.0 / 64;
/// To look closely: a small feature may lie in the margin.
constexpr double kBarelyDrawnIn = 1 - 1.0 / 4096;
/// But a wall between such a face and a sheet that passes through the node is this node's.
constexpr double kDrawnOut = 1 + 1.0 / 64;
constexpr double kFacing = 0.9063;  ///< cosine of 25°

tape::Cell child_of(const tape::Cell& cell, int child) {
    tape::Cell result = cell;
    result.half *= 0.5;
    for (int j = 0; j < 3; ++j) result.centre[j] += ((child >> j) & 1) != 0 ? result.half : -result.half;
    return result;
}

}  // namespace

Sampled sample_at(const tape::BoundModel& model, std::uint32_t surface, const Vec3& x) {
    constexpr double kStep = 1e-6;
    const Surface& of = model.surfaces[surface];
    const ExpressionOp* ops = model.expression_ops.data();
    const SurfaceSample s = surface_sample(&of, ops, x[0], x[1], x[2]);
    Sampled result = {s.value, {s.gradient[0], s.gradient[1], s.gradient[2]}, 0};
    result.slope = std::sqrt(dot(result.gradient, result.gradient));
    if (of.kind != kSurfaceExpression || std::isfinite(result.slope) || !std::isfinite(s.value))
        return result;
    for (std::size_t j = 0; j < 3; ++j) {
        Vec3 low = x;
        Vec3 high = x;
        low[j] -= kStep;
        high[j] += kStep;
        result.gradient[j] = (surface_value(&of, ops, high[0], high[1], high[2]) -
                              surface_value(&of, ops, low[0], low[1], low[2])) /
                             (2 * kStep);
    }
    result.slope = std::sqrt(dot(result.gradient, result.gradient));
    return result;
}

bool is_within(const Vec3& x, const tape::Cell& cell, double factor) {
    bool within = true;
    for (std::size_t j = 0; j < 3; ++j)
        within = within && std::fabs(x[j] - cell.centre[j]) <= factor * cell.half;
    return within;
}

Vec3 sample_point(const tape::Cell& cell, std::size_t index) {
    Vec3 x = {cell.centre[0], cell.centre[1], cell.centre[2]};
    if (index >= 8) return x;
    for (std::size_t j = 0; j < 3; ++j) x[j] += ((index >> j) & 1) != 0 ? cell.half : -cell.half;
    return x;
}

bool project(const tape::BoundModel& model, std::uint32_t surface, double reach, Vec3& x, Vec3& unit_normal,
             double& slope) {
    constexpr int kSteps = 10;
    constexpr double kClose = 1e-3;  // of the reach
    for (int step = 0;; ++step) {
        const Sampled s = sample_at(model, surface, x);
        slope = s.slope;
        if (!(slope > 0) || !std::isfinite(slope) || !std::isfinite(s.value)) return false;
        for (std::size_t j = 0; j < 3; ++j) unit_normal[j] = s.gradient[j] / slope;
        const double distance = s.value / slope;
        if (std::fabs(distance) <= kClose * reach) return true;
        if (step == kSteps) return false;
        const double move = std::clamp(distance, -reach, reach);
        for (std::size_t j = 0; j < 3; ++j) x[j] -= move * unit_normal[j];
    }
}

/// Whether interval bounds cannot rule out the surface, after `depth` subdivisions.
bool SheetFinder::passes(std::uint32_t surface, const tape::Cell& cell, int depth) const {
    if (tape::classify_surface(model_, surface, cell) != 0) return false;
    if (depth == 0) return true;
    for (int child = 0; child < 8; ++child) {
        if (passes(surface, child_of(cell, child), depth - 1)) return true;
    }
    return false;
}

/// Bounds may be loose; to first order no sample has the surface near it.
bool SheetFinder::is_far(std::uint32_t surface, const tape::Cell& cell) const {
    constexpr double kFar = 1.3;  // of half an edge: no point of the node is farther than 0.87 from a sample
    for (std::size_t i = 0; i < Sheet::kSamples; ++i) {
        const Sampled s = sample_at(model_, surface, sample_point(cell, i));
        if (!(std::fabs(s.value) > kFar * cell.half * s.slope)) return false;
    }
    return true;
}

/// Bounds of long formulas are so loose that nodes would split without end. So gradients at 3³ points do, if
/// they turn by no more than 60°: what is hidden between them shows in the gradients around it.
bool SheetFinder::looks_steady(std::uint32_t surface, const tape::Cell& cell) const {
    constexpr int kSide = 3;
    constexpr double kNear = 0.866;  // cosine of 30°
    const Sampled centre = sample_at(model_, surface, sample_point(cell, 8));
    for (int i = 0; i < kSide * kSide * kSide; ++i) {
        Vec3 x{};
        int rest = i;
        for (std::size_t j = 0; j < 3; ++j, rest /= kSide)
            x[j] = cell.centre[j] + cell.half * (2.0 * (rest % kSide) / (kSide - 1) - 1);
        const Sampled s = sample_at(model_, surface, x);
        if (!(dot(s.gradient, centre.gradient) > kNear * s.slope * centre.slope)) return false;
    }
    return true;
}

/// By its triangles: bounds of its gradient are not known, and where they are not, it is only an extension.
bool SheetFinder::make_patch(const tape::Cell& cell, Sheet& sheet, double& at_centre) const {
    const Sampled centre = sample_at(model_, sheet.surface, sample_point(cell, 8));
    at_centre = centre.value;
    const tape::PatchState state = tape::patch_in(model_, sheet.surface, cell);
    if (state == tape::PatchState::kAbsent) return false;
    sheet.steady = state == tape::PatchState::kSteady;
    sheet.normal = centre.gradient;
    for (std::size_t j = 0; j < 3; ++j) sheet.foot[j] = cell.centre[j] - centre.value * centre.gradient[j];
    sheet.distance[8] = centre.value;
    for (std::size_t i = 0; i < 8; ++i)
        sheet.distance[i] = sample_at(model_, sheet.surface, sample_point(cell, i)).value;
    return true;
}

/// False: it does not pass through the cell; then `at_centre` tells its sign.
bool SheetFinder::make_sheet(std::uint32_t surface, const tape::Cell& cell, Sheet& sheet,
                             double& at_centre) const {
    const Surface& s = model_.surfaces[surface];
    sheet.surface = surface;
    if (s.kind == kSurfacePatch) return make_patch(cell, sheet, at_centre);
    const auto value = [&](std::size_t i) {
        const Vec3 x = sample_point(cell, i);
        return surface_value(&s, model_.expression_ops.data(), x[0], x[1], x[2]);
    };
    at_centre = value(8);
    if (tape::classify_surface(model_, surface, cell) != 0) return false;
    sheet.distance[8] = at_centre;
    bool below = at_centre < 0;
    bool above = !below;
    for (std::size_t i = 0; i < 8; ++i) {
        sheet.distance[i] = value(i);
        (sheet.distance[i] < 0 ? below : above) = true;
    }
    const bool changes = below && above;
    sheet.flat = sheet.steady = s.kind == kSurfacePlane;
    if (sheet.flat) {
        if (!changes) return false;
        for (std::size_t j = 0; j < 3; ++j) {
            sheet.normal[j] = s.map[j];
            sheet.foot[j] = cell.centre[j] - at_centre * s.map[j];
        }
        return true;
    }
    tape::GradientBox box{};
    if (!tape::gradient_box(model_, surface, cell, box) || !tape::keeps_direction(box)) {
        // Once more without the children that it does not pass.
        bool first = true;
        for (int child = 0; child < 8; ++child) {
            const tape::Cell part = child_of(cell, child);
            if (!passes(surface, part, changes ? 0 : 1)) continue;
            tape::GradientBox of_part{};
            tape::gradient_box(model_, surface, part, of_part);
            for (int j = 0; j < 3; ++j) {
                box.low[j] = first ? of_part.low[j] : std::min(box.low[j], of_part.low[j]);
                box.high[j] = first ? of_part.high[j] : std::max(box.high[j], of_part.high[j]);
            }
            first = false;
        }
        if (first && !changes) return false;
    }
    sheet.steady =
        tape::keeps_direction(box) || (s.kind == kSurfaceExpression && looks_steady(surface, cell));
    if (!sheet.steady && !changes && is_far(surface, cell)) return false;
    if (!sheet.steady) {
        double apex[3];
        if (tape::singular_point(s, apex)) {
            sheet.apex = {apex[0], apex[1], apex[2]};
            sheet.has_apex = is_within(sheet.apex, cell, 5);
        }
    }
    sheet.foot = {cell.centre[0], cell.centre[1], cell.centre[2]};
    double slope = 0;
    const bool reached = project(model_, surface, cell.half, sheet.foot, sheet.normal, slope);
    if (!reached) {
        // Flat spots and centres: nothing is known, so it is taken to pass and not to be steady.
        sheet.steady = sheet.steady && changes;
        if (!(slope > 0) || !std::isfinite(slope)) return true;
    }
    if (sheet.steady && !changes && !is_within(sheet.foot, cell, 1)) return false;
    for (double& distance : sheet.distance) distance /= slope;
    return true;
}

void SheetFinder::run(const std::uint32_t* words, std::size_t length, const tape::Cell& cell, bool closely) {
    tape::list_surfaces(words, length, surfaces_);
    find_inside(cell, closely ? kBarelyDrawnIn : kDrawnIn);
    add_touching(cell);
}

/// Sheets in the cell, which is drawn in by a factor.
void SheetFinder::find_inside(const tape::Cell& cell, double factor) {
    const tape::Cell drawn_in = {{cell.centre[0], cell.centre[1], cell.centre[2]}, factor * cell.half};
    signs_.assign(surfaces_.size(), 0);
    sheets_.clear();
    for (std::size_t i = 0; i < surfaces_.size(); ++i) {
        Sheet sheet;
        double at_centre = 0;
        if (make_sheet(surfaces_[i], drawn_in, sheet, at_centre))
            sheets_.push_back(sheet);
        else
            signs_[i] = at_centre <= 0 ? -1 : 1;
    }
}

/// Sheets on the node's boundary that are parallel to one inside.
void SheetFinder::add_touching(const tape::Cell& cell) {
    touches_ = false;
    if (sheets_.empty()) return;
    const tape::Cell drawn_out = {{cell.centre[0], cell.centre[1], cell.centre[2]}, kDrawnOut * cell.half};
    const std::size_t inside = sheets_.size();
    for (std::size_t i = 0; i < surfaces_.size(); ++i) {
        Sheet sheet;
        double at_centre = 0;
        if (signs_[i] == 0 || !make_sheet(surfaces_[i], drawn_out, sheet, at_centre)) continue;
        const bool parallel = std::any_of(
            sheets_.begin(), sheets_.begin() + static_cast<std::ptrdiff_t>(inside),
            [&](const Sheet& other) { return std::fabs(dot(other.normal, sheet.normal)) > kFacing; });
        if (!parallel) continue;
        signs_[i] = 0;
        sheets_.push_back(sheet);
        touches_ = true;
    }
    std::sort(sheets_.begin(), sheets_.end(),
              [](const Sheet& a, const Sheet& b) { return a.surface < b.surface; });
}

tape::Cell SheetFinder::seen(const tape::Cell& cell) const {
    return {{cell.centre[0], cell.centre[1], cell.centre[2]}, (touches_ ? kDrawnOut : 1) * cell.half};
}

}  // namespace mortise::sizing
