#include "host/octree/tangent.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "host/common/vec3.hpp"
#include "host/tape/projection.hpp"

namespace mortise::octree {
namespace {

// Lengths in edges of the leaf.
constexpr double kReach = 16;       ///< from the leaf's centre to where two surfaces touch
constexpr double kFarApart = 2;     ///< distance of one surface from the foot on the other
constexpr double kSteep = 0.7;      ///< sine between their normals there
constexpr double kTouch = 4e-6;     ///< distance where they touch
constexpr double kParallel = 1e-6;  ///< sine between their normals there
constexpr double kCrossing = 0.1;   ///< sine between surfaces that cross
constexpr double kNear = 0.75;      ///< from the leaf's centre, along each axis
constexpr double kFilm = 1e-5;      ///< what is thinner is no part of the solid
constexpr double kDifference = 1e-3;
constexpr double kDamping = 1e-6;
constexpr int kSteps = 16;
constexpr double kAround = 1.5;  ///< samples are taken so far from the leaf's centre, along each axis
constexpr int kSamples = 7;      ///< along each axis
constexpr int kMostRewrites = 4;

/// A choice of sides of two surfaces that does not occur in the leaf, nor in those that touch it.
struct Excluded {
    std::size_t a;
    std::size_t b;
    bool inside_a;
    bool inside_b;

    bool holds(std::uint32_t choice) const {
        return (((choice >> a) & 1u) != 0) == inside_a && (((choice >> b) & 1u) != 0) == inside_b;
    }
};

class TangentFinder {
  public:
    TangentFinder(const tape::BoundModel& model, const LeafBox& leaf, const LeafFormula& formula)
        : model_(model), leaf_(leaf), formula_(formula) {}

    /// What two surfaces that touch each other leave out.
    std::optional<Excluded> find(std::size_t a, std::size_t b) const {
        const std::int32_t kinds[2] = {surface(a).kind, surface(b).kind};
        if (kinds[0] == kSurfacePlane && kinds[1] == kSurfacePlane) return std::nullopt;
        // Formulas may have kinks, and patches end somewhere: samples do not tell.
        for (const std::int32_t kind : kinds) {
            if (kind == kSurfaceExpression || kind == kSurfacePatch) return std::nullopt;
        }
        double scale_a = 0;
        double scale_b = 0;
        if (!find_contact(a, b, scale_a, scale_b)) return std::nullopt;
        // Normalised at the contact, the two differ by terms of second order, which have one sign or not; in
        // the leaves around, too: there it may be the other surface that changes nothing, and an edge between
        // would be left without either. Where the two are one in the leaf itself, leaves on both sides of it
        // could take different ones, so both stay.
        double low = kMortiseInfinity;
        double high = -kMortiseInfinity;
        double inside = 0;  // the largest difference in the leaf
        for (int i = 0; i < kSamples * kSamples * kSamples; ++i) {
            const int step[3] = {i % kSamples, i / kSamples % kSamples, i / (kSamples * kSamples)};
            Vec3 x;
            for (std::size_t j = 0; j < 3; ++j)
                x[j] = leaf_.centre[j] + kAround * leaf_.edge * (2 * step[j] / (kSamples - 1.0) - 1);
            const double difference = (scale_a * value(a, x) - scale_b * value(b, x)) / leaf_.edge;
            low = std::min(low, difference);
            high = std::max(high, difference);
            bool within = true;
            for (const int k : step) within = within && std::abs(2 * k - (kSamples - 1)) <= kSamples / 3;
            if (within) inside = std::max(inside, std::fabs(difference));
        }
        const bool same_way = scale_b > 0;
        if (inside <= kFilm) {
            // A plane that touches a convex solid has all of it on one side: that holds for every leaf.
            const bool a_rounded = kinds[0] == kSurfaceRounded;
            if (!(a_rounded && kinds[1] == kSurfacePlane) &&
                !(kinds[0] == kSurfacePlane && kinds[1] == kSurfaceRounded))
                return std::nullopt;
            if (a_rounded || !same_way) return Excluded{a, b, true, !same_way};
            return Excluded{a, b, false, same_way};
        }
        if (low >= -kFilm && high > kFilm) return Excluded{a, b, true, !same_way};
        if (high <= kFilm && low < -kFilm) return Excluded{a, b, false, same_way};
        return std::nullopt;
    }

    /// Whether the solid's boundary passes the chooser from one surface of a joint to the other: there, both
    /// end alike.
    bool goes_on(std::size_t chooser, std::size_t inside, std::size_t outside, bool negated) const {
        for (int corner = 0; corner <= 8; ++corner) {
            Vec3 start;
            for (std::size_t j = 0; j < 3; ++j) {
                const double half = corner == 8 ? 0 : ((corner >> j) & 1) != 0 ? 0.5 : -0.5;
                start[j] = leaf_.centre[j] + half * leaf_.edge;
            }
            Vec3 at = start;
            Sample a;
            Sample b;
            if (foot({chooser}, at) && sample(inside, at, a) && sample(outside, at, b)) {
                const bool certain = std::min(std::fabs(a.distance), std::fabs(b.distance)) > kFilm;
                if (certain && ((a.distance < 0) != (b.distance < 0)) != negated) return false;
            }
            for (const bool first : {true, false}) {
                at = start;
                if (!foot({chooser, first ? inside : outside}, at)) continue;
                if (!sample(first ? outside : inside, at, b) || std::fabs(b.distance) > kFilm) return false;
            }
        }
        return true;
    }

  private:
    /// Moves a point onto surfaces; false if it then is not near the leaf.
    bool foot(const std::vector<std::size_t>& surfaces, Vec3& x) const {
        std::vector<std::uint32_t> on;
        for (const std::size_t s : surfaces) on.push_back(formula_.surfaces()[s]);
        const tape::ProjectionLimits limits = {kFarApart * leaf_.edge, kCrossing, 1e-9 * leaf_.edge};
        if (!tape::project(model_, on.data(), on.size(), limits, x.data())) return false;
        bool near = true;
        for (std::size_t j = 0; j < 3; ++j)
            near = near && std::fabs(x[j] - leaf_.centre[j]) < kNear * leaf_.edge;
        return near;
    }

    const Surface& surface(std::size_t s) const { return model_.surfaces[formula_.surfaces()[s]]; }
    double value(std::size_t s, const Vec3& x) const {
        return surface_value(&surface(s), model_.expression_ops.data(), x[0], x[1], x[2]);
    }

    struct Sample {
        double distance;  ///< in edges, to first order
        double slope;
        Vec3 normal;
    };
    bool sample(std::size_t s, const Vec3& x, Sample& out) const {
        const SurfaceSample at = surface_sample(&surface(s), model_.expression_ops.data(), x[0], x[1], x[2]);
        out.normal = {at.gradient[0], at.gradient[1], at.gradient[2]};
        out.slope = std::sqrt(dot(out.normal, out.normal));
        if (!(out.slope > 0 && out.slope < kMortiseInfinity)) return false;
        for (double& component : out.normal) component /= out.slope;
        out.distance = at.value / (out.slope * leaf_.edge);
        return std::isfinite(out.distance);
    }

    /// What vanishes where two surfaces touch: both distances, and the sine between the normals.
    using Residual = std::array<double, 5>;
    bool residual(std::size_t a, std::size_t b, const Vec3& x, Residual& out) const {
        Sample at_a;
        Sample at_b;
        if (!sample(a, x, at_a) || !sample(b, x, at_b)) return false;
        const Vec3 turn = cross(at_a.normal, at_b.normal);
        out = {at_a.distance, at_b.distance, turn[0], turn[1], turn[2]};
        return true;
    }

    /// Finds where two surfaces touch by Gauss and Newton's method, from the foot of the leaf's centre; and
    /// factors that make both gradients there the same unit vector.
    bool find_contact(std::size_t a, std::size_t b, double& scale_a, double& scale_b) const {
        Vec3 x = {leaf_.centre[0], leaf_.centre[1], leaf_.centre[2]};
        const std::uint32_t first = formula_.surfaces()[a];
        const tape::ProjectionLimits limits = {kFarApart * leaf_.edge, 0.5, 1e-6 * leaf_.edge};
        if (!tape::project(model_, &first, 1, limits, x.data())) return false;
        Residual now;
        if (!residual(a, b, x, now)) return false;
        if (std::fabs(now[1]) > kFarApart || sine(now) > kSteep) return false;
        for (int i = 0; i < kSteps && !touches(now); ++i) {
            Vec3 move;
            if (!gauss_step(a, b, x, now, move)) return false;
            for (std::size_t j = 0; j < 3; ++j) {
                x[j] += leaf_.edge * move[j];
                if (!(std::fabs(x[j] - leaf_.centre[j]) < kReach * leaf_.edge)) return false;
            }
            if (!residual(a, b, x, now)) return false;
        }
        Sample at_a;
        Sample at_b;
        if (!touches(now) || !sample(a, x, at_a) || !sample(b, x, at_b)) return false;
        scale_a = 1 / at_a.slope;
        scale_b = (dot(at_a.normal, at_b.normal) > 0 ? 1 : -1) / at_b.slope;
        return true;
    }

    static double sine(const Residual& r) { return std::sqrt(r[2] * r[2] + r[3] * r[3] + r[4] * r[4]); }
    static bool touches(const Residual& r) {
        return std::fabs(r[0]) + std::fabs(r[1]) < kTouch && sine(r) < kParallel;
    }

    /// The step of least length, in edges, that makes the linearised residual least.
    bool gauss_step(std::size_t a, std::size_t b, const Vec3& x, const Residual& now, Vec3& move) const {
        double rows[5][3];
        for (std::size_t j = 0; j < 3; ++j) {
            Vec3 beside = x;
            beside[j] += kDifference * leaf_.edge;
            Residual other;
            if (!residual(a, b, beside, other)) return false;
            for (std::size_t i = 0; i < 5; ++i) rows[i][j] = (other[i] - now[i]) / kDifference;
        }
        double m[3][4] = {};
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t k = 0; k < 3; ++k) {
                for (const auto& row : rows) m[j][k] += row[j] * row[k];
            }
            m[j][j] += kDamping;
            for (std::size_t i = 0; i < 5; ++i) m[j][3] -= rows[i][j] * now[i];
        }
        // Positive definite: no pivoting.
        for (std::size_t j = 0; j < 3; ++j) {
            if (!(m[j][j] > 0)) return false;
            for (std::size_t i = j + 1; i < 3; ++i) {
                const double factor = m[i][j] / m[j][j];
                for (std::size_t k = j; k < 4; ++k) m[i][k] -= factor * m[j][k];
            }
        }
        for (std::size_t j = 3; j-- > 0;) {
            double sum = m[j][3];
            for (std::size_t k = j + 1; k < 3; ++k) sum -= m[j][k] * move[k];
            move[j] = sum / m[j][j];
        }
        return true;
    }

    const tape::BoundModel& model_;
    const LeafBox& leaf_;
    const LeafFormula& formula_;
};

/// The two ways to let one of a pair stand for both.
std::array<LeafFormula::Substitution, 2> substitutions(const Excluded& pair) {
    const bool negated = pair.inside_a == pair.inside_b;
    return {{{pair.a, pair.b, negated}, {pair.b, pair.a, negated}}};
}

using Pairs = std::vector<Excluded>;

bool occurs(const Pairs& excluded, std::uint32_t choice) {
    return std::none_of(excluded.begin(), excluded.end(),
                        [choice](const Excluded& pair) { return pair.holds(choice); });
}

/// Lets one surface stand for another in the whole leaf, if there is such a pair.
bool replace_one(LeafFormula& formula, const Pairs& pairs) {
    for (const Excluded& pair : pairs) {
        for (const auto& s : substitutions(pair)) {
            if (!formula.allows(s, [&](std::uint32_t choice) { return occurs(pairs, choice); })) continue;
            formula.substitute(s);
            return true;
        }
    }
    return false;
}

/// The same on one side of a chooser, and the other way round beyond it. The joint names surfaces by their
/// number in the model, as places in the formula change.
bool choose_by(LeafFormula& formula, const Pairs& pairs, const Excluded& pair, std::size_t chooser,
               Joint& joint) {
    const auto allows = [&](const LeafFormula::Substitution& s, bool inside) {
        return formula.allows(s, [&](std::uint32_t choice) {
            return (((choice >> chooser) & 1u) != 0) == inside && occurs(pairs, choice);
        });
    };
    const auto ways = substitutions(pair);
    for (const std::size_t first : {0, 1}) {
        const auto& inside = ways[first];
        const auto& outside = ways[1 - first];
        if (!allows(inside, true) || !allows(outside, false)) continue;
        const auto& surface = formula.surfaces();
        joint = {surface[chooser], surface[inside.by], surface[outside.by], inside.negated};
        if (formula.choose(chooser, inside, outside)) return true;
    }
    return false;
}

/// Makes one change, if there is one.
bool rewrite(LeafFormula& formula, const Pairs& pairs, std::vector<Joint>& joints) {
    if (replace_one(formula, pairs)) return true;
    for (const Excluded& pair : pairs) {
        for (std::size_t chooser = 0; chooser < formula.count(); ++chooser) {
            Joint joint{};
            if (chooser == pair.a || chooser == pair.b) continue;
            if (!choose_by(formula, pairs, pair, chooser, joint)) continue;
            joints.push_back(joint);
            return true;
        }
    }
    return false;
}

}  // namespace

bool join_tangent(const tape::BoundModel& model, const LeafBox& leaf, LeafFormula& formula,
                  LeafJoint& joint) {
    bool changed = false;
    std::vector<Joint> joints;
    for (int i = 0; i < kMostRewrites; ++i) {
        const TangentFinder finder(model, leaf, formula);
        Pairs pairs;
        for (std::size_t a = 0; a < formula.count(); ++a) {
            for (std::size_t b = a + 1; b < formula.count(); ++b) {
                if (const auto pair = finder.find(a, b)) pairs.push_back(*pair);
            }
        }
        if (pairs.empty() || !rewrite(formula, pairs, joints)) break;
        changed = true;
    }
    const auto place = [&formula](std::uint32_t surface) {
        const auto& all = formula.surfaces();
        return static_cast<std::size_t>(std::find(all.begin(), all.end(), surface) - all.begin());
    };
    joint.tape.clear();
    for (const Joint& j : joints) {
        const std::size_t chooser = place(j.chooser);
        const LeafFormula::Substitution s = {place(j.outside), place(j.inside), j.negated};
        if (std::max({chooser, s.gone, s.by}) >= formula.count()) continue;
        if (!TangentFinder(model, leaf, formula).goes_on(chooser, s.by, s.gone, s.negated)) continue;
        joint.joint = j;
        joint.tape = formula.joined(s, chooser, kJointSurface);
        if (!joint.tape.empty()) break;
    }
    return changed;
}

}  // namespace mortise::octree
