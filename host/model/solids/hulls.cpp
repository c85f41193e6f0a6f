// hull() and minkowski(): see hulls.hpp.
#include "host/model/solids/hulls.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <unordered_set>
#include <utility>

#include "host/common/constants.hpp"
#include "host/common/vec3.hpp"
#include "host/model/affine.hpp"
#include "host/model/agreement.hpp"
#include "host/model/solids/convex_hull.hpp"
#include "host/model/solids/convex_pieces.hpp"
#include "host/model/solids/rounded_solids.hpp"
#include "host/model/solids/swept_outline.hpp"
#include "host/model/solids/tangent_hull.hpp"
#include "host/model/text.hpp"
#include "host/model/triangles/surface_repair.hpp"

namespace mortise::model_reader {
namespace {

using PieceKind = ConvexPiece::Kind;

std::uint32_t empty(Model& model) { return model.add_operation(CsgNode::Op::kUnion, {}); }

// --- Special cases. Each gives nothing if the pieces are not of its kind.

std::optional<std::uint32_t> hull_of_spheres(Model& model, const std::vector<ConvexPiece>& pieces,
                                             const std::string& name) {
    for (const ConvexPiece& piece : pieces) {
        if (piece.kind != PieceKind::kSphere) return std::nullopt;
    }
    constexpr std::size_t kMost = 2000;
    if (pieces.size() > kMost) return std::nullopt;
    std::vector<Ball> balls;
    for (const ConvexPiece& piece : pieces) balls.push_back({piece.a, piece.ra});
    return add_hull_of_spheres(model, std::move(balls), name);
}

Vec3 axis_of(const ConvexPiece& piece) {
    if (piece.kind == PieceKind::kRounded) return {piece.frame[2], piece.frame[6], piece.frame[10]};
    return piece.kind == PieceKind::kDisc ? piece.b : difference(piece.b, piece.a);
}

struct LevelDisc {
    Disc disc;
    double level;
};

/// Both ends of the pieces as discs about an axis, if all are cylinders about it or points.
std::vector<LevelDisc> ends_along(const std::vector<ConvexPiece>& pieces, const Affine& frame) {
    const Vec3 x = {frame[0], frame[4], frame[8]};
    const Vec3 y = {frame[1], frame[5], frame[9]};
    const Vec3 z = {frame[2], frame[6], frame[10]};
    std::vector<LevelDisc> ends;
    const auto add = [&](const Vec3& p, double radius) {
        ends.push_back({{{dot(x, p), dot(y, p)}, radius}, dot(z, p)});
    };
    for (const ConvexPiece& piece : pieces) {
        if (piece.kind == PieceKind::kSphere || piece.facetted) return {};
        if (piece.kind == PieceKind::kRounded && !is_prism(piece)) return {};
        for (const Vec3& point : piece.points) add(point, 0);
        if (piece.kind == PieceKind::kPoints) continue;
        const Vec3 axis = axis_of(piece);
        if (length(cross(axis, z)) > kSame * length(axis)) return {};
        if (is_prism(piece)) {
            for (const Ball& disc : piece.rounded->balls) {
                for (const double level : {piece.rounded->low, piece.rounded->high})
                    add(image(piece.frame, {disc.center[0], disc.center[1], level}), disc.radius);
            }
            continue;
        }
        add(piece.a, piece.ra);
        if (piece.kind == PieceKind::kFrustum) add(piece.b, piece.rb);
    }
    return ends;
}

/// Whether the hulls of two sets of discs are the same: each disc of one is inside the other's hull.
bool same_hull(const std::vector<Disc>& a, const std::vector<Disc>& b, double tolerance) {
    const std::vector<Disc> of_a = hull_of_discs(a);
    const std::vector<Disc> of_b = hull_of_discs(b);
    return of_a.size() == of_b.size() && std::all_of(of_a.begin(), of_a.end(), [&](const Disc& disc) {
               return std::any_of(of_b.begin(), of_b.end(), [&](const Disc& other) {
                   return std::hypot(disc.center[0] - other.center[0], disc.center[1] - other.center[1]) +
                              std::fabs(disc.radius - other.radius) <=
                          tolerance;
               });
           });
}

std::optional<std::uint32_t> hull_of_prism(Model& model, const std::vector<ConvexPiece>& pieces,
                                           const std::string& name) {
    const auto round = std::find_if(pieces.begin(), pieces.end(), [](const ConvexPiece& piece) {
        return piece.kind == PieceKind::kFrustum || piece.kind == PieceKind::kDisc || is_prism(piece);
    });
    if (round == pieces.end()) return std::nullopt;
    Vec3 axis = unit(axis_of(*round));
    // Upwards, so that the usual case needs no transform.
    if (axis[2] < -0.5) axis = {-axis[0], -axis[1], -axis[2]};
    const Affine frame = frame_along(axis, {});
    const std::vector<LevelDisc> ends = ends_along(pieces, frame);
    constexpr std::size_t kMost = 2000;
    if (ends.empty() || ends.size() > kMost) return std::nullopt;
    double low = HUGE_VAL;
    double high = -HUGE_VAL;
    double extent = 0;
    for (const LevelDisc& end : ends) {
        low = std::min(low, end.level);
        high = std::max(high, end.level);
        extent = std::max({extent, end.disc.radius, std::fabs(end.disc.center[0] - ends[0].disc.center[0]),
                           std::fabs(end.disc.center[1] - ends[0].disc.center[1])});
    }
    const double tolerance = kSame * std::max(extent, high - low);
    std::vector<Disc> all;
    std::vector<Disc> lower;
    std::vector<Disc> upper;
    for (const LevelDisc& end : ends) {
        all.push_back(end.disc);
        if (end.level <= low + tolerance) lower.push_back(end.disc);
        if (end.level >= high - tolerance) upper.push_back(end.disc);
    }
    if (!same_hull(all, lower, tolerance) || !same_hull(all, upper, tolerance)) return std::nullopt;
    return add_prism(model, all, low, high, frame, name);
}

// --- Polytopes.

std::uint32_t add_polytope(Model& model, const Polytope& polytope, bool facetted, const std::string& name) {
    constexpr std::size_t kMostPlanes = 200;
    if (facetted || polytope.faces.size() > kMostPlanes) {
        return model.add_primitive(polyhedron(triangles_of(polytope), facetted ? kSmoothTurn : 1), name);
    }
    Primitive primitive;
    std::size_t number = 0;
    for (const Polytope::Face& face : polytope.faces) {
        primitive.planes.push_back(face.plane);
        primitive.planes.back().name = "side" + std::to_string(++number);
    }
    const std::uint32_t node = model.add_primitive(std::move(primitive), name);
    Box3 box{polytope.vertices[0], polytope.vertices[0]};
    for (const Vec3& vertex : polytope.vertices) {
        for (std::size_t k = 0; k < 3; ++k) {
            box.min[k] = std::min(box.min[k], vertex[k]);
            box.max[k] = std::max(box.max[k], vertex[k]);
        }
    }
    for (std::size_t k = 0; k < 3; ++k) {
        const double rounding = kSame * (box.max[k] - box.min[k]);
        box.min[k] -= rounding;
        box.max[k] += rounding;
    }
    model.nodes[node].bounds = box;
    return node;
}

/// The smallest angle in degrees by which the normal turns at an edge.
double smallest_turn(const Polytope& polytope) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, const Vec3*> sides;
    for (const Polytope::Face& face : polytope.faces) {
        for (std::size_t i = 0; i < face.corners.size(); ++i) {
            sides[{face.corners[i], face.corners[(i + 1) % face.corners.size()]}] = &face.plane.normal;
        }
    }
    double largest = -1;
    for (const auto& [side, normal] : sides) {
        const auto other = sides.find({side.second, side.first});
        if (other == sides.end()) return 0;
        largest = std::max(largest, dot(*normal, *other->second));
    }
    return std::acos(std::clamp(largest, -1.0, 1.0)) * 360 / kTurn;
}

std::uint32_t hull_of_pieces(Model& model, const std::vector<ConvexPiece>& pieces, const std::string& name,
                             const Wanted& wanted) {
    if (const auto node = hull_of_spheres(model, pieces, name)) return *node;
    if (const auto node = hull_of_prism(model, pieces, name)) return *node;
    if (pieces.size() == 1 && pieces[0].kind == PieceKind::kRounded && !is_prism(pieces[0]) &&
        pieces[0].rounded->shape != RoundedSolid::Shape::kRing)
        return add_rounded(model, *pieces[0].rounded, pieces[0].frame, name);
    const std::optional<Polytope> polytope = tangent_hull(pieces);
    if (!polytope) {
        fail(wanted.source, wanted.where,
             "'" + wanted.name + "': the result is flat; expected children that span a volume");
    }
    const auto is_facetted = [](const ConvexPiece& piece) {
        return piece.kind != PieceKind::kPoints || piece.facetted;
    };
    const bool any_facetted = std::any_of(pieces.begin(), pieces.end(), is_facetted);
    const bool any_curved =
        std::any_of(pieces.begin(), pieces.end(), [](const ConvexPiece& piece) { return piece.curved; });
    if (any_facetted) {
        // Told once a file, with its first place.
        const std::string text = "'" + wanted.name +
                                 "' of these curved solids is approximated by flat facets, " +
                                 std::to_string(kDiscFacets) + " around cylinders";
        const bool is_told =
            std::any_of(model.warnings.begin(), model.warnings.end(), [&](const std::string& warning) {
                return warning.size() >= text.size() &&
                       warning.compare(warning.size() - text.size(), text.size(), text) == 0;
            });
        if (!is_told) model.warnings.push_back(place_text(wanted.source, wanted.where) + text);
    }
    return add_polytope(model, *polytope, any_facetted || any_curved, name);
}

// --- Minkowski sums of two pieces, as pieces whose hull is the sum.

bool is_cylinder(const ConvexPiece& piece) {
    return piece.kind == PieceKind::kFrustum && same(piece.ra, piece.rb);
}

ConvexPiece moved(ConvexPiece piece, const Vec3& by) {
    for (Vec3& point : piece.points) point = sum(point, by);
    piece.a = sum(piece.a, by);
    piece.b = sum(piece.b, by);
    for (std::size_t k = 0; k < 3; ++k) piece.frame[4 * k + 3] += by[k];
    return piece;
}

/// A frustum, or a rounded solid, and a ball of that radius about the origin.
ConvexPiece sum_with_ball(const ConvexPiece& piece, double radius) {
    using Shape = RoundedSolid::Shape;
    if (piece.kind == PieceKind::kRounded) {
        RoundedSolid solid = *piece.rounded;
        if (solid.shape == Shape::kPlate) {
            solid.rounding += radius;
        } else {
            for (Ball& ball : solid.balls) ball.radius += radius;
        }
        return rounded_piece(std::move(solid), piece.frame);
    }
    const Vec3 axis = difference(piece.b, piece.a);
    RoundedSolid solid;
    if (is_cylinder(piece)) {
        solid.shape = Shape::kPlate;
        solid.balls = {{{}, piece.ra}};
        solid.high = length(axis);
        solid.rounding = radius;
    } else {
        solid.shape = Shape::kRevolution;
        solid.balls = {{{piece.ra, 0, 0}, radius}, {{piece.rb, length(axis), 0}, radius}};
    }
    return rounded_piece(std::move(solid), frame_along(axis, piece.a));
}

/// A prism and a cylinder along its axis; nothing if they are something else.
std::optional<ConvexPiece> sum_of_prism(const ConvexPiece& prism, const ConvexPiece& cylinder) {
    if (!is_prism(prism) || !is_cylinder(cylinder)) return std::nullopt;
    const Vec3 axis = difference(cylinder.b, cylinder.a);
    const Vec3 z = axis_of(prism);
    if (length(cross(axis, z)) > kSame * length(axis)) return std::nullopt;
    RoundedSolid solid = *prism.rounded;
    for (Ball& disc : solid.balls) disc.radius += cylinder.ra;
    solid.high += length(axis);
    return moved(rounded_piece(std::move(solid), prism.frame), dot(axis, z) > 0 ? cylinder.a : cylinder.b);
}

void add_sum(const ConvexPiece& p, const ConvexPiece& q, const Wanted& wanted,
             std::vector<ConvexPiece>& out) {
    if (p.kind == PieceKind::kSphere && q.kind == PieceKind::kSphere) {
        ConvexPiece sphere = moved(p, q.a);
        sphere.ra += q.ra;
        out.push_back(std::move(sphere));
        return;
    }
    if (is_cylinder(p) && is_cylinder(q)) {
        const Vec3 u = difference(p.b, p.a);
        const Vec3 v = difference(q.b, q.a);
        if (length(cross(u, v)) <= kSame * length(u) * length(v)) {
            ConvexPiece cylinder = p;
            const bool alike = dot(u, v) > 0;
            cylinder.a = sum(p.a, alike ? q.a : q.b);
            cylinder.b = sum(p.b, alike ? q.b : q.a);
            cylinder.ra = cylinder.rb = p.ra + q.ra;
            out.push_back(std::move(cylinder));
            return;
        }
    }
    for (const bool swap : {false, true}) {
        const ConvexPiece& first = swap ? q : p;
        const ConvexPiece& second = swap ? p : q;
        if (second.kind == PieceKind::kSphere &&
            (first.kind == PieceKind::kFrustum || first.kind == PieceKind::kRounded)) {
            out.push_back(moved(sum_with_ball(first, second.ra), second.a));
            return;
        }
        if (const auto prism = sum_of_prism(first, second)) {
            out.push_back(*prism);
            return;
        }
    }
    // The hull of one solid at each of the other's points.
    const bool p_moves = q.kind == PieceKind::kPoints && p.kind != PieceKind::kPoints;
    const ConvexPiece fixed = facetted(p_moves ? q : p);
    const ConvexPiece& moving = p_moves ? p : q;
    constexpr std::size_t kMost = 2000000;
    if (fixed.points.size() * std::max<std::size_t>(moving.points.size(), 1) > kMost) {
        fail(wanted.source, wanted.where,
             "'" + wanted.name + "': too many points, " + std::to_string(fixed.points.size()) + " times " +
                 std::to_string(moving.points.size()) + "; expected simpler solids");
    }
    if (moving.kind == PieceKind::kPoints) {
        ConvexPiece points;
        points.facetted = fixed.facetted || moving.facetted;
        for (const Vec3& by : fixed.points) {
            for (const Vec3& point : moving.points) points.points.push_back(sum(point, by));
        }
        out.push_back(std::move(points));
        return;
    }
    for (const Vec3& by : fixed.points) {
        ConvexPiece piece = moved(moving, by);
        if (fixed.facetted) piece = facetted(piece);
        out.push_back(std::move(piece));
    }
}

/// Only the vertices of the points' hull.
ConvexPiece reduced(ConvexPiece piece) {
    if (piece.kind != PieceKind::kPoints) return piece;
    if (const std::optional<Polytope> hull = convex_hull(piece.points)) piece.points = hull->vertices;
    return piece;
}

using ConvexSet = std::vector<ConvexPiece>;  ///< the hull of these

/// Whether the triangles may lie in so few planes; if not, no hull of millions of points need be made.
/// Normals are counted by cells of 1/50: those of one plane, with rounding errors, lie in at most eight.
bool has_few_planes(const TriangleSurface& surface, std::size_t most) {
    constexpr double kCells = 50;
    std::unordered_set<std::int64_t> cells;
    for (const auto& t : surface.triangles) {
        std::array<Vec3, 2> edge{};
        for (std::size_t k = 0; k < 3; ++k) {
            edge[0][k] = surface.points[t[1]][k] - surface.points[t[0]][k];
            edge[1][k] = surface.points[t[2]][k] - surface.points[t[0]][k];
        }
        const Vec3 normal = cross(edge[0], edge[1]);
        const double size = length(normal);
        // Normals of slivers are rounding errors.
        if (!std::isfinite(size) || !(size > 1e-3 * dot(edge[0], edge[0])) ||
            !(size > 1e-3 * dot(edge[1], edge[1])))
            continue;
        std::int64_t cell = 0;
        for (const double component : normal) {
            cell = 128 * cell + static_cast<std::int64_t>(std::floor(kCells * component / size)) + 64;
        }
        cells.insert(cell);
        if (cells.size() > 8 * most) return false;
    }
    return true;
}

}  // namespace

std::uint32_t add_hull(Model& model, const std::vector<std::uint32_t>& children, const std::string& name,
                       SourceLocation where, const KnownExtents* known, const SweptShapes* swept) {
    const std::string source = model.source;
    const Wanted wanted = {"hull", source, where, known, true, true, swept};
    std::vector<ConvexPiece> pieces;
    for (const std::uint32_t child : children) {
        for (ConvexPiece& piece : convex_pieces(model, child, wanted)) pieces.push_back(std::move(piece));
    }
    if (pieces.empty()) return empty(model);
    // One curved solid is its own hull.
    if (pieces.size() == 1 && pieces[0].kind == PieceKind::kFrustum) {
        return model.add_operation(CsgNode::Op::kUnion, children, name);
    }
    const std::uint32_t node = hull_of_pieces(model, pieces, name, wanted);
    if (model.nodes[node].where.line == 0) model.nodes[node].where = where;
    return node;
}

std::uint32_t add_polyhedron(Model& model, TriangleSurface surface, double sharp_angle,
                             const std::string& name) {
    constexpr std::size_t kMostPlanes = 200;
    std::optional<Polytope> hull;
    if (has_few_planes(surface, kMostPlanes)) hull = convex_hull(surface.points);
    if (hull && hull->faces.size() <= kMostPlanes && same(six_volumes(surface) / 6, volume_of(*hull)) &&
        smallest_turn(*hull) > sharp_angle) {
        return add_polytope(model, *hull, false, name);
    }
    return model.add_primitive(polyhedron(std::move(surface), sharp_angle), name);
}

std::uint32_t add_minkowski(Model& model, const std::vector<std::uint32_t>& children, const std::string& name,
                            SourceLocation where, const SweptShapes* swept) {
    const std::string source = model.source;
    const Wanted wanted = {"minkowski", source, where, nullptr, false, true, swept};
    std::vector<ConvexSet> sums;
    std::size_t operands = 0;
    for (const std::uint32_t child : children) {
        std::vector<ConvexPiece> pieces = convex_pieces(model, child, wanted);
        // An empty child is left out, as in OpenSCAD.
        if (pieces.empty()) continue;
        for (ConvexPiece& piece : pieces) piece = reduced(std::move(piece));
        if (++operands == 1) {
            for (ConvexPiece& piece : pieces) sums.push_back({std::move(piece)});
            continue;
        }
        constexpr std::size_t kMost = 1000;
        if (sums.size() * pieces.size() > kMost) {
            fail(source, where,
                 "'minkowski': more than " + std::to_string(kMost) +
                     " pairs of convex solids; expected simpler children");
        }
        std::vector<ConvexSet> next;
        for (const ConvexSet& set : sums) {
            for (const ConvexPiece& piece : pieces) {
                ConvexSet result;
                for (const ConvexPiece& part : set) add_sum(part, piece, wanted, result);
                next.push_back(std::move(result));
            }
        }
        sums = std::move(next);
    }
    if (operands == 0) return empty(model);
    if (operands == 1) return model.add_operation(CsgNode::Op::kUnion, children, name);
    std::vector<std::uint32_t> nodes;
    for (const ConvexSet& set : sums) nodes.push_back(hull_of_pieces(model, set, name, wanted));
    const std::uint32_t node =
        nodes.size() == 1 ? nodes[0] : model.add_operation(CsgNode::Op::kUnion, std::move(nodes), name);
    if (model.nodes[node].where.line == 0) model.nodes[node].where = where;
    return node;
}

}  // namespace mortise::model_reader
