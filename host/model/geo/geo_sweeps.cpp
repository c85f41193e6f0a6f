// Netgen's extrusion and revolution: see geo_sweeps.hpp.
#include "host/model/geo/geo_sweeps.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "host/common/constants.hpp"
#include "host/common/parting.hpp"
#include "host/common/vec3.hpp"
#include "host/model/affine.hpp"
#include "host/model/outlines/polygon_triangles.hpp"
#include "host/model/outlines/polygons.hpp"
#include "host/model/solids/extrusion.hpp"
#include "host/model/triangles/surface_repair.hpp"

namespace mortise::model_reader {
namespace {

constexpr std::uint32_t kSlices = 192;   ///< of a revolution
constexpr double kMostTriangles = 2e6;   ///< of one solid
constexpr double kSharp = 20;            ///< degrees; chords meet at two
constexpr double kSmoothJoint = 0.01;    ///< radians: pieces that meet at less are one face
constexpr double kStraightJoint = 1e-6;  ///< radians: no kink
constexpr double kSharpestKink = 170;    ///< degrees, of a path
constexpr double kOnAxis = 1e-9;         ///< relative to the profile's extent
constexpr double kFit = 1e-6;            ///< of two sections at a kink, relative to their extent

[[noreturn]] void refuse(const std::string& message) { throw Error(ExitCode::kInput, message); }

Vec3 along(const Vec3& point, double t, const Vec3& direction) {
    return {point[0] + t * direction[0], point[1] + t * direction[1], point[2] + t * direction[2]};
}

/// A profile as a polygon. Edge k goes from point k to the next one and belongs to face[k].
struct Outline {
    std::vector<Vec2> points;
    std::vector<std::uint32_t> face;
    std::uint32_t faces = 0;
    double extent = 0;
    bool closed = false;
    bool one_name = false;  ///< for all faces
};

/// A smooth face that meets itself at the profile's only corner becomes two.
void part_at_corner(const std::vector<CurvePoint>& points, Outline& outline) {
    const std::size_t n = points.size();
    const auto corner = std::find_if(points.begin(), points.end(), [](const CurvePoint& p) {
        return angle_between(p.before, p.after) > kSmoothJoint;
    });
    if (corner == points.end()) return;
    std::vector<double> turns;
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3& p = points[i].point;
        turns.push_back(angle_between(difference(p, points[(i + n - 1) % n].point),
                                      difference(points[(i + 1) % n].point, p)));
    }
    outline.face = parts_of_ring(std::move(turns), static_cast<std::size_t>(corner - points.begin()));
    outline.faces = 2;
    outline.one_name = true;
}

Outline outline_of(const GeoCurve& profile) {
    const std::vector<CurvePoint> points = divided(profile);
    Outline outline;
    outline.closed = profile.closed;
    // Pieces that go on smoothly share a face.
    std::vector<std::uint32_t> face_of(profile.pieces.size(), 0);
    for (std::size_t k = 1; k < points.size(); ++k) {
        const std::uint32_t piece = points[k].piece;
        if (piece == points[k - 1].piece) continue;
        face_of[piece] =
            face_of[piece - 1] + (angle_between(points[k].before, points[k].after) > kSmoothJoint ? 1 : 0);
    }
    outline.faces = face_of.back() + 1;
    if (outline.closed && outline.faces > 1 &&
        angle_between(points[0].before, points[0].after) <= kSmoothJoint) {
        for (std::uint32_t& face : face_of) face %= outline.faces - 1;
        --outline.faces;
    }
    for (const CurvePoint& p : points) {
        outline.points.push_back({p.point[0], p.point[1]});
        outline.face.push_back(face_of[p.piece]);
        outline.extent = std::max({outline.extent, std::fabs(p.point[0]), std::fabs(p.point[1])});
    }
    if (outline.closed && outline.faces == 1) part_at_corner(points, outline);
    return outline;
}

/// The area enclosed must be what the loop's own area is: that is so if it does not cross itself.
void refuse_crossing(const Outline& outline) {
    const double area = signed_area(outline.points);
    double enclosed = 0;
    for (const auto& loop : normalised({outline.points})) enclosed += std::fabs(signed_area(loop));
    const double least = 1e-12 * outline.extent * outline.extent;
    if (!(std::fabs(area) > least)) refuse("the profile encloses no area");
    if (std::fabs(enclosed - std::fabs(area)) > 1e-7 * std::fabs(area)) refuse("the profile crosses itself");
}

/// Triangles with names for their faces. A single name is none.
class Shell {
  public:
    explicit Shell(const Outline& outline) {
        const bool is_single = outline.faces == 1 || outline.one_name;
        for (std::uint32_t k = 0; k < outline.faces; ++k)
            surface.group_names.push_back(is_single ? "side" : "side" + std::to_string(k + 1));
    }
    void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t face) {
        if (a == b || b == c || c == a) return;
        surface.triangles.push_back({a, b, c});
        surface.group.push_back(face);
    }
    /// Divided along the shorter diagonal.
    void quadrilateral(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d,
                       std::uint32_t face) {
        const auto& p = surface.points;
        if (length(difference(p[a], p[c])) <= length(difference(p[b], p[d]))) {
            triangle(a, b, c, face);
            triangle(a, c, d, face);
        } else {
            triangle(a, b, d, face);
            triangle(b, c, d, face);
        }
    }
    Primitive finish(bool flat) {
        std::vector<std::string>& names = surface.group_names;
        if (names.size() == 1) {
            surface.group.clear();
            names.clear();
        } else if (std::count(names.begin(), names.end(), names[0]) ==
                   static_cast<std::ptrdiff_t>(names.size())) {
            std::fill(names.begin(), names.end(), "");
        }
        if (six_volumes(surface) < 0) {
            for (auto& t : surface.triangles) std::swap(t[1], t[2]);
        }
        return polyhedron(std::move(surface), flat ? 0 : kSharp);
    }

    TriangleSurface surface;
};

/// Directions in which the profile's two coordinates count.
struct Section {
    Vec3 x{}, z{};
};

Section section_at(const Vec3& tangent, const Vec3& up) {
    const Vec3 side = cross(tangent, up);
    if (!(length(side) > 1e-6)) {
        refuse("the path runs along the z direction; expected a direction that the path never takes");
    }
    const Vec3 x = unit(side);
    return {x, cross(x, tangent)};
}

/// The profile at a point of the path, moved along the tangent onto the plane through that point.
std::vector<Vec3> ring_on(const Outline& outline, const Vec3& origin, const Vec3& tangent, const Vec3& up,
                          const Vec3& normal) {
    const Section section = section_at(tangent, up);
    const double rise = dot(tangent, normal);
    std::vector<Vec3> ring;
    ring.reserve(outline.points.size());
    for (const Vec2& p : outline.points) {
        const Vec3 offset = along(along({}, p[0], section.x), p[1], section.z);
        ring.push_back(along(along(origin, 1, offset), -dot(offset, normal) / rise, tangent));
    }
    return ring;
}

std::vector<Vec3> ring_at(const Outline& outline, const CurvePoint& at, const Vec3& up) {
    const double kink = angle_between(at.before, at.after);
    if (kink <= kStraightJoint) return ring_on(outline, at.point, at.after, up, at.after);
    if (kink > kSharpestKink * kPi / 180) refuse("the path turns back on itself");
    const Vec3 normal = unit(along(at.before, 1, at.after));
    std::vector<Vec3> ring = ring_on(outline, at.point, at.before, up, normal);
    const std::vector<Vec3> next = ring_on(outline, at.point, at.after, up, normal);
    for (std::size_t k = 0; k < ring.size(); ++k) {
        if (length(difference(ring[k], next[k])) > kFit * outline.extent) {
            refuse(
                "the sections on both sides of a kink of the path do not fit, for the profile turns there; "
                "round the kink by a spline, or choose a z direction across both directions");
        }
    }
    return ring;
}

void check_size(double profile, double path) {
    if (2 * profile * path > kMostTriangles) {
        refuse("profile and path have too many curved pieces: " + number_text(2 * profile * path) +
               " triangles or more; expected at most " + number_text(kMostTriangles));
    }
}

/// The profile's points on the axis become one point each, the others rings.
Primitive revolved(const Outline& outline, const Affine& frame) {
    check_size(static_cast<double>(outline.points.size()), kSlices);
    Shell shell(outline);
    std::vector<std::uint32_t> first;
    for (const Vec2& p : outline.points) {
        first.push_back(static_cast<std::uint32_t>(shell.surface.points.size()));
        const bool on_axis = p[1] <= kOnAxis * outline.extent;
        for (std::uint32_t slice = 0; slice < (on_axis ? 1 : kSlices); ++slice) {
            const double angle = 2 * kPi * slice / kSlices;
            const Vec3 local = {on_axis ? 0 : p[1] * std::cos(angle), on_axis ? 0 : p[1] * std::sin(angle),
                                p[0]};
            Vec3 point{};
            for (std::size_t k = 0; k < 3; ++k) {
                point[k] = frame[4 * k] * local[0] + frame[4 * k + 1] * local[1] +
                           frame[4 * k + 2] * local[2] + frame[4 * k + 3];
            }
            shell.surface.points.push_back(point);
        }
    }
    first.push_back(static_cast<std::uint32_t>(shell.surface.points.size()));
    const auto corner = [&first](std::size_t k, std::uint32_t slice) {
        return first[k] + slice % (first[k + 1] - first[k]);
    };
    const std::size_t count = outline.points.size();
    for (std::size_t k = 0; k < (outline.closed ? count : count - 1); ++k) {
        const std::size_t next = (k + 1) % count;
        for (std::uint32_t slice = 0; slice < kSlices; ++slice) {
            shell.quadrilateral(corner(k, slice), corner(next, slice), corner(next, slice + 1),
                                corner(k, slice + 1), outline.face[k]);
        }
    }
    return shell.finish(false);
}

}  // namespace

Primitive sweep_along(const GeoCurve& profile, const GeoCurve& path, const Vec3& up) {
    if (!profile.closed) refuse("the profile is open; expected one that ends where it starts");
    check_size(static_cast<double>(profile.pieces.size()), static_cast<double>(path.pieces.size()));
    check_size(most_points(profile) / 3, most_points(path) / 3);
    const Outline outline = outline_of(profile);
    refuse_crossing(outline);
    const std::vector<CurvePoint> stations = divided(path);
    check_size(static_cast<double>(outline.points.size()), static_cast<double>(stations.size()));
    const auto count = static_cast<std::uint32_t>(outline.points.size());
    const Vec3 z = unit(up);

    Shell shell(outline);
    for (const CurvePoint& station : stations) {
        const std::vector<Vec3> ring = ring_at(outline, station, z);
        shell.surface.points.insert(shell.surface.points.end(), ring.begin(), ring.end());
    }
    const std::size_t steps = path.closed ? stations.size() : stations.size() - 1;
    for (std::size_t k = 0; k < steps; ++k) {
        const std::size_t next = (k + 1) % stations.size();
        const auto here = static_cast<std::uint32_t>(k * count);
        const auto there = static_cast<std::uint32_t>(next * count);
        for (std::uint32_t i = 0; i < count; ++i) {
            const Vec3 step = difference(shell.surface.points[there + i], shell.surface.points[here + i]);
            if (!(dot(step, stations[k].after) > 0 && dot(step, stations[next].before) > 0)) {
                refuse(
                    "the profile reaches beyond the centre of a bend of the path; expected a smaller profile "
                    "or a wider bend");
            }
            const std::uint32_t j = (i + 1) % count;
            shell.quadrilateral(here + i, here + j, there + j, there + i, outline.face[i]);
        }
    }
    if (!path.closed) {
        std::vector<std::uint32_t> corners(count);
        for (const bool at_end : {false, true}) {
            for (std::uint32_t i = 0; i < count; ++i) {
                corners[i] =
                    at_end ? static_cast<std::uint32_t>((stations.size() - 1) * count + i) : count - 1 - i;
            }
            triangulate_polygon(shell.surface.points, corners, shell.surface.triangles);
            const auto face = static_cast<std::uint32_t>(shell.surface.group_names.size());
            shell.surface.group_names.emplace_back(at_end ? "end" : "start");
            shell.surface.group.resize(shell.surface.triangles.size(), face);
        }
    }
    return shell.finish(profile.has_lines_only() && path.has_lines_only());
}

std::uint32_t add_revolution(Model& model, const GeoCurve& profile, const Vec3& origin, const Vec3& axis,
                             SourceLocation where) {
    check_size(most_points(profile) / 3, kSlices);
    Outline outline = outline_of(profile);
    if (!outline.closed && (outline.points.front()[1] > kOnAxis * outline.extent ||
                            outline.points.back()[1] > kOnAxis * outline.extent)) {
        refuse(
            "the profile is open and does not end on the axis (second coordinate 0); expected a closed one, "
            "or both ends on the axis");
    }
    for (Vec2& p : outline.points) {
        if (p[1] < -kOnAxis * outline.extent) {
            refuse("the profile reaches to " + number_text(p[1]) +
                   " in its second coordinate, the distance from the axis; expected none below 0");
        }
        p[1] = std::max(p[1], 0.0);
    }
    refuse_crossing(outline);
    const Affine frame = frame_along(axis, origin);
    if (!profile.has_lines_only()) return model.add_primitive(revolved(outline, frame), {}, where);

    std::vector<Vec2> loop;
    for (const Vec2& p : outline.points) loop.push_back({p[1], p[0]});
    FlatTree tree;
    const std::uint32_t root = tree.add_contours({loop});
    const std::size_t first = model.nodes.size();
    const std::optional<std::uint32_t> solid = rotary_extrusion(model, tree, root, {}, {}, where);
    if (!solid) refuse("the profile encloses no area");
    // All faces are called after the solid of the file.
    for (std::size_t k = first; k < model.nodes.size(); ++k) {
        model.nodes[k].name.clear();
        for (Plane& plane : model.nodes[k].primitive.planes) plane.name.clear();
    }
    return model.add_transform(frame, *solid);
}

}  // namespace mortise::model_reader
