#include "host/improve/quality.hpp"

#include <algorithm>

namespace mortise::improve {
namespace {

/// Square of the sine of the angle between faces with outward normals n and m, per square of 6 V, obtuse
/// angles weighted: the sine is 6 V · (length of their edge) / (product of the normals). The last two are
/// squares.
double sine(const Point& n, const Point& m, double edge, double product) {
    const double value = edge / product;
    return dot(n, m) > 0 ? kObtuseWeight * kObtuseWeight * value : value;
}

}  // namespace

double tetrahedron_quality(const Point& a, const Point& b, const Point& c, const Point& d, double rounding) {
    const Point ab = b - a;
    const Point ac = c - a;
    const Point ad = d - a;
    const Point abc = cross(ac, ab);  // outward normals of the faces, twice their areas long
    const double volume = -dot(abc, ad);
    if (!(volume > 0)) return kInvertedQuality;
    const Point bc = c - b;
    const Point bd = d - b;
    const Point cd = d - c;
    const Point abd = cross(ab, ad);
    const Point acd = cross(ad, ac);
    const Point bcd = cross(bc, bd);
    const double l_ab = squared_length(ab);
    const double l_ac = squared_length(ac);
    const double l_ad = squared_length(ad);
    const double l_bc = squared_length(bc);
    const double l_bd = squared_length(bd);
    const double l_cd = squared_length(cd);
    const double span = std::max(std::max(l_ab, l_ac), std::max(l_ad, std::max(l_bc, std::max(l_bd, l_cd))));
    if (!(volume > rounding * span)) return kInvertedQuality;
    const double n_abc = squared_length(abc);
    const double n_abd = squared_length(abd);
    const double n_acd = squared_length(acd);
    const double n_bcd = squared_length(bcd);
    // Squares, for one root at the end.
    double worst = sine(abc, abd, l_ab, n_abc * n_abd);
    worst = std::min(worst, sine(abc, acd, l_ac, n_abc * n_acd));
    worst = std::min(worst, sine(abd, acd, l_ad, n_abd * n_acd));
    worst = std::min(worst, sine(abc, bcd, l_bc, n_abc * n_bcd));
    worst = std::min(worst, sine(abd, bcd, l_bd, n_abd * n_bcd));
    worst = std::min(worst, sine(acd, bcd, l_cd, n_acd * n_bcd));
    const double longest = std::max(std::max(l_ab * l_ac * l_ad, l_ab * l_bc * l_bd),
                                    std::max(l_ac * l_bc * l_cd, l_ad * l_bd * l_cd));
    worst = std::min(worst, kJacobianWeight * kJacobianWeight / longest);
    return volume * std::sqrt(worst);
}

double smallest_height(const std::array<Point, 4>& p) {
    const auto face = [&](std::size_t a, std::size_t b, std::size_t c) {
        return squared_length(cross(p[b] - p[a], p[c] - p[a]));
    };
    const double volume = std::fabs(dot(p[1] - p[0], cross(p[2] - p[0], p[3] - p[0])));
    const double largest = std::max({face(0, 1, 2), face(0, 1, 3), face(0, 2, 3), face(1, 2, 3)});
    return largest > 0 ? volume / std::sqrt(largest) : 0;
}

double corner_quality(const Point& u, const Point& v, const Point& w) {
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
    double worst = kJacobianWeight * kJacobianWeight / (l_u * l_v * l_w);
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
