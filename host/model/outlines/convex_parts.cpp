#include "host/model/outlines/convex_parts.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/model/outlines/polygons.hpp"

namespace mortise::model_reader {
namespace {

/// Sine of the angle from which on a corner is reentrant, and part of a length that counts.
constexpr double kTurned = 1e-9;

/// A line through `at`; what lies on its left has positive distances.
struct Line {
    Vec2 at{}, direction{};

    double distance(const Vec2& p) const {
        return direction[0] * (p[1] - at[1]) - direction[1] * (p[0] - at[0]);
    }
};

/// From a to b.
Line line_along(const Vec2& a, const Vec2& b) {
    const double size = std::hypot(b[0] - a[0], b[1] - a[1]);
    return {a, {(b[0] - a[0]) / size, (b[1] - a[1]) / size}};
}

double reach_of_shape(const Contours& shape) {
    double reach = 0;
    for (const auto& loop : shape) {
        for (const Vec2& p : loop) reach = std::max({reach, std::fabs(p[0]), std::fabs(p[1])});
    }
    return reach;
}

/// How many edges of the shape the line crosses.
std::size_t crossings(const Contours& shape, const Line& line, double margin) {
    std::size_t count = 0;
    for (const auto& loop : shape) {
        double before = line.distance(loop.back());
        for (const Vec2& p : loop) {
            const double here = line.distance(p);
            if (std::min(before, here) < -margin && std::max(before, here) > margin) ++count;
            before = here;
        }
    }
    return count;
}

/// The line along an edge at a reentrant corner that crosses the fewest edges; none: the shape is convex.
std::optional<Line> best_cut(const Contours& shape, double margin) {
    std::optional<Line> best;
    std::size_t fewest = 0;
    for (const auto& loop : shape) {
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Vec2& here = loop[i];
            const Line before = line_along(loop[(i + loop.size() - 1) % loop.size()], here);
            const Line after = line_along(here, loop[(i + 1) % loop.size()]);
            const double turn =
                before.direction[0] * after.direction[1] - before.direction[1] * after.direction[0];
            if (turn > -kTurned) continue;
            for (const Line& line : {before, after}) {
                const std::size_t count = crossings(shape, line, margin);
                if (best && count >= fewest) continue;
                best = line;
                fewest = count;
            }
        }
    }
    return best;
}

/// What lies on one side of the line, as shapes in one piece each.
void add_side(const PolygonLattice& lattice, const Contours& shape, const Line& line, double side,
              double reach, std::vector<Contours>& out) {
    const double far = 4 * reach;
    const auto corner = [&](double along, double across) {
        return Vec2{line.at[0] + along * line.direction[0] - across * line.direction[1],
                    line.at[1] + along * line.direction[1] + across * line.direction[0]};
    };
    const Contours half = {
        {corner(-far, 0), corner(far, 0), corner(far, side * far), corner(-far, side * far)}};
    const Contours kept = lattice.contours(
        lattice.combined(FlatNode::Op::kIntersection, {lattice.paths(shape), lattice.paths(half)}));
    for (const auto& loop : kept) {
        if (signed_area(loop) > 0) out.emplace_back();
        out.back().push_back(loop);
    }
}

}  // namespace

std::optional<Contours> convex_parts(const Contours& shape, std::size_t most) {
    const double reach = reach_of_shape(shape);
    const PolygonLattice lattice(8 * reach);
    std::vector<Contours> open;
    for (const auto& loop : shape) {
        if (open.empty() || signed_area(loop) > 0) open.emplace_back();
        open.back().push_back(loop);
    }
    Contours parts;
    while (!open.empty()) {
        if (parts.size() + open.size() > most) return std::nullopt;
        const Contours piece = std::move(open.back());
        open.pop_back();
        const std::optional<Line> cut = best_cut(piece, kTurned * reach);
        if (!cut) {
            parts.push_back(piece.front());
            continue;
        }
        for (const double side : {1.0, -1.0}) add_side(lattice, piece, *cut, side, reach, open);
    }
    return parts;
}

}  // namespace mortise::model_reader
