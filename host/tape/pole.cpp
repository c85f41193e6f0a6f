#include "host/tape/pole.hpp"

#include <cmath>

#include "host/common/vec3.hpp"

namespace mortise::tape {
namespace {

constexpr int kPoleSteps = 20;
constexpr double kStartSine = 0.5;    ///< sine between the normals where the search begins
constexpr double kSettled = 1e-13;    ///< length of the last step
constexpr double kTouching = 1e-10;   ///< difference of the heights
constexpr double kDifference = 1e-4;  ///< step of differences, in reaches
/// -det H over the square of H's norm: 1/2 where the creases cross at right angles, 5e-4 at 2.6 degrees.
constexpr double kSaddle = 5e-4;
constexpr double kCurved = 1e-4;  ///< norm of H times the reach: less is flat

Vec3 along(const Vec3& from, double t, const Vec3& direction) {
    return {from[0] + t * direction[0], from[1] + t * direction[1], from[2] + t * direction[2]};
}

struct Slope {
    double u, v;
};

class PoleSearch {
  public:
    PoleSearch(const BoundModel& model, std::uint32_t first, std::uint32_t second, const Vec3& near,
               double reach)
        : model_(model), surface_{first, second}, near_(near), reach_(reach) {}

    bool run(Pole* pole) {
        if (!take_frame()) return false;
        double u = 0, v = 0;
        for (int step = 0; step < kPoleSteps; ++step) {
            Slope slope{}, more{}, less{};
            const double h = kDifference * reach_;
            if (!difference(u, v, &slope)) return false;
            if (!difference(u + h, v, &more) || !difference(u - h, v, &less)) return false;
            const double uu = (more.u - less.u) / (2 * h);
            double uv = (more.v - less.v) / (2 * h);
            if (!difference(u, v + h, &more) || !difference(u, v - h, &less)) return false;
            const double vv = (more.v - less.v) / (2 * h);
            uv = 0.5 * (uv + (more.u - less.u) / (2 * h));
            const double determinant = uu * vv - uv * uv;
            const double norm = uu * uu + 2 * uv * uv + vv * vv;
            if (!(-determinant > kSaddle * norm) || !(norm * reach_ * reach_ > kCurved * kCurved))
                return false;
            const double du = -(vv * slope.u - uv * slope.v) / determinant;
            const double dv = -(uu * slope.v - uv * slope.u) / determinant;
            u += du;
            v += dv;
            if (!(std::fabs(u) <= reach_ && std::fabs(v) <= reach_)) return false;
            if (std::fabs(du) + std::fabs(dv) < kSettled) break;
        }
        return finish(u, v, pole);
    }

  private:
    bool take_frame() {
        Vec3 normal[2];
        for (int i = 0; i < 2; ++i) {
            const SurfaceSample s = sample(i, near_);
            normal[i] = {s.gradient[0], s.gradient[1], s.gradient[2]};
            const double length = std::sqrt(dot(normal[i], normal[i]));
            // Too far away for the surface to pass within reach, to first order and then some.
            if (!(length > 0 && length < kMortiseInfinity && std::fabs(s.value) < 2 * reach_ * length))
                return false;
            for (double& x : normal[i]) x /= length;
        }
        const Vec3 turn = cross(normal[0], normal[1]);
        if (!(dot(turn, turn) < kStartSine * kStartSine)) return false;
        const double side = dot(normal[0], normal[1]) < 0 ? -1 : 1;
        normal_ = along(normal[0], side, normal[1]);
        const double length = std::sqrt(dot(normal_, normal_));
        for (double& x : normal_) x /= length;
        u_axis_ = cross(normal_, std::fabs(normal_[0]) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0});
        const double size = std::sqrt(dot(u_axis_, u_axis_));
        for (double& x : u_axis_) x /= size;
        v_axis_ = cross(normal_, u_axis_);
        return true;
    }

    SurfaceSample sample(int i, const Vec3& x) const {
        return surface_sample(&model_.surfaces[surface_[i]], model_.expression_ops.data(), x[0], x[1], x[2]);
    }

    /// Height of a surface over the plane, and its slope there.
    bool height(int i, double u, double v, double* t, Slope* slope) const {
        const Vec3 foot = along(along(near_, u, u_axis_), v, v_axis_);
        *t = 0;
        for (int step = 0; step < kPoleSteps; ++step) {
            const SurfaceSample s = sample(i, along(foot, *t, normal_));
            const Vec3 gradient = {s.gradient[0], s.gradient[1], s.gradient[2]};
            const double rise = dot(gradient, normal_);
            const double move = -s.value / rise;
            if (!std::isfinite(move)) return false;
            *slope = {-dot(gradient, u_axis_) / rise, -dot(gradient, v_axis_) / rise};
            *t += move;
            if (!(std::fabs(*t) <= 2 * reach_)) return false;
            if (std::fabs(move) < 0.1 * kSettled) return true;
        }
        return true;  // as near as rounding allows
    }

    /// Slope of the second surface over the first.
    bool difference(double u, double v, Slope* slope) const {
        Slope first{}, second{};
        double t = 0;
        if (!height(0, u, v, &t, &first) || !height(1, u, v, &t, &second)) return false;
        *slope = {second.u - first.u, second.v - first.v};
        return true;
    }

    bool finish(double u, double v, Pole* pole) const {
        Slope slope{};
        double first = 0, second = 0;
        if (!height(0, u, v, &first, &slope) || !height(1, u, v, &second, &slope)) return false;
        if (!(std::fabs(first - second) < kTouching)) return false;
        pole->surfaces = {std::min(surface_[0], surface_[1]), std::max(surface_[0], surface_[1])};
        pole->at = along(along(along(near_, u, u_axis_), v, v_axis_), 0.5 * (first + second), normal_);
        const SurfaceSample s = sample(0, pole->at);
        pole->normal = {s.gradient[0], s.gradient[1], s.gradient[2]};
        const double length = std::sqrt(dot(pole->normal, pole->normal));
        for (double& x : pole->normal) x /= length;
        return true;
    }

    const BoundModel& model_;
    std::uint32_t surface_[2];
    Vec3 near_;
    double reach_;
    Vec3 normal_{}, u_axis_{}, v_axis_{};
};

}  // namespace

bool find_pole(const BoundModel& model, std::uint32_t first, std::uint32_t second, const Vec3& near,
               double reach, Pole* pole) {
    const std::int32_t kinds[2] = {model.surfaces[first].kind, model.surfaces[second].kind};
    if (kinds[0] == kSurfacePatch || kinds[1] == kSurfacePatch) return false;
    if (kinds[0] == kSurfacePlane && kinds[1] == kSurfacePlane) return false;
    return PoleSearch(model, first, second, near, reach).run(pole);
}

}  // namespace mortise::tape
