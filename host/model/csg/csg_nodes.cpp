#include "host/model/csg/csg_nodes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/model/csg/csg_implicit.hpp"
#include "host/model/csg/csg_imports.hpp"
#include "host/model/csg/csg_primitives.hpp"
#include "host/model/csg/csg_shapes.hpp"
#include "host/model/csg/csg_transforms.hpp"

namespace mortise::model_reader {
namespace {

using Kind = CsgOperand::Kind;
using Op = CsgNode::Op;

template <std::uint32_t (*add)(Model&, const CsgNodeText&)>
CsgOperand read_solid(CsgScene& scene, const CsgNodeText& node) {
    const std::size_t first = scene.model.nodes.size();
    const std::uint32_t solid = add(scene.model, node);
    for (std::size_t i = first; i < scene.model.nodes.size() && scene.flat_counts > 0; ++i) {
        const CsgNode& part = scene.model.nodes[i];
        if (part.op != Op::kPrimitive || !(part.primitive.radius > 0)) continue;
        const double count = std::min(fragment_count(node, part.primitive.radius), 1e6);
        scene.fragments[static_cast<std::uint32_t>(i)] = static_cast<int>(count);
    }
    return {Kind::kSolid, solid, node.where};
}

constexpr CsgNodeType operation(std::string_view name, Op op) { return {name, op, nullptr, nullptr}; }
constexpr CsgNodeType leaf(std::string_view name, CsgOperand (*read)(CsgScene&, const CsgNodeText&)) {
    return {name, Op::kPrimitive, read, nullptr};
}
constexpr CsgNodeType branch(std::string_view name, CsgFinish (*read)(CsgScene&, const CsgNodeText&)) {
    return {name, Op::kPrimitive, nullptr, read};
}

/// The commonest first.
constexpr std::array<CsgNodeType, 33> kTypes = {branch("multmatrix", read_multmatrix),
                                                leaf("cube", read_solid<add_csg_cube>),
                                                operation("group", Op::kUnion),
                                                leaf("cylinder", read_solid<add_csg_cylinder>),
                                                operation("union", Op::kUnion),
                                                operation("difference", Op::kDifference),
                                                leaf("sphere", read_solid<add_csg_sphere>),
                                                operation("color", Op::kUnion),
                                                operation("intersection", Op::kIntersection),
                                                operation("render", Op::kUnion),
                                                leaf("square", read_square),
                                                leaf("circle", read_circle),
                                                leaf("polygon", read_polygon),
                                                branch("linear_extrude", read_linear_extrude),
                                                branch("rotate_extrude", read_rotate_extrude),
                                                branch("offset", read_offset),
                                                branch("hull", read_hull),
                                                branch("minkowski", read_minkowski),
                                                branch("resize", read_resize),
                                                leaf("implicit", read_solid<add_csg_implicit>),
                                                leaf("gyroid", read_solid<add_csg_implicit>),
                                                leaf("schwarz_p", read_solid<add_csg_implicit>),
                                                leaf("schwarz_d", read_solid<add_csg_implicit>),
                                                branch("fill", read_fill),
                                                branch("projection", read_projection),
                                                leaf("polyhedron", read_polyhedron),
                                                leaf("text", read_text),
                                                leaf("import", read_import),
                                                leaf("surface", read_surface),
                                                branch("translate", read_translate),
                                                branch("rotate", read_rotate),
                                                branch("scale", read_scale),
                                                branch("mirror", read_mirror)};

/// OpenSCAD's other node types, to tell a gap in this reader from a typing error.
constexpr std::array<std::string_view, 2> kNotYet = {"roof", "path_extrude"};

}  // namespace

const CsgNodeType& csg_node_type(std::string_view name, const std::string& source, SourceLocation where) {
    for (const CsgNodeType& type : kTypes) {
        if (type.name == name) return type;
    }
    for (const std::string_view known : kNotYet) {
        if (known == name) {
            fail(source, where,
                 in_quotes(name) + " is not supported yet; disable the node with '*' to leave it out");
        }
    }
    std::string supported;
    std::vector<std::string_view> names;
    for (const CsgNodeType& type : kTypes) {
        supported += (supported.empty() ? "supported are " : ", ") + std::string(type.name);
        names.push_back(type.name);
    }
    const std::string hint = nearest_hint(name, names);
    fail(source, where, "unknown node " + in_quotes(name) + (hint.empty() ? "; " + supported : hint));
}

}  // namespace mortise::model_reader
