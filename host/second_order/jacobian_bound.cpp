#include "host/second_order/jacobian_bound.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host/common/constants.hpp"
#include "host/common/vec3.hpp"

namespace mortise::second_order {
namespace {

constexpr std::size_t kMostNodes = 8, kMostEdges = 12;

/// A shape function with its derivatives, or a linear factor of one, in coordinates of the reference element.
struct Term {
    double value;
    Vec3 slope;
};

Term operator*(const Term& a, const Term& b) {
    return {a.value * b.value, sum(scaled(a.slope, b.value), scaled(b.slope, a.value))};
}
Term operator*(double factor, const Term& a) { return {factor * a.value, scaled(a.slope, factor)}; }

/// Shape functions of a point: those of the corners of the element with straight edges, and of the nodes in
/// the middles of edges.
struct Shapes {
    std::array<Term, kMostNodes> corner;
    std::array<Term, kMostEdges> middle;
};

/// Barycentric coordinates of a triangle in the first two coordinates.
std::array<Term, 3> in_triangle(const Vec3& x) {
    return {{{1 - x[0] - x[1], {-1, -1, 0}}, {x[0], {1, 0, 0}}, {x[1], {0, 1, 0}}}};
}

/// Along each axis the factors 1 - x and x of the unit cube.
std::array<std::array<Term, 2>, 3> in_cube(const Vec3& x) {
    std::array<std::array<Term, 2>, 3> factors;
    for (std::size_t j = 0; j < 3; ++j) {
        factors[j] = {{{1 - x[j], {}}, {x[j], {}}}};
        factors[j][0].slope[j] = -1;
        factors[j][1].slope[j] = 1;
    }
    return factors;
}

/// Which of the two factors along an axis a corner of a hexahedron, or of a pyramid's base, has.
std::size_t cube_side(int corner, std::size_t axis) {
    const auto c = static_cast<std::size_t>(corner);
    if (axis == 2) return c / 4;
    return axis == 1 ? c % 4 / 2 : (c % 4 == 1 || c % 4 == 2);
}

Shapes hexahedron(const Vec3& x) {
    const auto factor = in_cube(x);
    Shapes shapes;
    for (int c = 0; c < 8; ++c)
        shapes.corner[static_cast<std::size_t>(c)] =
            factor[0][cube_side(c, 0)] * factor[1][cube_side(c, 1)] * factor[2][cube_side(c, 2)];
    for (std::size_t e = 0; e < 12; ++e) {
        Term product = {1, {}};
        for (std::size_t j = 0; j < 3; ++j) {
            const std::size_t a = cube_side(kHexahedronEdges[e][0], j);
            const std::size_t b = cube_side(kHexahedronEdges[e][1], j);
            product = product * (a == b ? factor[j][a] : 4 * (factor[j][0] * factor[j][1]));
        }
        shapes.middle[e] = product;
    }
    return shapes;
}

Shapes wedge(const Vec3& x) {
    const auto triangle = in_triangle(x);
    const auto height = in_cube(x)[2];
    Shapes shapes;
    for (std::size_t c = 0; c < 6; ++c) shapes.corner[c] = triangle[c % 3] * height[c / 3];
    for (std::size_t e = 0; e < 9; ++e) {
        const auto a = static_cast<std::size_t>(kWedgeEdges[e][0]);
        const auto b = static_cast<std::size_t>(kWedgeEdges[e][1]);
        shapes.middle[e] = a % 3 == b % 3 ? 4 * (triangle[a % 3] * height[0] * height[1])
                                          : 4 * (triangle[a % 3] * triangle[b % 3] * height[a / 3]);
    }
    return shapes;
}

/// The pyramid over the unit square with its apex above the corner at the origin, of height 1: with
/// s = 1 - z, corner functions are products of (s - x, x) and (s - y, y) over s.
Shapes pyramid(const Vec3& x) {
    const Term s = {1 - x[2], {0, 0, -1}}, z = {x[2], {0, 0, 1}};
    const Term inverse = {1 / s.value, {0, 0, 1 / (s.value * s.value)}};
    const std::array<std::array<Term, 2>, 2> factor = {
        {{{{s.value - x[0], {-1, 0, -1}}, {x[0], {1, 0, 0}}}},
         {{{s.value - x[1], {0, -1, -1}}, {x[1], {0, 1, 0}}}}}};
    Shapes shapes;
    for (int c = 0; c < 4; ++c) {
        const auto i = static_cast<std::size_t>(c);
        shapes.corner[i] = factor[0][cube_side(c, 0)] * factor[1][cube_side(c, 1)] * inverse;
        shapes.middle[4 + i] = 4 * (z * shapes.corner[i]);
    }
    shapes.corner[4] = z;
    for (std::size_t e = 0; e < 4; ++e) {
        const int a = kPyramidEdges[e][0], b = kPyramidEdges[e][1];
        const std::size_t along = cube_side(a, 0) == cube_side(b, 0) ? 1 : 0;
        shapes.middle[e] =
            4 * (factor[along][0] * factor[along][1] * factor[1 - along][cube_side(a, 1 - along)] * inverse);
    }
    return shapes;
}

Shapes tetrahedron(const Vec3& x) {
    const std::array<Term, 4> barycentric = {
        {{1 - x[0] - x[1] - x[2], {-1, -1, -1}}, {x[0], {1, 0, 0}}, {x[1], {0, 1, 0}}, {x[2], {0, 0, 1}}}};
    Shapes shapes;
    std::copy(barycentric.begin(), barycentric.end(), shapes.corner.begin());
    for (std::size_t e = 0; e < 6; ++e)
        shapes.middle[e] = 4 * (barycentric[static_cast<std::size_t>(kTetrahedronEdges[e][0])] *
                                barycentric[static_cast<std::size_t>(kTetrahedronEdges[e][1])]);
    return shapes;
}

/// What a type needs: the Jacobian's degree along each coordinate of the cube, where a point of the cube lies
/// in the reference element, and the shape functions there.
struct Reference {
    std::array<std::size_t, 3> degree;
    Vec3 (*place)(const Vec3& cube);
    Shapes (*shapes)(const Vec3& x);
};

/// In the order of ElementType.
constexpr std::array<Reference, kElementTypes> kReferences = {{
    {{5, 5, 5}, [](const Vec3& c) { return c; }, hexahedron},
    {{4, 4, 5},
     [](const Vec3& c) {
         return Vec3{c[0], c[1] * (1 - c[0]), c[2]};
     },
     wedge},
    {{5, 5, 3},
     [](const Vec3& c) {
         return Vec3{c[0] * (1 - c[2]), c[1] * (1 - c[2]), c[2]};
     },
     pyramid},
    {{3, 3, 3},
     [](const Vec3& c) {
         return Vec3{c[0] * (1 - c[1]) * (1 - c[2]), c[1] * (1 - c[2]), c[2]};
     },
     tetrahedron},
}};

/// A square matrix, row by row.
using Matrix = std::vector<double>;

/// Gauss-Jordan with pivots, for the small and well-conditioned matrices here.
Matrix inverse(Matrix a, std::size_t n) {
    Matrix result(n * n, 0.0);
    for (std::size_t i = 0; i < n; ++i) result[n * i + i] = 1;
    for (std::size_t column = 0; column < n; ++column) {
        std::size_t pivot = column;
        for (std::size_t row = column + 1; row < n; ++row) {
            if (std::fabs(a[n * row + column]) > std::fabs(a[n * pivot + column])) pivot = row;
        }
        for (Matrix* matrix : {&a, &result})
            std::swap_ranges(matrix->begin() + static_cast<std::ptrdiff_t>(n * column),
                             matrix->begin() + static_cast<std::ptrdiff_t>(n * (column + 1)),
                             matrix->begin() + static_cast<std::ptrdiff_t>(n * pivot));
        const double scale = 1 / a[n * column + column];
        for (std::size_t k = 0; k < n; ++k) {
            a[n * column + k] *= scale;
            result[n * column + k] *= scale;
        }
        for (std::size_t row = 0; row < n; ++row) {
            const double factor = a[n * row + column];
            if (row == column || factor == 0) continue;
            for (std::size_t k = 0; k < n; ++k) {
                a[n * row + k] -= factor * a[n * column + k];
                result[n * row + k] -= factor * result[n * column + k];
            }
        }
    }
    return result;
}

/// Where polynomials of a degree are sampled: Chebyshev's points of [0, 1], none at the ends, where collapsed
/// elements have no coordinates.
double sample_place(std::size_t i, std::size_t degree) {
    return 0.5 - 0.5 * std::cos((static_cast<double>(i) + 0.5) / static_cast<double>(degree + 1) * kPi);
}

/// From values at the samples to Bernstein coefficients.
Matrix to_bernstein(std::size_t degree) {
    const std::size_t n = degree + 1;
    Matrix values(n * n);
    for (std::size_t i = 0; i < n; ++i) {
        const double x = sample_place(i, degree);
        double binomial = 1;
        for (std::size_t k = 0; k < n; ++k) {
            values[n * i + k] = binomial * std::pow(x, static_cast<double>(k)) *
                                std::pow(1 - x, static_cast<double>(degree - k));
            binomial *= static_cast<double>(degree - k) / static_cast<double>(k + 1);
        }
    }
    return inverse(values, n);
}

/// Slopes of the shape functions at all samples, and what makes Bernstein coefficients of values there.
struct Table {
    std::size_t nodes = 0, edges = 0;
    std::array<std::size_t, 3> count{};
    std::array<Matrix, 3> transform;
    std::vector<Vec3> corner;  ///< by sample, then corner
    std::vector<Vec3> middle;  ///< by sample, then edge
    std::size_t samples() const { return count[0] * count[1] * count[2]; }
};

Table make_table(std::size_t t) {
    const Reference& reference = kReferences[t];
    Table table;
    table.nodes = static_cast<std::size_t>(kElementNodes[t]);
    table.edges = static_cast<std::size_t>(kElementEdges[t]);
    for (std::size_t j = 0; j < 3; ++j) {
        table.count[j] = reference.degree[j] + 1;
        table.transform[j] = to_bernstein(reference.degree[j]);
    }
    for (std::size_t s = 0; s < table.samples(); ++s) {
        const std::array<std::size_t, 3> index = {s / (table.count[1] * table.count[2]),
                                                  s / table.count[2] % table.count[1], s % table.count[2]};
        Vec3 cube;
        for (std::size_t j = 0; j < 3; ++j) cube[j] = sample_place(index[j], reference.degree[j]);
        const Shapes shapes = reference.shapes(reference.place(cube));
        for (std::size_t n = 0; n < table.nodes; ++n) table.corner.push_back(shapes.corner[n].slope);
        for (std::size_t e = 0; e < table.edges; ++e) table.middle.push_back(shapes.middle[e].slope);
    }
    return table;
}

const Table& table_of(ElementType type) {
    static const std::array<Table, kElementTypes> tables = {
        {make_table(0), make_table(1), make_table(2), make_table(3)}};
    return tables[static_cast<std::size_t>(type)];
}

/// Adds the derivatives of a node's part of the map.
void add_part(const Vec3& position, const Vec3& slope, std::array<Vec3, 3>& derivative) {
    for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t k = 0; k < 3; ++k) derivative[j][k] += slope[j] * position[k];
    }
}

/// Replaces values by coefficients along one coordinate.
void transform_axis(const Table& table, std::size_t axis, std::vector<double>& values) {
    const std::size_t n = table.count[axis];
    std::size_t stride = 1;
    for (std::size_t j = axis + 1; j < 3; ++j) stride *= table.count[j];
    const Matrix& matrix = table.transform[axis];
    std::array<double, 6> line{};
    for (std::size_t first = 0; first < values.size(); ++first) {
        if (first / stride % n != 0) continue;
        for (std::size_t i = 0; i < n; ++i) line[i] = values[first + stride * i];
        for (std::size_t i = 0; i < n; ++i) {
            double coefficient = 0;
            for (std::size_t k = 0; k < n; ++k) coefficient += matrix[n * i + k] * line[k];
            values[first + stride * i] = coefficient;
        }
    }
}

}  // namespace

bool is_surely_valid(const Vec3* corners, const Vec3* displacements, double share) {
    // With J of the straight tetrahedron, the Jacobian is det J · det(I + P), P = Σ J⁻¹ d ∇(4 λa λb).
    // Singular values of I + P are 1 - |P| at least, and |∇(4 λa λb)| is largest at a corner, 4 √3.
    constexpr double kSteepest = 6.93;
    const Vec3 a = difference(corners[1], corners[0]), b = difference(corners[2], corners[0]),
               c = difference(corners[3], corners[0]);
    const std::array<Vec3, 3> rows = {cross(b, c), cross(c, a), cross(a, b)};
    const double jacobian = dot(a, rows[0]);
    double most = 0;
    for (std::size_t e = 0; e < 6; ++e) {
        const Vec3& d = displacements[e];
        most += length({dot(rows[0], d), dot(rows[1], d), dot(rows[2], d)});
    }
    const double left = 1 - kSteepest * most / jacobian;
    return jacobian > 0 && left > 0 && left * left * left >= share;
}

double least_jacobian(ElementType type, const Vec3* corners, const Vec3* displacements) {
    const Table& table = table_of(type);
    // Edges that are straight, most of an element's, are left out.
    std::array<std::size_t, kMostEdges> curved{};
    std::size_t curves = 0;
    for (std::size_t e = 0; e < table.edges; ++e) {
        if (squared_length(displacements[e]) > 0) curved[curves++] = e;
    }
    thread_local std::vector<double> values;
    values.resize(table.samples());
    for (std::size_t s = 0; s < values.size(); ++s) {
        std::array<Vec3, 3> derivative{};
        // From the first corner: the functions of all add up to one.
        for (std::size_t n = 1; n < table.nodes; ++n)
            add_part(difference(corners[n], corners[0]), table.corner[table.nodes * s + n], derivative);
        for (std::size_t i = 0; i < curves; ++i)
            add_part(displacements[curved[i]], table.middle[table.edges * s + curved[i]], derivative);
        values[s] = dot(derivative[0], cross(derivative[1], derivative[2]));
    }
    for (std::size_t axis = 0; axis < 3; ++axis) transform_axis(table, axis, values);
    return *std::min_element(values.begin(), values.end());
}

}  // namespace mortise::second_order
