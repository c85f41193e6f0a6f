#include "host/model/solids/convex_leaves.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "host/common/constants.hpp"
#include "host/model/affine.hpp"
#include "host/model/agreement.hpp"
#include "host/model/solids/convex_hull.hpp"
#include "host/model/solids/rounded_facets.hpp"
#include "host/model/text.hpp"
#include "host/model/triangles/surface_repair.hpp"

namespace mortise::model_reader {
namespace {

Vec3 column(const Affine& m, std::size_t k) { return {m[k], m[4 + k], m[8 + k]}; }

/// The plane's image under the map. The normal follows the cofactors of the linear part.
Plane plane_image(const Affine& m, const Plane& plane) {
    const Vec3 x = column(m, 0);
    const Vec3 y = column(m, 1);
    const Vec3 z = column(m, 2);
    const double determinant = dot(x, cross(y, z));
    const Vec3 yz = cross(y, z);
    const Vec3 zx = cross(z, x);
    const Vec3 xy = cross(x, y);
    Plane result;
    for (std::size_t k = 0; k < 3; ++k) {
        result.normal[k] =
            (yz[k] * plane.normal[0] + zx[k] * plane.normal[1] + xy[k] * plane.normal[2]) / determinant;
    }
    result.offset = plane.offset + dot(result.normal, {m[3], m[7], m[11]});
    return result;
}

/// Whether circles about z stay circles about the image of z.
bool keeps_circles(const Affine& m) {
    const Vec3 x = column(m, 0);
    const Vec3 y = column(m, 1);
    const Vec3 z = column(m, 2);
    return same(length(x), length(y)) && perpendicular(x, y) && perpendicular(y, z) && perpendicular(z, x);
}

bool keeps_spheres(const Affine& m) {
    return keeps_circles(m) && same(length(column(m, 0)), length(column(m, 2)));
}

/// The map with columns of unit length.
Affine without_scale(Affine m) {
    for (std::size_t k = 0; k < 3; ++k) {
        const double size = length(column(m, k));
        for (std::size_t i = 0; i < 3; ++i) m[4 * i + k] /= size;
    }
    return m;
}

RoundedSolid enlarged(RoundedSolid solid, double factor) {
    for (Ball& ball : solid.balls) {
        for (double& x : ball.center) x *= factor;
        ball.radius *= factor;
    }
    solid.low *= factor;
    solid.high *= factor;
    solid.rounding *= factor;
    return solid;
}

const char* kind_name(Primitive::Kind kind) {
    switch (kind) {
        case Primitive::Kind::kTorus: return "a torus";
        case Primitive::Kind::kDoubleCone: return "a double cone";
        case Primitive::Kind::kExpression: return "a solid given by a formula";
        case Primitive::Kind::kPolyhedron: return "a polyhedron";
        case Primitive::Kind::kRounded: return "a rounded ring, or column without end,";
        default: return "a solid";
    }
}

/// Appends half-spaces whose intersection is the leaf; for a curved one they touch it all around.
void add_planes(const Leaf& leaf, const Wanted& wanted, std::vector<Plane>& planes, bool& facetted) {
    const Primitive& primitive = *leaf.primitive;
    const auto add = [&](const Vec3& normal, double offset) {
        planes.push_back(plane_image(leaf.map, Plane{normal, offset, {}}));
    };
    switch (primitive.kind) {
        case Primitive::Kind::kConvex:
            for (const Plane& plane : primitive.planes) add(plane.normal, plane.offset);
            return;
        case Primitive::Kind::kSphere:
            facetted = true;
            for (int ring = 1; ring < kFacets / 2; ++ring) {
                const double polar = kTurn * ring / kFacets;
                for (int i = 0; i < kFacets; ++i) {
                    const double turn = kTurn * i / kFacets;
                    add({std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)},
                        primitive.radius);
                }
            }
            add({0, 0, 1}, primitive.radius);
            add({0, 0, -1}, primitive.radius);
            return;
        case Primitive::Kind::kCylinder:
        case Primitive::Kind::kCone: {
            facetted = true;
            const double slope = primitive.kind == Primitive::Kind::kCone ? primitive.slope : 0;
            for (int i = 0; i < kFacets; ++i) {
                const double turn = kTurn * i / kFacets;
                add({std::cos(turn), std::sin(turn), -slope}, primitive.radius);
            }
            return;
        }
        case Primitive::Kind::kRounded: {
            if (primitive.rounded->shape == RoundedSolid::Shape::kRing)
                refuse(wanted,
                       "a rounded ring in an intersection is not supported; expected solids that are convex");
            facetted = true;
            RoundedSolid solid = *primitive.rounded;
            const bool column = solid.shape == RoundedSolid::Shape::kColumn;
            solid.high = solid.low + 1;  // of a column any two heights will do
            const std::optional<Polytope> hull = convex_hull(points_of(column ? solid : *primitive.rounded));
            if (!hull) return;
            for (const Polytope::Face& face : hull->faces) {
                if (!column || std::fabs(face.plane.normal[2]) < 0.5)
                    add(face.plane.normal, face.plane.offset);
            }
            return;
        }
        case Primitive::Kind::kPolyhedron: {
            const TriangleSurface& surface = *primitive.triangles;
            const std::optional<Polytope> hull = convex_hull(surface.points);
            if (!hull || !same(std::fabs(six_volumes(surface)) / 6, volume_of(*hull))) {
                refuse(wanted, "a solid that is not convex is not supported; expected convex solids");
            }
            facetted = facetted || primitive.sharp_angle >= 5;
            for (const Polytope::Face& face : hull->faces) add(face.plane.normal, face.plane.offset);
            return;
        }
        default:
            refuse(wanted, std::string(kind_name(primitive.kind)) +
                               " in an intersection is not supported; expected solids that are convex");
    }
}

/// Heights in the frame of a leaf.
struct Span {
    double low = -HUGE_VAL;
    double high = HUGE_VAL;
};

/// The only leaf that is no polytope.
const Leaf* round_leaf(const std::vector<Leaf>& leaves) {
    const Leaf* round = nullptr;
    for (const Leaf& leaf : leaves) {
        if (leaf.primitive->kind == Primitive::Kind::kConvex) continue;
        if (round != nullptr) return nullptr;
        round = &leaf;
    }
    return round;
}

/// What planes across the z axis of one leaf leave of it. Nothing if there are others.
std::optional<Span> span_of(const std::vector<Leaf>& leaves, const Leaf* round) {
    const Vec3 axis = column(round->map, 2);
    const double stretch = length(axis);
    const Vec3 origin = image(round->map, Vec3{});
    Span span;
    for (const Leaf& leaf : leaves) {
        if (&leaf == round) continue;
        for (const Plane& given : leaf.primitive->planes) {
            const Plane plane = plane_image(leaf.map, given);
            const double along = dot(plane.normal, axis) / stretch;
            if (!same(std::fabs(along), length(plane.normal))) return std::nullopt;
            // The plane's height in the frame of the cylinder.
            const double level = (plane.offset - dot(plane.normal, origin)) / along / stretch;
            if (along > 0) span.high = std::min(span.high, level);
            if (along < 0) span.low = std::max(span.low, level);
        }
    }
    return span;
}

/// Discs between two planes across their axis.
std::optional<ConvexPiece> prism_of(const std::vector<Leaf>& leaves) {
    const Leaf* round = round_leaf(leaves);
    if (round == nullptr || round->primitive->kind != Primitive::Kind::kRounded ||
        round->primitive->rounded->shape != RoundedSolid::Shape::kColumn || !keeps_circles(round->map)) {
        return std::nullopt;
    }
    const std::optional<Span> span = span_of(leaves, round);
    if (!span || !(span->low < span->high) || !std::isfinite(span->high - span->low)) return std::nullopt;
    RoundedSolid solid = enlarged(*round->primitive->rounded, length(column(round->map, 0)));
    solid.shape = RoundedSolid::Shape::kPlate;
    const double stretch = length(column(round->map, 2));
    solid.low = span->low * stretch;
    solid.high = span->high * stretch;
    return rounded_piece(std::move(solid), without_scale(round->map));
}

/// One cylinder or cone, cut by planes across its axis: a frustum. Nothing if it is something else.
std::optional<ConvexPiece> frustum_of(const std::vector<Leaf>& leaves) {
    const Leaf* round = round_leaf(leaves);
    if (round == nullptr || !keeps_circles(round->map)) return std::nullopt;
    const Primitive::Kind kind = round->primitive->kind;
    if (kind != Primitive::Kind::kCylinder && kind != Primitive::Kind::kCone) return std::nullopt;
    const std::optional<Span> span = span_of(leaves, round);
    if (!span) return std::nullopt;
    double low = span->low;
    double high = span->high;
    const double slope = round->primitive->kind == Primitive::Kind::kCone ? round->primitive->slope : 0;
    const auto radius = [&](double level) { return round->primitive->radius + slope * level; };
    // The single nappe ends at its apex.
    if (slope > 0) low = std::max(low, -round->primitive->radius / slope);
    if (slope < 0) high = std::min(high, -round->primitive->radius / slope);
    if (!(low < high) || !std::isfinite(low) || !std::isfinite(high)) return std::nullopt;
    ConvexPiece piece;
    piece.kind = ConvexPiece::Kind::kFrustum;
    piece.a = image(round->map, Vec3{0, 0, low});
    piece.b = image(round->map, Vec3{0, 0, high});
    const double scale = length(column(round->map, 0));
    // Rounding must not leave a tiny radius at an apex.
    const double widest = std::max(radius(low), radius(high));
    piece.ra = radius(low) > 1e-9 * widest ? scale * radius(low) : 0;
    piece.rb = radius(high) > 1e-9 * widest ? scale * radius(high) : 0;
    return piece;
}

ConvexPiece sphere_piece(const Leaf& leaf) {
    ConvexPiece piece;
    if (keeps_spheres(leaf.map)) {
        piece.kind = ConvexPiece::Kind::kSphere;
        piece.a = image(leaf.map, Vec3{});
        piece.ra = leaf.primitive->radius * length(column(leaf.map, 0));
        return piece;
    }
    ConvexPiece local;
    local.kind = ConvexPiece::Kind::kSphere;
    local.ra = leaf.primitive->radius;
    piece = facetted(local);
    for (Vec3& point : piece.points) point = image(leaf.map, point);
    return piece;
}

/// A rounded solid that is bounded: its balls, where their hull will do.
void add_rounded_leaf(const Leaf& leaf, const Wanted& wanted, std::vector<ConvexPiece>& pieces) {
    const RoundedSolid& solid = *leaf.primitive->rounded;
    if (!keeps_spheres(leaf.map)) {
        ConvexPiece piece;
        piece.facetted = true;
        for (const Vec3& point : points_of(solid)) piece.points.push_back(image(leaf.map, point));
        pieces.push_back(std::move(piece));
        return;
    }
    const double scale = length(column(leaf.map, 0));
    if (solid.shape != RoundedSolid::Shape::kHull || !wanted.only_hull) {
        pieces.push_back(rounded_piece(enlarged(solid, scale), without_scale(leaf.map)));
        return;
    }
    for (const Ball& ball : solid.balls) {
        ConvexPiece sphere;
        sphere.kind = ConvexPiece::Kind::kSphere;
        sphere.a = image(leaf.map, ball.center);
        sphere.ra = scale * ball.radius;
        pieces.push_back(std::move(sphere));
    }
}

}  // namespace

void refuse(const Wanted& wanted, const std::string& what) {
    fail(wanted.source, wanted.where, "'" + wanted.name + "': " + what);
}

void add_intersection(const std::vector<Leaf>& leaves, const Wanted& wanted,
                      std::vector<ConvexPiece>& pieces) {
    if (const std::optional<ConvexPiece> frustum = frustum_of(leaves)) {
        pieces.push_back(*frustum);
        return;
    }
    if (const std::optional<ConvexPiece> prism = prism_of(leaves)) {
        pieces.push_back(*prism);
        return;
    }
    std::vector<Plane> planes;
    ConvexPiece piece;
    for (const Leaf& leaf : leaves) add_planes(leaf, wanted, planes, piece.facetted);
    switch (vertices_of(planes, piece.points)) {
        case Boundedness::kEmpty: return;
        case Boundedness::kUnbounded:
            refuse(wanted, "a child is not bounded; expected solids such as cubes, spheres and cylinders");
        case Boundedness::kBounded: pieces.push_back(std::move(piece));
    }
}

void add_primitive(const Leaf& leaf, const Wanted& wanted, std::vector<ConvexPiece>& pieces) {
    ConvexPiece piece;
    switch (leaf.primitive->kind) {
        case Primitive::Kind::kRounded:
            // A column has no end, a ring is not convex.
            if (leaf.primitive->rounded->shape == RoundedSolid::Shape::kColumn) break;
            if (leaf.primitive->rounded->shape == RoundedSolid::Shape::kRing && !wanted.only_hull) break;
            add_rounded_leaf(leaf, wanted, pieces);
            return;
        case Primitive::Kind::kSphere: pieces.push_back(sphere_piece(leaf)); return;
        case Primitive::Kind::kTorus: {
            if (!wanted.only_hull) break;
            piece.facetted = true;
            for (int i = 0; i < kFacets; ++i) {
                const double turn = kTurn * i / kFacets;
                for (int j = 0; j < kFacets; ++j) {
                    const double round = kTurn * j / kFacets;
                    const double rho = leaf.primitive->major + leaf.primitive->radius * std::cos(round);
                    piece.points.push_back(image(leaf.map, Vec3{rho * std::cos(turn), rho * std::sin(turn),
                                                                leaf.primitive->radius * std::sin(round)}));
                }
            }
            pieces.push_back(std::move(piece));
            return;
        }
        case Primitive::Kind::kPolyhedron: {
            for (const Vec3& point : leaf.primitive->triangles->points) {
                piece.points.push_back(image(leaf.map, point));
            }
            // Edges that are not creases stand for a curved surface.
            piece.facetted = leaf.primitive->sharp_angle >= 5;
            if (!wanted.only_hull) {
                TriangleSurface moved = *leaf.primitive->triangles;
                moved.points = piece.points;
                const std::optional<Polytope> hull = convex_hull(piece.points);
                const double volume = std::fabs(six_volumes(moved)) / 6;
                if (!hull || !same(volume, volume_of(*hull))) break;
            }
            pieces.push_back(std::move(piece));
            return;
        }
        case Primitive::Kind::kExpression: break;
        default: add_intersection({leaf}, wanted, pieces); return;
    }
    refuse(wanted, std::string(kind_name(leaf.primitive->kind)) +
                       " is not supported; expected solids that "
                       "are convex");
}

}  // namespace mortise::model_reader
