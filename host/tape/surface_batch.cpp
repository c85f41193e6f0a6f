#include "host/tape/surface_batch.hpp"

#include <algorithm>
#include <cmath>

#include "host/tape/expression_program.hpp"
#include "host/tape/patch_bounds.hpp"
#include "host/tape/variation.hpp"

namespace mortise::tape {
namespace {

/// Runs a formula at all places. `input(i, u)` makes of coordinate u[i] what the lanes want; `store(k, block,
/// lane)` takes the result of place k.
template <class Lanes, class MakeInput, class Store>
void run_at(ExpressionProgram<Lanes>& program, const BoundModel& model, const Surface& s,
            const Places& places, const MakeInput& input, const Store& store) {
    const Grid* grid = places.grid;
    const auto in_plane = [&](std::size_t i, std::size_t axis, std::size_t k) {
        Vec3 x = {grid->middle(0, 0), grid->middle(1, 0), grid->middle(2, 0)};
        x[axis] = grid->middle(axis, k);
        double u[3];
        surface_frame(&s, x[0], x[1], x[2], u);
        return input(i, u[i]);
    };
    program.prepare(s, model.expression_ops.data(), grid != nullptr ? grid->side : 0, in_plane);
    typename Lanes::Input inputs[kLanes][3];
    for (std::size_t first = 0; first < places.count; first += kLanes) {
        const std::size_t n = std::min(kLanes, places.count - first);
        for (std::size_t k = 0; k < n && program.needs_coordinates(); ++k) {
            const Vec3 x = places.point(first + k);
            double u[3];
            surface_frame(&s, x[0], x[1], x[2], u);
            for (std::size_t i = 0; i < 3; ++i) inputs[k][i] = input(i, u[i]);
        }
        const auto& block = program.run(n, grid != nullptr ? places.places + first : nullptr, inputs);
        for (std::size_t k = 0; k < n; ++k) store(first + k, block, k);
    }
}

/// The range of a coordinate over a cell, as classify_surface has it.
class CoordinateRange {
  public:
    CoordinateRange(const Surface& s, double half) {
        for (int i = 0; i < 3; ++i) {
            const double* row = s.map + 4 * i;
            w_[i] = half * (std::fabs(row[0]) + std::fabs(row[1]) + std::fabs(row[2]));
        }
    }
    Interval operator()(std::size_t i, double u) const {
        return make_interval(static_cast<float>(u - w_[i]), static_cast<float>(u + w_[i]));
    }

  private:
    double w_[3];
};

double coordinate(std::size_t, double u) { return u; }

/// A surface at all places: a formula in lanes, whose results `store` takes; all else, and places where a
/// formula is no number, by `single`, one after the other.
template <class Lanes, class Single, class Store, class Result>
void evaluate(ExpressionProgram<Lanes>& program, const BoundModel& model, std::uint32_t surface,
              const Places& places, const Single& single, const Store& store, std::vector<Result>& results) {
    const Surface& s = model.surfaces[surface];
    results.resize(places.count);
    const auto ask = [&](std::size_t k) {
        const Vec3 x = places.point(k);
        results[k] = single(&s, model.expression_ops.data(), x[0], x[1], x[2]);
    };
    if (s.kind != kSurfaceExpression) {
        for (std::size_t k = 0; k < places.count; ++k) ask(k);
        return;
    }
    run_at(program, model, s, places, coordinate,
           [&](std::size_t k, const typename Lanes::Block& block, std::size_t lane) {
               if (!store(results[k], block, lane)) ask(k);
           });
}

}  // namespace

struct SurfaceBatch::Programs {
    ExpressionProgram<BoundsLanes> bounds;
    ExpressionProgram<ValueLanes> values;
    ExpressionProgram<SampleLanes> samples;
    ExpressionProgram<GradientLanes> gradients;
};

SurfaceBatch::SurfaceBatch(const BoundModel& model)
    : model_(model), programs_(std::make_unique<Programs>()) {}
SurfaceBatch::~SurfaceBatch() = default;

void SurfaceBatch::classify(std::uint32_t surface, const Grid& grid, const std::vector<GridPlace>& cells,
                            std::vector<std::int8_t>& signs, std::vector<double>* widths) {
    const Surface& s = model_.surfaces[surface];
    const Places places(grid, cells);
    signs.resize(places.count);
    if (widths != nullptr) widths->assign(places.count, kMortiseInfinity);
    const double half = 0.5 * grid.edge;
    if (s.kind != kSurfaceExpression) {
        for (std::size_t k = 0; k < places.count; ++k) {
            const Vec3 x = places.point(k);
            const Cell cell = {{x[0], x[1], x[2]}, half};
            signs[k] =
                static_cast<std::int8_t>(s.kind == kSurfacePatch ? classify_patch(model_, surface, cell)
                                                                 : classify_surface(model_, surface, cell));
        }
        return;
    }
    const auto store = [&](std::size_t k, const BoundsLanes::Block& block, std::size_t lane) {
        signs[k] = static_cast<std::int8_t>(interval_sign(BoundsLanes::get(block, lane)));
        if (widths != nullptr) (*widths)[k] = double{block.high[lane]} - double{block.low[lane]};
    };
    run_at(programs_->bounds, model_, s, places, CoordinateRange(s, half), store);
}

void SurfaceBatch::slopes(std::uint32_t surface, const Grid& grid, const std::vector<GridPlace>& cells,
                          std::vector<double>& slopes) {
    const Surface& s = model_.surfaces[surface];
    const Places places(grid, cells);
    slopes.assign(places.count, kMortiseInfinity);
    if (s.kind != kSurfaceExpression) return;
    const auto store = [&](std::size_t k, const GradientLanes::Block& block, std::size_t lane) {
        bool partial = block.f.partial[lane] != 0;
        double size[3];
        for (int i = 0; i < 3; ++i) {
            const Interval d = BoundsLanes::get(block.slope[i], lane);
            partial = partial || d.partial != 0;
            size[i] = larger(-d.low, d.high);
        }
        if (partial) return;
        slopes[k] = 0;
        for (int j = 0; j < 3; ++j) {
            for (int i = 0; i < 3; ++i) slopes[k] += size[i] * std::fabs(s.map[4 * i + j]);
        }
        if (!(slopes[k] < kMortiseInfinity)) slopes[k] = kMortiseInfinity;
    };
    run_at(programs_->gradients, model_, s, places, CoordinateRange(s, 0.5 * grid.edge), store);
}

void SurfaceBatch::find_steady(std::uint32_t surface, const std::vector<Vec3>& centres, double half,
                               std::vector<std::uint8_t>& steady) {
    const Surface& s = model_.surfaces[surface];
    steady.assign(centres.size(), 0);
    const auto store = [&](std::size_t k, const GradientLanes::Block& block, std::size_t lane) {
        GradientBox box{};
        bool partial = block.f.partial[lane] != 0;
        for (int i = 0; i < 3; ++i) {
            const Interval d = BoundsLanes::get(block.slope[i], lane);
            partial = partial || d.partial != 0;
            box.low[i] = d.low;
            box.high[i] = d.high;
        }
        steady[k] = !partial && keeps_direction(to_local(s, box)) ? 1 : 0;
    };
    run_at(programs_->gradients, model_, s, Places(centres), CoordinateRange(s, half), store);
}

void SurfaceBatch::values(std::uint32_t surface, const Places& places, std::vector<double>& values) {
    const auto store = [](double& value, const ValueLanes::Block& block, std::size_t lane) {
        value = block.value[lane];
        return value == value;
    };
    evaluate(programs_->values, model_, surface, places, surface_value, store, values);
}

void SurfaceBatch::samples(std::uint32_t surface, const Places& places, std::vector<SurfaceSample>& samples) {
    const double* map = model_.surfaces[surface].map;
    const auto store = [map](SurfaceSample& sample, const SampleLanes::Block& block, std::size_t lane) {
        sample.value = block.f.value[lane];
        for (int j = 0; j < 3; ++j) {
            sample.gradient[j] = block.slope[0][lane] * map[j] + block.slope[1][lane] * map[4 + j] +
                                 block.slope[2][lane] * map[8 + j];
        }
        return sample.value == sample.value;
    };
    evaluate(programs_->samples, model_, surface, places, surface_sample, store, samples);
}

}  // namespace mortise::tape
