#include "host/improve/stratum.hpp"

#include <algorithm>
#include <cmath>

#include "host/tape/projection.hpp"
#include "host/tape/reference.hpp"
#include "host/tape/singular_point.hpp"
#include "kernels/shared/surface.h"

namespace mortise::improve {
namespace {

constexpr double kConverged = 1e-11;       ///< of a cell: the last step of Newton's method
constexpr double kProjectionReach = 0.25;  ///< cells: farther, the stratum is not what the mesh shows
constexpr double kUpright = 0.3;           ///< sine: surfaces that are steeper cross a normal elsewhere
constexpr double kTangent = 0.05;          ///< sine between gradients below which surfaces count as tangent
/// What Newton's method can reach, in edges of the root box: in finest cells of deep trees more than
/// kConverged.
constexpr int kRoundingBits = 48;

/// Box-local distance, to first order, below which a surface's side of a point is not certain.
constexpr double kUncertain = 1e-9;

/// The model's region at a point, for assumed signs of some surfaces there; others that pass through it are
/// unknown.
class Surroundings {
  public:
    Surroundings(const tape::BoundModel& model, const double* x)
        : model_(model), all_(model.surfaces.size()), signs_(model.surfaces.size()) {
        for (std::size_t s = 0; s < all_.size(); ++s) {
            all_[s] = static_cast<std::uint32_t>(s);
            const SurfaceSample sample =
                surface_sample(&model.surfaces[s], model.expression_ops.data(), x[0], x[1], x[2]);
            const double norm = length({sample.gradient[0], sample.gradient[1], sample.gradient[2]});
            signs_[s] = static_cast<std::int8_t>(std::fabs(sample.value) <= kUncertain * norm ? 0
                                                 : sample.value < 0                           ? -1
                                                                                              : 1);
        }
    }
    void assume(std::uint32_t surface, int sign) { signs_[surface] = static_cast<std::int8_t>(sign); }
    std::int32_t region() const {
        return tape::resolve_signs(model_.tape.data(), model_.tape.size(), all_.data(), all_.size(),
                                   signs_.data());
    }

  private:
    const tape::BoundModel& model_;
    std::vector<std::uint32_t> all_;
    std::vector<std::int8_t> signs_;
};

}  // namespace

std::vector<Tip> find_tips(const tape::BoundModel& model, const std::vector<tape::Pole>& poles, int level) {
    const double cells = std::ldexp(1.0, level);
    std::vector<Tip> tips;
    for (std::uint32_t s = 0; s < model.surfaces.size(); ++s) {
        double x[3];
        if (!tape::singular_point(model.surfaces[s], x)) continue;
        if (!(std::min({x[0], x[1], x[2]}) >= 0 && std::max({x[0], x[1], x[2]}) <= 1)) continue;
        Surroundings around(model, x);
        around.assume(s, -1);
        const std::int32_t inside = around.region();
        around.assume(s, 1);
        // One of them may be unknown: a plane through the apex changes nothing there.
        if (inside == around.region()) continue;
        tips.push_back({{s}, {cells * x[0], cells * x[1], cells * x[2]}});
    }
    for (const tape::Pole& pole : poles) {
        tips.push_back({pole.surfaces, {cells * pole.at[0], cells * pole.at[1], cells * pole.at[2]}, &pole});
    }
    return tips;
}

Surfaces::Surfaces(const tape::BoundModel& model, int level)
    : model_(model), cell_(std::ldexp(1.0, -level)), rounding_(std::ldexp(1.0, level - kRoundingBits)) {}

Surfaces::Sample Surfaces::sample(std::uint32_t surface, const Point& x) const {
    const SurfaceSample s = surface_sample(&model_.surfaces[surface], model_.expression_ops.data(),
                                           x[0] * cell_, x[1] * cell_, x[2] * cell_);
    Sample result{};
    result.value = s.value;
    result.gradient = {s.gradient[0] * cell_, s.gradient[1] * cell_, s.gradient[2] * cell_};
    const double squared = squared_length(result.gradient);
    result.valid = squared > 0 && squared < kMortiseInfinity && result.value - result.value == 0;
    return result;
}

bool Surfaces::is_plane(std::uint32_t surface) const {
    return model_.surfaces[surface].kind == kSurfacePlane;
}

std::uint32_t Surfaces::turn_at(const tape::Pole& pole, const Point& x) const {
    struct Crossing {
        double way;
        std::size_t surface;
    };
    std::vector<Crossing> crossings;
    std::size_t signs = 0;
    for (std::size_t i = 0; i < pole.through.size(); ++i) {
        const Sample s = sample(pole.through[i], x);
        const double rise = dot(s.gradient, {pole.normal[0], pole.normal[1], pole.normal[2]});
        const bool crosses = std::fabs(rise) > kUpright * length(s.gradient);
        if (crosses) crossings.push_back({-s.value / rise, i});
        if (crosses ? rise < 0 : s.value > 0) signs |= std::size_t{1} << i;
    }
    std::sort(crossings.begin(), crossings.end(),
              [](const Crossing& a, const Crossing& b) { return a.way < b.way; });
    std::uint32_t found = kNoTurn;
    for (const Crossing& c : crossings) {
        const std::int32_t before = pole.region[signs];
        signs ^= std::size_t{1} << c.surface;
        if (pole.region[signs] == before) continue;
        if (found != kNoTurn) return kNoTurn;
        found = pole.through[c.surface];
    }
    return found;
}

bool Surfaces::project(const std::uint32_t* surfaces, std::size_t count, double size, Point* x) const {
    double at[3] = {(*x)[0] * cell_, (*x)[1] * cell_, (*x)[2] * cell_};
    const double settled = std::max(kConverged * size, rounding_);
    const tape::ProjectionLimits limits = {kProjectionReach * size * cell_, kTangent, settled * cell_};
    if (!tape::project(model_, surfaces, count, limits, at)) return false;
    for (std::size_t j = 0; j < 3; ++j) (*x)[j] = at[j] / cell_;
    return true;
}

}  // namespace mortise::improve
