#include "host/model/csg/csg_implicit.hpp"

#include <array>
#include <cmath>

#include "host/common/constants.hpp"

namespace mortise::model_reader {
namespace {

[[noreturn]] void refuse(const CsgNodeText& node, SourceLocation where, const std::string& message) {
    fail(node.source, where, "'" + std::string(node.name) + "': " + message);
}

/// The number of that name; not positive, or for `zero` negative: refused.
double length(const CsgNodeText& node, std::string_view name, int position, double otherwise, bool zero) {
    const CsgArgument* argument = node.arguments.find(name, position);
    if (argument == nullptr) return otherwise;
    const double value =
        argument->kind == CsgArgument::Kind::kNumber ? *node.arguments.numbers(*argument) : NAN;
    if (!std::isfinite(value) || value < 0 || (value == 0 && !zero)) {
        refuse(node, argument->where,
               std::string(name) + " is not a " + (zero ? "number from 0 on" : "positive, finite number"));
    }
    return value;
}

Box3 box_of(const CsgNodeText& node) {
    Box3 box{{0, 0, 0}, {1, 1, 1}};
    const CsgArgument* size = node.arguments.find("size", 0);
    if (size != nullptr) {
        const double* numbers = node.arguments.numbers(*size);
        if (size->kind == CsgArgument::Kind::kNumber)
            box.max = {numbers[0], numbers[0], numbers[0]};
        else if (size->kind == CsgArgument::Kind::kList && size->regular && size->rows == 0 &&
                 size->count == 3)
            box.max = {numbers[0], numbers[1], numbers[2]};
        else
            refuse(node, size->where, "size is not a number or a list of three numbers");
        for (const double edge : box.max) {
            if (!(edge > 0) || !std::isfinite(edge))
                refuse(node, size->where,
                       "size is " + number_text(edge) + "; expected three positive, finite numbers");
        }
    }
    if (!optional_boolean(node, "center", 3)) return box;
    for (std::size_t j = 0; j < 3; ++j) {
        box.max[j] /= 2;
        box.min[j] = -box.max[j];
    }
    return box;
}

std::uint32_t add_in_box(Model& model, const CsgNodeText& node, std::string formula, SourceLocation where,
                         const Box3& box) {
    Primitive primitive;
    primitive.kind = Primitive::Kind::kExpression;
    primitive.expression = std::move(formula);
    const std::uint32_t solid = model.add_primitive(std::move(primitive), node.surface, where);
    const std::uint32_t cut = model.add_primitive(mortise::box(box.min, box.max), node.surface, node.where);
    return model.add_operation(CsgNode::Op::kIntersection, {solid, cut});
}

std::uint32_t add_formula(Model& model, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {"formula", "bounds"}, 2);
    const CsgArgument* text = node.arguments.find("formula", 0);
    if (text == nullptr || text->kind != CsgArgument::Kind::kString || text->text.empty()) {
        refuse(node, text == nullptr ? node.where : text->where,
               "expected a formula in quotes, such as implicit(\"x^2 + y^2 + z^2 - 1\")");
    }
    if (text->text.find('\\') != std::string_view::npos)
        refuse(node, text->where, "the formula holds a '\\', which has no meaning there");
    const SourceLocation where = {text->where.line, text->where.column + 1};
    const CsgArgument* bounds = node.arguments.find("bounds", 1);
    if (bounds == nullptr) {
        Primitive primitive;
        primitive.kind = Primitive::Kind::kExpression;
        primitive.expression = std::string(text->text);
        return model.add_primitive(std::move(primitive), node.surface, where);
    }
    const double* numbers = node.arguments.numbers(*bounds);
    const bool shaped = bounds->kind == CsgArgument::Kind::kList && bounds->regular && bounds->rows == 2 &&
                        bounds->row_length == 3 && bounds->direct == 0 && bounds->not_finite.line == 0;
    Box3 box;
    for (std::size_t j = 0; shaped && j < 3; ++j) {
        box.min[j] = numbers[j];
        box.max[j] = numbers[3 + j];
    }
    if (!shaped || !(box.min[0] < box.max[0] && box.min[1] < box.max[1] && box.min[2] < box.max[2]))
        refuse(node, bounds->where, "bounds are not [[x0, y0, z0], [x1, y1, z1]] with a volume");
    return add_in_box(model, node, std::string(text->text), where, box);
}

/// A periodic function of a = 2πx/period, …, whose zero set is close to a minimal surface.
struct Periodic {
    std::string_view name;
    const char* formula;
    double largest;   ///< value of the function
    double gradient;  ///< its mean length over the surface, measured
};

constexpr std::array<Periodic, 3> kPeriodic = {
    {{"gyroid", "sin(a)*cos(b) + sin(b)*cos(c) + sin(c)*cos(a)", 1.5, 1.531},
     {"schwarz_p", "cos(a) + cos(b) + cos(c)", 3, 1.340},
     {"schwarz_d",
      "sin(a)*sin(b)*sin(c) + sin(a)*cos(b)*cos(c) + cos(a)*sin(b)*cos(c) + cos(a)*cos(b)*sin(c)",
      1.4142135623730951, 1.498}}};

std::uint32_t add_periodic(Model& model, const CsgNodeText& node, const Periodic& kind) {
    refuse_unknown_arguments(node, {"size", "period", "thickness", "center"}, 4);
    const Box3 box = box_of(node);
    const double period = length(node, "period", 1, 1, false);
    const double thickness = length(node, "thickness", 2, 0, true);
    std::string formula;
    for (const char* const axis : {"a = x", "b = y", "c = z"})
        formula += axis + ("*(2*pi/" + number_text(period)) + "); ";
    formula += std::string("f = ") + kind.formula + "; ";
    if (thickness == 0) return add_in_box(model, node, formula + "f", node.where, box);
    // |f| <= gradient · thickness / 2, in radians.
    const double reach = kind.gradient * kPi * thickness / period;
    if (reach >= kind.largest) {
        refuse(node, node.arguments.find("thickness", 2)->where,
               "sheets of thickness " + number_text(thickness) + " fill the box; expected less than " +
                   number_text(kind.largest * period / (kind.gradient * kPi)));
    }
    const std::string level = number_text(reach);
    return add_in_box(model, node, formula + "max(f - " + level + ", -f - " + level + ")", node.where, box);
}

}  // namespace

std::uint32_t add_csg_implicit(Model& model, const CsgNodeText& node) {
    for (const Periodic& kind : kPeriodic) {
        if (kind.name == node.name) return add_periodic(model, node, kind);
    }
    return add_formula(model, node);
}

}  // namespace mortise::model_reader
