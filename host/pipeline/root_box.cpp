#include "host/pipeline/root_box.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "host/common/constants.hpp"

namespace mortise::pipeline {
namespace {

constexpr int kDefaultLevel = 6;
constexpr double kOnPlane = 1e-6;      ///< cells: closer than signs can tell (kSignTolerance)
constexpr double kFewestCells = 0.8;   ///< share of the cells across the model that fitting keeps
constexpr double kWhole = 1e-9;        ///< cells
constexpr double kSamePlane = 1e-12;   ///< of the extent
constexpr double kFarFromGrid = 0.36;  ///< cells: vertices do not move onto a plane (snap.h), edges are long
constexpr int kParted = 3;             ///< a plane that parts, on the grid, counts as so many far from it
constexpr int kPlacements = 32;        ///< of the grid within a cell, tried for an axis
constexpr std::size_t kMostPlanes = 512;  ///< per axis, of models with more the first

/// Across an axis.
struct Plane {
    double place = 0;
    bool parts = false;  ///< primitives lie on both sides
};
using Planes = std::array<std::vector<Plane>, 3>;

/// The planes across each axis, ascending, inside the bounds.
Planes axis_planes(const tape::CompiledModel& compiled, const Box3& bounds) {
    struct Side {
        double place = 0;
        bool is_upper = false;
    };
    std::array<std::vector<Side>, 3> sides;
    for (const tape::WorldSurface& surface : compiled.surfaces) {
        if (surface.surface.kind != kSurfacePlane) continue;
        const double* row = surface.surface.map;
        for (std::size_t j = 0; j < 3; ++j) {
            const double across = std::fabs(row[j]);
            const double off = std::max(std::fabs(row[(j + 1) % 3]), std::fabs(row[(j + 2) % 3]));
            if (!(off <= 1e-12 * across)) continue;
            const double place = -row[3] / row[j];
            const double slack = kOnPlane * (bounds.max[j] - bounds.min[j]);
            if (place >= bounds.min[j] - slack && place <= bounds.max[j] + slack &&
                sides[j].size() < kMostPlanes)
                sides[j].push_back({place, row[j] > 0});
        }
    }
    Planes result;
    for (std::size_t j = 0; j < 3; ++j) {
        std::sort(sides[j].begin(), sides[j].end(),
                  [](const Side& a, const Side& b) { return a.place < b.place; });
        const double same = kSamePlane * (bounds.max[j] - bounds.min[j]);
        bool is_upper = false;
        for (const Side& side : sides[j]) {
            if (result[j].empty() || side.place - result[j].back().place > same) {
                result[j].push_back({side.place, false});
                is_upper = side.is_upper;
            }
            result[j].back().parts |= side.is_upper != is_upper;
        }
    }
    return result;
}

struct Fit {
    double origin = 0;
    std::size_t on_planes = 0;
};

/// The origin in [low, high] that puts the most planes on the grid, the one nearest the middle of these.
Fit fit_axis(const std::vector<Plane>& planes, double low, double high, double cell) {
    Fit best{0.5 * (low + high), 0};
    double best_shift = high - low;
    for (const Plane& anchor : planes) {
        // Grid planes through the anchor; the origin nearest the middle of its range.
        const double middle = 0.5 * (low + high);
        const double origin = anchor.place - cell * std::round((anchor.place - middle) / cell);
        if (origin < low - kOnPlane * cell || origin > high + kOnPlane * cell) continue;
        Fit fit{origin, 0};
        for (const Plane& plane : planes) {
            const double at = (plane.place - origin) / cell;
            if (std::fabs(at - std::round(at)) < kOnPlane) ++fit.on_planes;
        }
        const double shift = std::fabs(origin - middle);
        if (fit.on_planes < best.on_planes || (fit.on_planes == best.on_planes && shift >= best_shift))
            continue;
        best = fit;
        best_shift = shift;
    }
    return best;
}

/// Where a plane lies in the grid, in cells.
struct PlanePlace {
    double layer = 0;    ///< of cells, the one above if it is on the grid
    double to_grid = 0;  ///< distance to the nearest plane of the grid

    bool is_on_grid() const { return to_grid < kOnPlane; }
};

PlanePlace place_of(const Plane& plane, double origin, double cell) {
    const double at = (plane.place - origin) / cell;
    const double nearest = std::round(at);
    const double to_grid = std::fabs(at - nearest);
    return {to_grid < kOnPlane ? nearest : std::floor(at), to_grid};
}

/// How well a grid suits the planes. One counts if cells at its creases have good elements as they are: it is
/// on the grid, or so far from it that no vertex would have to be moved onto it, and alone between two planes
/// of the grid. Where primitives lie on both sides, each has surfaces of its own, and only on the grid no
/// cell has those of both.
int count_well_placed(const std::vector<Plane>& planes, double origin, double cell) {
    int count = 0;
    PlanePlace before{-kInfinity, 0};
    PlanePlace here = planes.empty() ? before : place_of(planes[0], origin, cell);
    for (std::size_t i = 0; i < planes.size(); ++i) {
        const PlanePlace after =
            i + 1 < planes.size() ? place_of(planes[i + 1], origin, cell) : PlanePlace{kInfinity, 0};
        const auto shares_layer = [&](const PlanePlace& other) {
            return other.layer == here.layer && !other.is_on_grid();
        };
        if (here.is_on_grid())
            count += planes[i].parts ? kParted : 1;
        else if (here.to_grid > kFarFromGrid && !shares_layer(before) && !shares_layer(after))
            ++count;
        before = here;
        here = after;
    }
    return count;
}

/// The origin in [low, high] at which the most planes are well placed, the one nearest the middle of these.
double place_axis(const std::vector<Plane>& planes, double low, double high, double cell) {
    const double middle = 0.5 * (low + high);
    double best = middle;
    int most = -1;
    const auto try_shift = [&](double shift) {
        const double origin = middle + shift * cell;
        if (origin < low - kOnPlane * cell || origin > high + kOnPlane * cell) return;
        const int count = count_well_placed(planes, origin, cell);
        const bool is_nearer = std::fabs(origin - middle) < std::fabs(best - middle);
        if (count < most || (count == most && !is_nearer)) return;
        best = origin;
        most = count;
    };
    try_shift(0);
    for (const Plane& plane : planes) {
        const double at = (plane.place - middle) / cell;
        try_shift(at - std::round(at));
    }
    for (int i = 1; i <= kPlacements / 2; ++i) {
        try_shift(static_cast<double>(i) / kPlacements);
        try_shift(-static_cast<double>(i) / kPlacements);
    }
    return best;
}

/// Shifts the grid, within a cell, for the planes across the axes.
Root shift_root(const tape::CompiledModel& compiled, const Box3& bounds, const Root& plain) {
    const Planes planes = axis_planes(compiled, bounds);
    const double cell = plain.cell();
    Root root = plain;
    for (std::size_t j = 0; j < 3; ++j)
        root.origin[j] = place_axis(planes[j], bounds.max[j] + cell - root.side, bounds.min[j] - cell, cell);
    return root;
}

/// Tries cells of a whole number to the longest extent, and takes the grid with the most planes on it,
/// weighed against its coarseness.
Root fit_root(const tape::CompiledModel& compiled, const Box3& bounds, double extent, const Root& plain,
              bool fixed_size) {
    const Planes planes = axis_planes(compiled, bounds);
    const double cells = std::ldexp(1.0, plain.level);
    const double most = cells - 2;
    Root best = plain;
    double best_score = -1;
    for (double count = most; count >= kFewestCells * most; --count) {
        const double cell = fixed_size ? plain.cell() : extent / count;
        Root root = plain;
        root.side = cell * cells;
        double score = 0;
        for (std::size_t j = 0; j < 3; ++j) {
            const Fit fit = fit_axis(planes[j], bounds.max[j] + cell - root.side, bounds.min[j] - cell, cell);
            root.origin[j] = fit.origin;
            score += static_cast<double>(fit.on_planes);
        }
        score *= std::sqrt(count / most);
        if (score > best_score) {
            best = root;
            best_score = score;
        }
        if (fixed_size) break;
    }
    return best;
}

/// Cells of which every distance between periodic planes is a whole number, with all these planes on the
/// grid: the largest number of them that the root's level allows, the smallest not below its size. False, and
/// nothing done, if there are none.
bool fit_periodic(const std::vector<PeriodicAxis>& pairs, const Box3& bounds, double extent, bool fixed_size,
                  Root& root) {
    if (root.level < 3) return false;
    const auto is_whole = [](double length, double cell) {
        const double count = std::fabs(length) / cell;
        return std::fabs(count - std::round(count)) < kWhole && std::round(count) >= 1;
    };
    const double period = std::fabs(pairs[0].second - pairs[0].first);
    const double wanted = root.cell();
    const double ratio = period / wanted;
    double count = fixed_size ? std::ceil(ratio * (1 - kWhole)) : std::floor(ratio * (1 + kWhole));
    const double step = fixed_size ? 1 : -1;
    for (; count >= std::max(1.0, 0.5 * ratio) && count <= 2 * ratio + 1; count += step) {
        Root tried = root;
        const double cell = period / count;
        while (tried.level < kMaxLevel && std::ldexp(cell, tried.level) < (extent + 2 * cell) * (1 - kWhole))
            ++tried.level;
        if (!fixed_size && tried.level != root.level) continue;
        tried.side = std::ldexp(cell, tried.level);
        bool fits = true;
        for (std::size_t j = 0; j < 3 && fits; ++j) {
            tried.origin[j] = 0.5 * (bounds.min[j] + bounds.max[j] - tried.side);
            const PeriodicAxis* anchor = nullptr;
            for (const PeriodicAxis& pair : pairs) {
                if (pair.axis != j) continue;
                if (anchor == nullptr) anchor = &pair;
                fits = fits && is_whole(pair.second - pair.first, cell) &&
                       (pair.first == anchor->first || is_whole(pair.first - anchor->first, cell));
            }
            if (anchor == nullptr || !fits) continue;
            const double most = bounds.min[j] - cell;
            const double least = bounds.max[j] + cell - tried.side;
            double origin = anchor->first - cell * std::round((anchor->first - tried.origin[j]) / cell);
            if (origin > most + kOnPlane * cell) origin -= cell;
            if (origin < least - kOnPlane * cell) origin += cell;
            fits = origin <= most + kOnPlane * cell && origin >= least - kOnPlane * cell;
            tried.origin[j] = origin;
        }
        if (!fits) continue;
        root = tried;
        return true;
    }
    return false;
}

}  // namespace

double Root::cell() const { return std::ldexp(side, -level); }

Root choose_root(const tape::CompiledModel& compiled, const Box3& bounds, const MeshOptions& options,
                 const std::vector<PeriodicAxis>& periodic, std::vector<std::string>& warnings) {
    double extent = 0;
    for (std::size_t j = 0; j < 3; ++j) extent = std::max(extent, bounds.max[j] - bounds.min[j]);
    Root root{};
    root.level = options.level > 0 ? options.level : kDefaultLevel;
    const bool fixed_size = options.size > 0 && options.level == 0;
    if (fixed_size) {
        root.level = 1;
        while (root.level < kMaxLevel && std::ldexp(options.size, root.level) < extent + 2 * options.size)
            ++root.level;
        root.side = std::ldexp(options.size, root.level);
    } else {
        const double cells = std::ldexp(1.0, root.level);
        root.side = root.level >= 3 ? extent * (cells / (cells - 2)) : 1.25 * extent;
    }
    for (std::size_t j = 0; j < 3; ++j) root.origin[j] = 0.5 * (bounds.min[j] + bounds.max[j] - root.side);
    if (!periodic.empty()) {
        if (fit_periodic(periodic, bounds, extent, fixed_size, root)) return root;
        warnings.push_back(
            "the distances of periodic planes have no common cell of about this size; their faces may "
            "differ");
    }
    if (root.level < 3) return root;
    return options.box_fit ? fit_root(compiled, bounds, extent, root, fixed_size)
                           : shift_root(compiled, bounds, root);
}

}  // namespace mortise::pipeline
