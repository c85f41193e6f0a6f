#include "host/improve/quality.hpp"

#include <algorithm>

#include "host/improve/quality_formula.hpp"

namespace mortise::improve {
namespace {

/// Square of the sine of the angle between faces with outward normals n and m, per square of 6 V, obtuse
/// angles weighted: the sine is 6 V · (length of their edge) / (product of the normals). The last two are
/// squares.
double sine(const Point& n, const Point& m, double edge, double product) {
    return weigh(edge / product, dot(n, m));
}

}  // namespace

double tetrahedron_quality(const Point& a, const Point& b, const Point& c, const Point& d, double rounding) {
    OppositeFace<double> face{};
    face.b = {b[0], b[1], b[2]};
    face.c = {c[0], c[1], c[2]};
    face.d = {d[0], d[1], d[2]};
    set_face(face);
    const double square = squared_quality(face, {a[0], a[1], a[2]}, rounding);
    return square < 0 ? kInvertedQuality : std::sqrt(square);
}

double smallest_height(const std::array<Point, 4>& p) {
    const auto face = [&](std::size_t a, std::size_t b, std::size_t c) {
        return squared_length(cross(p[b] - p[a], p[c] - p[a]));
    };
    const double volume = std::fabs(dot(p[1] - p[0], cross(p[2] - p[0], p[3] - p[0])));
    const double largest = std::max({face(0, 1, 2), face(0, 1, 3), face(0, 2, 3), face(1, 2, 3)});
    return largest > 0 ? volume / std::sqrt(largest) : 0;
}

double corner_quality(const Point& u, const Point& v, const Point& w, double jacobian_weight) {
    const Point uv = cross(u, v);
    const double volume = dot(uv, w);
    if (!(volume > 0)) return kInvertedQuality;
    const Point vw = cross(v, w);
    const Point wu = cross(w, u);
    const double n_uv = squared_length(uv);
    const double n_vw = squared_length(vw);
    const double n_wu = squared_length(wu);
    const double l_u = squared_length(u);
    const double l_v = squared_length(v);
    const double l_w = squared_length(w);
    double worst = jacobian_weight * jacobian_weight / (l_u * l_v * l_w);
    worst = std::min(worst, sine(uv, wu, l_u, n_uv * n_wu));
    worst = std::min(worst, sine(uv, vw, l_v, n_uv * n_vw));
    worst = std::min(worst, sine(vw, wu, l_w, n_vw * n_wu));
    return volume * std::sqrt(worst);
}

double pyramid_quality(const std::array<Point, 5>& p) {
    double worst = 1;
    for (std::size_t i = 0; i < 4; ++i) {
        worst = std::min(worst, corner_quality(p[(i + 1) % 4] - p[i], p[(i + 3) % 4] - p[i], p[4] - p[i]));
    }
    return worst;
}

}  // namespace mortise::improve
