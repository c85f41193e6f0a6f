#include "host/model/solids/extrusion.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/common/constants.hpp"
#include "host/model/affine.hpp"
#include "host/model/outlines/polygons.hpp"
#include "host/model/solids/sweep.hpp"
#include "host/model/solids/swept_outline.hpp"
#include "host/model/text.hpp"

namespace mortise::model_reader {
namespace {

/// Relative size below which a component of a normal, or a distance from the axis, is rounding.
constexpr double kRounding = 1e-12;
constexpr double kOnAxis = 1e-9;
/// By how much of its extent a prism exceeds its height at either end: a cell of level 4.
constexpr double kBeyond = 1.0 / 16;
/// Part of the outer radius that a ring's hole has at least.
constexpr double kClearOfAxis = 0.02;

/// A number in a formula.
std::string in_formula(double value) { return "(" + number_text(value) + ")"; }

Vec2 direction(double degrees) { return {cosine_of_degrees(degrees), sine_of_degrees(degrees)}; }

/// The longer edge of the box around loops; there is one at least.
double width_of(const Contours& loops) {
    Box2 box = {loops[0][0], loops[0][0]};
    for (const auto& loop : loops) {
        for (const Vec2& p : loop) {
            for (std::size_t k = 0; k < 2; ++k) {
                box.min[k] = std::min(box.min[k], p[k]);
                box.max[k] = std::max(box.max[k], p[k]);
            }
        }
    }
    return std::max(box.max[0] - box.min[0], box.max[1] - box.min[1]);
}

Primitive rounded_of(const std::vector<Disc>& discs, RoundedSolid::Shape shape) {
    RoundedSolid solid;
    solid.shape = shape;
    for (const Disc& disc : discs) solid.balls.push_back({{disc.center[0], disc.center[1], 0}, disc.radius});
    return rounded(std::move(solid));
}

class LinearBuilder final : public Sweep {
  public:
    LinearBuilder(Model& model, const LinearSweep& sweep, const std::string& name, SourceLocation where)
        : Sweep(model, name, where), sweep_(sweep) {
        for (std::size_t k = 0; k < 2; ++k) growth_[k] = (sweep.scale[k] - 1) / sweep.height;
        uniform_ = sweep.scale[0] == sweep.scale[1];
        if (sweep.twist == 0 && uniform_) return;
        // The point's coordinates divided by the scale, all times `level_`, the product of the scales.
        const std::string height = "(z-" + in_formula(sweep.base) + ")";
        const auto scale = [&](std::size_t k) {
            return sweep.scale[k] == 1 ? std::string("1")
                                       : "(1+" + in_formula(growth_[k]) + "*" + height + ")";
        };
        turn_ = in_formula(sweep.twist * kRadians / sweep.height) + "*" + height;
        level_ = uniform_ ? scale(0) : scale(0) + "*" + scale(1);
        x_ = uniform_ ? "x" : "x*" + scale(1);
        y_ = uniform_ ? "y" : "y*" + scale(0);
    }

  protected:
    /// Beyond top and bottom, which cut it: no two surfaces end at the same edge.
    std::optional<Piece> outline(const Contours& loops) override {
        if (loops.empty() || !wants_prism(loops, sweep_.smooth)) return std::nullopt;
        const double width = width_of(loops);
        const double beyond = kBeyond * std::max(sweep_.height, width);
        PrismSpan span;
        double below = beyond;
        double above = beyond;
        for (std::size_t k = 0; k < 2; ++k) {  // the scales stay positive
            if (growth_[k] > 0) below = std::min(below, 0.5 / growth_[k]);
            if (growth_[k] < 0) above = std::min(above, -0.5 * sweep_.scale[k] / growth_[k]);
        }
        span.low = sweep_.base - below;
        span.high = sweep_.base + sweep_.height + above;
        if (sweep_.twist != 0 || !uniform_) return rows(loops, span, width);
        span.low_scale = 1 - growth_[0] * below;
        span.high_scale = sweep_.scale[0] + growth_[0] * above;
        return node_of(
            prism(loops, span, outline_sharp_angle(loops, sweep_.smooth), [this] { return next_side(); }));
    }

    std::optional<Piece> rounded_outline(const std::vector<Disc>& discs) override {
        if (sweep_.twist != 0 || sweep_.scale != Vec2{1, 1}) return std::nullopt;
        return primitive(rounded_of(discs, RoundedSolid::Shape::kColumn), next_side());
    }

    Piece half_plane(const Vec2& normal, double offset, const std::string& side) override {
        if (sweep_.twist == 0) {
            const bool along_y = std::fabs(normal[0]) <= kRounding;
            const bool along_x = std::fabs(normal[1]) <= kRounding;
            if (uniform_ || along_x || along_y) {
                const double growth = growth_[along_y ? 1 : 0];
                return planes(
                    {{{normal[0], normal[1], -offset * growth}, offset * (1 - growth * sweep_.base), ""}},
                    side);
            }
            return expression(in_formula(normal[0]) + "*" + x_ + "+" + in_formula(normal[1]) + "*" + y_ +
                                  "-" + in_formula(offset) + "*" + level_,
                              side);
        }
        const double length = std::hypot(normal[0], normal[1]);
        const std::string angle = turn_ + "-" + in_formula(std::atan2(normal[1], normal[0]));
        return expression(x_ + "*cos(" + angle + ")-" + y_ + "*sin(" + angle + ")-" +
                              in_formula(offset / length) + "*" + level_,
                          side);
    }

    Piece circle(const FlatMap& map, double radius, const std::string& side) override {
        const Ellipse e = ellipse_of(map, radius);
        const bool central = e.round && e.centre == Vec2{0, 0};
        if (uniform_ && (sweep_.twist == 0 || central)) {
            const FlatMap flat = e.round ? FlatMap{1, 0, e.centre[0], 0, 1, e.centre[1]} : map;
            const double r = e.round ? e.radius : radius;
            // At the height z the centre is scaled, too: a shear.
            const double growth = growth_[0];
            const Affine place = {flat[0],
                                  flat[1],
                                  growth * flat[2],
                                  flat[2],
                                  flat[3],
                                  flat[4],
                                  growth * flat[5],
                                  flat[5],
                                  0,
                                  0,
                                  1,
                                  growth == 0 ? 0 : sweep_.base};
            return moved(place, primitive(growth == 0 ? infinite_cylinder(r) : cone(r, r * growth), side));
        }
        ends_at_apex_ = false;  // the squares forget the scale's sign
        std::string u = x_;
        std::string v = y_;
        if (sweep_.twist != 0) {
            const std::string cosine = "cos(" + turn_ + ")";
            const std::string sine = "sin(" + turn_ + ")";
            u = x_ + "*" + cosine + "-" + y_ + "*" + sine;
            v = x_ + "*" + sine + "+" + y_ + "*" + cosine;
        }
        u = "(" + u + "-" + in_formula(e.centre[0]) + "*" + level_ + ")";
        v = "(" + v + "-" + in_formula(e.centre[1]) + "*" + level_ + ")";
        std::string form = in_formula(e.xx) + "*" + u + "^2+" + in_formula(e.yy) + "*" + v + "^2";
        if (e.xy != 0) form += "+" + in_formula(2 * e.xy) + "*" + u + "*" + v;
        return expression(form + "-(" + level_ + ")^2", side);
    }

  private:
    /// What has curves and is not straight, in steps of a degree.
    std::optional<Piece> rows(const Contours& loops, const PrismSpan& span, double width) {
        if (outline_sharp_angle(loops, sweep_.smooth) == 0) return std::nullopt;
        if (sweep_.scale[0] == 0 || sweep_.scale[1] == 0) return std::nullopt;
        const double change =
            std::fabs(sweep_.twist) + std::fabs(sweep_.scale[0] - sweep_.scale[1]) / kRadians;
        OutlineRows rows;
        rows.count = 2 + static_cast<std::size_t>(std::ceil(change * (span.high - span.low) / sweep_.height));
        rows.twist = sweep_.twist * kRadians / sweep_.height;
        rows.place = [this, &span](const Vec2& p, std::size_t row, std::size_t count) {
            const double along = static_cast<double>(row) / static_cast<double>(count - 1);
            const double z = span.low + along * (span.high - span.low);
            const double height = z - sweep_.base;
            const Vec2 turned = direction(-sweep_.twist * height / sweep_.height);
            return Vec3{(p[0] * turned[0] - p[1] * turned[1]) * (1 + growth_[0] * height),
                        (p[0] * turned[1] + p[1] * turned[0]) * (1 + growth_[1] * height), z};
        };
        return node_of(swept_outline(loops, rows, width, sweep_.smooth, [this] { return next_side(); }));
    }

    LinearSweep sweep_;
    Vec2 growth_{};  ///< change of the scales per unit of z
    bool uniform_ = true;
    std::string turn_, level_, x_, y_;
};

class RotaryBuilder final : public Sweep {
  public:
    /// `facets`: outward normals of the flat steps, of length 1 / cos(half a step); empty: round.
    RotaryBuilder(Model& model, std::vector<Vec2> facets, double reach, const std::string& name,
                  SourceLocation where)
        : Sweep(model, name, where), facets_(std::move(facets)), reach_(reach) {}

  protected:
    /// What lies beyond the axis is cut away by others, and would be swept to the wrong side.
    void adjust(Contours& loops) const override {
        bool changed = false;
        Box2 box = {{0, HUGE_VAL}, {0, -HUGE_VAL}};
        for (auto& loop : loops) {
            for (Vec2& point : loop) {
                if (point[0] != 0 && std::fabs(point[0]) <= kOnAxis * reach_) {
                    point[0] = 0;
                    changed = true;
                }
                for (std::size_t k = 0; k < 2; ++k) {
                    box.min[k] = std::min(box.min[k], point[k]);
                    box.max[k] = std::max(box.max[k], point[k]);
                }
            }
        }
        if (changed) loops = normalised(loops);
        if (!(box.min[0] < 0)) return;
        FlatTree tree;
        const std::uint32_t all = tree.add_contours(loops);
        const std::uint32_t right = tree.add_contours({{{0, box.min[1] - reach_},
                                                        {box.max[0] + reach_, box.min[1] - reach_},
                                                        {box.max[0] + reach_, box.max[1] + reach_},
                                                        {0, box.max[1] + reach_}}});
        loops = to_contours(tree, tree.add_operation(FlatNode::Op::kIntersection, {all, right}));
    }

    std::optional<Piece> rounded_outline(const std::vector<Disc>& discs) override {
        const bool clear = std::all_of(discs.begin(), discs.end(), [](const Disc& disc) {
            return disc.center[0] - disc.radius > kClearOfAxis * (disc.center[0] + disc.radius);
        });
        if (!facets_.empty() || !clear) return std::nullopt;
        return primitive(rounded_of(discs, RoundedSolid::Shape::kRing), next_side());
    }

    /// Dozens of cones meet in a cell where a curve of a polygon is revolved.
    std::optional<Piece> outline(const Contours& loops) override {
        constexpr std::size_t kSteps = 360;  // chords are 4e-5 of the radius inside the circle
        if (!facets_.empty() || outline_sharp_angle(loops, true) == 0) return std::nullopt;
        OutlineRows rows;
        rows.is_ring = true;
        rows.count = kSteps;
        rows.place = [](const Vec2& p, std::size_t row, std::size_t count) {
            const Vec2 along = direction(-360.0 * static_cast<double>(row) / static_cast<double>(count));
            return Vec3{p[0] * along[0], p[0] * along[1], p[1]};
        };
        return node_of(swept_outline(loops, rows, width_of(loops), true, [this] { return next_side(); }));
    }

    Piece half_plane(const Vec2& normal, double offset, const std::string& side) override {
        const double a = normal[0];
        const double b = normal[1];
        if (std::fabs(a) <= kRounding) return planes({{{0, 0, b}, offset, ""}}, side);
        const bool vertical = std::fabs(b) <= kRounding;
        if (vertical && offset / a <= 0) {
            // The axis, or beyond: all of space or nothing.
            return {a < 0 ? Piece::State::kEverything : Piece::State::kNothing};
        }
        if (!facets_.empty()) {
            std::vector<Piece> steps;
            for (const Vec2& facet : facets_) {
                steps.push_back(planes({{{a * facet[0], a * facet[1], vertical ? 0 : b}, offset, ""}}, side));
            }
            return combine(a > 0 ? FlatNode::Op::kIntersection : FlatNode::Op::kUnion, std::move(steps));
        }
        if (vertical) {
            Piece inside = primitive(infinite_cylinder(offset / a), side);
            return a > 0 ? inside : complement(std::move(inside));
        }
        Primitive cone;
        cone.kind = Primitive::Kind::kCone;
        cone.radius = offset / a;
        cone.slope = -b / a;
        Piece inside = primitive(std::move(cone), side);
        return a > 0 ? inside : complement(std::move(inside));
    }

    Piece circle(const FlatMap& map, double radius, const std::string& side) override {
        Ellipse e = ellipse_of(map, radius);
        const double width = std::sqrt(e.yy / (e.xx * e.yy - e.xy * e.xy));
        if (std::fabs(e.centre[0]) <= kOnAxis * width) e.centre[0] = 0;
        if (e.centre[0] <= -width) return {};
        const Affine raised = translation({0, 0, e.centre[1]});
        if (e.round && e.centre[0] > 0) return moved(raised, primitive(torus(e.centre[0], e.radius), side));
        if (e.round && e.centre[0] == 0) return moved(raised, primitive(sphere(e.radius), side));
        if (e.centre[0] == 0 && std::fabs(e.xy) <= kRounding * std::max(e.xx, e.yy)) {
            const double across = 1 / std::sqrt(e.xx);
            const Affine place = {across, 0, 0, 0, 0, across, 0, 0, 0, 0, 1 / std::sqrt(e.yy), e.centre[1]};
            return moved(place, primitive(sphere(1), side));
        }
        const std::string u = "(sqrt(x^2+y^2)-" + in_formula(e.centre[0]) + ")";
        const std::string v = "(z-" + in_formula(e.centre[1]) + ")";
        std::string form = in_formula(e.xx) + "*" + u + "^2+" + in_formula(e.yy) + "*" + v + "^2";
        if (e.xy != 0) form += "+" + in_formula(2 * e.xy) + "*" + u + "*" + v;
        return expression(form + "-1", side);
    }

  private:
    std::vector<Vec2> facets_;
    double reach_;
};

/// One flat step of a sweep: along `facet`·(x, y) = 1 the profile is that at x = 1.
class StepBuilder final : public Sweep {
  public:
    StepBuilder(Model& model, const Vec2& facet, const std::string& name, SourceLocation where)
        : Sweep(model, name, where), facet_(facet) {}

  protected:
    Piece half_plane(const Vec2& normal, double offset, const std::string& side) override {
        return planes({{{normal[0] * facet_[0], normal[0] * facet_[1], normal[1]}, offset, ""}}, side);
    }

    Piece circle(const FlatMap& map, double radius, const std::string& side) override {
        const double square = facet_[0] * facet_[0] + facet_[1] * facet_[1];
        const Vec2 out = {facet_[0] / square, facet_[1] / square};
        const Affine place = from_columns({map[0] * out[0], map[0] * out[1], map[3]},
                                          {map[1] * out[0], map[1] * out[1], map[4]}, {-out[1], out[0], 0},
                                          {map[2] * out[0], map[2] * out[1], map[5]});
        return moved(place, primitive(infinite_cylinder(radius), side));
    }

  private:
    Vec2 facet_;
};

/// Between two angles, less than a full turn apart.
Piece wedge_between(Sweep& sweep, double from, double to) {
    const Vec2 first = direction(from);
    const Vec2 last = direction(to);
    std::vector<Piece> sides = {{Piece::State::kPlanes, {{{first[1], -first[0], 0}, 0, "start"}}},
                                {Piece::State::kPlanes, {{{-last[1], last[0], 0}, 0, "end"}}}};
    if (to - from == 180) sides.pop_back();
    return sweep.combine(to - from > 180 ? FlatNode::Op::kUnion : FlatNode::Op::kIntersection,
                         std::move(sides));
}

/// What a sweep from one angle to another of distances between `near` and `far` covers.
Box2 ring_bounds(double from, double to, double near, double far) {
    Box2 box = {{far, far}, {-far, -far}};
    const auto add = [&box](const Vec2& along, double distance) {
        for (std::size_t k = 0; k < 2; ++k) {
            box.min[k] = std::min(box.min[k], along[k] * distance);
            box.max[k] = std::max(box.max[k], along[k] * distance);
        }
    };
    for (const double angle : {from, to}) {
        add(direction(angle), near);
        add(direction(angle), far);
    }
    for (double axis = std::ceil(from / 90) * 90; axis <= to; axis += 90) add(direction(axis), far);
    return box;
}

std::uint32_t finish(Sweep& sweep, Model& model, std::vector<Piece> parts, const std::string& name,
                     const Box3& bounds, SourceLocation where) {
    const std::uint32_t node = sweep.to_node(sweep.combine(FlatNode::Op::kIntersection, std::move(parts)));
    CsgNode& top = model.nodes[node];
    // Only a node of this extrusion may carry its name.
    if (top.op == CsgNode::Op::kTransform || (top.op == CsgNode::Op::kPrimitive && !top.name.empty())) {
        CsgNode outer;
        outer.op = CsgNode::Op::kUnion;
        outer.children = {node};
        outer.name = name;
        outer.bounds = bounds;
        outer.where = where;
        return model.add(std::move(outer));
    }
    top.name = name;
    top.bounds = bounds;
    top.where = where;
    return node;
}

}  // namespace

std::optional<std::uint32_t> linear_extrusion(Model& model, const FlatTree& tree, std::uint32_t root,
                                              const LinearSweep& sweep, const std::string& name,
                                              SourceLocation where) {
    LinearBuilder builder(model, sweep, name, where);
    const Box2 flat = flat_bounds(tree, root);
    Piece profile = builder.sweep(tree, root);
    if (profile.state == Piece::State::kNothing || flat.is_empty()) return {};

    Box3 bounds;
    for (std::size_t k = 0; k < 2; ++k) {
        bounds.min[k] = std::min(flat.min[k], flat.min[k] * sweep.scale[k]);
        bounds.max[k] = std::max(flat.max[k], flat.max[k] * sweep.scale[k]);
    }
    if (sweep.twist != 0) {
        const double reach =
            std::hypot(std::max(-flat.min[0], flat.max[0]), std::max(-flat.min[1], flat.max[1]));
        for (std::size_t k = 0; k < 2; ++k) {
            bounds.max[k] = reach * std::max(1.0, sweep.scale[k]);
            bounds.min[k] = -bounds.max[k];
        }
    }
    const double top = sweep.base + sweep.height;
    bounds.min[2] = sweep.base;
    bounds.max[2] = top;

    std::vector<Plane> caps = {{{0, 0, -1}, -sweep.base, "bottom"}};
    // Where convex shapes shrink to nothing they have no top: the planes themselves end there.
    const double smaller = std::min(sweep.scale[0], sweep.scale[1]);
    const double larger = std::max(sweep.scale[0], sweep.scale[1]);
    const bool vanishes = smaller == 0 && (larger == 0 || larger >= 1) && builder.ends_at_apex();
    if (!vanishes) caps.push_back({{0, 0, 1}, top, "top"});
    std::vector<Piece> parts;
    parts.push_back(std::move(profile));
    parts.push_back({Piece::State::kPlanes, std::move(caps)});
    return finish(builder, model, std::move(parts), name, bounds, where);
}

std::optional<std::uint32_t> rotary_extrusion(Model& model, const FlatTree& tree, std::uint32_t root,
                                              const RotarySweep& sweep, const std::string& name,
                                              SourceLocation where) {
    const Box2 flat = flat_bounds(tree, root);
    if (flat.is_empty() || flat.max[0] <= 0) return {};
    const double angle = std::fabs(sweep.angle);
    const bool full = angle >= 360;
    const double from = sweep.angle < 0 ? sweep.start + sweep.angle : sweep.start;
    const double to = from + (full ? 360 : angle);

    std::vector<Vec2> facets;
    for (int j = 0; j < sweep.facets; ++j) {
        const double half = (to - from) / sweep.facets / 2;
        const Vec2 middle = direction(from + (2 * j + 1) * half);
        const double apothem = cosine_of_degrees(half);
        facets.push_back({middle[0] / apothem, middle[1] / apothem});
    }
    RotaryBuilder builder(model, facets, std::max(-flat.min[0], flat.max[0]), name, where);
    std::vector<Piece> parts;
    const bool clear_of_axis = flat.min[0] > kClearOfAxis * flat.max[0];
    if (sweep.facets != 0 && clear_of_axis) {
        // Step by step, so that a cell sees the surfaces of its own step only. At the axis it would see all.
        std::vector<Piece> steps;
        const double step = (to - from) / sweep.facets;
        for (std::size_t j = 0; j < facets.size(); ++j) {
            StepBuilder one(model, facets[j], name, where);
            std::vector<Piece> both;
            both.push_back(one.sweep(tree, root));
            both.push_back(
                wedge_between(one, from + static_cast<double>(j) * step,
                              j + 1 == facets.size() ? to : from + static_cast<double>(j + 1) * step));
            steps.push_back(one.combine(FlatNode::Op::kIntersection, std::move(both)));
        }
        parts.push_back(builder.combine(FlatNode::Op::kUnion, std::move(steps)));
    } else if (sweep.facets != 0) {
        FlatTree polygons;
        polygons.add_contours(to_contours(tree, root));
        parts.push_back(builder.sweep(polygons, 0));
    } else {
        parts.push_back(builder.sweep(tree, root));
    }
    if (parts[0].state == Piece::State::kNothing) return {};
    if (!full && !(sweep.facets != 0 && clear_of_axis)) parts.push_back(wedge_between(builder, from, to));

    Box2 ring = {{-flat.max[0], -flat.max[0]}, {flat.max[0], flat.max[0]}};
    if (!full) ring = ring_bounds(from, to, std::max(flat.min[0], 0.0), flat.max[0]);
    const Box3 bounds = {{ring.min[0], ring.min[1], flat.min[1]}, {ring.max[0], ring.max[1], flat.max[1]}};
    return finish(builder, model, std::move(parts), name, bounds, where);
}

}  // namespace mortise::model_reader
