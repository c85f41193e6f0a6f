#include "host/common/rounded_parts.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/constants.hpp"
#include "host/common/vec3.hpp"

namespace mortise {
namespace {

using Shape = RoundedSolid::Shape;

constexpr double kInside = 1e-9;  ///< of the solid's size: a ball that sticks out less from another is inside
constexpr double kLeastArc = 1e-6;     ///< radians: what a shorter arc would add is of second order
constexpr double kSameNormal = 1e-14;  ///< squared difference of normals of one facet
constexpr double kNoDifference = 1e-12;

/// Angles of a circle that no half-plane excludes.
class AllowedAngles {
  public:
    /// Keeps only angles where a cos + b sin <= c. `size`: of the numbers that c was computed from.
    void require(double a, double b, double c, double size) {
        const double m = std::hypot(a, b);
        if (c >= m - kNoDifference * size) return;
        if (c <= -m) {
            none_ = true;
            return;
        }
        const double middle = std::atan2(b, a);
        const double half = std::acos(c / m);
        double low = middle - half;
        low -= kTurn * std::floor(low / kTurn);
        const double high = low + 2 * half;
        excluded_.push_back({low, std::min(high, kTurn)});
        if (high > kTurn) excluded_.push_back({0, high - kTurn});
    }

    struct Arc {
        double middle;
        double half;
    };
    std::vector<Arc> arcs() {
        if (none_) return {};
        if (excluded_.empty()) return {{0, kTurn / 2}};
        std::sort(excluded_.begin(), excluded_.end());
        std::vector<Arc> result;
        double end = excluded_.front()[1];
        const auto add = [&result](double low, double high) {
            if (high - low > kLeastArc) result.push_back({(low + high) / 2, (high - low) / 2});
        };
        for (const auto& range : excluded_) {
            add(end, range[0]);
            end = std::max(end, range[1]);
        }
        // Round once to where the first excluded range begins.
        add(end, kTurn + excluded_.front()[0]);
        return result;
    }

  private:
    std::vector<std::array<double, 2>> excluded_;
    bool none_ = false;
};

class Taker {
  public:
    explicit Taker(const RoundedSolid& solid) : flat_(solid.shape != Shape::kHull) {
        std::vector<Ball> all = solid.balls;
        for (Ball& ball : all) {
            if (flat_) ball.center[2] = 0;
        }
        if (solid.shape == Shape::kRevolution) {
            for (const Ball& ball : solid.balls)
                all.push_back({{-ball.center[0], ball.center[1], 0}, ball.radius});
        }
        for (const Ball& ball : all) size_ = std::max(size_, length(ball.center) + ball.radius);
        parts_.reach = size_;
        std::stable_sort(all.begin(), all.end(),
                         [](const Ball& a, const Ball& b) { return a.radius > b.radius; });
        for (const Ball& ball : all) {
            const bool inside = std::any_of(parts_.balls.begin(), parts_.balls.end(), [&](const Ball& other) {
                return length(difference(ball.center, other.center)) + ball.radius <=
                       other.radius + kInside * size_;
            });
            if (!inside) parts_.balls.push_back(ball);
        }
    }

    RoundedParts take() {
        const std::size_t count = parts_.balls.size();
        if (flat_) {
            for (std::size_t i = 0; i < count; ++i) take_disc(i);
        } else {
            for (std::size_t i = 0; i < count; ++i) {
                for (std::size_t j = i + 1; j < count; ++j) take_pair(i, j);
            }
            for (std::size_t i = 0; i < count; ++i) take_ball(i);
        }
        return std::move(parts_);
    }

  private:
    const Ball& ball(std::size_t i) const { return parts_.balls[i]; }

    void add_facet(const Vec3& normal) {
        for (const auto& facet : parts_.facets) {
            const Vec3 apart = difference(facet.normal, normal);
            if (dot(apart, apart) < kSameNormal) return;
        }
        double support = -HUGE_VAL;
        for (const Ball& b : parts_.balls) support = std::max(support, dot(normal, b.center) + b.radius);
        parts_.facets.push_back({normal, support});
    }

    /// Arcs of directions along * axis + across * (x cos + y sin), and the facets at their ends.
    void add_arcs(std::size_t i, std::size_t other, const Vec3& axis, double along, const Vec3& x,
                  const Vec3& y, AllowedAngles& angles) {
        const double across = std::sqrt((1 - along) * (1 + along));
        const auto at = [&](double angle) {
            return sum(scaled(x, std::cos(angle)), scaled(y, std::sin(angle)));
        };
        for (const auto& arc : angles.arcs()) {
            const bool whole = arc.half >= kTurn / 2;
            parts_.arcs.push_back({i, other, axis, along, across, whole ? Vec3{} : at(arc.middle),
                                   whole ? -1 : std::cos(arc.half)});
            for (const double end : {arc.middle - arc.half, arc.middle + arc.half}) {
                if (whole) continue;
                const Vec3 normal = sum(scaled(axis, along), scaled(at(end), across));
                add_facet(scaled(normal, 1 / length(normal)));
            }
        }
    }

    void take_disc(std::size_t i) {
        AllowedAngles angles;
        for (std::size_t k = 0; k < parts_.balls.size(); ++k) {
            if (k == i) continue;
            const Vec3 to = difference(ball(k).center, ball(i).center);
            angles.require(to[0], to[1], ball(i).radius - ball(k).radius, size_);
        }
        add_arcs(i, i, {0, 0, 1}, 0, {1, 0, 0}, {0, 1, 0}, angles);
    }

    void take_pair(std::size_t i, std::size_t j) {
        const Vec3 to = difference(ball(j).center, ball(i).center);
        const double apart = length(to);
        const Vec3 axis = scaled(to, 1 / apart);
        const double along = std::clamp((ball(i).radius - ball(j).radius) / apart, -1.0, 1.0);
        const double across = std::sqrt((1 - along) * (1 + along));
        // The coordinate axis that is least along the pair's.
        Vec3 beside{};
        std::size_t least = 0;
        for (std::size_t k = 1; k < 3; ++k) {
            if (std::fabs(axis[k]) < std::fabs(axis[least])) least = k;
        }
        beside[least] = 1;
        Vec3 x = cross(axis, beside);
        x = scaled(x, 1 / length(x));
        const Vec3 y = cross(axis, x);
        AllowedAngles angles;
        for (std::size_t k = 0; k < parts_.balls.size(); ++k) {
            if (k == i || k == j) continue;
            const Vec3 d = difference(ball(k).center, ball(i).center);
            angles.require(across * dot(x, d), across * dot(y, d),
                           ball(i).radius - ball(k).radius - along * dot(axis, d), size_);
        }
        add_arcs(i, j, axis, along, x, y, angles);
    }

    /// The part of a ball that no other ball hides: towards those with which it shares an arc, or, as
    /// directions that balls of other radii hide need not be convex, towards all.
    void take_ball(std::size_t i) {
        RoundedParts::Cap cap;
        cap.ball = i;
        const bool alike = ball(0).radius - parts_.balls.back().radius <= kInside * size_;
        bool shares = parts_.balls.size() == 1;
        std::vector<bool> beside(parts_.balls.size(), !alike);
        for (const auto& arc : parts_.arcs) {
            if (arc.ball != i && arc.other != i) continue;
            shares = true;
            beside[arc.ball == i ? arc.other : arc.ball] = true;
        }
        if (!shares) return;
        for (std::size_t k = 0; k < parts_.balls.size(); ++k) {
            if (k == i || !beside[k]) continue;
            const Vec3 to = difference(ball(k).center, ball(i).center);
            const double apart = length(to);
            cap.axes.push_back(scaled(to, 1 / apart));
            cap.along.push_back((ball(i).radius - ball(k).radius) / apart);
        }
        parts_.caps.push_back(std::move(cap));
    }

    bool flat_;
    double size_ = 0;
    RoundedParts parts_;
};

}  // namespace

RoundedParts rounded_parts(const RoundedSolid& solid) {
    RoundedParts parts = Taker(solid).take();
    if (solid.shape == Shape::kPlate) {
        const double height = std::max(std::fabs(solid.low), std::fabs(solid.high));
        parts.reach = std::hypot(parts.reach, height) + solid.rounding;
    }
    return parts;
}

}  // namespace mortise
