#include "host/quality/curved.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "host/common/constants.hpp"

namespace mortise::quality {
namespace {

constexpr double kRounding = 1e-12;  ///< of an edge's length
constexpr std::size_t kMostNodes = 20;

/// x^a y^b z^c / (1 - z)^d.
struct Monomial {
    int a, b, c, d = 0;
};

double power(double x, int exponent) { return exponent == 0 ? 1 : std::pow(x, exponent); }

double value(const Monomial& m, const Vector& x) {
    const double upper = power(x.x, m.a) * power(x.y, m.b) * power(x.z, m.c);
    if (m.d == 0 || upper == 0) return upper;  // 0 at the apex of a pyramid, which it tends to
    return upper / power(1 - x.z, m.d);
}

Vector slope(const Monomial& m, const Vector& x) {
    const auto part = [&](int a, int b, int c, int d, int factor) {
        return factor == 0 ? 0 : factor * value({a, b, c, d}, x);
    };
    return {part(m.a - 1, m.b, m.c, m.d, m.a), part(m.a, m.b - 1, m.c, m.d, m.b),
            part(m.a, m.b, m.c - 1, m.d, m.c) + part(m.a, m.b, m.c, m.d + 1, m.d)};
}

/// Powers up to the second order, which all types have.
const std::vector<Monomial> kQuadratic = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 0, 0},
                                          {0, 2, 0}, {0, 0, 2}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}};

std::vector<Monomial> basis_of(ElementType type) {
    std::vector<Monomial> basis = kQuadratic;
    const auto add = [&](const std::vector<Monomial>& more) {
        basis.insert(basis.end(), more.begin(), more.end());
    };
    switch (type) {
        case ElementType::kHexahedron:
            add({{2, 1, 0}, {2, 0, 1}, {1, 2, 0}, {0, 2, 1}, {1, 0, 2}, {0, 1, 2}, {1, 1, 1}});
            add({{2, 1, 1}, {1, 2, 1}, {1, 1, 2}});
            break;
        case ElementType::kWedge: add({{1, 1, 1}, {2, 0, 1}, {0, 2, 1}, {1, 0, 2}, {0, 1, 2}}); break;
        case ElementType::kPyramid: add({{1, 1, 0, 1}, {2, 1, 0, 1}, {1, 2, 0, 1}}); break;
        default: break;
    }
    return basis;
}

/// Corners of the reference element. The pyramid's apex is above the middle of its base.
std::vector<Vector> reference_corners(ElementType type) {
    switch (type) {
        case ElementType::kHexahedron:
            return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
        case ElementType::kWedge: return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
        case ElementType::kPyramid: return {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, 0, 1}};
        default: return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    }
}

/// A point of the reference element, and the volume of it that a unit of the cube becomes there.
struct CubePlace {
    Vector x;
    double scale;
};

/// From the unit cube, collapsed where the element has fewer corners.
CubePlace place_of(ElementType type, double p, double q, double r) {
    switch (type) {
        case ElementType::kHexahedron: return {{p, q, r}, 1};
        case ElementType::kWedge: return {{p, q * (1 - p), r}, 1 - p};
        case ElementType::kPyramid:
            return {{(2 * p - 1) * (1 - r), (2 * q - 1) * (1 - r), r}, 4 * (1 - r) * (1 - r)};
        default: return {{p * (1 - q) * (1 - r), q * (1 - r), r}, (1 - q) * (1 - r) * (1 - r)};
    }
}

/// Gauss-Legendre on [0, 1] by Newton's method on the Legendre polynomial.
std::vector<std::pair<double, double>> gauss(int count) {
    std::vector<std::pair<double, double>> points;
    for (int i = 1; i <= count; ++i) {
        double x = std::cos(kPi * (i - 0.25) / (count + 0.5)), derivative = 1;
        for (int step = 0; step < 50; ++step) {
            double before = 1, at = x;
            for (int n = 2; n <= count; ++n)
                before = std::exchange(at, ((2 * n - 1) * x * at - (n - 1) * before) / n);
            derivative = count * (x * at - before) / (x * x - 1);
            x -= at / derivative;
        }
        points.emplace_back(0.5 + 0.5 * x, 1 / ((1 - x * x) * derivative * derivative));
    }
    return points;
}

/// Solves for the coefficients of all shape functions: row by monomial, column by node.
std::vector<std::vector<double>> coefficients(const std::vector<Monomial>& basis,
                                              const std::vector<Vector>& nodes) {
    const std::size_t n = nodes.size();
    // [V | I] with V(node, monomial), turned into [I | V^-1].
    std::vector<std::vector<double>> rows(n, std::vector<double>(2 * n, 0.0));
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < n; ++k) rows[i][k] = value(basis[k], nodes[i]);
        rows[i][n + i] = 1;
    }
    for (std::size_t k = 0; k < n; ++k) {
        std::size_t pivot = k;
        for (std::size_t i = k; i < n; ++i) {
            if (std::fabs(rows[i][k]) > std::fabs(rows[pivot][k])) pivot = i;
        }
        std::swap(rows[k], rows[pivot]);
        const double lead = rows[k][k];
        for (double& entry : rows[k]) entry /= lead;
        for (std::size_t i = 0; i < n; ++i) {
            const double factor = i == k ? 0 : rows[i][k];
            for (std::size_t j = 0; factor != 0 && j < 2 * n; ++j) rows[i][j] -= factor * rows[k][j];
        }
    }
    for (auto& row : rows) row.erase(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(n));
    return rows;
}

/// Slopes of all shape functions at one point, with its weight in the quadrature (0: looked at only).
struct Sample {
    std::array<Vector, kMostNodes> slopes;
    double weight;
};

struct Rule {
    std::size_t nodes = 0;
    std::vector<Sample> samples;
};

Rule make_rule(ElementType type) {
    const std::vector<Monomial> basis = basis_of(type);
    std::vector<Vector> nodes = reference_corners(type);
    const std::vector<Vector> corners = nodes;
    const LocalEdges edges = local_edges(type);
    for (int e = 0; e < edges.count; ++e)
        nodes.push_back(0.5 * (corners[static_cast<std::size_t>(edges.edges[e][0])] +
                               corners[static_cast<std::size_t>(edges.edges[e][1])]));
    const auto shape = coefficients(basis, nodes);
    Rule rule;
    rule.nodes = nodes.size();
    const auto add = [&](const CubePlace& place, double weight) {
        Sample sample{{}, weight * place.scale};
        for (std::size_t k = 0; k < basis.size(); ++k) {
            const Vector d = slope(basis[k], place.x);
            for (std::size_t i = 0; i < nodes.size(); ++i)
                sample.slopes[i] = sample.slopes[i] + shape[k][i] * d;
        }
        rule.samples.push_back(sample);
    };
    // The Jacobian has degree 5 at most in each coordinate of the cube, the scale 2: exact.
    const auto points = gauss(4);
    for (const auto& [p, a] : points) {
        for (const auto& [q, b] : points) {
            for (const auto& [r, c] : points) add(place_of(type, p, q, r), a * b * c);
        }
    }
    constexpr double kNearApex = 0.999;  // a pyramid's Jacobian is no function of the place at its apex
    for (int i = 0; i < 125; ++i) {
        const double r = 0.25 * (i % 5);
        const double top = type == ElementType::kPyramid ? std::min(r, kNearApex) : r;
        add(place_of(type, 0.25 * (i / 25), 0.25 * (i / 5 % 5), top), 0);
    }
    return rule;
}

const Rule& rule_of(ElementType type) {
    static const std::array<Rule, kElementTypes> rules = {
        make_rule(ElementType::kHexahedron), make_rule(ElementType::kWedge), make_rule(ElementType::kPyramid),
        make_rule(ElementType::kTetrahedron)};
    return rules[static_cast<std::size_t>(type)];
}

Vector middle_between(const Vector& a, const Vector& b) { return 0.5 * (a + b); }

}  // namespace

bool is_curved(ElementType type, const Corners& corners, const Middles& middles) {
    const LocalEdges edges = local_edges(type);
    for (int e = 0; e < edges.count; ++e) {
        const Vector &a = corners.p[edges.edges[e][0]], &b = corners.p[edges.edges[e][1]];
        if (length(middles.p[e] - middle_between(a, b)) > kRounding * length(b - a)) return true;
    }
    return false;
}

JacobianFigures curved_figures(ElementType type, const Corners& corners, const Middles& middles) {
    const Rule& rule = rule_of(type);
    const auto count = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(type)]);
    std::array<Vector, kMostNodes> nodes;
    for (std::size_t i = 0; i < rule.nodes; ++i)
        nodes[i] = (i < count ? corners.p[i] : middles.p[i - count]) - corners.p[0];
    JacobianFigures figures;
    figures.minimum = std::numeric_limits<double>::infinity();
    for (const Sample& sample : rule.samples) {
        Vector x, y, z;  // rows of the matrix of derivatives
        for (std::size_t i = 1; i < rule.nodes; ++i) {
            x = x + nodes[i].x * sample.slopes[i];
            y = y + nodes[i].y * sample.slopes[i];
            z = z + nodes[i].z * sample.slopes[i];
        }
        const double jacobian = dot(x, cross(y, z));
        figures.minimum = std::min(figures.minimum, jacobian);
        figures.volume += sample.weight * jacobian;
    }
    figures.positive = figures.minimum > 0;
    return figures;
}

double curved_area(const Vector* corners, const Vector* middles, int count) {
    static const std::vector<std::pair<double, double>> points = gauss(6);
    double sum = 0;
    for (const auto& [p, a] : points) {
        for (const auto& [q, b] : points) {
            Vector along_u, along_v;
            const auto add = [&](const Vector& node, double u, double v) {
                along_u = along_u + u * node;
                along_v = along_v + v * node;
            };
            double scale = 1;
            if (count == 3) {
                // u, v and w = 1 - u - v; slopes of w (2w - 1), u (2u - 1), v (2v - 1), 4wu, 4uv, 4vw.
                const double u = p, v = q * (1 - p), w = 1 - u - v;
                scale = 1 - p;
                add(corners[0], 1 - 4 * w, 1 - 4 * w);
                add(corners[1], 4 * u - 1, 0);
                add(corners[2], 0, 4 * v - 1);
                add(middles[0], 4 * (w - u), -4 * u);
                add(middles[1], 4 * v, 4 * u);
                add(middles[2], -4 * v, 4 * (w - v));
            } else {
                // The bilinear patch, and what each middle adds to it.
                const double u = p, v = q;
                add(corners[0], v - 1, u - 1);
                add(corners[1], 1 - v, -u);
                add(corners[2], v, u);
                add(corners[3], -v, 1 - u);
                const auto bend = [&](int k) {
                    return middles[k] - middle_between(corners[k], corners[(k + 1) % 4]);
                };
                add(bend(0), 4 * (1 - 2 * u) * (1 - v), -4 * u * (1 - u));
                add(bend(1), 4 * v * (1 - v), 4 * u * (1 - 2 * v));
                add(bend(2), 4 * (1 - 2 * u) * v, 4 * u * (1 - u));
                add(bend(3), -4 * v * (1 - v), 4 * (1 - u) * (1 - 2 * v));
            }
            sum += a * b * scale * length(cross(along_u, along_v));
        }
    }
    return sum;
}

}  // namespace mortise::quality
