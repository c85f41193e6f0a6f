// Netgen's curves: see geo_curves.hpp. Source of the semantics: Netgen's CSG parser and spline segments.
//
// A piece of kind 4 names the centre of its circle: Netgen intersects the lines from the ends through the
// middle point, which is that point itself.
#include "host/model/geo/geo_curves.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/common/constants.hpp"
#include "host/common/coordinate_limits.hpp"
#include "host/common/vec3.hpp"
#include "host/model/affine.hpp"

namespace mortise::model_reader {
namespace {

constexpr double kPieceTurn = kPi / 2 / 48;  ///< of the tangent, from point to point
/// A spline whose tangent turns by more is a fold, an arc may go either way round.
constexpr double kMostTurn = 0.999 * kPi;
constexpr double kSamePoint = 1e-9;  ///< relative to the extent

double distance(const Vec3& a, const Vec3& b) { return length(difference(a, b)); }

Vec3 combination(double s, const Vec3& a, double t, const Vec3& b, double u, const Vec3& c) {
    Vec3 sum{};
    for (std::size_t k = 0; k < 3; ++k) sum[k] = s * a[k] + t * b[k] + u * c[k];
    return sum;
}

/// Angle by which the tangent turns along a piece: a conic between two points has no inflection.
double turn_of(const GeoCurve::Piece& piece) {
    switch (piece.kind) {
        case GeoCurve::Kind::kLine: return 0;
        case GeoCurve::Kind::kSpline:
            return angle_between(difference(piece.b, piece.a), difference(piece.c, piece.b));
        case GeoCurve::Kind::kArc:
            return angle_between(difference(piece.a, piece.b), difference(piece.c, piece.b));
    }
    return 0;
}

/// Point and unit tangent of a piece at a parameter from 0 to 1.
struct Sample {
    Vec3 point{};
    Vec3 tangent{};
};

Sample sample(const GeoCurve::Piece& piece, double t) {
    const auto& [kind, a, b, c] = piece;
    if (kind == GeoCurve::Kind::kLine) {
        return {combination(1 - t, a, t, c, 0, c), unit(difference(c, a))};
    }
    if (kind == GeoCurve::Kind::kSpline) {
        // A rational Bézier curve; Netgen's middle weight makes a circle if the tangents are equally long.
        const double ab = distance(a, b);
        const double bc = distance(b, c);
        const double weight = distance(a, c) / std::sqrt(2 * (ab * ab + bc * bc));
        const double sa = (1 - t) * (1 - t);
        const double sb = 2 * weight * t * (1 - t);
        const double sc = t * t;
        const double sum = sa + sb + sc;
        const Vec3 tangent = combination(weight * sa, difference(b, a), t * (1 - t), difference(c, a),
                                         weight * sc, difference(c, b));
        return {combination(sa / sum, a, sb / sum, b, sc / sum, c), unit(tangent)};
    }
    const Vec3 from = difference(a, b);
    const Vec3 to = difference(c, b);
    const double turn = angle_between(from, to);
    // The second axis of the arc's plane, as long as the radius.
    const Vec3 side = combination(1 / std::sin(turn), to, -std::cos(turn) / std::sin(turn), from, 0, from);
    const double cosine = std::cos(t * turn);
    const double sine = std::sin(t * turn);
    return {combination(1, b, cosine, from, sine, side),
            unit(combination(-sine, from, cosine, side, 0, side))};
}

double parts_of(const GeoCurve::Piece& piece) {
    return std::max(1.0, std::ceil(turn_of(piece) / kPieceTurn - 1e-9));
}

class CurveReader {
  public:
    CurveReader(GeoLexer& lexer, bool in_plane) : lexer_(lexer) { curve_.in_plane = in_plane; }

    GeoCurve read() {
        lexer_.take_symbol('(', "before the points of the curve");
        read_points();
        const std::size_t count = take_count("the number of pieces", 1);
        for (std::size_t k = 0; k < count; ++k) {
            lexer_.take_symbol(';', "before a piece of the curve");
            read_piece();
        }
        if (lexer_.is_symbol(';')) lexer_.next();
        lexer_.take_symbol(')', "after the last piece of the curve");
        curve_.closed = same(curve_.pieces.front().a, curve_.pieces.back().c);
        if (curve_.closed) curve_.pieces.back().c = curve_.pieces.front().a;
        return std::move(curve_);
    }

  private:
    [[noreturn]] void refuse(SourceLocation where, const std::string& message) const {
        fail(lexer_.source(), where, message);
    }
    bool same(const Vec3& a, const Vec3& b) const { return distance(a, b) <= kSamePoint * extent_; }

    std::size_t take_count(const char* what, int least) {
        const SourceLocation where = lexer_.token().where;
        const double number = lexer_.take_number(what);
        if (!(number >= least && number <= 1e9) || number != std::floor(number)) {
            refuse(where, std::string(what) + " is " + number_text(number) +
                              "; expected a whole number from " + std::to_string(least) + " on");
        }
        return static_cast<std::size_t>(number);
    }

    void read_points() {
        const std::size_t count = take_count("the number of points", 2);
        for (std::size_t k = 0; k < count; ++k) {
            lexer_.take_symbol(';', "before a point of the curve");
            const SourceLocation where = lexer_.token().where;
            Vec3 point{};
            point[0] = lexer_.take_number("a coordinate of a point");
            for (std::size_t axis = 1; axis < (curve_.in_plane ? 2U : 3U); ++axis) {
                lexer_.take_symbol(',', "between the coordinates of a point");
                point[axis] = lexer_.take_number("a coordinate of a point");
            }
            for (const double x : point) {
                if (!(std::fabs(x) <= kLargestCoordinate)) {
                    refuse(where, "a coordinate is " + number_text(x) + "; expected at most " +
                                      kLargestCoordinateText);
                }
                extent_ = std::max(extent_, std::fabs(x));
            }
            points_.push_back(point);
        }
        lexer_.take_symbol(';', "before the number of pieces");
        if (!(extent_ >= kSmallestCoordinate)) {
            refuse(lexer_.token().where, "the points of the curve are all at the origin; expected a curve");
        }
    }

    Vec3 take_point() {
        const SourceLocation where = lexer_.token().where;
        const double number = lexer_.take_number("the number of a point");
        if (!(number >= 1 && number <= static_cast<double>(points_.size())) || number != std::floor(number)) {
            refuse(where, "a piece names the point " + number_text(number) +
                              "; expected a number from 1 to " + std::to_string(points_.size()));
        }
        return points_[static_cast<std::size_t>(number) - 1];
    }

    void read_piece() {
        const SourceLocation where = lexer_.token().where;
        const double kind = lexer_.take_number("the kind of a piece");
        if (kind != 2 && kind != 3 && kind != 4) {
            refuse(where, "a piece is of kind " + number_text(kind) +
                              "; expected 2 (line), 3 (spline) or 4 (arc of a circle)");
        }
        GeoCurve::Piece piece;
        lexer_.take_symbol(',', "after the kind of a piece");
        piece.a = take_point();
        lexer_.take_symbol(',', "between the points of a piece");
        if (kind != 2) {
            piece.kind = kind == 3 ? GeoCurve::Kind::kSpline : GeoCurve::Kind::kArc;
            piece.b = take_point();
            lexer_.take_symbol(',', "between the points of a piece");
        }
        piece.c = take_point();
        check(piece, where);
        if (!curve_.pieces.empty()) {
            if (!same(curve_.pieces.back().c, piece.a)) {
                refuse(where,
                       "this piece does not start where the one before it ends; expected one curve "
                       "without gaps, pieces in order");
            }
            piece.a = curve_.pieces.back().c;
        }
        curve_.pieces.push_back(piece);
    }

    void check(const GeoCurve::Piece& piece, SourceLocation where) const {
        const auto& [kind, a, b, c] = piece;
        if (same(a, c)) refuse(where, "this piece ends where it starts; expected two different points");
        if (kind == GeoCurve::Kind::kLine) return;
        if (same(a, b) || same(b, c)) {
            refuse(where, "the middle point of this piece is one of its ends; expected another point");
        }
        if (turn_of(piece) > kMostTurn) {
            refuse(where, kind == GeoCurve::Kind::kArc
                              ? "this arc is half a circle, which may go either way; use two arcs"
                              : "this spline goes back on itself; expected a middle point where the tangents "
                                "of its ends meet");
        }
        if (kind != GeoCurve::Kind::kArc) return;
        const double radius = distance(a, b);
        const double other = distance(c, b);
        if (std::fabs(radius - other) > 1e-6 * radius) {
            refuse(where, "the ends of this arc are " + number_text(radius) + " and " + number_text(other) +
                              " from its centre, the middle point; expected equal distances");
        }
    }

    GeoLexer& lexer_;
    GeoCurve curve_;
    std::vector<Vec3> points_;
    double extent_ = 0;
};

}  // namespace

bool GeoCurve::has_lines_only() const {
    return std::all_of(pieces.begin(), pieces.end(), [](const Piece& p) { return p.kind == Kind::kLine; });
}

GeoCurve read_geo_curve(GeoLexer& lexer, bool in_plane) { return CurveReader(lexer, in_plane).read(); }

double most_points(const GeoCurve& curve) {
    double sum = 1;
    // Where a spline's tangent turns unevenly, more points are added: one for each half of a step.
    for (const GeoCurve::Piece& piece : curve.pieces) sum += 3 * parts_of(piece);
    return sum;
}

std::vector<CurvePoint> divided(const GeoCurve& curve) {
    std::vector<CurvePoint> points;
    const auto add = [&points](const Sample& at, std::uint32_t piece, bool begins) {
        if (begins && !points.empty()) {
            points.back().after = at.tangent;
            points.back().piece = piece;
        } else {
            points.push_back({at.point, at.tangent, at.tangent, piece});
        }
    };
    for (std::uint32_t index = 0; index < curve.pieces.size(); ++index) {
        const GeoCurve::Piece& piece = curve.pieces[index];
        Sample from = sample(piece, 0);
        add(from, index, true);
        const double parts = parts_of(piece);
        const std::size_t limit = points.size() + static_cast<std::size_t>(3 * parts);
        double t = 0;
        for (double k = 1; k <= parts; ++k) {
            // Ends of intervals still to be reached, the nearest last.
            std::vector<double> ends = {k / parts};
            while (!ends.empty()) {
                const Sample to = sample(piece, ends.back());
                const bool turns = angle_between(from.tangent, to.tangent) > 1.5 * kPieceTurn;
                if (turns && parts > 1 && ends.size() < 12 && points.size() + ends.size() < limit) {
                    ends.push_back((t + ends.back()) / 2);
                    continue;
                }
                t = ends.back();
                ends.pop_back();
                from = to;
                add(to, index, false);
            }
        }
        points.back().point = piece.c;
    }
    if (curve.closed) {
        points.front().before = points.back().before;
        points.pop_back();
    }
    return points;
}

}  // namespace mortise::model_reader
