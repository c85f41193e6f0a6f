// Qhull's hull (Barber, Dobkin & Huhdanpaa 1996) as plain data, and half-spaces by duality about a point
// inside.
#include "host/model/solids/convex_hull.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include "host/common/sort_unique.hpp"
#include "host/common/vec3.hpp"
#include "host/model/affine.hpp"
#include "host/model/agreement.hpp"
#include "host/model/text.hpp"
#include "host/model/triangles/surface_repair.hpp"

namespace mortise::model_reader {
namespace {

double extent_of(const std::vector<Vec3>& points) {
    double extent = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const auto [low, high] = std::minmax_element(
            points.begin(), points.end(), [k](const Vec3& a, const Vec3& b) { return a[k] < b[k]; });
        extent = std::max(extent, (*high)[k] - (*low)[k]);
    }
    return extent;
}

/// Whether the points span a volume, as far as `tolerance` can tell; Qhull would complain of flat input.
bool has_volume(const std::vector<Vec3>& points, double tolerance) {
    const auto farthest = [&](auto&& measure) {
        return *std::max_element(points.begin(), points.end(),
                                 [&](const Vec3& a, const Vec3& b) { return measure(a) < measure(b); });
    };
    const Vec3& origin = points[0];
    const Vec3 u = difference(farthest([&](const Vec3& p) { return length(difference(p, origin)); }), origin);
    if (!(length(u) > tolerance)) return false;
    const auto off_line = [&](const Vec3& p) { return length(cross(unit(u), difference(p, origin))); };
    const Vec3 v = difference(farthest(off_line), origin);
    const Vec3 normal = cross(unit(u), v);
    if (!(length(normal) > tolerance)) return false;
    const Vec3 n = unit(normal);
    const auto off_plane = [&](const Vec3& p) { return std::fabs(dot(n, difference(p, origin))); };
    return off_plane(farthest(off_plane)) > tolerance;
}

/// Vertices of each face of the hull, as indices of points; empty if Qhull fails.
std::vector<std::vector<std::uint32_t>> qhull_faces(const std::vector<Vec3>& points,
                                                    const std::string& options) {
    std::vector<std::vector<std::uint32_t>> faces;
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> nowhere(std::fopen("/dev/null", "w"), std::fclose);
    if (!nowhere) throw Error(ExitCode::kFiles, "/dev/null cannot be opened");
    std::vector<coordT> coordinates;
    for (const Vec3& point : points) coordinates.insert(coordinates.end(), point.begin(), point.end());
    qhT state;
    qhT* qh = &state;
    qh_zero(qh, nowhere.get());
    std::string command = "qhull Pp " + options;
    const int failure = qh_new_qhull(qh, 3, static_cast<int>(points.size()), coordinates.data(), False,
                                     command.data(), nullptr, nowhere.get());
    if (failure == 0) {
        facetT* facet = nullptr;
        vertexT* vertex = nullptr;
        vertexT** vertexp = nullptr;
        FORALLfacets {
            faces.emplace_back();
            FOREACHvertex_(facet->vertices) {
                faces.back().push_back(static_cast<std::uint32_t>(qh_pointid(qh, vertex->point)));
            }
        }
    }
    qh_freeqhull(qh, !qh_ALL);
    int left = 0;
    int blocks = 0;
    qh_memfreeshort(qh, &left, &blocks);
    return faces;
}

/// Orders the corners of a face about its middle and finds its plane.
Polytope::Face ordered_face(const std::vector<Vec3>& points, std::vector<std::uint32_t> corners,
                            const Vec3& inside) {
    std::sort(corners.begin(), corners.end());
    Vec3 middle{};
    for (const std::uint32_t i : corners) {
        for (std::size_t k = 0; k < 3; ++k) middle[k] += points[i][k] / static_cast<double>(corners.size());
    }
    // A first normal from the triangle of the largest area at the first corner.
    Vec3 normal{};
    const Vec3& first = points[corners[0]];
    std::size_t second = 1;
    for (std::size_t i = 1; i < corners.size(); ++i) {
        if (length(difference(points[corners[i]], first)) >
            length(difference(points[corners[second]], first))) {
            second = i;
        }
    }
    for (const std::uint32_t i : corners) {
        const Vec3 area = cross(difference(points[corners[second]], first), difference(points[i], first));
        if (length(area) > length(normal)) normal = area;
    }
    if (dot(normal, difference(middle, inside)) < 0) normal = {-normal[0], -normal[1], -normal[2]};
    const Affine frame = frame_along(normal, middle);
    const auto angle = [&](std::uint32_t i) {
        const Vec3 d = difference(points[i], middle);
        return std::atan2(frame[1] * d[0] + frame[5] * d[1] + frame[9] * d[2],
                          frame[0] * d[0] + frame[4] * d[1] + frame[8] * d[2]);
    };
    std::sort(corners.begin(), corners.end(), [&](std::uint32_t a, std::uint32_t b) {
        const double of_a = angle(a);
        const double of_b = angle(b);
        return of_a != of_b ? of_a < of_b : a < b;
    });
    // The mean plane (Newell), pushed out until no corner is outside.
    Vec3 sum{};
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec3 area = cross(difference(points[corners[i]], first),
                                difference(points[corners[(i + 1) % corners.size()]], first));
        for (std::size_t k = 0; k < 3; ++k) sum[k] += area[k];
    }
    Polytope::Face face;
    face.plane.normal = unit(length(sum) > 0 ? sum : normal);
    for (double& component : face.plane.normal) component += 0.0;
    face.plane.offset = -HUGE_VAL;
    for (const std::uint32_t i : corners) {
        face.plane.offset = std::max(face.plane.offset, dot(face.plane.normal, points[i]));
    }
    face.corners = std::move(corners);
    return face;
}

}  // namespace

std::optional<Polytope> convex_hull(const std::vector<Vec3>& points) {
    if (points.size() < 4) return std::nullopt;
    const double tolerance = kSame * extent_of(points);
    if (!has_volume(points, tolerance)) return std::nullopt;
    auto faces = qhull_faces(points, "C-" + number_text(tolerance));
    // Without merging of what is nearly plane, where that went wrong.
    if (faces.empty()) faces = qhull_faces(points, "");
    if (faces.empty()) return std::nullopt;

    std::vector<std::uint32_t> used;
    for (const auto& face : faces) used.insert(used.end(), face.begin(), face.end());
    sort_unique(used);
    Polytope polytope;
    Vec3 inside{};
    for (const std::uint32_t i : used) {
        polytope.vertices.push_back(points[i]);
        for (std::size_t k = 0; k < 3; ++k) inside[k] += points[i][k] / static_cast<double>(used.size());
    }
    for (auto& face : faces) {
        if (face.size() < 3) continue;
        for (std::uint32_t& i : face) {
            i = static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), i) - used.begin());
        }
        polytope.faces.push_back(ordered_face(polytope.vertices, std::move(face), inside));
    }
    std::sort(polytope.faces.begin(), polytope.faces.end(), [](const auto& a, const auto& b) {
        return a.plane.normal != b.plane.normal ? a.plane.normal < b.plane.normal : a.corners < b.corners;
    });
    return polytope;
}

double volume_of(const Polytope& polytope) { return six_volumes(triangles_of(polytope)) / 6; }

TriangleSurface triangles_of(const Polytope& polytope) {
    TriangleSurface surface;
    surface.points = polytope.vertices;
    for (const Polytope::Face& face : polytope.faces) {
        for (std::size_t i = 2; i < face.corners.size(); ++i) {
            surface.triangles.push_back({face.corners[0], face.corners[i - 1], face.corners[i]});
        }
    }
    return surface;
}

namespace {

/// A point with a large smallest distance to all planes (unit normals), from the ball of that radius about
/// the origin: the ellipsoid method (Shor 1977) with cuts through its centre. Returns the distance, which is
/// negative or zero if the planes leave nothing.
double deepest_point(const std::vector<Plane>& planes, double radius, Vec3& best) {
    // An ellipsoid { x : (x - c)' E^-1 (x - c) <= 1 }; each cut divides its volume by at least e^(1/8).
    constexpr int kCuts = 1500;
    std::array<double, 9> e = {radius * radius, 0, 0, 0, radius * radius, 0, 0, 0, radius * radius};
    Vec3 c{};
    double best_depth = -HUGE_VAL;
    for (int cut = 0; cut < kCuts; ++cut) {
        double depth = HUGE_VAL;
        const Plane* tightest = nullptr;
        for (const Plane& plane : planes) {
            const double distance = plane.offset - dot(plane.normal, c);
            if (distance >= depth) continue;
            depth = distance;
            tightest = &plane;
        }
        if (depth > best_depth) {
            best_depth = depth;
            best = c;
        }
        const Vec3& g = tightest->normal;
        Vec3 b{};
        for (std::size_t i = 0; i < 3; ++i)
            b[i] = e[3 * i] * g[0] + e[3 * i + 1] * g[1] + e[3 * i + 2] * g[2];
        const double reach = std::sqrt(dot(g, b));
        // Nothing in the ellipsoid is much deeper than what is known.
        if (!(reach > 0) || depth + reach < best_depth * (1 + 1e-3)) break;
        for (std::size_t i = 0; i < 3; ++i) c[i] -= b[i] / reach / 4;
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                e[3 * i + j] = 9.0 / 8 * (e[3 * i + j] - b[i] * b[j] / (reach * reach) / 2);
            }
        }
    }
    return best_depth;
}

}  // namespace

Boundedness vertices_of(const std::vector<Plane>& given, std::vector<Vec3>& vertices) {
    vertices.clear();
    std::vector<Plane> planes = given;
    std::vector<Vec3> normals;
    double largest = 0;
    for (Plane& plane : planes) {
        const double norm = length(plane.normal);
        plane.normal = unit(plane.normal);
        plane.offset /= norm;
        normals.push_back(plane.normal);
        largest = std::max(largest, std::fabs(plane.offset));
    }
    // Bounded if the origin is inside the hull of the normals: if a ball of radius b about it is, a point x
    // in all half-spaces has b |x| <= the largest offset.
    constexpr double kFlat = 1e-9;
    if (normals.size() < 4 || !has_volume(normals, kFlat)) return Boundedness::kUnbounded;
    double ball = HUGE_VAL;
    for (const auto& corners : qhull_faces(normals, "")) {
        const Polytope::Face face = ordered_face(normals, corners, {});
        // Oriented away from the origin: its distance says nothing of the side, other points do.
        double beyond = 0;
        for (const Vec3& normal : normals) {
            beyond = std::max(beyond, dot(face.plane.normal, normal) - face.plane.offset);
        }
        if (beyond > 1e-6) return Boundedness::kUnbounded;
        ball = std::min(ball, face.plane.offset);
    }
    if (!(ball > kFlat) || !(ball < HUGE_VAL)) return Boundedness::kUnbounded;
    const double radius = std::max(largest / ball, kFlat) * 1.01;
    Vec3 inside{};
    if (!(deepest_point(planes, radius, inside) > 1e-12 * radius)) return Boundedness::kEmpty;

    std::vector<Vec3> dual;
    for (const Plane& plane : planes) {
        const double depth = plane.offset - dot(plane.normal, inside);
        dual.push_back({plane.normal[0] / depth, plane.normal[1] / depth, plane.normal[2] / depth});
    }
    for (const auto& corners : qhull_faces(dual, "")) {
        // dot(m, y) = o for the planes y that meet in the vertex inside + m / o.
        const Plane plane = ordered_face(dual, corners, {}).plane;
        if (!(plane.offset > 0)) return Boundedness::kUnbounded;
        Vec3 vertex = inside;
        for (std::size_t k = 0; k < 3; ++k) vertex[k] += plane.normal[k] / plane.offset;
        vertices.push_back(vertex);
    }
    return vertices.size() < 4 ? Boundedness::kEmpty : Boundedness::kBounded;
}

}  // namespace mortise::model_reader
