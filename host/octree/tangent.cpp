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
constexpr double kTouchReach = 16;  ///< from the leaf's centre to where two surfaces touch
constexpr double kFarApart = 2;     ///< distance of one surface from the foot on the other
constexpr double kSteep = 0.7;      ///< sine between their normals there
constexpr double kTouch = 4e-5;     ///< distance where they touch
constexpr double kParallel = 1e-5;  ///< sine between their normals there
constexpr double kCrossing = 0.1;   ///< sine between surfaces that cross
constexpr double kNear = 0.75;      ///< from the leaf's centre, along each axis
constexpr double kFilm = 1e-4;      ///< what is thinner is no part of the solid
constexpr double kStep = 1e-3;      ///< lower ones, at the end of an overlap, are not meshed
constexpr double kDifference = 1e-3;
constexpr double kDamping = 1e-6;       ///< of steps towards the contact
constexpr double kLeastDamping = 1e-9;  ///< where they touch already, but for their normals
constexpr double kAlmost = 1e-3;        ///< sine between these
constexpr int kSteps = 16;
constexpr double kAround = 1.5;  ///< samples are taken so far from the leaf's centre, along each axis
constexpr int kSamples = 7;      ///< along each axis
constexpr int kMostRewrites = 4;

/// Two surfaces that touch each other.
struct Contact {
    std::size_t a;
    std::size_t b;
    bool negated;  ///< they have opposite insides
    /// Whether the choice that has b's other side with this one of a does not occur in the leaf, nor in those
    /// that touch it.
    bool excludes;
    bool inside_a;

    bool rules_out(std::uint32_t choice) const {
        const bool is_inside_a = ((choice >> a) & 1u) != 0, is_inside_b = ((choice >> b) & 1u) != 0;
        return excludes && is_inside_a == inside_a && is_inside_b == (inside_a == negated);
    }
};

/// Two parallel planes between which two surfaces are one, but for a film: parts made to overlap by a little.
struct Overlap {
    Contact planes;
    Contact surfaces;

    bool rules_out(std::uint32_t choice) const {
        const auto side = [choice](std::size_t s) { return ((choice >> s) & 1u) != 0; };
        // Between the planes is where no side is the one that is ruled out.
        const bool is_between =
            side(planes.a) != planes.inside_a && side(planes.b) != (planes.inside_a == planes.negated);
        return is_between && (side(surfaces.a) == side(surfaces.b)) == surfaces.negated;
    }
};

class TangentFinder {
  public:
    TangentFinder(const tape::BoundModel& model, const LeafBox& leaf, const LeafFormula& formula)
        : model_(model), leaf_(leaf), formula_(formula) {}

    /// Whether two surfaces touch each other, and what that leaves out.
    std::optional<Contact> find(std::size_t a, std::size_t b) const {
        const std::int32_t kinds[2] = {surface(a).kind, surface(b).kind};
        if (kinds[0] == kSurfacePlane && kinds[1] == kSurfacePlane) return std::nullopt;
        // Formulas may have kinks, and patches end somewhere: samples do not tell.
        for (const std::int32_t kind : kinds) {
            if (kind == kSurfaceExpression || kind == kSurfacePatch) return std::nullopt;
        }
        double scale_a = 0;
        double scale_b = 0;
        if (!find_contact(a, b, scale_a, scale_b)) return std::nullopt;
        const bool negated = scale_b < 0;
        const Contact touching = {a, b, negated, false, false};
        // Normalised at the contact, the two differ by terms of second order, which have one sign or not; in
        // the leaves around, too: there it may be the other surface that changes nothing, and an edge between
        // would be left without either. Where the two are one in the leaf itself, leaves on both sides of it
        // could take different ones, so both stay.
        double low = kMortiseInfinity;
        double high = -kMortiseInfinity;
        double inside = 0;  // the largest difference in the leaf
        for (int i = 0; i < kSamples * kSamples * kSamples; ++i) {
            const Vec3 x = sample_point(i);
            const double difference = (scale_a * value(a, x) - scale_b * value(b, x)) / leaf_.edge;
            low = std::min(low, difference);
            high = std::max(high, difference);
            bool within = true;
            for (const int k : sample_place(i))
                within = within && std::abs(2 * k - (kSamples - 1)) <= kSamples / 3;
            if (within) inside = std::max(inside, std::fabs(difference));
        }
        if (inside <= kFilm) {
            // A plane that touches a convex solid has all of it on one side: that holds for every leaf.
            const bool a_rounded = kinds[0] == kSurfaceRounded;
            if (!(a_rounded && kinds[1] == kSurfacePlane) &&
                !(kinds[0] == kSurfacePlane && kinds[1] == kSurfaceRounded))
                return touching;
            return Contact{a, b, negated, true, a_rounded || negated};
        }
        if (low >= -kFilm && high > kFilm) return Contact{a, b, negated, true, true};
        if (high <= kFilm && low < -kFilm) return Contact{a, b, negated, true, false};
        return touching;
    }

    /// What two parallel planes leave out.
    std::optional<Contact> find_parallel(std::size_t a, std::size_t b) const {
        if (surface(a).kind != kSurfacePlane || surface(b).kind != kSurfacePlane) return std::nullopt;
        Sample at_a;
        Sample at_b;
        if (!sample(a, leaf_.centre, at_a) || !sample(b, leaf_.centre, at_b)) return std::nullopt;
        const Vec3 turn = cross(at_a.normal, at_b.normal);
        const bool negated = dot(at_a.normal, at_b.normal) < 0;
        const double apart = at_a.distance - (negated ? -at_b.distance : at_b.distance);
        if (!(std::sqrt(dot(turn, turn)) * kTouchReach < std::fabs(apart))) return std::nullopt;
        return Contact{a, b, negated, true, apart > 0};
    }

    /// Whether two surfaces that touch are one between two parallel planes, in the leaf and around it.
    bool are_one_between(const Contact& planes, const Contact& surfaces) const {
        double scale_a = 0;
        double scale_b = 0;
        if (!find_contact(surfaces.a, surfaces.b, scale_a, scale_b)) return false;
        for (const std::size_t plane : {planes.a, planes.b}) {
            Sample centre;
            if (!sample(plane, leaf_.centre, centre) || std::fabs(centre.distance) > kFarApart) return false;
            for (int i = 0; i < kSamples * kSamples * kSamples; ++i) {
                Vec3 x = sample_point(i);
                Sample at;
                if (!sample(plane, x, at)) return false;
                for (std::size_t j = 0; j < 3; ++j) x[j] -= at.distance * leaf_.edge * at.normal[j];
                const double difference = scale_a * value(surfaces.a, x) - scale_b * value(surfaces.b, x);
                if (!(std::fabs(difference) <= kStep * leaf_.edge)) return false;
            }
        }
        return true;
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
                const bool certain = std::min(std::fabs(a.distance), std::fabs(b.distance)) > kStep;
                if (certain && ((a.distance < 0) != (b.distance < 0)) != negated) return false;
            }
            for (const bool first : {true, false}) {
                at = start;
                if (!foot({chooser, first ? inside : outside}, at)) continue;
                if (!sample(first ? outside : inside, at, b) || std::fabs(b.distance) > kStep) return false;
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

    /// Samples in the leaf and around it.
    static std::array<int, 3> sample_place(int i) {
        return {i % kSamples, i / kSamples % kSamples, i / (kSamples * kSamples)};
    }
    Vec3 sample_point(int i) const {
        const std::array<int, 3> place = sample_place(i);
        Vec3 x;
        for (std::size_t j = 0; j < 3; ++j)
            x[j] = leaf_.centre[j] + kAround * leaf_.edge * (2 * place[j] / (kSamples - 1.0) - 1);
        return x;
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
        Vec3 x = leaf_.centre;
        const std::uint32_t first = formula_.surfaces()[a];
        const tape::ProjectionLimits limits = {kFarApart * leaf_.edge, 0.5, 1e-6 * leaf_.edge};
        if (!tape::project(model_, &first, 1, limits, x.data())) return false;
        Residual now;
        if (!residual(a, b, x, now)) return false;
        if (std::fabs(now[1]) > kFarApart || sine(now) > kSteep) return false;
        for (int i = 0; i < 2 * kSteps && !touches(now); ++i) {
            // Where the surfaces bend away from each other ever less (the top of a bent pipe), the usual
            // damping leaves little of the steps.
            if (i == kSteps && !(std::fabs(now[0]) + std::fabs(now[1]) < kTouch && sine(now) < kAlmost))
                return false;
            Vec3 move;
            if (!gauss_step(a, b, x, now, i < kSteps ? kDamping : kLeastDamping, move)) return false;
            for (std::size_t j = 0; j < 3; ++j) {
                x[j] += leaf_.edge * move[j];
                if (!(std::fabs(x[j] - leaf_.centre[j]) < kTouchReach * leaf_.edge)) return false;
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
    bool gauss_step(std::size_t a, std::size_t b, const Vec3& x, const Residual& now, double damping,
                    Vec3& move) const {
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
            m[j][j] += damping;
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
std::array<LeafFormula::Substitution, 2> substitutions(const Contact& pair) {
    return {{{pair.a, pair.b, pair.negated}, {pair.b, pair.a, pair.negated}}};
}

/// What is known of the surfaces of a leaf.
struct Relations {
    std::vector<Contact> contacts;  ///< of surfaces that touch
    std::vector<Contact> planes;    ///< parallel ones
    std::vector<Overlap> overlaps;

    bool occurs(std::uint32_t choice) const {
        const auto rules_out = [choice](const auto& relation) { return relation.rules_out(choice); };
        return std::none_of(contacts.begin(), contacts.end(), rules_out) &&
               std::none_of(planes.begin(), planes.end(), rules_out) &&
               std::none_of(overlaps.begin(), overlaps.end(), rules_out);
    }
};

Relations find_relations(const TangentFinder& finder, std::size_t count) {
    Relations found;
    for (std::size_t a = 0; a < count; ++a) {
        for (std::size_t b = a + 1; b < count; ++b) {
            if (const auto contact = finder.find(a, b)) found.contacts.push_back(*contact);
            if (const auto planes = finder.find_parallel(a, b)) found.planes.push_back(*planes);
        }
    }
    for (const Contact& planes : found.planes) {
        for (const Contact& surfaces : found.contacts) {
            if (finder.are_one_between(planes, surfaces)) found.overlaps.push_back({planes, surfaces});
        }
    }
    return found;
}

/// Lets one surface stand for another in the whole leaf, if there is such a pair.
bool replace_one(LeafFormula& formula, const Relations& known) {
    const auto replaces = [&](const Contact& pair) {
        for (const auto& s : substitutions(pair)) {
            if (!pair.excludes ||
                !formula.allows(s, [&](std::uint32_t choice) { return known.occurs(choice); }))
                continue;
            formula.substitute(s);
            return true;
        }
        return false;
    };
    return std::any_of(known.contacts.begin(), known.contacts.end(), replaces) ||
           std::any_of(known.planes.begin(), known.planes.end(), replaces);
}

/// Calls visit(inside, outside) where one surface may stand for the other inside a chooser, and the other way
/// round outside, until it returns true.
template <class Visit>
bool any_choice(const LeafFormula& formula, const Relations& known, const Contact& pair, std::size_t chooser,
                const Visit& visit) {
    if (chooser == pair.a || chooser == pair.b) return false;
    const auto allows = [&](const LeafFormula::Substitution& s, bool inside) {
        return formula.allows(s, [&](std::uint32_t choice) {
            return (((choice >> chooser) & 1u) != 0) == inside && known.occurs(choice);
        });
    };
    const auto ways = substitutions(pair);
    for (const std::size_t first : {0, 1}) {
        const auto& inside = ways[first];
        const auto& outside = ways[1 - first];
        if (allows(inside, true) && allows(outside, false) && visit(inside, outside)) return true;
    }
    return false;
}

/// Makes one change, if there is one. Joints name surfaces by their number in the model, as places in the
/// formula change.
bool rewrite(LeafFormula& formula, const Relations& known, std::vector<Joint>& joints) {
    if (replace_one(formula, known)) return true;
    for (const Contact& pair : known.contacts) {
        for (std::size_t chooser = 0; chooser < formula.count(); ++chooser) {
            const auto choose = [&](const auto& inside, const auto& outside) {
                const auto& surface = formula.surfaces();
                const Joint joint = {surface[chooser], surface[inside.by], surface[outside.by],
                                     inside.negated};
                const bool is_known = std::find(joints.begin(), joints.end(), joint) != joints.end();
                if (!is_known) joints.push_back(joint);
                // Where the formula is like that already, the joint may still be one.
                return pair.excludes && formula.choose(chooser, inside, outside);
            };
            if (any_choice(formula, known, pair, chooser, choose)) return true;
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
        const Relations known = find_relations(finder, formula.count());
        if (known.contacts.empty() || !rewrite(formula, known, joints)) break;
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
    return changed || !joint.tape.empty();
}

}  // namespace mortise::octree
