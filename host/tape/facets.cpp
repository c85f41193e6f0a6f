#include "host/tape/facets.hpp"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numeric>

#include "host/tape/affine_map.hpp"
#include "host/tape/smooth_faces.hpp"

namespace mortise::tape {
namespace {

constexpr double kFlat = 1e-6;     ///< of the surface's size: written coordinates have 6 or 7 digits
constexpr double kSameWay = 0.9;   ///< least cosine between normals of a group; slivers tell nothing
constexpr double kNoArea = 1e-14;  ///< of the size squared

/// Numbers points so that equal places have equal numbers.
std::vector<std::uint32_t> weld(const std::vector<Vec3>& points) {
    std::vector<std::uint32_t> order(points.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        return points[a] != points[b] ? points[a] < points[b] : a < b;
    });
    std::vector<std::uint32_t> number(points.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool same = i > 0 && points[order[i]] == points[order[i - 1]];
        number[order[i]] = same ? number[order[i - 1]] : order[i];
    }
    return number;
}

std::vector<std::array<std::uint32_t, 3>> neighbours(const TriangleSurface& surface) {
    struct Side {
        std::uint32_t low;
        std::uint32_t high;
        std::uint32_t triangle;
        std::uint32_t edge;
    };
    const std::vector<std::uint32_t> number = weld(surface.points);
    std::vector<Side> sides;
    sides.reserve(3 * surface.triangles.size());
    for (std::uint32_t t = 0; t < surface.triangles.size(); ++t) {
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t a = number[surface.triangles[t][k]];
            const std::uint32_t b = number[surface.triangles[t][(k + 1) % 3]];
            sides.push_back({std::min(a, b), std::max(a, b), t, k});
        }
    }
    std::sort(sides.begin(), sides.end(), [](const Side& p, const Side& q) {
        if (p.low != q.low) return p.low < q.low;
        if (p.high != q.high) return p.high < q.high;
        return p.triangle < q.triangle;
    });
    std::vector<std::array<std::uint32_t, 3>> result(surface.triangles.size(),
                                                     {Facets::kNone, Facets::kNone, Facets::kNone});
    for (std::size_t i = 0; i < sides.size();) {
        std::size_t j = i;
        while (j < sides.size() && sides[j].low == sides[i].low && sides[j].high == sides[i].high) ++j;
        if (j == i + 2) {
            result[sides[i].triangle][sides[i].edge] = sides[i + 1].triangle;
            result[sides[i + 1].triangle][sides[i + 1].edge] = sides[i].triangle;
        }
        i = j;
    }
    return result;
}

}  // namespace

Facets find_facets(const TriangleSurface& surface, double sharp_angle) {
    Facets facets;
    const std::size_t count = surface.triangles.size();
    facets.of_triangle.assign(count, Facets::kNone);
    if (surface.points.empty()) return facets;
    glm::dvec3 low = to_vector(surface.points[0]);
    glm::dvec3 high = low;
    for (const Vec3& point : surface.points) {
        low = glm::min(low, to_vector(point));
        high = glm::max(high, to_vector(point));
    }
    const double size = glm::length(high - low);
    std::vector<glm::dvec3> normal(count);  // twice the area long
    std::vector<double> area(count);
    for (std::size_t t = 0; t < count; ++t) {
        const auto& corner = surface.triangles[t];
        const glm::dvec3 a = to_vector(surface.points[corner[0]]);
        normal[t] =
            glm::cross(to_vector(surface.points[corner[1]]) - a, to_vector(surface.points[corner[2]]) - a);
        area[t] = glm::length(normal[t]);
    }
    facets.across = neighbours(surface);
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return area[a] > area[b]; });
    std::vector<std::uint32_t> open;
    for (const std::uint32_t seed : order) {
        if (facets.of_triangle[seed] != Facets::kNone) continue;
        if (!(area[seed] > kNoArea * size * size)) break;  // the rest is smaller still
        const auto group = static_cast<std::uint32_t>(facets.planes.size());
        const glm::dvec3 n = normal[seed] / area[seed];
        const double d = -glm::dot(n, to_vector(surface.points[surface.triangles[seed][0]]));
        facets.planes.push_back({n.x, n.y, n.z, d});
        facets.of_triangle[seed] = group;
        open.assign(1, seed);
        while (!open.empty()) {
            const std::uint32_t at = open.back();
            open.pop_back();
            for (const std::uint32_t next : facets.across[at]) {
                if (next == Facets::kNone || facets.of_triangle[next] != Facets::kNone) continue;
                if (!surface.group.empty() && surface.group[next] != surface.group[seed]) continue;
                if (glm::dot(normal[next], n) < kSameWay * area[next]) continue;
                bool flat = true;
                for (const std::uint32_t corner : surface.triangles[next]) {
                    flat =
                        flat && std::fabs(glm::dot(n, to_vector(surface.points[corner])) + d) <= kFlat * size;
                }
                if (!flat) continue;
                facets.of_triangle[next] = group;
                open.push_back(next);
            }
        }
    }
    find_patches(surface, sharp_angle, facets);
    return facets;
}

}  // namespace mortise::tape
