#include "host/model/solids/swept_outline.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

#include "host/common/constants.hpp"
#include "host/common/parting.hpp"
#include "host/model/outlines/contour_triangles.hpp"
#include "host/model/outlines/polygons.hpp"

namespace mortise::model_reader {
namespace {

constexpr std::size_t kMostNamedSides = 24;
constexpr std::size_t kFewEdges = 8;
// Corners of twisted outlines part sides, whatever the angle; within a side triangles turn by this at most.
constexpr double kTwistedTurn = 60;
/// Of an arc over its chord, in longest edges: 0.001 of the outline's width.
constexpr double kMostRise = 0.016;

using Loop = std::vector<Vec2>;

const Vec2& at(const Loop& loop, std::size_t i) { return loop[i % loop.size()]; }

double cross(const Vec2& o, const Vec2& a, const Vec2& b) {
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
}

/// Angle to the left by which the outline turns where edge i ends.
double turn_after(const Loop& loop, std::size_t i) {
    const Vec2& a = at(loop, i);
    const Vec2& b = at(loop, i + 1);
    const Vec2& c = at(loop, i + 2);
    const Vec2 u = {b[0] - a[0], b[1] - a[1]};
    const Vec2 v = {c[0] - b[0], c[1] - b[1]};
    return std::atan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]);
}

/// Whether the outline turns by no more than that many degrees where edge i ends.
bool is_smooth_after(const Loop& loop, std::size_t i, double degrees) {
    return std::fabs(turn_after(loop, i)) <= (degrees + 1e-6) * kRadians;
}

bool is_curved(const Loop& loop, double degrees) {
    const bool has_few = loop.size() <= kMostSharpEdges;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const bool turns_little =
            has_few ? is_smooth_after(loop, i, kHardlyTurn) && is_smooth_after(loop, i + 1, kHardlyTurn)
                    : is_smooth_after(loop, i, degrees);
        if (turns_little) return true;
    }
    return false;
}

/// Each turn to the left, or each to the right.
bool turns_one_way(const Loop& loop) {
    const bool left = signed_area(loop) > 0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const double turn = cross(at(loop, i), at(loop, i + 1), at(loop, i + 2));
        if (left ? turn < 0 : turn > 0) return false;
    }
    return true;
}

/// The first edge that begins at a corner; the number of edges if there is none.
std::size_t edge_behind_corner(const Loop& loop, double sharp_angle) {
    const std::size_t n = loop.size();
    std::size_t i = 0;
    while (i < n && is_smooth_after(loop, i + n - 1, sharp_angle)) ++i;
    return i;
}

/// Per edge the number of the side that it is part of, from 0.
std::vector<std::uint32_t> sides_of(const Loop& loop, double sharp_angle) {
    const std::size_t n = loop.size();
    std::vector<std::uint32_t> side(n, 0);
    const bool curved = sharp_angle > 0 && is_curved(loop, sharp_angle);
    // From a corner on, so that no side is cut where the loop happens to begin.
    const std::size_t first = curved ? edge_behind_corner(loop, sharp_angle) : 0;
    if (first == n) return side;
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < n; ++i) {
        side[(first + i) % n] = count;
        if (!curved || !is_smooth_after(loop, first + i, sharp_angle)) ++count;
    }
    return side;
}

/// Per edge the number of the curved surface that it sweeps: its side, but if a side meets itself at a
/// corner, as that of a teardrop, it becomes two. A single surface could not tell the two sides of the corner
/// apart.
std::vector<std::uint32_t> parts_of(const Loop& loop, const std::vector<std::uint32_t>& side,
                                    double sharp_angle) {
    const std::size_t n = loop.size();
    const std::size_t corner = edge_behind_corner(loop, sharp_angle);
    if (corner == n || *std::max_element(side.begin(), side.end()) > 0) return side;
    std::vector<double> turns(n);
    for (std::size_t i = 0; i < n; ++i) turns[i] = turn_after(loop, i + n - 1);
    return parts_of_ring(std::move(turns), corner);
}

}  // namespace

double outline_sharp_angle(const Contours& loops, bool smooth) {
    const bool curved = smooth && std::any_of(loops.begin(), loops.end(),
                                              [](const Loop& loop) { return is_curved(loop, kSmoothTurn); });
    return curved ? kSmoothTurn : 0;
}

bool wants_prism(const Contours& loops, bool smooth) {
    if (outline_sharp_angle(loops, smooth) > 0) return true;
    return std::any_of(loops.begin(), loops.end(),
                       [](const Loop& loop) { return loop.size() > kFewEdges && !turns_one_way(loop); });
}

namespace {

double length_of(const Loop& loop, std::size_t i) {
    const Vec2& p = at(loop, i);
    const Vec2& q = at(loop, i + 1);
    return std::hypot(q[0] - p[0], q[1] - p[1]);
}

/// Slopes, seen from edge i, of the curve that its side stands for, where the edge starts and ends: as of an
/// arc through three corners. Where a side ends it goes on as it came; zero: the edge is straight.
std::array<double, 2> end_slopes(const Loop& loop, std::size_t i, const std::vector<std::uint32_t>& side) {
    const std::size_t n = loop.size();
    const std::size_t before = (i + n - 1) % n;
    const std::size_t after = (i + 1) % n;
    const auto share = [&](std::size_t first, std::size_t other) {
        const double turn = turn_after(loop, first);
        return std::tan(turn * length_of(loop, i) / (length_of(loop, i) + length_of(loop, other)));
    };
    const bool joins_before = before != i && side[before] == side[i];
    const bool joins_after = after != i && side[after] == side[i];
    const double start = joins_before ? share(before, before) : 0;
    const double end = joins_after ? share(i, after) : 0;
    return {-(joins_before ? start : end), joins_after ? end : start};
}

/// Loops with divided edges and per edge the number of its part of the surface.
struct SweptSides {
    Contours loops;
    std::vector<std::vector<std::uint32_t>> parts;
    std::vector<std::uint32_t> side_count;  ///< per loop: one for all parts if it has one corner at most

    std::size_t edge_count() const {
        return std::accumulate(loops.begin(), loops.end(), std::size_t{0},
                               [](std::size_t sum, const Loop& loop) { return sum + loop.size(); });
    }

    /// `twist`: angle by which the outline turns per unit of height. An edge sweeps a part of a helicoid,
    /// and is divided where the normal turns by more than `most_turn` along it.
    SweptSides(const Contours& given, double sharp_angle, double longest_edge, double twist, double most_turn)
        : loops(given.size()) {
        for (std::size_t l = 0; l < given.size(); ++l) {
            const Loop& loop = given[l];
            const std::vector<std::uint32_t> side = sides_of(loop, sharp_angle);
            const std::vector<std::uint32_t> part = parts_of(loop, side, sharp_angle);
            parts.emplace_back();
            side_count.push_back(1 + *std::max_element(side.begin(), side.end()));
            for (std::size_t i = 0; i < loop.size(); ++i) {
                const Vec2& p = loop[i];
                const Vec2& q = at(loop, i + 1);
                const double length = length_of(loop, i);
                const Vec2 along = {(q[0] - p[0]) / length, (q[1] - p[1]) / length};
                std::array<double, 2> slopes =
                    twist == 0 ? std::array<double, 2>{0, 0} : end_slopes(loop, i, side);
                // Far from its chord the arc would be another solid.
                if (length * (std::fabs(slopes[0]) + std::fabs(slopes[1])) / 8 > kMostRise * longest_edge)
                    slopes = {0, 0};
                const bool is_curve = slopes[0] != 0 || slopes[1] != 0;
                const double from = std::atan(twist * (along[0] * p[0] + along[1] * p[1]));
                const double to = std::atan(twist * (along[0] * q[0] + along[1] * q[1]));
                const double pieces = std::max(
                    {1.0, std::ceil(length / longest_edge), std::ceil(std::fabs(to - from) / most_turn)});
                for (double k = 0; k < pieces; ++k) {
                    // Of a straight edge by equal angles of the normal, of a curve by equal lengths.
                    double t = k / pieces;
                    if (k > 0 && !is_curve && std::fabs(to - from) > most_turn) {
                        t = (std::tan(from + t * (to - from)) - std::tan(from)) /
                            (std::tan(to) - std::tan(from));
                    }
                    const double rise = t * (1 - t) * (slopes[0] * (1 - t) - slopes[1] * t);
                    loops[l].push_back(k == 0 ? p
                                              : Vec2{p[0] + t * (q[0] - p[0]) - rise * (q[1] - p[1]),
                                                     p[1] + t * (q[1] - p[1]) + rise * (q[0] - p[0])});
                    parts[l].push_back(part[i]);
                }
            }
        }
    }
};

TriangleSurface joined_rows(const SweptSides& outline, const OutlineRows& rows,
                            const std::function<std::string()>& next_side) {
    const Contours& loops = outline.loops;
    TriangleSurface surface;
    if (!rows.is_ring) surface.group_names = {"bottom", "top"};
    // Row after row. On an axis a point is that of the row before, at an apex that beside it.
    std::vector<std::uint32_t> number;
    for (std::size_t row = 0; row < rows.count; ++row) {
        const std::size_t in_row = number.size() / std::max<std::size_t>(row, 1);
        const std::size_t begin = number.size();
        for (const Loop& loop : loops) {
            for (const Vec2& p : loop) {
                const Vec3 at = rows.place(p, row, rows.count);
                const auto is_at = [&](std::size_t other) { return surface.points[number[other]] == at; };
                if (row > 0 && is_at(number.size() - in_row)) {
                    number.push_back(number[number.size() - in_row]);
                } else if (number.size() > begin && is_at(number.size() - 1)) {
                    number.push_back(number.back());
                } else {
                    number.push_back(static_cast<std::uint32_t>(surface.points.size()));
                    surface.points.push_back(at);
                }
            }
        }
    }
    const std::size_t count = number.size() / rows.count;
    const auto add = [&](std::size_t i, std::size_t j, std::size_t k, std::size_t group) {
        const std::uint32_t a = number[i];
        const std::uint32_t b = number[j];
        const std::uint32_t c = number[k];
        if (a == b || b == c || c == a) return;
        surface.triangles.push_back({a, b, c});
        surface.group.push_back(static_cast<std::uint32_t>(group));
    };

    std::size_t first = 0;
    for (std::size_t l = 0; l < loops.size(); ++l) {
        const std::vector<std::uint32_t>& parts = outline.parts[l];
        const std::uint32_t part_count = 1 + *std::max_element(parts.begin(), parts.end());
        const bool named = outline.side_count[l] <= kMostNamedSides;
        const bool parted = named || rows.twist != 0;
        const std::size_t group = surface.group_names.size();
        for (std::uint32_t k = 0; k < (parted ? part_count : 1); ++k) {
            const bool is_new = k == 0 || (named && outline.side_count[l] > 1);
            surface.group_names.push_back(is_new ? next_side() : surface.group_names.back());
        }
        const std::size_t n = loops[l].size();
        for (std::size_t row = 0; row + (rows.is_ring ? 0 : 1) < rows.count; ++row) {
            const std::size_t here = row * count;
            const std::size_t next = (row + 1) % rows.count * count;
            for (std::size_t i = 0; i < n; ++i) {
                const std::size_t a = first + i;
                const std::size_t b = first + (i + 1) % n;
                const std::size_t side = group + (parted ? parts[i] : 0);
                add(here + a, here + b, next + b, side);
                add(here + a, next + b, next + a, side);
            }
        }
        first += n;
    }
    if (rows.is_ring) return surface;

    const std::size_t top = (rows.count - 1) * count;
    for (const auto& [a, b, c] : triangulate(loops)) {
        add(a, c, b, 0);
        add(top + a, top + b, top + c, 1);
    }
    return surface;
}

}  // namespace

Primitive prism(const Contours& loops, const PrismSpan& span, double sharp_angle,
                const std::function<std::string()>& next_side) {
    OutlineRows rows;
    rows.count = 2;
    rows.place = [&span](const Vec2& p, std::size_t row, std::size_t) {
        const double scale = row == 0 ? span.low_scale : span.high_scale;
        return Vec3{p[0] * scale, p[1] * scale, row == 0 ? span.low : span.high};
    };
    constexpr double kAnyLength = std::numeric_limits<double>::infinity();
    return polyhedron(joined_rows(SweptSides(loops, sharp_angle, kAnyLength, 0, kAnyLength), rows, next_side),
                      sharp_angle);
}

std::optional<Primitive> swept_outline(const Contours& loops, OutlineRows rows, double width, bool smooth,
                                       const std::function<std::string()>& next_side) {
    constexpr double kLongestEdge = 1.0 / 16;
    constexpr double kFineTurn = 6;
    constexpr double kCoarseTurn = 12;
    constexpr std::size_t kManyQuads = 200000;
    constexpr std::size_t kMostQuads = 500000;
    const double sharp_angle = outline_sharp_angle(loops, smooth);
    const double longest_edge = kLongestEdge * width;
    SweptSides outline(loops, sharp_angle, longest_edge, rows.twist, kFineTurn * kRadians);
    if (outline.edge_count() * rows.count > kManyQuads)
        outline = SweptSides(loops, sharp_angle, longest_edge, rows.twist, kCoarseTurn * kRadians);
    const std::size_t edges = outline.edge_count();
    const std::size_t fewest = rows.count / 4;
    if (fewest > kMostQuads / edges) return std::nullopt;
    const std::size_t affordable = kManyQuads / edges / 4 * 4;
    rows.count = std::min(rows.count, std::max(fewest, affordable));
    return polyhedron(joined_rows(outline, rows, next_side), rows.twist != 0 ? kTwistedTurn : kSmoothTurn);
}

}  // namespace mortise::model_reader
