// A plane that is tangent to round pieces touches each of them in its support point along the plane's normal.
// The hull of some points of the pieces has a face close to that plane; with the support points along the
// face's normal in place of the face's corners its error is squared.
#include "host/model/solids/tangent_hull.hpp"

#include <cmath>
#include <map>

#include "host/common/constants.hpp"
#include "host/common/vec3.hpp"
#include "host/model/affine.hpp"

namespace mortise::model_reader {
namespace {

using PieceKind = ConvexPiece::Kind;

constexpr int kRounds = 3;  ///< of Newton's method: from 1/60 by squares to rounding
/// Corners this far from their support points, in radii, are at most where their neighbours were.
constexpr double kFarthestCorner = 0.6 * kTurn / kFacets;

/// A disc or a ball, and the points that stand for it.
struct Round {
    Vec3 center;
    double radius = 0;
    std::optional<Vec3> axis;  ///< of a disc
    std::vector<Vec3> directions;

    Vec3 point(std::size_t i) const { return sum(center, scaled(directions[i], radius)); }
};

Round disc(const Vec3& center, double radius, const Vec3& axis) {
    Round result = {center, radius, axis, {}};
    const Affine frame = frame_along(axis, {});
    for (int i = 0; i < kDiscFacets; ++i) {
        const double turn = kTurn * i / kDiscFacets;
        result.directions.push_back(image(frame, Vec3{std::cos(turn), std::sin(turn), 0}));
    }
    return result;
}

Round ball(const ConvexPiece& piece) {
    ConvexPiece whole;
    whole.kind = PieceKind::kSphere;
    whole.ra = 1;
    return {piece.a, piece.ra, std::nullopt, facetted(whole).points};
}

struct Points {
    std::vector<Round> rounds;
    std::vector<Vec3> others;
};

void add_frustum(const ConvexPiece& piece, Points& points) {
    const Vec3 axis = unit(difference(piece.b, piece.a));
    for (const auto& [center, radius] : {std::pair(piece.a, piece.ra), std::pair(piece.b, piece.rb)}) {
        if (radius > 0) points.rounds.push_back(disc(center, radius, axis));
        if (radius <= 0) points.others.push_back(center);
    }
}

/// A plate that is not rounded, as the discs at its corners.
void add_prism(const ConvexPiece& piece, Points& points) {
    const Vec3 axis = {piece.frame[2], piece.frame[6], piece.frame[10]};
    for (const Ball& corner : piece.rounded->balls) {
        for (const double level : {piece.rounded->low, piece.rounded->high}) {
            const Vec3 center = image(piece.frame, {corner.center[0], corner.center[1], level});
            if (corner.radius > 0) points.rounds.push_back(disc(center, corner.radius, axis));
            if (corner.radius <= 0) points.others.push_back(center);
        }
    }
}

Points points_of(const std::vector<ConvexPiece>& pieces) {
    Points points;
    for (const ConvexPiece& piece : pieces) {
        if (piece.kind == PieceKind::kFrustum) {
            add_frustum(piece, points);
        } else if (piece.kind == PieceKind::kDisc) {
            points.rounds.push_back(disc(piece.a, piece.ra, piece.b));
        } else if (piece.kind == PieceKind::kSphere) {
            points.rounds.push_back(ball(piece));
        } else if (is_prism(piece)) {
            add_prism(piece, points);
        } else {
            const std::vector<Vec3> more = facetted(piece).points;
            points.others.insert(points.others.end(), more.begin(), more.end());
        }
    }
    return points;
}

std::optional<Polytope> hull_of(const Points& points) {
    std::vector<Vec3> all = points.others;
    for (const Round& round : points.rounds) {
        for (std::size_t i = 0; i < round.directions.size(); ++i) all.push_back(round.point(i));
    }
    return convex_hull(all);
}

/// Moves the corner of the piece to where a plane with that normal touches it; false if that is far away.
bool move_to_support(Round& round, std::size_t corner, const Vec3& normal) {
    Vec3 direction = normal;
    if (round.axis) direction = sum(direction, scaled(*round.axis, -dot(*round.axis, normal)));
    const double size = length(direction);
    if (!(size > 1e-6)) return false;
    direction = scaled(direction, 1 / size);
    if (length(difference(direction, round.directions[corner])) > kFarthestCorner) return false;
    round.directions[corner] = direction;
    return true;
}

/// Of each face that has at most one corner of each round piece; false if there is none.
bool move_corners(const Polytope& hull, Points& points) {
    std::map<Vec3, std::vector<std::pair<std::size_t, std::size_t>>> owners;  // round pieces with that point
    for (std::size_t r = 0; r < points.rounds.size(); ++r) {
        for (std::size_t i = 0; i < points.rounds[r].directions.size(); ++i)
            owners[points.rounds[r].point(i)].push_back({r, i});
    }
    bool any = false;
    std::vector<std::pair<std::size_t, std::size_t>> touched;
    for (const Polytope::Face& face : hull.faces) {
        touched.clear();
        bool is_tangent = true;
        for (const std::uint32_t corner : face.corners) {
            const auto found = owners.find(hull.vertices[corner]);
            if (found == owners.end()) continue;
            for (const auto& owner : found->second) {
                for (const auto& other : touched) is_tangent = is_tangent && other.first != owner.first;
                touched.push_back(owner);
            }
        }
        if (!is_tangent) continue;
        for (const auto& [round, i] : touched)
            any = move_to_support(points.rounds[round], i, face.plane.normal) || any;
    }
    return any;
}

}  // namespace

std::optional<Polytope> tangent_hull(const std::vector<ConvexPiece>& pieces) {
    Points points = points_of(pieces);
    std::optional<Polytope> hull = hull_of(points);
    for (int round = 0; round < kRounds && hull && move_corners(*hull, points); ++round)
        hull = hull_of(points);
    return hull;
}

}  // namespace mortise::model_reader
