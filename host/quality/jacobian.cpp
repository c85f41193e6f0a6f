// Bernstein-Bézier form of the Jacobian, per element type.
//
// Hexahedron: the Jacobian has degree 2 in each variable. Its 27 Bernstein coefficients bound it from below,
// and the eight outer ones are its corner values. If a bound is not positive the unit cube is split in eight
// (de Casteljau) until every part is decided; the bound closes in quadratically. Source: Johnen, Remacle,
// Geuzaine, "Geometrical validity of curvilinear finite elements" (2013), here for trilinear hexahedra.
//
// Wedge: linear over the triangle, so its minimum lies on one of the three upright edges, where it is a
// quadratic of the height: decided exactly.
//
// Pyramid: with base Q(u, v) = q + u e + v f + uv d the Jacobian is (1 - w)² J(u, v),
// J = (e×f + u e×d + v d×f)·(apex - Q). All products of d with the terms of Q cancel to one multiple of uv,
// so J is bilinear and its minimum is one of the four base corners: decided exactly, apex included.
#include "host/quality/jacobian.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

namespace mortise::quality {
namespace {

constexpr double kNoise = 1e-14;
constexpr int kMaxDepth = 8;             // the bound's error shrinks by 4 per level
constexpr std::size_t kMaxParts = 4096;  // parts looked at before the bound is taken as the answer

/// Bernstein coefficients of degree 2 in each of three variables; index 9 i + 3 j + k.
using Coefficients = std::array<double, 27>;

/// A Jacobian value with the scale of its rounding error.
struct Determinant {
    double value;
    double scale;
    double lower() const { return value - kNoise * scale; }
};

Determinant determinant(const Vector& a, const Vector& b, const Vector& c) {
    return {dot(cross(a, b), c), length(a) * length(b) * length(c)};
}

/// Edge vectors of a hexahedron along each axis: a[j][k] along x, b[i][k] along y, c[i][j] along z.
struct HexahedronEdges {
    Vector a[2][2], b[2][2], c[2][2];
};

HexahedronEdges hexahedron_edges(const Vector* p) {
    const auto corner = [p](int i, int j, int k) { return p[4 * k + (j == 0 ? i : 3 - i)]; };
    HexahedronEdges edges;
    for (int s = 0; s < 2; ++s) {
        for (int t = 0; t < 2; ++t) {
            edges.a[s][t] = corner(1, s, t) - corner(0, s, t);
            edges.b[s][t] = corner(s, 1, t) - corner(s, 0, t);
            edges.c[s][t] = corner(s, t, 1) - corner(s, t, 0);
        }
    }
    return edges;
}

/// Products of Bernstein polynomials of degree 1: weight 1 / binomial(2, i) for each index.
constexpr double kWeight[3] = {1.0, 0.5, 1.0};

/// Sums term(a, b, c) over all triples of edge vectors into the coefficients that they contribute to.
template <class Pair, class Term>
Coefficients sum_products(const Pair& pair, const Term& term) {
    Coefficients sum{};
    for (int j1 = 0; j1 < 2; ++j1)
        for (int k1 = 0; k1 < 2; ++k1)
            for (int i1 = 0; i1 < 2; ++i1)
                for (int k2 = 0; k2 < 2; ++k2) {
                    const auto ab = pair(j1, k1, i1, k2);
                    for (int i2 = 0; i2 < 2; ++i2)
                        for (int j2 = 0; j2 < 2; ++j2)
                            sum[static_cast<std::size_t>(9 * (i1 + i2) + 3 * (j1 + j2) + k1 + k2)] +=
                                term(ab, i2, j2);
                }
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            for (std::size_t k = 0; k < 3; ++k)
                sum[9 * i + 3 * j + k] *= kWeight[i] * kWeight[j] * kWeight[k];
    return sum;
}

Coefficients jacobian_coefficients(const HexahedronEdges& e) {
    return sum_products([&e](int j1, int k1, int i1, int k2) { return cross(e.a[j1][k1], e.b[i1][k2]); },
                        [&e](const Vector& ab, int i2, int j2) { return dot(ab, e.c[i2][j2]); });
}

Coefficients scale_coefficients(const HexahedronEdges& e) {
    return sum_products(
        [&e](int j1, int k1, int i1, int k2) { return length(e.a[j1][k1]) * length(e.b[i1][k2]); },
        [&e](double ab, int i2, int j2) { return ab * length(e.c[i2][j2]); });
}

double max_length(const Vector (&edges)[2][2]) {
    return std::sqrt(std::max(std::max(dot(edges[0][0], edges[0][0]), dot(edges[0][1], edges[0][1])),
                              std::max(dot(edges[1][0], edges[1][0]), dot(edges[1][1], edges[1][1]))));
}

/// Halves the coefficients along one axis (stride 9, 3 or 1): the halves below and above the middle.
void halve(const Coefficients& whole, std::size_t stride, Coefficients& below, Coefficients& above) {
    for (std::size_t i = 0; i < 27; ++i) {
        if (i / stride % 3 != 0) continue;
        const double first = whole[i], middle = whole[i + stride], last = whole[i + 2 * stride];
        const double left = 0.5 * (first + middle), right = 0.5 * (middle + last);
        const double centre = 0.5 * (left + right);
        below[i] = first, below[i + stride] = left, below[i + 2 * stride] = centre;
        above[i] = centre, above[i + stride] = right, above[i + 2 * stride] = last;
    }
}

double smallest_corner(const Coefficients& c) {
    double smallest = std::numeric_limits<double>::infinity();
    for (const std::size_t i : {0, 2, 6, 8, 18, 20, 24, 26}) smallest = std::min(smallest, c[i]);
    return smallest;
}

struct Part {
    Coefficients coefficients;
    int depth;
};

/// Decides whether a polynomial is positive on the unit cube. A part that is still undecided at the limits
/// counts as not positive. `minimum` becomes the sample or bound that decided, or a lower bound.
bool positive_by_subdivision(const Coefficients& root, double& minimum) {
    std::vector<Part> parts{{root, 0}};
    minimum = std::numeric_limits<double>::infinity();
    for (std::size_t looked_at = 0; !parts.empty(); ++looked_at) {
        const Part part = parts.back();
        parts.pop_back();
        const double sample = smallest_corner(part.coefficients);
        const double bound = *std::min_element(part.coefficients.begin(), part.coefficients.end());
        const bool gives_up = part.depth == kMaxDepth || looked_at == kMaxParts;
        if (!(sample > 0) || (!(bound > 0) && gives_up)) {
            minimum = sample > 0 ? bound : sample;
            return false;
        }
        if (bound > 0) {
            minimum = std::min(minimum, bound);
            continue;
        }
        Coefficients halves[2], quarters[2];
        halve(part.coefficients, 9, halves[0], halves[1]);
        for (const Coefficients& half : halves) {
            halve(half, 3, quarters[0], quarters[1]);
            for (const Coefficients& quarter : quarters) {
                Part low{{}, part.depth + 1}, high{{}, part.depth + 1};
                halve(quarter, 1, low.coefficients, high.coefficients);
                parts.push_back(low);
                parts.push_back(high);
            }
        }
    }
    return true;
}

JacobianFigures hexahedron_figures(const Vector* p) {
    const HexahedronEdges edges = hexahedron_edges(p);
    Coefficients coefficients = jacobian_coefficients(edges);
    JacobianFigures figures;
    double smallest = coefficients[0];
    double sum = 0;
    for (const double c : coefficients) {
        smallest = std::min(smallest, c);
        sum += c;
    }
    figures.volume = sum / 27;
    figures.minimum = smallest;
    // Nearly every hexahedron ends here.
    figures.positive = smallest > kNoise * max_length(edges.a) * max_length(edges.b) * max_length(edges.c);
    if (figures.positive) return figures;
    const Coefficients scale = scale_coefficients(edges);
    for (std::size_t i = 0; i < coefficients.size(); ++i) coefficients[i] -= kNoise * scale[i];
    figures.positive = positive_by_subdivision(coefficients, figures.minimum);
    return figures;
}

JacobianFigures wedge_figures(const Vector* p) {
    const Vector bottom[2] = {p[1] - p[0], p[2] - p[0]};
    const Vector top[2] = {p[4] - p[3], p[5] - p[3]};
    JacobianFigures figures;
    figures.positive = true;
    figures.minimum = std::numeric_limits<double>::infinity();
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        const Vector up = p[i + 3] - p[i];
        const Determinant first = determinant(bottom[0], bottom[1], up);
        const Determinant mixed[2] = {determinant(bottom[0], top[1], up), determinant(top[0], bottom[1], up)};
        const Determinant last = determinant(top[0], top[1], up);
        sum += first.value + 0.5 * (mixed[0].value + mixed[1].value) + last.value;
        const double b0 = first.lower(), b1 = 0.5 * (mixed[0].lower() + mixed[1].lower()), b2 = last.lower();
        double smallest = std::min(b0, b2);
        // Only a coefficient below both ends gives a minimum between them.
        if (b1 < smallest) smallest = (b0 * b2 - b1 * b1) / (b0 - 2 * b1 + b2);
        figures.minimum = std::min(figures.minimum, smallest);
        figures.positive = figures.positive && smallest > 0;
    }
    figures.volume = sum / 18;
    return figures;
}

JacobianFigures pyramid_figures(const Vector* p) {
    JacobianFigures figures;
    figures.positive = true;
    figures.minimum = std::numeric_limits<double>::infinity();
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
        const Determinant corner = determinant(p[(i + 1) % 4] - p[i], p[(i + 3) % 4] - p[i], p[4] - p[i]);
        sum += corner.value;
        figures.minimum = std::min(figures.minimum, corner.lower());
        figures.positive = figures.positive && corner.lower() > 0;
    }
    figures.volume = sum / 12;
    return figures;
}

JacobianFigures tetrahedron_figures(const Vector* p) {
    const Determinant whole = determinant(p[1] - p[0], p[2] - p[0], p[3] - p[0]);
    return {whole.lower() > 0, whole.lower(), whole.value / 6};
}

}  // namespace

JacobianFigures jacobian_figures(ElementType type, const Corners& corners) {
    switch (type) {
        case ElementType::kHexahedron: return hexahedron_figures(corners.p);
        case ElementType::kWedge: return wedge_figures(corners.p);
        case ElementType::kPyramid: return pyramid_figures(corners.p);
        default: return tetrahedron_figures(corners.p);
    }
}

}  // namespace mortise::quality
