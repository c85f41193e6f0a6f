// See rounded_solids.hpp.
#include "host/model/solids/rounded_solids.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "host/model/affine.hpp"
#include "host/model/outlines/polygons.hpp"
#include "host/model/solids/convex_hull.hpp"
#include "host/model/solids/convex_pieces.hpp"
#include "host/model/solids/swept_outline.hpp"

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

/// What the hull of centres is made of: its edges with the normals of the two faces beside, and its vertices.
/// A polygon has two faces, a segment none.
struct Skeleton {
    struct Edge {
        std::array<std::size_t, 2> ends;
        std::array<Vec3, 2> normals;  ///< of the faces beside; zero: none
    };
    std::vector<Vec3> vertices;
    std::vector<Edge> edges;
};

std::optional<Skeleton> skeleton_of(const Polytope& polytope) {
    Skeleton skeleton;
    skeleton.vertices = polytope.vertices;
    std::map<std::pair<std::size_t, std::size_t>, Vec3> sides;
    for (const Polytope::Face& face : polytope.faces) {
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
        skeleton.edges.push_back({{side.first, side.second}, {normal, other->second}});
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
        skeleton.edges.push_back({{0, 1}, {}});
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
    const std::size_t n = skeleton.vertices.size();
    for (std::size_t i = 0; i < n; ++i) {
        skeleton.edges.push_back({{i, (i + 1) % n}, {z, scaled(z, -1)}});
    }
    return skeleton;
}

/// A vertex off the line through an edge.
std::size_t other_vertex(const Skeleton& skeleton, const Skeleton::Edge& edge) {
    const Vec3& a = skeleton.vertices[edge.ends[0]];
    const Vec3 along = unit(difference(skeleton.vertices[edge.ends[1]], a));
    const auto distance = [&](const Vec3& p) { return length(cross(along, difference(p, a))); };
    const auto farthest =
        std::max_element(skeleton.vertices.begin(), skeleton.vertices.end(),
                         [&](const Vec3& p, const Vec3& q) { return distance(p) < distance(q); });
    return static_cast<std::size_t>(farthest - skeleton.vertices.begin());
}

constexpr double kFacetAngle = kTurn / kFacets;

/// Directions from u to v; `across` is a unit vector perpendicular to u, on the arc's side.
void add_arc(const Vec3& u, const Vec3& v, const Vec3& across, std::vector<Vec3>& directions) {
    const double angle = std::atan2(dot(v, across), dot(v, u));
    const int steps = std::max(1, static_cast<int>(std::ceil(angle / kFacetAngle - 1e-6)));
    for (int i = 1; i < steps; ++i) {
        const double turn = angle * i / steps;
        directions.push_back(sum(scaled(u, std::cos(turn)), scaled(across, std::sin(turn))));
    }
    directions.push_back(u);
    directions.push_back(v);
}

/// Points of a sphere by latitude and longitude.
std::vector<Vec3> sphere_directions() {
    std::vector<Vec3> result;
    for (int ring = 0; ring <= kFacets / 2; ++ring) {
        const bool pole = ring == 0 || ring == kFacets / 2;
        const double polar = kFacetAngle * ring;
        for (int i = 0; i < (pole ? 1 : kFacets); ++i) {
            const double turn = kFacetAngle * i;
            result.push_back(
                {std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)});
        }
    }
    return result;
}

std::optional<std::uint32_t> add_smooth(Model& model, const std::vector<Vec3>& points,
                                        const std::string& name) {
    const std::optional<Polytope> hull = convex_hull(points);
    if (!hull) return std::nullopt;
    return model.add_primitive(polyhedron(triangles_of(*hull), kSmoothTurn), name);
}

/// The hull's outline, with arcs in pieces of one facet's angle at most; tangents meet them exactly.
std::vector<Vec2> outline_of(const std::vector<Disc>& hull, const std::vector<Vec2>& normals) {
    const std::size_t n = hull.size();
    std::vector<Vec2> outline;
    for (std::size_t i = 0; i < n; ++i) {
        const Disc& disc = hull[i];
        const Vec2& before = normals[(i + n - 1) % n];
        const Vec2& after = normals[i];
        double arc = std::atan2(after[1], after[0]) - std::atan2(before[1], before[0]);
        arc -= kTurn * std::floor(arc / kTurn);
        if (!(disc.radius > 0)) {
            outline.push_back(disc.center);
            continue;
        }
        if (arc > kTurn - 1e-7) arc = 0;
        const int steps = std::max(1, static_cast<int>(std::ceil(arc / kFacetAngle - 1e-6)));
        const double start = std::atan2(before[1], before[0]);
        for (int k = 0; k <= steps; ++k) {
            if (k == steps && arc < 1e-7) break;
            const double turn = start + arc * k / steps;
            const Vec2 normal = k == 0 ? before : k == steps ? after : Vec2{std::cos(turn), std::sin(turn)};
            outline.push_back(
                {disc.center[0] + disc.radius * normal[0], disc.center[1] + disc.radius * normal[1]});
        }
    }
    return outline;
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
    std::vector<Vec3> corners;
    double reach = high - low;
    for (const Disc& disc : hull) {
        for (const double sign : {-1.0, 1.0}) {
            const double r = sign * disc.radius;
            corners.push_back({disc.center[0] + r, disc.center[1] + r, low});
            corners.push_back({disc.center[0] + r, disc.center[1] + r, high});
        }
    }
    const Box3 bounds = box_of(corners, 0);
    for (std::size_t k = 0; k < 2; ++k) reach = std::max(reach, bounds.max[k] - bounds.min[k]);
    const bool round =
        std::any_of(hull.begin(), hull.end(), [](const Disc& disc) { return disc.radius > 0; });
    std::vector<std::uint32_t> parts;
    if (n == 1) {
        const Vec3 center = {hull[0].center[0], hull[0].center[1], 0};
        std::uint32_t tube = model.add_primitive(infinite_cylinder(hull[0].radius), name + "_round");
        if (center != Vec3{}) tube = model.add_transform(translation(center), tube);
        parts.push_back(tube);
    } else if (round) {
        // Tangent-continuous sides are one smooth surface, cut by the planes at its ends.
        const Contours loops = normalised({outline_of(hull, normals)});
        if (loops.empty()) return std::nullopt;
        const PrismSpan span = {low - reach / 16, high + reach / 16, 1, 1};
        int sides = 0;
        parts.push_back(model.add_primitive(
            prism(loops, span, kSmoothTurn, [&sides] { return "side" + std::to_string(++sides); }), name));
        planes.clear();
    }
    planes.push_back({{0, 0, -1}, -low, "zmin"});
    planes.push_back({{0, 0, 1}, high, "zmax"});
    parts.push_back(add_half_spaces(model, std::move(planes), {}));
    const std::uint32_t node = model.add_operation(CsgNode::Op::kIntersection, std::move(parts), name);
    model.nodes[node].bounds = bounds;
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
    if (vertices.size() == 1) return add_ball(model, vertices[0], radius, name);

    if (vertices.size() == 2) {
        return add_hull_of_two_spheres(model, vertices[0], radius, vertices[1], radius, name);
    }
    const std::vector<Vec3> round = sphere_directions();
    // Per vertex: exact directions, around its edges from face to face; and the ways to its neighbours.
    std::vector<std::vector<Vec3>> exact(vertices.size());
    std::vector<std::vector<Vec3>> ways(vertices.size());
    for (const Skeleton::Edge& edge : skeleton->edges) {
        const Vec3 along = unit(difference(vertices[edge.ends[1]], vertices[edge.ends[0]]));
        ways[edge.ends[0]].push_back(along);
        ways[edge.ends[1]].push_back(scaled(along, -1));
        Vec3 across = cross(along, edge.normals[0]);
        // The other normal, or the middle of the flat edges' half circle, is on the arc's side.
        const Vec3 inwards = difference(vertices[other_vertex(*skeleton, edge)], vertices[edge.ends[0]]);
        if (dot(across, inwards) > 0) across = scaled(across, -1);
        for (const std::size_t end : edge.ends) add_arc(edge.normals[0], edge.normals[1], across, exact[end]);
    }
    // A direction counts at the vertex that is farthest along it, and a little beyond: so do its neighbours.
    const double slack = std::sin(1.5 * kFacetAngle);
    const double apart = std::cos(0.3 * kFacetAngle);
    std::vector<Vec3> points;
    for (std::size_t v = 0; v < vertices.size(); ++v) {
        const auto add = [&](const Vec3& u) { points.push_back(sum(vertices[v], scaled(u, radius))); };
        for (const Vec3& u : exact[v]) add(u);
        for (const Vec3& u : round) {
            const bool counts = std::all_of(ways[v].begin(), ways[v].end(),
                                            [&](const Vec3& way) { return dot(u, way) <= slack; });
            const bool doubled = counts && std::any_of(exact[v].begin(), exact[v].end(),
                                                       [&](const Vec3& w) { return dot(u, w) > apart; });
            if (counts && !doubled) add(u);
        }
    }
    return add_smooth(model, points, name);
}

std::optional<std::uint32_t> add_hull_of_two_spheres(Model& model, const Vec3& a, double ra, const Vec3& b,
                                                     double rb, const std::string& name) {
    if (ra < rb) return add_hull_of_two_spheres(model, b, rb, a, ra, name);
    // The cone touches both: its normal makes an angle of this cosine with the axis.
    const Vec3 axis = difference(b, a);
    const double apart = length(axis);
    const double cosine = (ra - rb) / apart;
    const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
    const Primitive side = ra == rb ? infinite_cylinder(ra) : cone(ra / sine, -cosine / sine);
    const std::uint32_t tube = model.add_operation(
        CsgNode::Op::kIntersection,
        {model.add_primitive(side, name + "_side"),
         add_half_spaces(
             model, {{{0, 0, -1}, -ra * cosine, "start"}, {{0, 0, 1}, apart + rb * cosine, "end"}}, name)});
    return model.add_operation(
        CsgNode::Op::kUnion,
        {add_ball(model, a, ra, name + "_ball1"), add_ball(model, b, rb, name + "_ball2"),
         model.add_transform(frame_along(axis, a), tube)},
        name);
}

}  // namespace mortise::model_reader
