// OpenSCAD's primitives as Mortise primitives.
//
// Source: the OpenSCAD language (fragments, vertex placement) as written by OpenSCAD's .csg export, with
// one difference. Curved solids stay curved, unless $fn asks for at most twelve fragments: that is how
// users make prisms, so then the flat faces are meant. Objects with sizes that are zero, negative or not
// finite are left out, as OpenSCAD does, but with a warning.
#include "host/model/csg/csg_primitives.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "host/model/affine.hpp"
#include "host/model/solids/facetted_primitives.hpp"

namespace mortise::model_reader {
namespace {

void add_caps(std::vector<Plane>& planes, const double* zmin, const double* zmax) {
    if (zmin != nullptr) planes.push_back({{0, 0, -1}, -*zmin, "zmin"});
    if (zmax != nullptr) planes.push_back({{0, 0, 1}, *zmax, "zmax"});
}

}  // namespace

std::uint32_t add_csg_cube(Model& model, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {"size", "center"}, 2);
    Vec3 low{};
    Vec3 high{};
    read_corners(node, 3, low.data(), high.data());
    return model.add_primitive(box(low, high), node.surface, node.where);
}

std::uint32_t add_csg_sphere(Model& model, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {"r", "d"}, 1);
    const double radius = read_radius(node);
    const int n = flat_fragments(node, radius);
    if (n == 0) return model.add_primitive(sphere(radius), node.surface, node.where);
    return model.add_primitive(facetted_sphere(radius, n), node.surface, node.where);
}

std::uint32_t add_csg_cylinder(Model& model, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {"h", "r1", "r2", "center", "r", "d", "d1", "d2"}, 4);
    refuse_both(node, "r", "d");
    refuse_both(node, "r1", "d1");
    refuse_both(node, "r2", "d2");
    double height = 1;
    if (const CsgArgument* argument = node.arguments.find("h", 0)) {
        height = size_number(node, *argument, "height");
        if (!(height > 0)) throw_no_extent(node, argument->where, "height", height);
    }
    std::array<double, 2> radii = {1, 1};
    SourceLocation where = node.where;
    // The general argument first, so that the particular one overrides it.
    const std::array<std::pair<const char*, const char*>, 2> particular = {{{"r1", "d1"}, {"r2", "d2"}}};
    for (std::size_t k = 0; k < 2; ++k) {
        const CsgArgument* r = node.arguments.find(particular[k].first, static_cast<int>(k) + 1);
        const CsgArgument* d = node.arguments.find(particular[k].second);
        if (r == nullptr && d == nullptr) r = node.arguments.find("r");
        if (r == nullptr && d == nullptr) d = node.arguments.find("d");
        if (r == nullptr && d == nullptr) continue;
        const CsgArgument& given = r != nullptr ? *r : *d;
        where = given.where;
        radii[k] = size_number(node, given, "radius") / (r != nullptr ? 1 : 2);
        if (radii[k] < 0) throw_no_extent(node, where, "radius", radii[k]);
    }
    // One radius may be 0: an apex.
    if (radii[0] == 0 && radii[1] == 0) throw_no_extent(node, where, "radius", 0);
    const double zmin = optional_boolean(node, "center", 3) ? -height / 2 : 0;
    const double zmax = zmin + height;
    // A cap is missing where the solid ends in an apex.
    const double* lower_cap = radii[0] > 0 ? &zmin : nullptr;
    const double* upper_cap = radii[1] > 0 ? &zmax : nullptr;
    const double slope = (radii[1] - radii[0]) / height;

    if (const int n = flat_fragments(node, std::max(radii[0], radii[1])); n != 0) {
        Primitive polyhedron;
        // Without taper the offset is exactly the radius; else the line goes through the wider end.
        const double at_zero = radii[0] >= radii[1] ? radii[0] - slope * zmin : radii[1] - slope * zmax;
        add_frustum_sides(polyhedron.planes, n, at_zero, slope);
        add_caps(polyhedron.planes, lower_cap, upper_cap);
        return model.add_primitive(std::move(polyhedron), node.surface, node.where);
    }
    Primitive caps;
    if (radii[0] == radii[1]) {
        const std::uint32_t side = model.add_primitive(infinite_cylinder(radii[0]), {}, node.where);
        add_caps(caps.planes, lower_cap, upper_cap);
        const std::uint32_t cap = model.add_primitive(std::move(caps), {}, node.where);
        return model.add_operation(CsgNode::Op::kIntersection, {side, cap}, node.surface);
    }
    // The cone's own origin lies at the wider end, where its radius is positive.
    const bool upright = radii[0] > radii[1];
    const double origin = upright ? zmin : zmax;
    std::uint32_t side = model.add_primitive(cone(upright ? radii[0] : radii[1], slope), {}, node.where);
    if (origin != 0) side = model.add_transform(translation({0, 0, origin}), side);
    add_caps(caps.planes, lower_cap, upper_cap);
    const std::uint32_t cap = model.add_primitive(std::move(caps), {}, node.where);
    return model.add_operation(CsgNode::Op::kIntersection, {side, cap}, node.surface);
}

}  // namespace mortise::model_reader
