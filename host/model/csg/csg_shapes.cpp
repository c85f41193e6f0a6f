// square, circle, polygon and the nodes that need outlines: offset, fill, hull, minkowski, resize.
#include "host/model/csg/csg_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/model/csg/csg_imports.hpp"
#include "host/model/outlines/disc_hulls.hpp"
#include "host/model/outlines/polygons.hpp"
#include "host/model/solids/section.hpp"
#include "host/model/solids/shadow_planes.hpp"

namespace mortise::model_reader {
namespace {

using Kind = CsgOperand::Kind;

/// Sides of the polygon that stands for a smooth circle where an outline is needed.
constexpr int kFewestSides = 96;
/// Pairs of points that a Minkowski sum may look at.
constexpr double kMostSums = 4e6;

int outline_sides(const CsgNodeText& node, double radius) {
    const int flat = flat_fragments(node, radius);
    return flat != 0 ? flat : std::max(kFewestSides, fragments_of(node, radius));
}

[[noreturn]] void fail_not_yet(const std::string& source, SourceLocation where, const std::string& what) {
    fail(source, where, what + "; disable the node with '*' to leave it out");
}

Contours outline(const CsgScene& scene, const CsgOperand& operand) {
    return operand.kind == Kind::kFlat ? to_contours(scene.flat, operand.node) : Contours{};
}

/// A shape that stands for the hull of discs, if that is round all over.
CsgOperand outlined(CsgScene& scene, const Contours& loops, const std::vector<Disc>& discs,
                    SourceLocation where) {
    const CsgOperand result = scene.outlined(loops, where);
    if (result.kind == Kind::kFlat) scene.flat.nodes[result.node].discs = round_hull(discs);
    return result;
}

std::size_t point_count(const Contours& contours) {
    std::size_t count = 0;
    for (const auto& loop : contours) count += loop.size();
    return count;
}

/// Three numbers, missing ones 0.
Vec3 three_numbers(const CsgNodeText& node, const CsgArgument& argument) {
    if (argument.kind != CsgArgument::Kind::kList || !argument.numeric || argument.rows != 0 ||
        argument.count < 2 || argument.count > 3) {
        fail(node.source, argument.where,
             in_quotes(node.name) + ": " + std::string(argument.name) + " is not a list of three numbers");
    }
    if (argument.not_finite.line != 0) {
        fail(node.source, argument.not_finite,
             in_quotes(node.name) + ": a number is nan or inf; expected finite numbers");
    }
    Vec3 result{};
    std::copy_n(node.arguments.numbers(argument), argument.count, result.begin());
    return result;
}

}  // namespace

CsgOperand read_square(CsgScene& scene, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {"size", "center"}, 2);
    Vec2 low{};
    Vec2 high{};
    read_corners(node, 2, low.data(), high.data());
    return scene.outlined({{low, {high[0], low[1]}, high, {low[0], high[1]}}}, node.where);
}

CsgOperand read_circle(CsgScene& scene, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {"r", "d"}, 1);
    const double radius = read_radius(node);
    if (const int n = flat_fragments(node, radius); n != 0) {
        return scene.outlined({regular_polygon(radius, n)}, node.where);
    }
    return {Kind::kFlat, scene.flat.add_circle(radius, outline_sides(node, radius)), node.where};
}

CsgOperand read_polygon(CsgScene& scene, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {"points", "paths", "convexity"}, 2);
    const CsgArgument* points = node.arguments.find("points", 0);
    const bool is_empty =
        points != nullptr && (points->kind == CsgArgument::Kind::kUndefined ||
                              (points->kind == CsgArgument::Kind::kList && points->count == 0));
    if (points == nullptr || (!is_empty && (points->kind != CsgArgument::Kind::kList || !points->regular ||
                                            points->direct != 0 || points->row_length != 2))) {
        fail(node.source, points != nullptr ? points->where : node.where,
             "'polygon': points is not a list of pairs of numbers");
    }
    if (points->not_finite.line != 0) {
        fail(node.source, points->not_finite,
             "'polygon': a coordinate is nan or inf; expected finite numbers");
    }
    const double* numbers = node.arguments.numbers(*points);
    const std::size_t count = is_empty ? 0 : points->rows;
    const auto point = [numbers](std::size_t i) { return Vec2{numbers[2 * i], numbers[2 * i + 1]}; };

    Contours loops;
    const CsgArgument* paths = node.arguments.find("paths", 1);
    if (paths == nullptr || paths->kind == CsgArgument::Kind::kUndefined) {
        loops.emplace_back();
        for (std::size_t i = 0; i < count; ++i) loops[0].push_back(point(i));
    } else {
        if (paths->kind != CsgArgument::Kind::kList || !paths->numeric ||
            (paths->rows != 0 && paths->direct != 0)) {
            fail(node.source, paths->where, "'polygon': paths is neither undef nor lists of point numbers");
        }
        const double* indices = node.arguments.numbers(*paths);
        std::size_t at = 0;
        for (std::size_t row = 0; row < std::max<std::size_t>(paths->rows, 1); ++row) {
            const std::size_t end = paths->rows == 0 ? paths->count : node.arguments.row_ends(*paths)[row];
            loops.emplace_back();
            for (; at < end; ++at) {
                const double index = indices[at];
                if (!(index >= 0 && index < static_cast<double>(count)) || index != std::floor(index)) {
                    fail(node.source, paths->where,
                         "'polygon': paths names point " + number_text(index) + "; expected whole numbers " +
                             "from 0 to " + std::to_string(count == 0 ? 0 : count - 1));
                }
                loops.back().push_back(point(static_cast<std::size_t>(index)));
            }
        }
    }
    const CsgOperand result = scene.outlined(loops, node.where);
    if (result.kind == Kind::kNothing) scene.warn(node.where, "a polygon without area is left out");
    return result;
}

CsgFinish read_offset(CsgScene&, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {"r", "delta", "chamfer"}, 1);
    const CsgArgument* round = node.arguments.find("r", 0);
    const CsgArgument* straight = node.arguments.find("delta");
    double distance = 1;
    OffsetCorner corner = OffsetCorner::kRound;
    if (round != nullptr) {
        distance = finite_number(node, *round, "r");
    } else if (straight != nullptr) {
        distance = finite_number(node, *straight, "delta");
        corner = optional_boolean(node, "chamfer", -1) ? OffsetCorner::kChamfer : OffsetCorner::kMiter;
    }
    const int sides = outline_sides(node, std::fabs(distance));
    const bool round_corners =
        corner == OffsetCorner::kRound && distance > 0 && flat_fragments(node, distance) == 0;
    const SourceLocation where = node.where;
    return
        [distance, corner, sides, round_corners, where](CsgScene& scene, std::vector<CsgOperand> children) {
            const CsgOperand child = scene.united_flat(std::move(children), "offset", where);
            std::vector<Disc> discs;
            if (round_corners && child.kind == Kind::kFlat) {
                if (const auto convex = convex_discs_of(scene.flat, child.node))
                    discs = sum_of_discs(*convex, {{{0, 0}, distance}});
            }
            return outlined(scene, offset(outline(scene, child), distance, corner, sides), discs, where);
        };
}

CsgFinish read_fill(CsgScene&, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {"convexity"}, 1);
    const SourceLocation where = node.where;
    return [where](CsgScene& scene, std::vector<CsgOperand> children) {
        const CsgOperand child = scene.united_flat(std::move(children), "fill", where);
        return scene.outlined(filled(outline(scene, child)), where);
    };
}

CsgFinish read_hull(CsgScene& opening, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {}, 0);
    ++opening.flat_counts;
    const SourceLocation where = node.where;
    return [where, name = node.surface](CsgScene& scene, std::vector<CsgOperand> children) {
        --scene.flat_counts;
        if (std::any_of(children.begin(), children.end(),
                        [](const CsgOperand& child) { return child.kind == Kind::kSolid; })) {
            return hull_of_solids(scene, children, name, where);
        }
        Contours all;
        std::vector<Disc> discs;
        bool known = true;
        for (const CsgOperand& child : children) {
            if (child.kind != Kind::kFlat) continue;
            for (auto& loop : outline(scene, child)) all.push_back(std::move(loop));
            const auto more = discs_of(scene.flat, child.node);
            known = known && more;
            if (known) discs.insert(discs.end(), more->begin(), more->end());
        }
        return outlined(scene, convex_hull(all), known ? discs : std::vector<Disc>{}, where);
    };
}

CsgFinish read_minkowski(CsgScene& opening, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {"convexity"}, 1);
    ++opening.flat_counts;
    const SourceLocation where = node.where;
    return [where, name = node.surface](CsgScene& scene, std::vector<CsgOperand> children) -> CsgOperand {
        --scene.flat_counts;
        if (std::any_of(children.begin(), children.end(),
                        [](const CsgOperand& child) { return child.kind == Kind::kSolid; })) {
            return minkowski_of_solids(scene, children, name, where);
        }
        std::optional<Contours> sum;
        std::optional<std::vector<Disc>> discs = std::vector<Disc>{{}};
        for (const CsgOperand& child : children) {
            if (child.kind == Kind::kNothing) return {};
            const auto convex = convex_discs_of(scene.flat, child.node);
            discs = convex && discs ? std::optional(sum_of_discs(*discs, *convex)) : std::nullopt;
            Contours next = outline(scene, child);
            if (sum) {
                if (static_cast<double>(point_count(*sum)) * static_cast<double>(point_count(next)) >
                    kMostSums) {
                    fail(scene.source, where,
                         "'minkowski': outlines of " + std::to_string(point_count(*sum)) + " and " +
                             std::to_string(point_count(next)) +
                             " points are too fine; expected a product below 4 million");
                }
                next = minkowski_sum(*sum, next);
            }
            sum = std::move(next);
        }
        if (!sum) return {};
        return outlined(scene, *sum, discs ? *discs : std::vector<Disc>{}, where);
    };
}

namespace {

/// What `resize` asks for: lengths, 0 where there are none, and axes that follow the largest of them.
struct Resizing {
    Vec3 size{};
    std::array<bool, 3> automatic{};

    /// Factors of a shape with these extents.
    Vec3 scale_of(const Vec3& extent, std::size_t dimensions) const {
        std::size_t largest = 0;
        for (std::size_t k = 1; k < dimensions; ++k) {
            if (size[k] > size[largest]) largest = k;
        }
        const double common = size[largest] > 0 ? size[largest] / extent[largest] : 1;
        Vec3 scale = {1, 1, 1};
        for (std::size_t k = 0; k < dimensions; ++k) {
            if (size[k] > 0)
                scale[k] = size[k] / extent[k];
            else if (automatic[k])
                scale[k] = common;
        }
        return scale;
    }
};

Resizing read_resizing(const CsgNodeText& node) {
    Resizing asked;
    if (const CsgArgument* argument = node.arguments.find("newsize", 0)) {
        asked.size = three_numbers(node, *argument);
        for (const double length : asked.size) {
            if (length < 0)
                fail_size(node, argument->where, "newsize", length, "positive numbers, or 0 to keep a size");
        }
    }
    const CsgArgument* argument = node.arguments.find("auto", 1);
    if (argument == nullptr) return asked;
    if (argument->kind == CsgArgument::Kind::kBoolean) {
        asked.automatic.fill(argument->boolean);
    } else if (argument->kind == CsgArgument::Kind::kList && argument->rows == 0 &&
               argument->count == argument->direct && (argument->count == 2 || argument->count == 3)) {
        for (std::size_t k = 0; k < argument->count; ++k)
            asked.automatic[k] = node.arguments.numbers(*argument)[k] != 0;
    } else {
        fail(node.source, argument->where,
             in_quotes(node.name) + ": auto is neither true or false nor a list of two or three of them");
    }
    return asked;
}

/// None if the shape is empty.
std::optional<Vec3> flat_extent(CsgScene& scene, const CsgOperand& shape) {
    Box2 box = flat_bounds(scene.flat, shape.node);
    if (!has_exact_bounds(scene.flat, shape.node)) {
        FlatTree polygons;
        box = flat_bounds(polygons, polygons.add_contours(outline(scene, shape)));
        if (box.is_empty()) return std::nullopt;
    }
    return Vec3{box.max[0] - box.min[0], box.max[1] - box.min[1], 0};
}

Vec3 solid_extent(CsgScene& scene, const CsgOperand& solid, SourceLocation where) {
    std::optional<Box3> box = exact_bounds(scene.model, solid.node, scene.extents);
    if (!box) box = flat_faced_bounds(scene.model, solid.node, Wanted{"resize", scene.source, where});
    if (!box) {
        fail_not_yet(scene.source, where,
                     "'resize' is not supported yet for this solid, whose exact size is not known: it may "
                     "hold unions of cubes, spheres, cylinders and straight extrusions, and anything with "
                     "flat faces");
    }
    return {box->max[0] - box->min[0], box->max[1] - box->min[1], box->max[2] - box->min[2]};
}

}  // namespace

CsgFinish read_resize(CsgScene&, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {"newsize", "auto", "convexity"}, 2);
    const Resizing asked = read_resizing(node);
    const SourceLocation where = node.where;
    return [asked, where](CsgScene& scene, std::vector<CsgOperand> children) -> CsgOperand {
        CsgOperand child = scene.united(std::move(children));
        if (child.kind == Kind::kNothing || asked.size == Vec3{}) return child;
        const bool flat = child.kind == Kind::kFlat;
        const std::optional<Vec3> extent =
            flat ? flat_extent(scene, child) : solid_extent(scene, child, where);
        if (!extent) return {};
        const Vec3 scale = asked.scale_of(*extent, flat ? 2 : 3);
        if (scale == Vec3{1, 1, 1}) return child;
        child.node = flat ? scene.flat.add_transform({scale[0], 0, 0, 0, scale[1], 0}, child.node)
                          : scene.model.add_transform(
                                {scale[0], 0, 0, 0, 0, scale[1], 0, 0, 0, 0, scale[2], 0}, child.node);
        return child;
    };
}

CsgFinish read_projection(CsgScene& opening, const CsgNodeText& node) {
    if (const CsgArgument* file = node.arguments.find("file")) {
        fail(node.source, file->where,
             "'projection': the form with file = is not supported; use import() as its child");
    }
    refuse_unknown_arguments(node, {"cut", "convexity"}, 1);
    const bool cut = optional_boolean(node, "cut", 0);
    if (!cut) ++opening.flat_counts;
    const SourceLocation where = node.where;
    return [cut, where](CsgScene& scene, std::vector<CsgOperand> children) -> CsgOperand {
        if (!cut) --scene.flat_counts;
        const bool flat = std::any_of(children.begin(), children.end(),
                                      [](const CsgOperand& child) { return child.kind == Kind::kFlat; });
        if (flat) {
            scene.warn(where, "'projection' wants solids; 2D shapes among its children are left out");
            children.erase(std::remove_if(children.begin(), children.end(),
                                          [](const CsgOperand& child) { return child.kind == Kind::kFlat; }),
                           children.end());
        }
        const CsgOperand child = scene.united(std::move(children));
        if (child.kind == Kind::kNothing) return child;
        const Wanted wanted{"projection", scene.source, where};
        const std::optional<std::uint32_t> shape =
            cut ? section(scene.model, child.node, kIdentity, node_boxes(scene.model, child.node), scene.flat,
                          wanted)
                : shadow(scene.model, child.node, scene.fragments, scene.flat, wanted);
        if (!shape) return {};
        return {Kind::kFlat, *shape, where};
    };
}

}  // namespace mortise::model_reader
