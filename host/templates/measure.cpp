// Geometry and quality of template elements; see measure.hpp for the definitions.
#include "host/templates/measure.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/constants.hpp"
#include "host/common/vec3.hpp"
#include "kernels/shared/corners.h"

namespace mortise::templates {
namespace {

Point operator-(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double det(const Point& a, const Point& b, const Point& c) { return dot(cross(a, b), c); }
Point blend(const Point& a, const Point& b, double t) {
    return {a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t, a[2] + (b[2] - a[2]) * t};
}

/// Coefficients below this are rounding noise of coordinates near 1 (volumes of real elements are larger).
constexpr double kNoise = 1e-14;

/// A corner and the ends of its three edges, right-handed.
using Corner = std::array<int, 4>;
#define MORTISE_CORNER(node, first, second, third) Corner{node, first, second, third},
constexpr Corner kHexahedronCorners[] = {MORTISE_HEXAHEDRON_CORNERS(MORTISE_CORNER)};
constexpr Corner kWedgeCorners[] = {MORTISE_WEDGE_CORNERS(MORTISE_CORNER)};
constexpr Corner kPyramidCorners[] = {MORTISE_PYRAMID_CORNERS(MORTISE_CORNER)};
constexpr Corner kTetrahedronCorners[] = {MORTISE_TETRAHEDRON_CORNERS(MORTISE_CORNER)};
#undef MORTISE_CORNER

struct Corners {
    const Corner* first;
    int count;
};

Corners corners_of(ElementType type) {
    switch (type) {
        case ElementType::kHexahedron: return {kHexahedronCorners, 8};
        case ElementType::kWedge: return {kWedgeCorners, 6};
        case ElementType::kPyramid: return {kPyramidCorners, 4};
        default: return {kTetrahedronCorners, 4};
    }
}

class Placed {
  public:
    Placed(const Element& element, const Positions& positions) : element_(element), positions_(positions) {}
    const Point& operator[](int local) const {
        return positions_[element_.nodes[static_cast<std::size_t>(local)]];
    }

  private:
    const Element& element_;
    const Positions& positions_;
};

/// The middle Bernstein coefficient of the parabola through values at 0, 1/2 and 1.
double middle_coefficient(double first, double middle, double last) {
    return 2 * middle - 0.5 * (first + last);
}

double hexahedron_jacobian(const Placed& at, double u, double v, double w) {
    const auto bilinear = [](const Point& a, const Point& b, const Point& c, const Point& d, double s,
                             double t) { return blend(blend(a, b, s), blend(d, c, s), t); };
    // Each column blends the four edges along one parameter.
    const Point du = bilinear(at[1] - at[0], at[2] - at[3], at[6] - at[7], at[5] - at[4], v, w);
    const Point dv = bilinear(at[3] - at[0], at[2] - at[1], at[6] - at[5], at[7] - at[4], u, w);
    const Point dw = bilinear(at[4] - at[0], at[5] - at[1], at[6] - at[2], at[7] - at[3], u, v);
    return det(du, dv, dw);
}

double smallest_coefficient(const Element& element, const Positions& positions) {
    const Placed at(element, positions);
    double smallest = 1e300;
    if (element.type == ElementType::kHexahedron) {
        // Degree 2 in each parameter: sample 3 x 3 x 3, then turn values into coefficients axis by axis.
        std::array<double, 27> c{};
        for (int i = 0; i < 27; ++i) {
            const int u = i % 3, v = i / 3 % 3, w = i / 9;
            c[static_cast<std::size_t>(i)] = hexahedron_jacobian(at, 0.5 * u, 0.5 * v, 0.5 * w);
        }
        for (const std::size_t stride : {std::size_t{1}, std::size_t{3}, std::size_t{9}}) {
            for (std::size_t i = 0; i < 27; ++i) {
                if (i / stride % 3 == 1) c[i] = middle_coefficient(c[i - stride], c[i], c[i + stride]);
            }
        }
        return *std::min_element(c.begin(), c.end());
    }
    if (element.type == ElementType::kWedge) {
        // Linear over the triangle, degree 2 along the axis.
        for (int i = 0; i < 3; ++i) {
            const Point dw = at[i + 3] - at[i];
            const auto value = [&](double w) {
                return det(blend(at[1] - at[0], at[4] - at[3], w), blend(at[2] - at[0], at[5] - at[3], w),
                           dw);
            };
            const double first = value(0), last = value(1);
            smallest = std::min({smallest, first, middle_coefficient(first, value(0.5), last), last});
        }
        return smallest;
    }
    // A pyramid's Jacobian is (1 - w)^2 times a bilinear function: its base corners decide.
    const Corners corners = corners_of(element.type);
    for (int i = 0; i < corners.count; ++i) {
        const Corner& c = corners.first[i];
        smallest = std::min(smallest, det(at[c[1]] - at[c[0]], at[c[2]] - at[c[0]], at[c[3]] - at[c[0]]));
    }
    return smallest;
}

/// One end of an element edge, with the next node there in each of the edge's two faces.
struct Hinge {
    int start, end, left, right;
};

std::vector<Hinge> hinges_of(ElementType type) {
    const LocalFaces local = local_faces(type);
    std::vector<Hinge> hinges;
    const auto size = [&](int f) { return local.faces[f][3] < 0 ? 3 : 4; };
    const auto node = [&](int f, int i) {
        return local.faces[f][static_cast<std::size_t>((i + size(f)) % size(f))];
    };
    for (int f = 0; f < local.count; ++f) {
        for (int i = 0; i < size(f); ++i) {
            for (int g = 0; g < local.count; ++g) {
                for (int j = 0; j < size(g); ++j) {
                    if (node(g, j) != node(f, i + 1) || node(g, j + 1) != node(f, i)) continue;
                    hinges.push_back({node(f, i), node(f, i + 1), node(f, i + 2), node(g, j - 1)});
                }
            }
        }
    }
    return hinges;
}

/// The open interval of offsets for which the normal cuts the pattern off.
std::array<double, 2> offsets(Pattern pattern, const Point& normal) {
    std::array<double, 2> interval = {-1e300, 1e300};
    for (int c = 0; c < kCorners; ++c) {
        const double at = (c & 1) * normal[0] + (c >> 1 & 1) * normal[1] + (c >> 2 & 1) * normal[2];
        if ((pattern >> c & 1) != 0) {
            interval[0] = std::max(interval[0], at);
        } else {
            interval[1] = std::min(interval[1], at);
        }
    }
    return interval;
}

Point random_normal(Pattern pattern, Random& random) {
    for (;;) {
        Point n{};
        for (double& x : n) x = 2 * random.uniform() - 1;
        const double length = std::sqrt(dot(n, n));
        if (length > 1 || length < 1e-3) continue;
        for (double& x : n) x /= length;
        const auto interval = offsets(pattern, n);
        if (interval[0] < interval[1]) return n;
    }
}

Positions corner_positions() {
    Positions positions{};
    for (std::size_t c = 0; c < kCorners; ++c) {
        for (std::size_t a = 0; a < 3; ++a) positions[c][a] = static_cast<double>(c >> a & 1U);
    }
    return positions;
}

void place_cut(Positions& positions, int edge, double t) {
    Point& cut = positions[static_cast<std::size_t>(kFirstCut + edge)];
    cut = positions[static_cast<std::size_t>(edge_corners(edge)[0])];
    cut[static_cast<std::size_t>(edge / 4)] = t;
}

}  // namespace

Plane random_plane(Pattern pattern, Random& random) {
    const Point normal = random_normal(pattern, random);
    const auto interval = offsets(pattern, normal);
    return {normal, interval[0] + (interval[1] - interval[0]) * random.uniform()};
}

Plane extreme_plane(Pattern pattern, Random& random) {
    const Point normal = random_normal(pattern, random);
    const auto interval = offsets(pattern, normal);
    double fraction = 0.5;
    const double decades = 6 * random.uniform();
    for (int i = 0; i < static_cast<int>(decades); ++i) fraction *= 0.1;
    fraction *= 1 - 0.9 * (decades - static_cast<int>(decades));
    if (random.uniform() < 0.5) fraction = 1 - fraction;
    return {normal, interval[0] + (interval[1] - interval[0]) * fraction};
}

Positions plane_positions(Pattern pattern, const Plane& plane, double margin) {
    Positions positions = corner_positions();
    const NodeSet nodes = pattern_nodes(pattern);
    for (int e = 0; e < kEdges; ++e) {
        if ((nodes >> (kFirstCut + e) & 1U) == 0) continue;
        const double at = dot(plane.normal, positions[static_cast<std::size_t>(edge_corners(e)[0])]);
        const double t = (plane.offset - at) / plane.normal[static_cast<std::size_t>(e / 4)];
        place_cut(positions, e, std::clamp(t, margin, 1 - margin));
    }
    return positions;
}

Positions independent_positions(Pattern pattern, double low, double high, Random& random) {
    Positions positions = corner_positions();
    const NodeSet nodes = pattern_nodes(pattern);
    for (int e = 0; e < kEdges; ++e) {
        if ((nodes >> (kFirstCut + e) & 1U) != 0) {
            place_cut(positions, e, low + (high - low) * random.uniform());
        }
    }
    return positions;
}

Point mean(const Positions& positions, NodeSet nodes) {
    Point sum{};
    for (std::size_t i = 0; i < kNodeCodes; ++i) {
        if ((nodes >> i & 1U) == 0) continue;
        for (std::size_t a = 0; a < 3; ++a) sum[a] += positions[i][a];
    }
    for (double& x : sum) x /= bits(nodes);
    return sum;
}

double scaled_jacobian(const Element& element, const Positions& positions) {
    const Placed at(element, positions);
    const Corners corners = corners_of(element.type);
    double smallest = 1;
    for (int i = 0; i < corners.count; ++i) {
        const Corner& c = corners.first[i];
        const Point a = at[c[1]] - at[c[0]];
        const Point b = at[c[2]] - at[c[0]];
        const Point d = at[c[3]] - at[c[0]];
        smallest = std::min(smallest, det(a, b, d) / std::sqrt(dot(a, a) * dot(b, b) * dot(d, d)));
    }
    return smallest;
}

bool is_positive(const Element& element, const Positions& positions) {
    return smallest_coefficient(element, positions) > kNoise;
}

Cosines dihedral_cosines(const Element& element, const Positions& positions) {
    static const std::array<std::vector<Hinge>, kElementTypes> hinges = {
        hinges_of(ElementType::kHexahedron), hinges_of(ElementType::kWedge), hinges_of(ElementType::kPyramid),
        hinges_of(ElementType::kTetrahedron)};
    const Placed at(element, positions);
    Cosines result;
    for (const Hinge& hinge : hinges[static_cast<std::size_t>(element.type)]) {
        const Point edge = at[hinge.end] - at[hinge.start];
        const Point m = cross(edge, at[hinge.left] - at[hinge.end]);
        const Point n = cross(edge, at[hinge.right] - at[hinge.end]);
        const double cosine = dot(m, n) / std::sqrt(dot(m, m) * dot(n, n));
        result.smallest = std::min(result.smallest, cosine);
        result.largest = std::max(result.largest, cosine);
    }
    return result;
}

double enclosed_volume(const std::vector<Facet>& facets, const Positions& positions) {
    double six = 0;
    for (const Facet& f : facets) {
        const auto p = [&](int i) -> const Point& { return positions[f.nodes[static_cast<std::size_t>(i)]]; };
        six += f.size == 3 ? det(p(0), p(1), p(2))
                           : 0.5 * (det(p(0), p(1), p(2)) + det(p(0), p(2), p(3)) + det(p(0), p(1), p(3)) +
                                    det(p(1), p(2), p(3)));
    }
    return six / 6;
}

double degrees(double cosine) { return std::acos(std::clamp(cosine, -1.0, 1.0)) * kDegrees; }

}  // namespace mortise::templates
