// Netgen's curve2d and curve3d: pieces between numbered points, and their division into chords.
#pragma once

#include <string>
#include <unordered_map>
#include <vector>

#include "host/model/geo/geo_lexer.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// One curve without branches: each piece starts where the one before it ended.
struct GeoCurve {
    enum class Kind : std::uint8_t {
        kLine,
        kSpline,  ///< conic from a to c whose tangents there meet at b
        kArc,     ///< of the circle about b, the shorter way from a to c
    };
    struct Piece {
        Kind kind = Kind::kLine;
        Vec3 a{}, b{}, c{};  ///< z = 0 in the plane; b is not used by lines
    };
    bool in_plane = false;
    bool closed = false;
    std::vector<Piece> pieces;  ///< at least one

    bool has_lines_only() const;
};

/// Curves defined so far.
using GeoCurves = std::unordered_map<std::string, GeoCurve>;

/// Reads "( n; points; m; pieces )" at the lexer's token.
GeoCurve read_geo_curve(GeoLexer& lexer, bool in_plane);

/// A point of a divided curve with the unit tangents of the pieces that end and begin there.
struct CurvePoint {
    Vec3 point{};
    Vec3 before{};
    Vec3 after{};
    std::uint32_t piece = 0;  ///< the piece that begins here
};

/// Chords of the curve: the tangent turns by at most 1/48 of a right angle, or a little more, between two
/// points. The first point of a closed curve is not repeated.
std::vector<CurvePoint> divided(const GeoCurve& curve);

/// Upper bound of the number of points that `divided` returns.
double most_points(const GeoCurve& curve);

}  // namespace mortise::model_reader
