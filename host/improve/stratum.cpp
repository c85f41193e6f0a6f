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
constexpr double kTangent = 0.05;          ///< sine between gradients below which surfaces count as tangent
/// What Newton's method can reach, in edges of the root box: in finest cells of deep trees more than
/// kConverged.
constexpr int kRoundingBits = 48;

/// Box-local distance, to first order, below which a surface's side of a point is not certain.
constexpr double kUncertain = 1e-9;

}  // namespace

std::vector<Tip> find_tips(const tape::BoundModel& model, int level) {
    std::vector<Tip> tips;
    std::vector<std::uint32_t> all(model.surfaces.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint32_t>(i);
    for (const std::uint32_t s : all) {
        double x[3];
        if (!tape::singular_point(model.surfaces[s], x)) continue;
        if (!(std::min({x[0], x[1], x[2]}) >= 0 && std::max({x[0], x[1], x[2]}) <= 1)) continue;
        std::vector<std::int8_t> signs(all.size());
        for (const std::uint32_t other : all) {
            const SurfaceSample sample =
                surface_sample(&model.surfaces[other], model.expression_ops.data(), x[0], x[1], x[2]);
            const double norm = length({sample.gradient[0], sample.gradient[1], sample.gradient[2]});
            signs[other] = static_cast<std::int8_t>(std::fabs(sample.value) <= kUncertain * norm ? 0
                                                    : sample.value < 0                           ? -1
                                                                                                 : 1);
        }
        signs[s] = -1;
        const std::int32_t inside =
            tape::resolve_signs(model.tape.data(), model.tape.size(), all.data(), all.size(), signs.data());
        signs[s] = 1;
        const std::int32_t outside =
            tape::resolve_signs(model.tape.data(), model.tape.size(), all.data(), all.size(), signs.data());
        // One of them may be unknown: a plane through the apex changes nothing there.
        if (inside == outside) continue;
        const double cells = std::ldexp(1.0, level);
        tips.push_back({s, {cells * x[0], cells * x[1], cells * x[2]}});
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

bool Surfaces::project(const std::uint32_t* surfaces, std::size_t count, double size, Point* x) const {
    double at[3] = {(*x)[0] * cell_, (*x)[1] * cell_, (*x)[2] * cell_};
    const double settled = std::max(kConverged * size, rounding_);
    const tape::ProjectionLimits limits = {kProjectionReach * size * cell_, kTangent, settled * cell_};
    if (!tape::project(model_, surfaces, count, limits, at)) return false;
    for (std::size_t j = 0; j < 3; ++j) (*x)[j] = at[j] / cell_;
    return true;
}

}  // namespace mortise::improve
