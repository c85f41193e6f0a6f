// Offsets of polygons.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "host/model/outlines/polygons.hpp"

namespace mortise::model_reader {
namespace {

using OffsetVector = std::array<double, 2>;

/// A quarter turn; exact.
Contours turned(Contours contours, bool clockwise) {
    for (auto& loop : contours) {
        for (Vec2& p : loop) p = clockwise ? Vec2{p[1], -p[0]} : Vec2{-p[1], p[0]};
    }
    return contours;
}

bool is_wide(const Contours& contours) {
    constexpr double kWide = 8;
    Vec2 low = {0, 0};
    Vec2 high = {0, 0};
    bool first = true;
    for (const auto& loop : contours) {
        for (const Vec2& p : loop) {
            for (std::size_t k = 0; k < 2; ++k) {
                low[k] = first ? p[k] : std::min(low[k], p[k]);
                high[k] = first ? p[k] : std::max(high[k], p[k]);
            }
            first = false;
        }
    }
    return high[0] - low[0] > kWide * (high[1] - low[1]);
}

double cross_of(const OffsetVector& a, const OffsetVector& b) { return a[0] * b[1] - a[1] * b[0]; }

/// Every round or cut corner has two points or more, so offsets of offsets would double theirs each time. An
/// edge between two turns of one direction is drawn together to where its neighbours meet, if that lies
/// within `tolerance` of it; no two edges that share a point in one call.
void join_close_turns(ClipperLib::Path& loop, double tolerance) {
    const auto vector = [](const ClipperLib::IntPoint& from, const ClipperLib::IntPoint& to) {
        return OffsetVector{static_cast<double>(to.X - from.X), static_cast<double>(to.Y - from.Y)};
    };
    ClipperLib::Path kept;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        kept.push_back(loop[i]);
        if (loop.size() < 5 || i == 0 || i + 2 >= loop.size()) continue;
        const ClipperLib::IntPoint& before = kept[kept.size() - 2];
        const OffsetVector in = vector(before, loop[i]);
        const OffsetVector edge = vector(loop[i], loop[i + 1]);
        const OffsetVector out = vector(loop[i + 1], loop[i + 2]);
        const double first = cross_of(in, edge);
        const double second = cross_of(edge, out);
        const double whole = cross_of(in, out);
        if (first * second <= 0 || first * whole <= 0) continue;
        // Both lines meet at loop[i] + t in.
        const double t = cross_of(edge, out) / whole;
        const double height = std::fabs(t * first) / std::hypot(edge[0], edge[1]);
        if (height > tolerance) continue;
        kept.back().X += std::llround(t * in[0]);
        kept.back().Y += std::llround(t * in[1]);
        ++i;
    }
    loop = std::move(kept);
}

}  // namespace

Contours offset(const Contours& contours, double distance, OffsetCorner corner, int fragments) {
    if (distance == 0) return contours;
    // Clipper sweeps along y: each of its steps would cross all letters of a line of text.
    if (is_wide(contours)) {
        return turned(offset(turned(contours, true), distance, corner, fragments), false);
    }
    constexpr double kMiterLimit = 1e6;
    constexpr double kFinerThanArc = 16;
    double reach = 0;
    for (const auto& loop : contours) {
        for (const Vec2& p : loop) reach = std::max({reach, std::fabs(p[0]), std::fabs(p[1])});
    }
    const PolygonLattice lattice(reach + 2 * std::fabs(distance));
    const double delta = distance / lattice.step();
    const double tolerance = std::fabs(delta) * (1 - cosine_of_degrees(180.0 / fragments));
    ClipperLib::ClipperOffset clipper(kMiterLimit, tolerance);
    clipper.AddPaths(lattice.paths(contours),
                     corner == OffsetCorner::kRound     ? ClipperLib::jtRound
                     : corner == OffsetCorner::kChamfer ? ClipperLib::jtSquare
                                                        : ClipperLib::jtMiter,
                     ClipperLib::etClosedPolygon);
    LatticePaths result;
    clipper.Execute(result, delta);
    if (corner != OffsetCorner::kMiter) {
        for (auto& loop : result) join_close_turns(loop, tolerance / kFinerThanArc);
    }
    return lattice.contours(lattice.combined(FlatNode::Op::kUnion, {std::move(result)}));
}

}  // namespace mortise::model_reader
