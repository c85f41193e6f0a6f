// See convex_differences.hpp.
#include "host/model/solids/convex_differences.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/model/affine.hpp"
#include "host/model/agreement.hpp"
#include "host/model/solids/convex_hull.hpp"
#include "host/model/text.hpp"

namespace mortise::model_reader {
namespace {

constexpr std::size_t kMostParts = 256;

struct Part {
    std::vector<Vec3> points;
    std::vector<Plane> planes;
    double size = 0;
};

/// Nothing if it is flat.
std::optional<Part> part_of(const std::vector<Vec3>& points) {
    const std::optional<Polytope> hull = convex_hull(points);
    if (!hull) return {};
    Part part;
    part.points = hull->vertices;
    for (const Polytope::Face& face : hull->faces) part.planes.push_back(face.plane);
    for (const Vec3& p : part.points) {
        const Vec3& o = part.points[0];
        part.size = std::max(part.size, length({p[0] - o[0], p[1] - o[1], p[2] - o[2]}));
    }
    return part;
}

bool is_within(const Part& part, const Plane& plane, double margin) {
    return std::all_of(part.points.begin(), part.points.end(),
                       [&](const Vec3& p) { return dot(plane.normal, p) <= plane.offset + margin; });
}

bool is_beyond(const Part& part, const Plane& plane, double margin) {
    return std::all_of(part.points.begin(), part.points.end(),
                       [&](const Vec3& p) { return dot(plane.normal, p) >= plane.offset - margin; });
}

std::optional<Part> common(const Part& part, const std::vector<Plane>& planes) {
    std::vector<Plane> all = part.planes;
    all.insert(all.end(), planes.begin(), planes.end());
    std::vector<Vec3> points;
    if (vertices_of(all, points) != Boundedness::kBounded) return {};
    return part_of(points);
}

void add_parts(const Part& part, const Part& cut, std::vector<Part>& out) {
    const double margin = kSame * std::max(part.size, cut.size);
    const bool apart = std::any_of(cut.planes.begin(), cut.planes.end(),
                                   [&](const Plane& plane) { return is_beyond(part, plane, margin); });
    if (apart || !common(part, cut.planes)) {
        out.push_back(part);
        return;
    }
    for (const Plane& plane : cut.planes) {
        if (is_within(part, plane, margin)) continue;
        const Vec3& n = plane.normal;
        if (auto rest = common(part, {{{-n[0], -n[1], -n[2]}, -plane.offset, {}}})) {
            out.push_back(std::move(*rest));
        }
    }
}

/// Without parts that lie in others.
void drop_inner(std::vector<Part>& parts) {
    std::vector<Part> kept;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        bool inside = false;
        for (std::size_t j = 0; j < parts.size() && !inside; ++j) {
            if (i == j) continue;
            const auto holds = [&](std::size_t outer, std::size_t inner) {
                const double margin = kSame * std::max(parts[outer].size, parts[inner].size);
                return std::all_of(
                    parts[outer].planes.begin(), parts[outer].planes.end(),
                    [&](const Plane& plane) { return is_within(parts[inner], plane, margin); });
            };
            // Of equal ones the first stays.
            inside = holds(j, i) && (j < i || !holds(i, j));
        }
        if (!inside) kept.push_back(parts[i]);
    }
    parts = std::move(kept);
}

}  // namespace

void take_away(std::vector<ConvexPiece>& pieces, const std::vector<ConvexPiece>& cuts, const Wanted& wanted) {
    std::vector<Part> parts;
    for (const ConvexPiece& piece : pieces) {
        if (auto part = part_of(piece.points)) parts.push_back(std::move(*part));
    }
    for (const ConvexPiece& piece : cuts) {
        const std::optional<Part> cut = part_of(piece.points);
        if (!cut) continue;
        std::vector<Part> next;
        for (const Part& part : parts) add_parts(part, *cut, next);
        if (next.size() <= 4 * kMostParts) drop_inner(next);
        if (next.size() > kMostParts) {
            fail(wanted.source, wanted.where,
                 "'" + wanted.name + "': a difference among its children has more than " +
                     std::to_string(kMostParts) + " convex parts; expected simpler children");
        }
        parts = std::move(next);
    }
    pieces.clear();
    for (Part& part : parts) {
        ConvexPiece piece;
        piece.points = std::move(part.points);
        pieces.push_back(std::move(piece));
    }
}

}  // namespace mortise::model_reader
