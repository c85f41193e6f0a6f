// Netgen's .geo primitives. Source of the semantics: Netgen's CSG parser and algebraic primitives.
//
// Elliptic solids are affine images of circular ones. Netgen measures a point's coordinates along each
// semi-axis separately, ((p - c)·v / |v|²), which differs from the affine image of v when semi-axes are not
// perpendicular; axes_map follows Netgen.
#include "host/model/geo/geo_primitives.hpp"

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "host/common/vec3.hpp"
#include "host/model/affine.hpp"
#include "host/model/geo/geo_sweeps.hpp"

namespace mortise::model_reader {
namespace {

/// The primitive being read: where it stands, for messages, and its arguments as they are taken.
struct Reading {
    Model& model;
    GeoLexer& lexer;
    GeoShapes& shapes;
    std::string_view name;
    SourceLocation where;

    [[noreturn]] void refuse(const std::string& message) const {
        fail(lexer.source(), where, "'" + std::string(name) + "': " + message);
    }
    void semicolon(const char* before) const { lexer.take_symbol(';', before); }
    Vec3 vector(const char* what) const { return lexer.take_vector(what); }
    double number(const char* what) const { return lexer.take_number(what); }

    double positive(const char* what) const {
        const double value = lexer.take_number(what);
        if (!(value > 0))
            refuse(std::string(what) + " is " + number_text(value) + "; expected a positive number");
        return value;
    }
    double not_negative(const char* what) const {
        const double value = lexer.take_number(what);
        if (value < 0) {
            refuse(std::string(what) + " is " + number_text(value) + "; expected zero or a positive number");
        }
        return value;
    }
    Vec3 direction(const Vec3& v, const char* what) const {
        const double norm = length(v);
        if (!(norm > 0) || !std::isfinite(norm)) {
            refuse(std::string(what) + " has length " + number_text(norm) + "; expected a direction");
        }
        return v;
    }

    std::uint32_t add(Primitive primitive, const Affine& map) const {
        const std::uint32_t node = model.add_primitive(std::move(primitive), {}, where);
        if (map == kIdentity) return node;
        if (std::fabs(relative_determinant(map)) <= kSingular) {
            refuse("its axes lie in one plane; expected independent vectors");
        }
        const std::uint32_t moved = model.add_transform(map, node);
        model.nodes[moved].where = where;
        return moved;
    }
};

/// Maps the unit ball to { p : sum over k of ((p - center)·v_k / |v_k|²)² <= 1 }.
Affine axes_map(const Reading& reading, const Vec3& center, const Vec3& v0, const Vec3& v1, const Vec3& v2) {
    if (dot(v0, v1) == 0 && dot(v1, v2) == 0 && dot(v2, v0) == 0) return from_columns(v0, v1, v2, center);
    // The inverse map has the rows v_k / |v_k|².
    const Vec3 r0 = scaled(v0, 1 / dot(v0, v0));
    const Vec3 r1 = scaled(v1, 1 / dot(v1, v1));
    const Vec3 r2 = scaled(v2, 1 / dot(v2, v2));
    const double determinant = dot(r0, cross(r1, r2));
    if (std::fabs(determinant) <= kSingular * length(r0) * length(r1) * length(r2)) {
        reading.refuse("its axes lie in one plane; expected independent vectors");
    }
    const double inverse = 1 / determinant;
    return from_columns(scaled(cross(r1, r2), inverse), scaled(cross(r2, r0), inverse),
                        scaled(cross(r0, r1), inverse), center);
}

/// plane (point; outward normal)
std::uint32_t read_plane(const Reading& r) {
    const Vec3 point = r.vector("the point");
    r.semicolon("before the normal");
    const Vec3 normal = r.direction(r.vector("the normal"), "the normal");
    return r.add(half_space(point, normal), kIdentity);
}

/// sphere (center; radius)
std::uint32_t read_sphere(const Reading& r) {
    const Vec3 center = r.vector("the center");
    r.semicolon("before the radius");
    return r.add(sphere(r.positive("the radius")), translation(center));
}

/// cylinder (a; b; radius): infinite along the line from a to b
std::uint32_t read_cylinder(const Reading& r) {
    const Vec3 a = r.vector("the first point of the axis");
    r.semicolon("before the second point");
    const Vec3 b = r.vector("the second point of the axis");
    r.semicolon("before the radius");
    const double radius = r.positive("the radius");
    return r.add(infinite_cylinder(radius), frame_along(r.direction(difference(b, a), "the axis"), a));
}

/// cone (a; radius at a; b; radius at b): both nappes
std::uint32_t read_cone(const Reading& r) {
    const Vec3 a = r.vector("the first point of the axis");
    r.semicolon("before the first radius");
    const double radius_a = r.not_negative("the first radius");
    r.semicolon("before the second point");
    const Vec3 b = r.vector("the second point of the axis");
    r.semicolon("before the second radius");
    const double radius_b = r.not_negative("the second radius");
    const Vec3 axis = r.direction(difference(b, a), "the axis");
    if (radius_a == 0 && radius_b == 0) r.refuse("both radii are 0; expected at least one positive radius");
    // The local origin lies at the wider end, where the radius is positive.
    const bool from_a = radius_a >= radius_b;
    const double radius = from_a ? radius_a : radius_b;
    const Affine frame = frame_along(axis, from_a ? a : b);
    if (radius_a == radius_b) return r.add(infinite_cylinder(radius), frame);
    return r.add(double_cone(radius, (radius_b - radius_a) / length(axis)), frame);
}

/// The elliptic solids' two semi-axes.
std::array<Vec3, 2> read_axes(const Reading& r) {
    const Vec3 first = r.direction(r.vector("the first semi-axis"), "the first semi-axis");
    r.semicolon("before the second semi-axis");
    return {first, r.direction(r.vector("the second semi-axis"), "the second semi-axis")};
}

Vec3 third_axis(const Reading& r, const Vec3& first, const Vec3& second) {
    const Vec3 normal = cross(first, second);
    if (!(length(normal) > kSingular * length(first) * length(second))) {
        r.refuse("its semi-axes are parallel; expected independent vectors");
    }
    return unit(normal);
}

/// ellipticcylinder (center; semi-axis; semi-axis): infinite along their cross product
std::uint32_t read_elliptic_cylinder(const Reading& r) {
    const Vec3 center = r.vector("the center");
    r.semicolon("before the first semi-axis");
    const auto [first, second] = read_axes(r);
    const Vec3 axis = third_axis(r, first, second);
    return r.add(infinite_cylinder(1), axes_map(r, center, first, second, axis));
}

/// ellipticcone (center; long semi-axis; short semi-axis; height; ratio of the ellipse at that height).
/// The axis is long × short: like Netgen, the longer vector counts as the long one, whatever the order.
std::uint32_t read_elliptic_cone(const Reading& r) {
    const Vec3 center = r.vector("the center");
    r.semicolon("before the first semi-axis");
    auto [longer, shorter] = read_axes(r);
    if (dot(longer, longer) < dot(shorter, shorter)) std::swap(longer, shorter);
    r.semicolon("before the height");
    const double height = r.positive("the height");
    r.semicolon("before the ratio");
    const double ratio = r.not_negative("the ratio");
    const Vec3 axis = third_axis(r, longer, shorter);
    const Affine map = axes_map(r, center, longer, shorter, axis);
    if (ratio == 1) return r.add(infinite_cylinder(1), map);
    return r.add(double_cone(1, (ratio - 1) / height), map);
}

/// ellipsoid (center; three semi-axes)
std::uint32_t read_ellipsoid(const Reading& r) {
    const Vec3 center = r.vector("the center");
    r.semicolon("before the first semi-axis");
    const auto [first, second] = read_axes(r);
    r.semicolon("before the third semi-axis");
    const Vec3 third = r.direction(r.vector("the third semi-axis"), "the third semi-axis");
    return r.add(sphere(1), axes_map(r, center, first, second, third));
}

/// torus (center; axis; major radius; minor radius)
std::uint32_t read_torus(const Reading& r) {
    const Vec3 center = r.vector("the center");
    r.semicolon("before the axis");
    const Vec3 axis = r.direction(r.vector("the axis"), "the axis");
    r.semicolon("before the major radius");
    const double major = r.positive("the major radius");
    r.semicolon("before the minor radius");
    const double minor = r.positive("the minor radius");
    return r.add(torus(major, minor), frame_along(axis, center));
}

/// orthobrick (lowest corner; highest corner)
std::uint32_t read_brick(const Reading& r) {
    const Vec3 low = r.vector("the first corner");
    r.semicolon("before the second corner");
    const Vec3 high = r.vector("the second corner");
    static constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};
    for (std::size_t k = 0; k < 3; ++k) {
        if (!(low[k] < high[k])) {
            r.refuse(std::string("the corners have ") + kAxes[k] + " = " + number_text(low[k]) + " and " +
                     number_text(high[k]) + "; expected the second to be larger");
        }
    }
    return r.add(box(low, high), kIdentity);
}

/// A point's number, from 1, as an index.
std::uint32_t read_corner(const Reading& r, std::size_t points) {
    const double number = r.number("the number of a point");
    if (!(number >= 1 && number <= static_cast<double>(points)) || number != std::floor(number)) {
        r.refuse("a face names the point " + number_text(number) + "; expected a number from 1 to " +
                 std::to_string(points));
    }
    return static_cast<std::uint32_t>(number) - 1;
}

/// polyhedron (point; point; ...;; i, j, k; i, j, k, l; ...): faces of three or four points, numbered from 1
std::uint32_t read_polyhedron(const Reading& r) {
    TriangleSurface surface;
    std::vector<std::uint32_t> face_of;
    std::uint32_t faces = 0;
    do {
        surface.points.push_back(r.vector("a point, or ';' before the faces"));
        r.semicolon("after a point (';;' after the last one)");
    } while (!r.lexer.is_symbol(';'));
    r.lexer.next();
    const auto take = [&r](char symbol) {
        if (!r.lexer.is_symbol(symbol)) return false;
        r.lexer.next();
        return true;
    };
    do {
        if (r.lexer.is_symbol(')')) break;  // after a last ';'
        std::vector<std::uint32_t> face;
        do {
            face.push_back(read_corner(r, surface.points.size()));
        } while (take(','));
        if (face.size() != 3 && face.size() != 4)
            r.refuse("a face has " + std::to_string(face.size()) + " points; expected three or four");
        surface.triangles.push_back({face[0], face[1], face[2]});
        if (face.size() == 4) surface.triangles.push_back({face[0], face[2], face[3]});
        face_of.resize(surface.triangles.size(), faces++);
    } while (take(';'));
    // Whichever way all faces are turned.
    double volume = 0;
    for (const auto& t : surface.triangles)
        volume += dot(surface.points[t[0]], cross(surface.points[t[1]], surface.points[t[2]]));
    if (volume < 0) {
        for (auto& t : surface.triangles) std::swap(t[1], t[2]);
    }
    const std::uint32_t node = r.add(polyhedron(std::move(surface)), kIdentity);
    r.shapes.faces.emplace(node, std::move(face_of));
    return node;
}

const GeoCurve& read_curve(const Reading& r, bool in_plane) {
    const SourceLocation where = r.lexer.token().where;
    const std::string kind = in_plane ? "curve2d" : "curve3d";
    const std::string name(r.lexer.take_name("the name of a " + kind));
    const auto found = r.shapes.curves.find(name);
    if (found == r.shapes.curves.end() || found->second.in_plane != in_plane) {
        fail(r.lexer.source(), where,
             "'" + name + "' is not a " + kind + "; expected '" + kind + " " + name +
                 " = (...);' above this line");
    }
    return found->second;
}

/// extrusion (path; profile; z direction)
std::uint32_t read_extrusion(const Reading& r) {
    const GeoCurve& path = read_curve(r, false);
    r.semicolon("before the profile");
    const GeoCurve& profile = read_curve(r, true);
    r.semicolon("before the z direction");
    const Vec3 up = r.direction(r.vector("the z direction"), "the z direction");
    return r.add(sweep_along(profile, path, up), kIdentity);
}

/// revolution (point of the axis; another one; profile)
std::uint32_t read_revolution(const Reading& r) {
    const Vec3 a = r.vector("the first point of the axis");
    r.semicolon("before the second point");
    const Vec3 b = r.vector("the second point of the axis");
    r.semicolon("before the profile");
    const Vec3 axis = r.direction(difference(b, a), "the axis");
    return add_revolution(r.model, read_curve(r, true), a, axis, r.where);
}

using Reader = std::uint32_t (*)(const Reading&);
constexpr std::array<std::pair<std::string_view, Reader>, 12> kReaders = {
    {{"plane", read_plane},
     {"sphere", read_sphere},
     {"cylinder", read_cylinder},
     {"cone", read_cone},
     {"ellipticcylinder", read_elliptic_cylinder},
     {"ellipticcone", read_elliptic_cone},
     {"ellipsoid", read_ellipsoid},
     {"torus", read_torus},
     {"orthobrick", read_brick},
     {"polyhedron", read_polyhedron},
     {"extrusion", read_extrusion},
     {"revolution", read_revolution}}};

Reader reader_of(std::string_view name) {
    for (const auto& [known, reader] : kReaders) {
        if (known == name) return reader;
    }
    return nullptr;
}

/// Rotation that takes axis `from` towards axis `to` by a negative angle: clockwise.
Affine clockwise(std::size_t from, std::size_t to, double angle) {
    Affine map = kIdentity;
    map[4 * from + from] = std::cos(angle);
    map[4 * to + to] = std::cos(angle);
    map[4 * from + to] = std::sin(angle);
    map[4 * to + from] = -std::sin(angle);
    return map;
}

}  // namespace

bool is_geo_primitive(std::string_view name) { return reader_of(name) != nullptr; }

std::vector<std::string_view> geo_primitive_names() {
    std::vector<std::string_view> names;
    for (const auto& [name, reader] : kReaders) names.emplace_back(name);
    return names;
}

std::string geo_primitive_list() {
    std::string list;
    for (const auto& [name, reader] : kReaders) list += (list.empty() ? "" : ", ") + std::string(name);
    return list;
}

std::uint32_t add_geo_primitive(Model& model, GeoLexer& lexer, GeoShapes& shapes) {
    const Reading reading = {model, lexer, shapes, lexer.token().text, lexer.token().where};
    const Reader reader = reader_of(reading.name);
    lexer.next();
    lexer.take_symbol('(', "after '" + std::string(reading.name) + "'");
    std::uint32_t node = 0;
    try {
        node = reader(reading);
    } catch (const Error& error) {
        // Errors of the primitives' own checks carry no place yet.
        const std::string message = error.what();
        if (message.rfind(lexer.source() + ":", 0) == 0) throw;
        reading.refuse(message);
    }
    lexer.take_symbol(')', "after the arguments of '" + std::string(reading.name) + "'");
    return node;
}

Affine geo_rotation(const Vec3& center, const Vec3& angles) {
    const Affine first = clockwise(0, 1, angles[0]);
    const Affine second = clockwise(1, 2, angles[1]);
    const Affine third = clockwise(0, 1, angles[2]);
    const Affine turn = compose(third, compose(second, first));
    return compose(translation(center), compose(turn, translation({-center[0], -center[1], -center[2]})));
}

}  // namespace mortise::model_reader
