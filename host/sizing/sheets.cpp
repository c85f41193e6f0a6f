#include "host/sizing/sheets.hpp"

#include <algorithm>
#include <cmath>

#include "host/tape/singular_point.hpp"
#include "host/tape/variation.hpp"

namespace mortise::sizing {
namespace {

/// Faces of models often lie on grid planes: what stays in this margin of the node belongs to its neighbour.
constexpr double kDrawnIn = 1 - 1.0 / 64;

tape::Cell child_of(const tape::Cell& cell, int child) {
    tape::Cell result = cell;
    result.half *= 0.5;
    for (int j = 0; j < 3; ++j) result.centre[j] += ((child >> j) & 1) != 0 ? result.half : -result.half;
    return result;
}

SurfaceSample sample_at(const tape::BoundModel& model, std::uint32_t surface, const Vec3& x) {
    return surface_sample(&model.surfaces[surface], model.expression_ops.data(), x[0], x[1], x[2]);
}

}  // namespace

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

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
        const SurfaceSample s = sample_at(model, surface, x);
        slope = std::sqrt(s.gradient[0] * s.gradient[0] + s.gradient[1] * s.gradient[1] +
                          s.gradient[2] * s.gradient[2]);
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
        const SurfaceSample s = sample_at(model_, surface, sample_point(cell, i));
        const Vec3 gradient = {s.gradient[0], s.gradient[1], s.gradient[2]};
        if (!(std::fabs(s.value) > kFar * cell.half * std::sqrt(dot(gradient, gradient)))) return false;
    }
    return true;
}

/// By the closest points of the samples: bounds of a patch's gradient are not known.
bool SheetFinder::make_patch(const tape::Cell& cell, Sheet& sheet, double& at_centre) const {
    constexpr double kMargin = 1.05;
    constexpr double kTurned = 1e-6;
    std::array<Vec3, Sheet::kSamples> normals;
    std::size_t found = 0;
    double nearest = 4 * cell.half;
    bool below = false;
    bool above = false;
    for (std::size_t i = 0; i < Sheet::kSamples; ++i) {
        const Vec3 x = sample_point(cell, i);
        const SurfaceSample s = sample_at(model_, sheet.surface, x);
        sheet.distance[i] = s.value;
        (s.value < 0 ? below : above) = true;
        Vec3 closest;
        for (std::size_t j = 0; j < 3; ++j) closest[j] = x[j] - s.value * s.gradient[j];
        if (!is_within(closest, cell, kMargin)) continue;
        normals[found++] = {s.gradient[0], s.gradient[1], s.gradient[2]};
        const double off =
            std::hypot(closest[0] - cell.centre[0], closest[1] - cell.centre[1], closest[2] - cell.centre[2]);
        if (off >= nearest) continue;
        nearest = off;
        sheet.foot = closest;
        sheet.normal = normals[found - 1];
    }
    at_centre = sheet.distance[8];
    sheet.steady = true;
    for (std::size_t i = 0; i < found; ++i) {
        for (std::size_t k = 0; k < i; ++k)
            sheet.steady = sheet.steady && dot(normals[i], normals[k]) > kTurned;
    }
    if (found > 0) return true;
    if (!below || !above) return false;
    const SurfaceSample s = sample_at(model_, sheet.surface, sample_point(cell, 8));
    for (std::size_t j = 0; j < 3; ++j) {
        sheet.normal[j] = s.gradient[j];
        sheet.foot[j] = cell.centre[j] - s.value * s.gradient[j];
    }
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
    sheet.steady = tape::keeps_direction(box);
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

void SheetFinder::run(const std::uint32_t* words, std::size_t length, const tape::Cell& cell) {
    const tape::Cell drawn_in = {{cell.centre[0], cell.centre[1], cell.centre[2]}, kDrawnIn * cell.half};
    surfaces_.clear();
    for (std::size_t i = 0; i < length; ++i) {
        if (tape_operation(words[i]) == kTapeLiteral) surfaces_.push_back(tape_surface(words[i]));
    }
    std::sort(surfaces_.begin(), surfaces_.end());
    surfaces_.erase(std::unique(surfaces_.begin(), surfaces_.end()), surfaces_.end());
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

}  // namespace mortise::sizing
