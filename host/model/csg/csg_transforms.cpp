#include "host/model/csg/csg_transforms.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/model/affine.hpp"
#include "host/model/outlines/flat_tree.hpp"

namespace mortise::model_reader {
namespace {

using Kind = CsgOperand::Kind;

[[noreturn]] void fail_argument(const CsgNodeText& node, const CsgArgument* argument,
                                std::string_view expected) {
    fail(node.source, argument != nullptr ? argument->where : node.where,
         in_quotes(node.name) + ": expected " + std::string(expected));
}

/// A list of `fewest` to three numbers, filled up with `missing`.
Vec3 numbers_of(const CsgNodeText& node, const CsgArgument* argument, std::size_t fewest, double missing,
                std::string_view expected) {
    if (argument == nullptr || argument->kind != CsgArgument::Kind::kList || argument->rows != 0 ||
        !argument->numeric || argument->count < fewest || argument->count > 3) {
        fail_argument(node, argument, expected);
    }
    if (argument->not_finite.line != 0) {
        throw NoExtent{argument->not_finite, in_quotes(node.name) + " with a number that is nan or inf"};
    }
    Vec3 result = {missing, missing, missing};
    std::copy_n(node.arguments.numbers(*argument), argument->count, result.begin());
    return result;
}

Affine linear(const Vec3& column0, const Vec3& column1, const Vec3& column2) {
    return from_columns(column0, column1, column2, {0, 0, 0});
}

/// By an angle in degrees about a coordinate axis; exact where sine and cosine are rational.
Affine rotation_about(std::size_t axis, double degrees) {
    const double c = cosine_of_degrees(degrees);
    const double s = sine_of_degrees(degrees);
    std::array<Vec3, 3> columns = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
    const std::size_t u = (axis + 1) % 3;
    const std::size_t v = (axis + 2) % 3;
    columns[u][u] = columns[v][v] = c;
    columns[u][v] = s;
    columns[v][u] = -s;
    return linear(columns[0], columns[1], columns[2]);
}

/// About any axis (Rodrigues' formula).
Affine rotation_about(const Vec3& axis, double degrees) {
    const Vec3 n = unit(axis);
    for (std::size_t k = 0; k < 3; ++k) {
        if (std::fabs(n[k]) == 1) return rotation_about(k, n[k] * degrees);
    }
    const double c = cosine_of_degrees(degrees);
    const double s = sine_of_degrees(degrees);
    std::array<Vec3, 3> columns{};
    for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t i = 0; i < 3; ++i) columns[j][i] = (1 - c) * n[i] * n[j] + (i == j ? c : 0);
        columns[j][(j + 1) % 3] += s * n[(j + 2) % 3];
        columns[j][(j + 2) % 3] -= s * n[(j + 1) % 3];
    }
    return linear(columns[0], columns[1], columns[2]);
}

Affine matrix_of(const CsgNodeText& node) {
    const CsgArgument* argument = node.arguments.find("m", 0);
    if (argument == nullptr || argument->kind != CsgArgument::Kind::kList || !argument->regular ||
        argument->direct != 0 || argument->rows != 4 || argument->row_length != 4) {
        fail_argument(node, argument, "a matrix of four rows of four numbers");
    }
    if (argument->not_finite.line != 0) {
        throw NoExtent{argument->not_finite, "'multmatrix' with an entry that is nan or inf"};
    }
    const double* numbers = node.arguments.numbers(*argument);
    if (numbers[12] != 0 || numbers[13] != 0 || numbers[14] != 0 || numbers[15] != 1) {
        fail(node.source, argument->where,
             "'multmatrix': the last row is not 0, 0, 0, 1; expected an affine map");
    }
    Affine map{};
    std::copy_n(numbers, 12, map.begin());
    return map;
}

/// Moves the children; of plane shapes the xy part does.
CsgFinish moved(const CsgNodeText& node, const Affine& map) {
    const std::vector<CsgArgument>& arguments = node.arguments.all();
    const SourceLocation place = arguments.empty() ? node.where : arguments.front().where;
    return [map, where = node.where, place, name = std::string(node.name)](CsgScene& scene,
                                                                           std::vector<CsgOperand> children) {
        CsgOperand child = scene.united(std::move(children));
        const FlatMap flat = {map[0], map[1], map[3], map[4], map[5], map[7]};
        const Affine lifted = {flat[0], flat[1], 0, flat[2], flat[3], flat[4], 0, flat[5], 0, 0, 1, 0};
        const bool is_flat = child.kind == Kind::kFlat;
        if (child.kind == Kind::kNothing) return child;
        if (std::fabs(relative_determinant(is_flat ? lifted : map)) <= kSingular) {
            if (!is_flat && scene.flat_counts > 0) {
                fail(scene.source, place,
                     in_quotes(name) +
                         ": the matrix is singular, it flattens the solid, which is not supported inside "
                         "hull, minkowski and projection; expected a determinant other than 0");
            }
            return scene.leave_out(place, in_quotes(name) + " with a singular matrix");
        }
        if (is_flat && flat != kFlatIdentity) child.node = scene.flat.add_transform(flat, child.node);
        if (child.kind == Kind::kSolid && map != kIdentity) {
            child.node = scene.model.add_transform(map, child.node);
            scene.model.nodes[child.node].where = where;
        }
        return child;
    };
}

}  // namespace

CsgFinish read_multmatrix(CsgScene&, const CsgNodeText& node) { return moved(node, matrix_of(node)); }

CsgFinish read_translate(CsgScene&, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {"v"}, 1);
    return moved(node, translation(numbers_of(node, node.arguments.find("v", 0), 2, 0,
                                              "a list of two or three numbers")));
}

CsgFinish read_rotate(CsgScene&, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {"a", "v"}, 2);
    const CsgArgument* angle = node.arguments.find("a", 0);
    const CsgArgument* axis = node.arguments.find("v", 1);
    if (axis != nullptr && axis->kind == CsgArgument::Kind::kUndefined) axis = nullptr;
    if (angle != nullptr && angle->kind == CsgArgument::Kind::kNumber) {
        const double degrees = size_number(node, *angle, "a");
        if (axis == nullptr) return moved(node, rotation_about(2, degrees));
        const Vec3 along = numbers_of(node, axis, 3, 0, "an axis v of three numbers");
        if (along == Vec3{0, 0, 0}) fail_argument(node, axis, "an axis v other than [0, 0, 0]");
        return moved(node, rotation_about(along, degrees));
    }
    const Vec3 angles = numbers_of(node, angle, 1, 0, "an angle a in degrees, or a list of up to three");
    if (axis != nullptr) fail_argument(node, axis, "one angle a with the axis v, not a list");
    const Affine about_xy = compose(rotation_about(1, angles[1]), rotation_about(0, angles[0]));
    return moved(node, compose(rotation_about(2, angles[2]), about_xy));
}

CsgFinish read_scale(CsgScene&, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {"v"}, 1);
    const CsgArgument* argument = node.arguments.find("v", 0);
    Vec3 factors{};
    if (argument != nullptr && argument->kind == CsgArgument::Kind::kNumber) {
        factors.fill(size_number(node, *argument, "v"));
    } else {
        factors = numbers_of(node, argument, 2, 1, "a number, or a list of two or three");
    }
    return moved(node, linear({factors[0], 0, 0}, {0, factors[1], 0}, {0, 0, factors[2]}));
}

CsgFinish read_mirror(CsgScene&, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {"v"}, 1);
    const Vec3 normal = numbers_of(node, node.arguments.find("v", 0), 2, 0, "a list of two or three numbers");
    std::array<Vec3, 3> columns = {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
    if (normal != Vec3{0, 0, 0}) {
        const Vec3 n = unit(normal);
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t i = 0; i < 3; ++i) columns[j][i] -= 2 * n[i] * n[j];
        }
    }
    return moved(node, linear(columns[0], columns[1], columns[2]));
}

}  // namespace mortise::model_reader
