// linear_extrude and rotate_extrude.
#include <algorithm>
#include <cmath>
#include <utility>

#include "host/common/constants.hpp"
#include "host/model/affine.hpp"
#include "host/model/csg/csg_shapes.hpp"
#include "host/model/outlines/polygon_unions.hpp"
#include "host/model/solids/extrusion.hpp"

namespace mortise::model_reader {
namespace {

using Kind = CsgOperand::Kind;

void refuse_file_form(const CsgNodeText& node) {
    if (const CsgArgument* file = node.arguments.find("file")) {
        fail(node.source, file->where,
             in_quotes(node.name) + ": the form with file = is not supported; use import() as its child");
    }
}

CsgOperand solid(std::optional<std::uint32_t> node, SourceLocation where) {
    return node ? CsgOperand{Kind::kSolid, *node, where} : CsgOperand{};
}

Vec2 extrusion_scale(const CsgNodeText& node) {
    Vec2 scale = {1, 1};
    const CsgArgument* argument = node.arguments.find("scale");
    if (argument == nullptr || argument->kind == CsgArgument::Kind::kUndefined) return scale;
    if (argument->kind == CsgArgument::Kind::kNumber) {
        scale.fill(finite_number(node, *argument, "scale"));
    } else if (argument->kind == CsgArgument::Kind::kList && argument->regular && argument->rows == 0 &&
               argument->count == 2) {
        std::copy_n(node.arguments.numbers(*argument), 2, scale.begin());
    } else {
        fail(node.source, argument->where, in_quotes(node.name) + ": scale is not a number or a list of two");
    }
    for (const double factor : scale) {
        if (!(factor >= 0) || !std::isfinite(factor)) {
            fail_size(node, argument->where, "scale", factor, "finite numbers that are not negative");
        }
    }
    return scale;
}

}  // namespace

CsgFinish read_linear_extrude(CsgScene&, const CsgNodeText& node) {
    refuse_file_form(node);
    refuse_unknown_arguments(
        node, {"height", "h", "v", "center", "convexity", "twist", "slices", "segments", "scale"}, 1);
    LinearSweep sweep;
    sweep.height = 100;
    const CsgArgument* height = node.arguments.find("height", 0);
    if (height == nullptr) height = node.arguments.find("h");
    if (height != nullptr) sweep.height = finite_number(node, *height, "height");

    // Along v the shape is shifted, never turned.
    Vec3 along = {0, 0, 1};
    if (const CsgArgument* v = node.arguments.find("v")) {
        if (v->kind != CsgArgument::Kind::kList || !v->regular || v->rows != 0 || v->count != 3 ||
            v->not_finite.line != 0) {
            fail(node.source, v->where, "'linear_extrude': v is not a list of three finite numbers");
        }
        std::copy_n(node.arguments.numbers(*v), 3, along.begin());
        const double size = length(along);
        if (height == nullptr) sweep.height = size;
        if (!(std::fabs(along[2]) > kSingular * size)) {
            fail(node.source, v->where,
                 "'linear_extrude': v lies in the plane of the shape, it would flatten the solid; expected "
                 "z other than 0");
        }
        for (double& component : along) component /= size;
    }
    if (!(sweep.height > 0)) {
        throw_no_extent(node, height != nullptr ? height->where : node.where, "height", sweep.height);
    }
    const bool slanted = along[0] != 0 || along[1] != 0 || along[2] < 0;
    sweep.height *= std::fabs(along[2]);
    const Affine slant = {1, 0, along[0] / std::fabs(along[2]), 0, 0, 1, along[1] / std::fabs(along[2]), 0,
                          0, 0, along[2] < 0 ? -1.0 : 1.0,      0};
    sweep.twist = optional_number(node, "twist", -1, 0);
    sweep.scale = extrusion_scale(node);
    if (optional_boolean(node, "center", -1)) sweep.base = -sweep.height / 2;

    sweep.smooth = node.facets == Facets::kSmooth;
    const SourceLocation where = node.where;
    return [sweep, slanted, slant, where, name = node.surface](CsgScene& scene,
                                                               std::vector<CsgOperand> children) {
        const CsgOperand child = scene.united_flat(std::move(children), "linear_extrude", where);
        if (child.kind == Kind::kNothing) return child;
        unite_polygons(scene.flat, child.node);
        CsgOperand result =
            solid(linear_extrusion(scene.model, scene.flat, child.node, sweep, name, where), where);
        if (result.kind == Kind::kSolid) {
            if (auto extents = linear_extents(scene.flat, child.node, sweep)) {
                scene.extents[result.node] = std::move(*extents);
            }
            // Scaled apart along x and y, slanted sides are no planes.
            if (sweep.twist == 0 && sweep.scale[0] == sweep.scale[1])
                scene.sweeps[result.node] = {child.node, sweep};
        }
        if (slanted && result.kind == Kind::kSolid)
            result.node = scene.model.add_transform(slant, result.node);
        return result;
    };
}

CsgFinish read_rotate_extrude(CsgScene&, const CsgNodeText& node) {
    refuse_file_form(node);
    refuse_unknown_arguments(node, {"angle", "start", "convexity"}, 1);
    RotarySweep sweep;
    const CsgArgument* angle = node.arguments.find("angle", 0);
    if (angle != nullptr) sweep.angle = finite_number(node, *angle, "angle");
    if (sweep.angle == 0) throw_no_extent(node, angle->where, "angle", 0);
    if (std::fabs(sweep.angle) > 360) sweep.angle = 360;
    const bool full = std::fabs(sweep.angle) == 360;
    sweep.start = std::fmod(optional_number(node, "start", -1, full ? 180 : 0), 360);

    // The number of steps depends on the shape's width, which only the children tell; up to which radius
    // steps are flat does not.
    const bool exact = node.facets == Facets::kExact;
    const int flat = flat_fragments(node, 1);
    const double fn = optional_number(node, "$fn", -1, 0);
    const double fa = std::max(optional_number(node, "$fa", -1, 12), 0.01);
    const double fs = std::max(optional_number(node, "$fs", -1, 2), 0.01);
    const SourceLocation where = node.where;
    return [=, name = node.surface](CsgScene& scene, std::vector<CsgOperand> children) mutable {
        CsgOperand child = scene.united_flat(std::move(children), "rotate_extrude", where);
        if (child.kind == Kind::kNothing) return child;
        unite_polygons(scene.flat, child.node);
        Box2 box = flat_bounds(scene.flat, child.node);
        if (box.is_empty()) return CsgOperand{};
        double reach = std::max(-box.min[0], box.max[0]);
        constexpr double kOnAxis = 1e-9;
        if (box.min[0] < -kOnAxis * reach) {
            // Perhaps what lies there is cut away.
            FlatTree polygons;
            box = flat_bounds(polygons, polygons.add_contours(to_contours(scene.flat, child.node)));
            if (box.is_empty()) return CsgOperand{};
            reach = std::max(-box.min[0], box.max[0]);
        }
        if (box.min[0] < -kOnAxis * reach) {
            if (box.max[0] > kOnAxis * reach) {
                fail(scene.source, where,
                     "'rotate_extrude': the 2D shape lies on both sides of the axis (x from " +
                         number_text(box.min[0]) + " to " + number_text(box.max[0]) +
                         "); expected x >= 0 only");
            }
            child.node = scene.flat.add_transform({-1, 0, 0, 0, 1, 0}, child.node);
            sweep.start += 180;
        }
        int steps = flat;
        if (exact && !(fn > 0)) {
            steps = static_cast<int>(std::ceil(std::max(std::min(360 / fa, reach * kTurn / fs), 5.0)));
        }
        if (steps != 0 && !full) {
            const double part = std::fabs(sweep.angle) / 360;
            steps = std::max(part < 0.5 ? 1 : 3, static_cast<int>(steps * part));
        }
        sweep.facets = steps;
        return solid(rotary_extrusion(scene.model, scene.flat, child.node, sweep, name, where), where);
    };
}

}  // namespace mortise::model_reader
