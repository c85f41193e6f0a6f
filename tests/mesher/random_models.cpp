// Recipes of random models: see random_models.hpp. A recipe makes parts; assemble() joins them to a tree.
#include "tests/mesher/random_models.hpp"
#include "host/common/constants.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/mesher/random_source.hpp"
#include "tests/mesher/rounded_solids.hpp"
#include "tests/mesher/solids.hpp"

namespace mortise::test {
namespace {

constexpr double kExtent = 30;  ///< cells of a level-5 mesh inside its margin

class Recipe {
  public:
    /// Every fifth seed is for a recipe that the others do not draw from.
    explicit Recipe(std::uint64_t seed) : random_(seed), is_rounded_(seed % 5 == 4) {}

    RandomModel make() {
        std::string style;
        switch (is_rounded_ ? 10 : random_.integer(0, 9)) {
            case 10: rounded(), style = "rounded"; break;
            case 0: general(12), style = "general"; break;
            case 1: general(5), style = "general, few"; break;
            case 2: lattice(), style = "lattice"; break;
            case 3: lattice(), skew(), style = "lattice, mapped"; break;
            case 4: tangent(), style = "tangent"; break;
            case 5: thin(), style = "thin"; break;
            case 6: nearly_coincident(), style = "nearly coincident"; break;
            case 7: pencil(), style = "pencil"; break;
            case 8: common_axis(), style = "common axis"; break;
            default: flush(), style = "flush"; break;
        }
        return finished(style);
    }

    RandomModel make_hulls() {
        hulls();
        return finished("hulls");
    }

  private:
    RandomModel finished(std::string style) {
        if (random_.chance(0.3)) skew();
        const double regions = random_.uniform(0, 1);
        const int region_count = regions < 0.7 ? 1 : regions < 0.85 ? 2 : regions < 0.95 ? 3 : 4;
        make_regions(region_count);
        style += ", " + std::to_string(region_count) + (region_count == 1 ? " region" : " regions");
        if (random_.chance(0.1)) {
            const double scale = std::pow(10.0, random_.integer(-4, 4));
            model_ = transformed(std::move(model_), scaling({scale, scale, scale}));
        }
        model_.source = "random model";
        return {std::move(model_), style};
    }

    double uniform(double low, double high) { return random_.uniform(low, high); }
    double whole(int low, int high) { return random_.integer(low, high); }
    Vec3 direction() {
        for (;;) {
            const Vec3 d = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
            const double length = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            if (length > 0.01 && length < 1) return d;
        }
    }
    Affine random_rotation() { return rotation(direction(), uniform(-kPi, kPi)); }
    /// One of the six orders of the axes, mirrors included: exact.
    Affine axis_order() {
        int order[3] = {0, 1, 2};
        for (int i = 2; i > 0; --i) std::swap(order[i], order[random_.integer(0, i)]);
        Affine map{};
        for (std::size_t i = 0; i < 3; ++i) {
            map[4 * i + static_cast<std::size_t>(order[i])] = random_.chance(0.3) ? -1 : 1;
        }
        return map;
    }
    Affine random_map() {
        Affine map = random_rotation();
        if (random_.chance(0.2)) map = compose(map, scaling({-1, 1, 1}));
        if (random_.chance(0.3)) {
            map = compose(map, scaling({uniform(0.4, 1.6), uniform(0.4, 1.6), uniform(0.4, 1.6)}));
        }
        if (random_.chance(0.15)) {
            Affine shear = kIdentity;
            shear[1] = uniform(-0.7, 0.7);
            shear[6] = uniform(-0.7, 0.7);
            map = compose(shear, map);
        }
        return map;
    }
    /// A distance from 1e-9 to 1e-3 of the model's size, or a small part of a cell.
    double tiny() { return kExtent * std::pow(10.0, uniform(-9, -3)); }

    NodeIndex moved(NodeIndex node, const Affine& map) { return model_.add_transform(map, node); }
    NodeIndex placed(NodeIndex node, const Vec3& at) { return moved(node, translation(at)); }

    NodeIndex any_solid() {
        const double a = uniform(2, 8), b = uniform(2, 8), c = uniform(2, 8);
        switch (random_.integer(0, 9)) {
            case 0: return add_box(model_, {-a, -b, -c}, {a, b, c});
            case 1: return add_ball(model_, {0, 0, 0}, a);
            case 2: return add_cylinder(model_, a, -b, b);
            case 3: return add_frustum(model_, a, b, -c, c);
            case 4: return add_frustum(model_, a, 0, 0, b);
            case 5: return model_.add_primitive(wedge(2 * a, 2 * b, 2 * c));
            case 6: return add_torus(model_, a, uniform(0.2, 0.9) * a);
            case 7: return moved(add_ball(model_, {0, 0, 0}, 1), scaling({a, b, c}));
            case 8: return pencil_part(random_.integer(4, 8), {0, 0, 0}, false);
            default: return add_torus(model_, uniform(1, 3), uniform(3, 6));  // spindle
        }
    }

    void general(int most) {
        const int count = random_.integer(2, most);
        for (int i = 0; i < count; ++i) {
            const NodeIndex solid = any_solid();
            const Vec3 at = {uniform(-9, 9), uniform(-9, 9), uniform(-9, 9)};
            const Affine map = random_.chance(0.4) ? axis_order() : random_map();
            parts_.push_back(moved(solid, compose(translation(at), map)));
        }
    }

    /// Everything at whole coordinates of a block that spans the root box's inner cells.
    void lattice() {
        parts_.push_back(add_box(model_, {0, 0, 0}, {kExtent, whole(8, 30), whole(8, 30)}));
        const int count = random_.integer(1, 9);
        for (int i = 0; i < count; ++i) {
            const Vec3 low = {whole(-1, 25), whole(-1, 20), whole(-1, 20)};
            switch (random_.integer(0, 5)) {
                case 0:
                    parts_.push_back(
                        placed(moved(add_cylinder(model_, whole(1, 5), 0, whole(1, 12)), axis_order()), low));
                    break;
                case 1: parts_.push_back(add_ball(model_, low, whole(1, 6))); break;
                case 2:
                    parts_.push_back(
                        placed(moved(model_.add_primitive(wedge(whole(1, 9), whole(1, 9), whole(1, 9))),
                                     axis_order()),
                               low));
                    break;
                default:
                    parts_.push_back(add_box(
                        model_, low, {low[0] + whole(1, 9), low[1] + whole(1, 9), low[2] + whole(1, 9)}));
            }
            if (random_.chance(0.15)) parts_.back() = placed(parts_.back(), {0, 0, 0.5});
            if (random_.chance(0.15)) parts_.back() = placed(parts_.back(), {1e-12, tiny(), -1e-11});
        }
    }

    void tangent() {
        const double r = random_.chance(0.5) ? whole(3, 7) : uniform(3, 7);
        const double s = random_.chance(0.5) ? whole(2, 5) : uniform(2, 5);
        const double half = 12;
        switch (random_.integer(0, 5)) {
            case 0:  // balls on, under and inside the faces of a block
                parts_.push_back(add_box(model_, {-half, -half, -half}, {half, half, 0}));
                parts_.push_back(add_ball(model_, {uniform(-6, 6), uniform(-6, 6), r}, r));
                parts_.push_back(add_ball(model_, {uniform(-6, 6), uniform(-6, 6), -s}, s));
                parts_.push_back(add_ball(model_, {half - s, 0, -half / 2}, s));
                break;
            case 1:  // two balls that touch from outside or inside
                parts_.push_back(add_ball(model_, {0, 0, 0}, r));
                parts_.push_back(add_ball(model_, {random_.chance(0.5) ? r + s : r - s, 0, 0}, s));
                break;
            case 2:  // cylinders that touch along a line, and one crossing them at a right angle
                parts_.push_back(add_cylinder(model_, r, -half, half));
                parts_.push_back(placed(add_cylinder(model_, s, -half, half), {r + s, 0, 0}));
                parts_.push_back(moved(add_cylinder(model_, r, -half, half), rotation({1, 0, 0}, kPi / 2)));
                break;
            case 3:  // a cylinder lying on a block, another sunk to its edge line
                parts_.push_back(add_box(model_, {-half, -half, -half}, {half, half, 0}));
                parts_.push_back(moved(add_cylinder(model_, r, -half, half),
                                       compose(translation({0, 0, r}), rotation({1, 0, 0}, kPi / 2))));
                parts_.push_back(moved(add_cylinder(model_, s, -half - 1, half + 1),
                                       compose(translation({0, 0, -s}), rotation({0, 1, 0}, kPi / 2))));
                break;
            case 4:  // a torus on a plate, and a ball that fits its tube
                parts_.push_back(add_box(model_, {-half, -half, -half}, {half, half, -s / 2}));
                parts_.push_back(add_torus(model_, r + 1, s / 2));
                parts_.push_back(add_ball(model_, {r + 1, 0, 0}, s / 2));
                break;
            default:  // a cone that a ball touches along a circle
                parts_.push_back(add_frustum(model_, r, 0, 0, r));
                parts_.push_back(add_ball(model_, {0, 0, 0}, r * std::sqrt(0.5)));
                parts_.push_back(add_box(model_, {0, -half, 0}, {half, half, r}));
        }
        if (random_.chance(0.4)) parts_.push_back(placed(any_solid(), {uniform(-6, 6), 0, 0}));
    }

    void thin() {
        const double wall = random_.chance(0.5) ? 0.3 : uniform(0.01, 0.3);
        const double size = uniform(6, 13);
        const int count = random_.integer(1, 3);
        for (int i = 0; i < count; ++i) {
            NodeIndex part = 0;
            switch (random_.integer(0, 5)) {
                case 0: part = add_box(model_, {-size, -size, 0}, {size, size, wall}); break;
                case 1: {
                    const NodeIndex outer = add_ball(model_, {0, 0, 0}, size);
                    part = subtract(model_, {outer, add_ball(model_, {0, 0, 0}, size - wall)});
                    break;
                }
                case 2: {
                    const NodeIndex outer = add_cylinder(model_, size, -size, size);
                    part = subtract(model_, {outer, add_cylinder(model_, size - wall, -size - 1, size + 1)});
                    break;
                }
                case 3: {  // a slot
                    const NodeIndex block = add_box(model_, {-size, -size, -size}, {size, size, size});
                    const NodeIndex slot = add_box(model_, {-2, -20, -20}, {-2 + wall, 20, 20});
                    part = subtract(model_, {block, slot});
                    break;
                }
                case 4: {  // two lids a wall apart
                    const NodeIndex low = add_box(model_, {-size, -size, -4}, {size, size, 0});
                    part = unite(model_, {low, add_box(model_, {-4, -4, wall}, {size, size, 6})});
                    break;
                }
                default: {  // a sharp blade of a degree or a few
                    Primitive blade = box({-size, -size, 0}, {size, size, 5});
                    const double angle = uniform(0.5, 6) * kPi / 180;
                    blade.planes.push_back({{-std::sin(angle), 0, std::cos(angle)}, 0, ""});
                    part = model_.add_primitive(blade);
                }
            }
            parts_.push_back(random_.chance(0.4) ? part : moved(part, random_map()));
        }
        if (random_.chance(0.5)) parts_.push_back(placed(any_solid(), {uniform(-6, 6), 0, 0}));
    }

    /// A solid and copies of it that differ by next to nothing.
    void nearly_coincident() {
        const int kinds = random_.integer(1, 2);
        for (int k = 0; k < kinds; ++k) {
            const NodeIndex solid = placed(any_solid(), {uniform(-4, 4), uniform(-4, 4), 0});
            parts_.push_back(solid);
            const int copies = random_.integer(1, 3);
            for (int i = 0; i < copies; ++i) {
                switch (random_.integer(0, 3)) {
                    case 0: parts_.push_back(placed(solid, {tiny(), 0, 0})); break;
                    case 1: parts_.push_back(placed(solid, {tiny(), -tiny(), tiny()})); break;
                    case 2: parts_.push_back(moved(solid, rotation(direction(), tiny() / kExtent))); break;
                    default: {
                        const double scale = 1 + tiny() / kExtent;
                        parts_.push_back(moved(solid, scaling({scale, scale, scale})));
                    }
                }
            }
        }
    }

    /// Parts that meet tangentially.
    void rounded() {
        const int count = random_.integer(1, 4);
        for (int i = 0; i < count; ++i) {
            const bool even = random_.chance(0.5);
            const double r = even ? whole(2, 5) : uniform(1.5, 5);
            const double a = r + (even ? whole(1, 7) : uniform(0.5, 7));
            const double b = r + (even ? whole(1, 7) : uniform(0.5, 7));
            NodeIndex part = 0;
            switch (random_.integer(0, 6)) {
                case 0: part = add_stadium(model_, r, a, -b, b); break;
                case 1: part = add_capsule(model_, r, a); break;
                case 2: part = add_rounded_plate(model_, {a, b, uniform(2, 8)}, r); break;
                case 3: part = add_rounded_box(model_, {a, b, r + uniform(0.5, 4)}, r); break;
                case 4: part = add_rounded_disc(model_, a, r); break;
                case 5: part = add_teardrop(model_, r, -a, a); break;
                default: part = add_filleted_box(model_, {a, b, uniform(2, 9)}, r); break;
            }
            const Vec3 at = {even ? whole(-8, 8) : uniform(-8, 8), even ? whole(-8, 8) : uniform(-8, 8),
                             even ? whole(-8, 8) : uniform(-8, 8)};
            const Affine map = random_.chance(0.5) ? axis_order() : random_map();
            parts_.push_back(moved(part, compose(translation(at), map)));
        }
        if (random_.chance(0.3)) parts_.push_back(any_solid());
    }

    /// Rounded solids, some on a lattice, some with boxes whose faces lie in theirs.
    void hulls() {
        const int count = random_.integer(1, 3);
        for (int i = 0; i < count; ++i) {
            const bool even = random_.chance(0.5);
            const bool alike = random_.chance(0.6);
            const double r = even ? whole(2, 4) : uniform(1.5, 4);
            RoundedSolid solid;
            solid.shape = static_cast<RoundedSolid::Shape>(random_.integer(0, 4));
            const bool plate = solid.shape == RoundedSolid::Shape::kPlate;
            solid.low = even ? -whole(1, 4) : -uniform(1, 4);
            solid.high = even ? whole(1, 4) : uniform(1, 4);
            solid.rounding = r;
            Vec3 top{};  // the highest ball along each axis
            for (int k = random_.integer(2, 8); k-- > 0;) {
                Ball ball;
                for (double& x : ball.center) x = even ? 2 * whole(-3, 3) : uniform(-6, 6);
                ball.radius = alike ? r : even ? whole(2, 4) : uniform(1.5, 4);
                if (plate && random_.chance(0.5)) ball.radius = 0;
                if (solid.shape == RoundedSolid::Shape::kRing)
                    ball.center[0] = ball.radius + (even ? whole(1, 6) : uniform(0.2, 6));
                for (std::size_t j = 0; j < 3; ++j) top[j] = std::max(top[j], ball.center[j] + ball.radius);
                solid.balls.push_back(ball);
            }
            NodeIndex part = model_.add_primitive(mortise::rounded(solid));
            if (solid.shape == RoundedSolid::Shape::kColumn)
                part =
                    intersect(model_, {part, add_box(model_, {-30, -30, solid.low}, {30, 30, solid.high})});
            if (even && random_.chance(0.5)) {  // a box on it, and one flush with it
                const double side = top[0];
                const NodeIndex on = add_box(model_, {side, -4, -4}, {side + 4, 4, 4});
                const NodeIndex flush = add_box(model_, {side - 9, top[1] - 3, -9}, {side, top[1], 1});
                part = unite(model_, {part, random_.chance(0.5) ? on : flush});
            }
            const Vec3 at = {even ? whole(-4, 4) : uniform(-4, 4), even ? whole(-4, 4) : uniform(-4, 4),
                             even ? whole(-4, 4) : uniform(-4, 4)};
            const Affine map = random_.chance(0.5) ? axis_order() : random_map();
            parts_.push_back(moved(part, compose(translation(at), map)));
        }
        if (random_.chance(0.4)) parts_.push_back(any_solid());
    }

    /// Planes through one point, closed by a box or a ball.
    NodeIndex pencil_part(int planes, const Vec3& tip, bool with_ball) {
        const double size = uniform(4, 11);
        Primitive convex =
            box({tip[0] - size, tip[1] - size, tip[2]}, {tip[0] + size, tip[1] + size, tip[2] + size});
        const double turn = uniform(0, kPi), steep = uniform(0.3, 1.5);
        for (int i = 0; i < planes; ++i) {
            const double angle = turn + 2 * kPi * i / planes;
            const Vec3 normal = {std::cos(angle), std::sin(angle), -steep};
            convex.planes.push_back(
                {normal, normal[0] * tip[0] + normal[1] * tip[1] + normal[2] * tip[2], ""});
        }
        const NodeIndex solid = model_.add_primitive(convex);
        if (!with_ball) return solid;
        return intersect(model_, {solid, add_ball(model_, tip, size)});
    }

    void pencil() {
        Vec3 tip = {0, 0, 0};
        if (random_.chance(0.5)) tip = {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)};
        const int count = random_.integer(1, 4);
        if (random_.chance(0.4)) parts_.push_back(add_box(model_, {-8, -9, -10}, tip));
        for (int i = 0; i < count; ++i) {
            if (random_.chance(0.3)) {  // a cone with its apex there
                const NodeIndex cone = add_frustum(model_, uniform(2, 8), 0, -uniform(3, 9), 0);
                parts_.push_back(placed(random_.chance(0.5) ? cone : moved(cone, random_rotation()), tip));
            } else {
                const NodeIndex solid = pencil_part(random_.integer(3, 8), tip, random_.chance(0.3));
                const Affine turn = random_.chance(0.3) ? axis_order() : random_rotation();
                const Affine back = translation({-tip[0], -tip[1], -tip[2]});
                parts_.push_back(moved(solid, compose(translation(tip), compose(turn, back))));
            }
        }
        if (parts_.size() < 2) parts_.push_back(add_ball(model_, tip, uniform(3, 6)));
    }

    void common_axis() {
        const int count = random_.integer(2, 6);
        for (int i = 0; i < count; ++i) {
            const double r = random_.chance(0.5) ? whole(2, 9) : uniform(2, 9);
            const double low = random_.chance(0.5) ? whole(-10, 5) : uniform(-10, 5);
            switch (random_.integer(0, 5)) {
                case 0: parts_.push_back(add_cylinder(model_, r, low, low + whole(1, 10))); break;
                case 1:
                    parts_.push_back(add_frustum(model_, r, uniform(1, 9), low, low + whole(1, 10)));
                    break;
                case 2: parts_.push_back(add_frustum(model_, r, 0, low, low + whole(1, 10))); break;
                case 3: parts_.push_back(add_ball(model_, {0, 0, low}, r)); break;
                case 4: parts_.push_back(placed(add_torus(model_, r, uniform(0.5, 3)), {0, 0, low})); break;
                default: parts_.push_back(placed(add_torus(model_, r / 3, uniform(3, 6)), {0, 0, low}));
            }
        }
        if (random_.chance(0.3)) parts_.push_back(add_box(model_, {0, -9, -9}, {9, 9, 9}));
    }

    /// Boxes, wedges and cylinders that share whole planes with one base box, at odd coordinates.
    void flush() {
        double planes[3][4];
        for (auto& axis : planes) {
            for (double& plane : axis) plane = uniform(-13, 13);
            std::sort(std::begin(axis), std::end(axis));
        }
        const auto pick = [&](int axis, double& low, double& high) {
            const int first = random_.integer(0, 2), second = random_.integer(first + 1, 3);
            low = planes[axis][first];
            high = planes[axis][second];
        };
        const int count = random_.integer(2, 7);
        for (int i = 0; i < count; ++i) {
            Vec3 low{}, high{};
            for (int axis = 0; axis < 3; ++axis) {
                pick(axis, low[static_cast<std::size_t>(axis)], high[static_cast<std::size_t>(axis)]);
            }
            for (std::size_t j = 0; j < 3; ++j) high[j] = std::max(high[j], low[j] + 1e-3);
            if (i > 0 && random_.chance(0.3)) {
                const double radius = uniform(1, 5);
                const Vec3 at = {0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1]), 0};
                parts_.push_back(placed(add_cylinder(model_, radius, low[2], high[2]), at));
            } else {
                parts_.push_back(add_box(model_, low, high));
            }
        }
    }

    /// Maps the whole model, so that what is flush or tangent stays so up to rounding.
    void skew() {
        const Affine map = random_.chance(0.5) ? random_rotation() : random_map();
        for (NodeIndex& part : parts_) part = moved(part, map);
    }

    /// Joins parts [first, last) to one solid; unions are favoured, so that little is empty.
    NodeIndex assemble(std::size_t first, std::size_t last) {
        if (last - first == 1) return parts_[first];
        if (last - first <= 4 && random_.chance(0.3)) {
            const std::vector<NodeIndex> all(parts_.begin() + static_cast<std::ptrdiff_t>(first),
                                             parts_.begin() + static_cast<std::ptrdiff_t>(last));
            return random_.chance(0.5) ? unite(model_, all) : subtract(model_, all);
        }
        const std::size_t middle =
            first + 1 + static_cast<std::size_t>(random_.integer(0, static_cast<int>(last - first) - 2));
        const NodeIndex left = assemble(first, middle);
        const NodeIndex right = assemble(middle, last);
        const double choice = uniform(0, 1);
        if (choice < 0.5) return unite(model_, {left, right});
        if (choice < 0.85) return subtract(model_, {left, right});
        if (choice < 0.97) return intersect(model_, {left, right});
        const NodeIndex outside = model_.add_operation(CsgNode::Op::kComplement, {right});
        return intersect(model_, {left, outside});
    }

    void make_regions(int count) {
        const std::size_t parts = parts_.size();
        const auto regions = std::min(static_cast<std::size_t>(count), parts);
        for (std::size_t r = 0; r < regions; ++r) {
            const std::size_t first = parts * r / regions, last = parts * (r + 1) / regions;
            // The last region may hold everything: the earlier ones then are inclusions.
            const bool around = r > 0 && r + 1 == regions && random_.chance(0.5);
            const NodeIndex root = around ? unite(model_, parts_) : assemble(first, last);
            add_region(model_, root, "region_" + std::to_string(r + 1));
        }
    }

    RandomSource random_;
    bool is_rounded_;
    Model model_;
    std::vector<NodeIndex> parts_;
};

}  // namespace

RandomModel make_random_model(std::uint64_t seed) { return Recipe(seed).make(); }

RandomModel make_random_hulls(std::uint64_t seed) { return Recipe(seed).make_hulls(); }

}  // namespace mortise::test
