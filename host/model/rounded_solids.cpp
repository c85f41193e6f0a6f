// Exact hulls of discs and spheres: see rounded_solids.hpp.
//
// Why this is the hull: let p be a corner of the hull of the centres (an edge, seen along itself, is a corner
// in the plane), with the neighbouring faces' normals n1 and n2. What lies beyond the plane through the two
// points p + r n1 and p + r n2, and inside the faces' planes, lies in the normal cone of p, so that p is its
// nearest centre: the solid is the ball of radius r there. Elsewhere only the faces' planes bound it.
#include "host/model/rounded_solids.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "host/model/affine.hpp"
#include "host/model/convex_hull.hpp"

namespace mortise::model_reader {
namespace {

constexpr double kTurn = 6.283185307179586;
constexpr double kSame = 1e-6;

Vec3 difference(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec3 scaled(const Vec3& v, double by) { return {v[0] * by, v[1] * by, v[2] * by}; }
Vec3 sum(const Vec3& a, const Vec3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

std::uint32_t add_half_spaces(Model& model, std::vector<Plane> planes, const std::string& name) {
    Primitive primitive;
    primitive.planes = std::move(planes);
    return model.add_primitive(std::move(primitive), name);
}

void number_planes(std::vector<Plane>& planes) {
    std::size_t number = 0;
    for (Plane& plane : planes) {
        if (plane.name.empty()) plane.name = "side" + std::to_string(++number);
    }
}

std::uint32_t add_ball(Model& model, const Vec3& center, double radius, const std::string& name) {
    const std::uint32_t ball = model.add_primitive(sphere(radius), name);
    return center == Vec3{} ? ball : model.add_transform(translation(center), ball);
}

/// The infinite cylinder about the line through a and b.
std::uint32_t add_tube(Model& model, const Vec3& a, const Vec3& b, double radius, const std::string& name) {
    const std::uint32_t tube = model.add_primitive(infinite_cylinder(radius), name);
    return model.add_transform(frame_along(difference(b, a), a), tube);
}

std::uint32_t unite(Model& model, std::vector<std::uint32_t> children) {
    return children.size() == 1 ? children[0] : model.add_operation(CsgNode::Op::kUnion, std::move(children));
}

std::uint32_t intersect(Model& model, std::vector<std::uint32_t> children, const std::string& name,
                        const Box3& bounds) {
    const std::uint32_t node = model.add_operation(CsgNode::Op::kIntersection, std::move(children), name);
    model.nodes[node].bounds = bounds;
    return node;
}

/// The box of points, wider by `margin` and by what rounding may need.
Box3 box_of(const std::vector<Vec3>& points, double margin) {
    Box3 box{points[0], points[0]};
    for (const Vec3& point : points) {
        for (std::size_t k = 0; k < 3; ++k) {
            box.min[k] = std::min(box.min[k], point[k]);
            box.max[k] = std::max(box.max[k], point[k]);
        }
    }
    for (std::size_t k = 0; k < 3; ++k) {
        const double rounding = 1e-9 * (margin + std::max(std::fabs(box.min[k]), std::fabs(box.max[k])));
        box.min[k] -= margin + rounding;
        box.max[k] += margin + rounding;
    }
    return box;
}

/// What the hull of centres is made of: its faces' outward normals with a point each, its edges with the
/// normals of the two faces beside, and each vertex's neighbours. A polygon has two faces, a segment none.
struct Skeleton {
    struct Edge {
        std::array<std::size_t, 2> ends;
        Vec3 outward;  ///< unit, between the normals of the faces beside
        double depth;  ///< cosine of half the angle between these normals
    };
    std::vector<Vec3> vertices;
    std::vector<std::pair<Vec3, Vec3>> faces;  ///< normal, point
    std::vector<Edge> edges;
};

std::optional<Skeleton> skeleton_of(const Polytope& polytope) {
    Skeleton skeleton;
    skeleton.vertices = polytope.vertices;
    std::map<std::pair<std::size_t, std::size_t>, Vec3> sides;
    for (const Polytope::Face& face : polytope.faces) {
        skeleton.faces.emplace_back(face.plane.normal, polytope.vertices[face.corners[0]]);
        for (std::size_t i = 0; i < face.corners.size(); ++i) {
            const std::size_t from = face.corners[i];
            const std::size_t to = face.corners[(i + 1) % face.corners.size()];
            sides[{from, to}] = face.plane.normal;
        }
    }
    for (const auto& [side, normal] : sides) {
        const auto other = sides.find({side.second, side.first});
        if (other == sides.end()) return std::nullopt;
        if (side.first > side.second) continue;
        const Vec3 middle = sum(normal, other->second);
        skeleton.edges.push_back({{side.first, side.second}, unit(middle), length(middle) / 2});
    }
    return skeleton;
}

/// Centres in one plane or on one line.
Skeleton flat_skeleton(const std::vector<Vec3>& centers) {
    Skeleton skeleton;
    const auto farthest = [&](auto&& measure) {
        return *std::max_element(centers.begin(), centers.end(),
                                 [&](const Vec3& a, const Vec3& b) { return measure(a) < measure(b); });
    };
    const Vec3& seed = centers[0];
    const Vec3 a = farthest([&](const Vec3& p) { return length(difference(p, seed)); });
    const Vec3 b = farthest([&](const Vec3& p) { return length(difference(p, a)); });
    const Vec3 along = difference(b, a);
    if (!(length(along) > 0)) {
        skeleton.vertices = {a};
        return skeleton;
    }
    const Vec3 c = farthest([&](const Vec3& p) { return length(cross(along, difference(p, a))); });
    const Vec3 normal = cross(along, difference(c, a));
    if (!(length(normal) > kSame * dot(along, along))) {
        skeleton.vertices = {a, b};
        skeleton.edges.push_back({{0, 1}, {}, 0});
        return skeleton;
    }
    const Affine frame = frame_along(normal, a);
    const Vec3 x = {frame[0], frame[4], frame[8]};
    const Vec3 y = {frame[1], frame[5], frame[9]};
    const Vec3 z = {frame[2], frame[6], frame[10]};
    std::vector<Disc> discs;
    for (const Vec3& center : centers) {
        const Vec3 d = difference(center, a);
        discs.push_back({{dot(x, d), dot(y, d)}, 0});
    }
    for (const Disc& disc : hull_of_discs(discs)) {
        skeleton.vertices.push_back(sum(a, sum(scaled(x, disc.center[0]), scaled(y, disc.center[1]))));
    }
    skeleton.faces = {{z, a}, {scaled(z, -1), a}};
    const std::size_t n = skeleton.vertices.size();
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3 edge = difference(skeleton.vertices[(i + 1) % n], skeleton.vertices[i]);
        skeleton.edges.push_back({{i, (i + 1) % n}, unit(cross(edge, z)), 0});
    }
    return skeleton;
}

}  // namespace

std::vector<Disc> hull_of_discs(const std::vector<Disc>& given) {
    double extent = 0;
    for (const Disc& disc : given) {
        extent = std::max({extent, std::fabs(disc.center[0] - given[0].center[0]),
                           std::fabs(disc.center[1] - given[0].center[1]), disc.radius});
    }
    const double tolerance = kSame * extent;
    const auto distance = [](const Disc& a, const Disc& b) {
        return std::hypot(b.center[0] - a.center[0], b.center[1] - a.center[1]);
    };
    // Discs inside others do not count; of equal ones the first.
    std::vector<Disc> discs;
    std::vector<Disc> by_size = given;
    std::stable_sort(by_size.begin(), by_size.end(),
                     [](const Disc& a, const Disc& b) { return a.radius > b.radius; });
    for (const Disc& disc : by_size) {
        const bool inside = std::any_of(discs.begin(), discs.end(), [&](const Disc& larger) {
            return distance(disc, larger) + disc.radius <= larger.radius + tolerance;
        });
        if (!inside) discs.push_back(disc);
    }
    if (discs.size() < 2) return discs;
    // Gift wrapping: from the lowest disc on, the tangent that turns least; of equal ones the longest.
    const auto bottom = [](const Disc& d) { return d.center[1] - d.radius; };
    std::size_t first = 0;
    for (std::size_t i = 1; i < discs.size(); ++i) {
        const double rise = bottom(discs[i]) - bottom(discs[first]);
        // The rightmost of those that are equally low: the first arc starts at its lowest point.
        if (rise < -tolerance || (rise <= tolerance && discs[i].center[0] > discs[first].center[0]))
            first = i;
    }
    std::vector<Disc> hull;
    std::size_t at = first;
    double normal = -kTurn / 4;  // of the tangent line, turning counter-clockwise
    constexpr double kAngle = 1e-9;
    for (std::size_t step = 0; step < 2 * discs.size(); ++step) {
        hull.push_back(discs[at]);
        std::size_t next = at;
        double least = HUGE_VAL;
        for (std::size_t i = 0; i < discs.size(); ++i) {
            if (i == at) continue;
            const double apart = distance(discs[at], discs[i]);
            const double toward = std::atan2(discs[i].center[1] - discs[at].center[1],
                                             discs[i].center[0] - discs[at].center[0]);
            const double cosine = (discs[at].radius - discs[i].radius) / apart;
            // The common tangent with both discs on its left.
            double turn = toward - std::acos(std::clamp(cosine, -1.0, 1.0)) - normal;
            turn -= kTurn * std::floor(turn / kTurn);
            if (turn > kTurn - kAngle) turn = 0;
            const bool longer = apart > distance(discs[at], discs[next]);
            if (turn < least - kAngle || (turn <= least + kAngle && longer)) {
                least = std::min(turn, least);
                next = i;
            }
        }
        // Round once: the first disc's lowest point is passed again.
        if (normal + least >= kTurn * 3 / 4 - kAngle) break;
        normal += least;
        at = next;
    }
    if (hull.size() > 1 && at == first) hull.pop_back();
    return hull;
}

std::optional<std::uint32_t> add_prism(Model& model, const std::vector<Disc>& discs, double low, double high,
                                       const Affine& frame, const std::string& name) {
    if (discs.empty() || !(low < high)) return std::nullopt;
    const std::vector<Disc> hull = hull_of_discs(discs);
    const std::size_t n = hull.size();
    if (n == 1 && !(hull[0].radius > 0)) return std::nullopt;
    if (n == 2 && hull[0].radius == 0 && hull[1].radius == 0) return std::nullopt;
    std::vector<Plane> planes;
    std::vector<Vec2> normals;  // of the tangent from disc i to disc i + 1
    for (std::size_t i = 0; i < n && n > 1; ++i) {
        const Disc& from = hull[i];
        const Disc& to = hull[(i + 1) % n];
        const Vec2 d = {to.center[0] - from.center[0], to.center[1] - from.center[1]};
        const double apart = std::hypot(d[0], d[1]);
        const double cosine = std::clamp((from.radius - to.radius) / apart, -1.0, 1.0);
        const double sine = std::sqrt((1 - cosine) * (1 + cosine));
        // The direction to the next disc turned clockwise by the angle of that cosine.
        const Vec2 normal = {(d[0] * cosine + d[1] * sine) / apart, (d[1] * cosine - d[0] * sine) / apart};
        normals.push_back(normal);
        const Vec3 plane_normal = {normal[0], normal[1], 0};
        planes.push_back(
            {plane_normal, normal[0] * from.center[0] + normal[1] * from.center[1] + from.radius, {}});
    }
    number_planes(planes);
    planes.push_back({{0, 0, -1}, -low, "zmin"});
    planes.push_back({{0, 0, 1}, high, "zmax"});
    std::vector<std::uint32_t> parts = {add_half_spaces(model, std::move(planes), {})};
    std::vector<Vec3> corners;
    for (std::size_t i = 0; i < n; ++i) {
        const Disc& disc = hull[i];
        const Vec3 center = {disc.center[0], disc.center[1], 0};
        for (const double sign : {-1.0, 1.0}) {
            const double r = sign * disc.radius;
            corners.push_back({center[0] + r, center[1] + r, low});
            corners.push_back({center[0] + r, center[1] + r, high});
        }
        if (!(disc.radius > 0)) continue;
        std::uint32_t tube = model.add_primitive(infinite_cylinder(disc.radius), name + "_round");
        if (center != Vec3{}) tube = model.add_transform(translation(center), tube);
        if (n == 1) {
            parts.push_back(tube);
            continue;
        }
        const Vec2& before = normals[(i + n - 1) % n];
        const Vec2& after = normals[i];
        // The middle of the arc, which may be longer than half a circle.
        double from = std::atan2(before[1], before[0]);
        double arc = std::atan2(after[1], after[0]) - from;
        arc -= kTurn * std::floor(arc / kTurn);
        if (arc < 1e-7) continue;
        const Vec3 outward = {std::cos(from + arc / 2), std::sin(from + arc / 2), 0};
        const double offset = dot(outward, center) + disc.radius * std::cos(arc / 2);
        parts.push_back(unite(model, {add_half_spaces(model, {{outward, offset, {}}}, {}), tube}));
    }
    std::uint32_t node = intersect(model, std::move(parts), name, box_of(corners, 0));
    return frame == kIdentity ? node : model.add_transform(frame, node);
}

std::optional<std::uint32_t> add_hull_of_equal_spheres(Model& model, const std::vector<Vec3>& centers,
                                                       double radius, const std::string& name) {
    std::optional<Skeleton> skeleton;
    if (const std::optional<Polytope> polytope = convex_hull(centers)) {
        skeleton = skeleton_of(*polytope);
        if (!skeleton) return std::nullopt;
    } else {
        skeleton = flat_skeleton(centers);
    }
    const std::vector<Vec3>& vertices = skeleton->vertices;
    const std::string round = name + "_round";
    if (vertices.size() == 1) return add_ball(model, vertices[0], radius, name);

    std::vector<Plane> planes;
    for (const auto& [normal, point] : skeleton->faces) {
        planes.push_back({normal, dot(normal, point) + radius, {}});
    }
    number_planes(planes);
    std::vector<std::uint32_t> parts;
    if (!planes.empty()) parts.push_back(add_half_spaces(model, std::move(planes), {}));
    // Beyond the plane across each edge's end, on the vertex's side, the ball bounds the solid.
    std::vector<std::vector<std::uint32_t>> at_vertex(vertices.size());
    for (const Skeleton::Edge& edge : skeleton->edges) {
        const Vec3& a = vertices[edge.ends[0]];
        const Vec3& b = vertices[edge.ends[1]];
        std::vector<std::uint32_t> across = {add_tube(model, a, b, radius, round)};
        if (edge.outward != Vec3{}) {
            const double offset = dot(edge.outward, a) + radius * edge.depth;
            across.push_back(add_half_spaces(model, {{edge.outward, offset, {}}}, {}));
        }
        parts.push_back(unite(model, std::move(across)));
        const Vec3 along = unit(difference(b, a));
        at_vertex[edge.ends[0]].push_back(
            add_half_spaces(model, {{scaled(along, -1), -dot(along, a), {}}}, {}));
        at_vertex[edge.ends[1]].push_back(add_half_spaces(model, {{along, dot(along, b), {}}}, {}));
    }
    for (std::size_t v = 0; v < vertices.size(); ++v) {
        at_vertex[v].push_back(add_ball(model, vertices[v], radius, round));
        parts.push_back(unite(model, std::move(at_vertex[v])));
    }
    return intersect(model, std::move(parts), name, box_of(vertices, radius));
}

std::uint32_t add_hull_of_two_spheres(Model& model, const Vec3& a, double ra, const Vec3& b, double rb,
                                      const std::string& name) {
    if (ra < rb) return add_hull_of_two_spheres(model, b, rb, a, ra, name);
    const Vec3 axis = difference(b, a);
    const double apart = length(axis);
    // In the frame with a at the origin and b on z. A tangent's normal makes this sine with the axis.
    const double sine = (ra - rb) / apart;
    const double cosine = std::sqrt((1 - sine) * (1 + sine));
    const std::string round = name + "_round";
    const std::uint32_t side = ra == rb
                                   ? model.add_primitive(infinite_cylinder(ra), name + "_side")
                                   : model.add_primitive(cone(ra / cosine, -sine / cosine), name + "_side");
    const std::uint32_t below = unite(
        model, {add_half_spaces(model, {{{0, 0, -1}, -ra * sine, {}}}, {}), add_ball(model, {}, ra, round)});
    const std::uint32_t above =
        unite(model, {add_half_spaces(model, {{{0, 0, 1}, apart + rb * sine, {}}}, {}),
                      add_ball(model, {0, 0, apart}, rb, round)});
    const Box3 bounds = box_of({{-ra, -ra, -ra}, {ra, ra, apart + rb}}, 0);
    const std::uint32_t node = intersect(model, {side, below, above}, name, bounds);
    return model.add_transform(frame_along(axis, a), node);
}

}  // namespace mortise::model_reader
