#include "host/model/outlines/polygons.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "host/common/coordinate_limits.hpp"
#include "host/common/sort_unique.hpp"
#include "mortise/error.hpp"

namespace mortise::model_reader {
namespace {

constexpr int kLatticeBits = 45;
/// What deviates less from a straight line, in units of the drawing's size, is straight.
constexpr double kStraight = 1e-11;

double cross(const Vec2& o, const Vec2& a, const Vec2& b) {
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
}

double reach_of(const Contours& loops) {
    double reach = 0;
    for (const auto& loop : loops) {
        for (const Vec2& point : loop) reach = std::max({reach, std::fabs(point[0]), std::fabs(point[1])});
    }
    return reach;
}

/// Drops repeated and collinear points, and spikes.
void straighten(std::vector<Vec2>& loop, double tolerance) {
    std::vector<Vec2> kept;
    const auto is_straight = [&](const Vec2& a, const Vec2& b, const Vec2& c) {
        const double longest =
            std::max({std::hypot(b[0] - a[0], b[1] - a[1]), std::hypot(c[0] - b[0], c[1] - b[1]), tolerance});
        return std::fabs(cross(a, b, c)) <= tolerance * longest;
    };
    for (const Vec2& point : loop) {
        kept.push_back(point);
        while (kept.size() > 2 && is_straight(kept[kept.size() - 3], kept[kept.size() - 2], kept.back())) {
            kept.erase(kept.end() - 2);
        }
    }
    // The seam, from both sides.
    std::size_t first = 0;
    for (bool changed = true; changed && kept.size() >= first + 3;) {
        changed = false;
        if (is_straight(kept[kept.size() - 2], kept.back(), kept[first])) {
            kept.pop_back();
            changed = true;
        } else if (is_straight(kept.back(), kept[first], kept[first + 1])) {
            ++first;
            changed = true;
        }
    }
    kept.erase(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(first));
    if (kept.size() < 3) kept.clear();
    loop = std::move(kept);
}

double perimeter(const std::vector<Vec2>& loop) {
    double sum = 0;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const Vec2& a = loop[i];
        const Vec2& b = loop[(i + 1) % loop.size()];
        sum += std::hypot(b[0] - a[0], b[1] - a[1]);
    }
    return sum;
}

bool is_inside(const std::vector<Vec2>& loop, const Vec2& p) {
    bool inside = false;
    for (std::size_t i = 0, j = loop.size() - 1; i < loop.size(); j = i++) {
        const Vec2& a = loop[i];
        const Vec2& b = loop[j];
        if ((a[1] > p[1]) == (b[1] > p[1])) continue;
        if (p[0] < (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]) + a[0]) inside = !inside;
    }
    return inside;
}

struct Segment {
    Vec2 a, b;  ///< a left of b
    std::size_t loop, index, count;
};

double distance_to_segment(const Vec2& p, const Segment& s) {
    const Vec2 d = {s.b[0] - s.a[0], s.b[1] - s.a[1]};
    const double square = d[0] * d[0] + d[1] * d[1];
    const double t = std::clamp(((p[0] - s.a[0]) * d[0] + (p[1] - s.a[1]) * d[1]) / square, 0.0, 1.0);
    return std::hypot(p[0] - s.a[0] - t * d[0], p[1] - s.a[1] - t * d[1]);
}

/// Whether two segments that are not neighbours come closer than `tolerance`.
bool touch(const Segment& s, const Segment& t, double tolerance) {
    if (std::max(s.a[1], s.b[1]) < std::min(t.a[1], t.b[1]) - tolerance ||
        std::max(t.a[1], t.b[1]) < std::min(s.a[1], s.b[1]) - tolerance) {
        return false;
    }
    const bool crosses = (cross(s.a, s.b, t.a) > 0) != (cross(s.a, s.b, t.b) > 0) &&
                         (cross(t.a, t.b, s.a) > 0) != (cross(t.a, t.b, s.b) > 0);
    return crosses || distance_to_segment(t.a, s) <= tolerance || distance_to_segment(t.b, s) <= tolerance ||
           distance_to_segment(s.a, t) <= tolerance || distance_to_segment(s.b, t) <= tolerance;
}

/// Whether no two edges meet but neighbours at their common end: sweep along x with a list of open edges.
bool are_simple(const Contours& loops, double tolerance) {
    std::vector<Segment> segments;
    for (std::size_t l = 0; l < loops.size(); ++l) {
        const std::size_t count = loops[l].size();
        for (std::size_t i = 0; i < count; ++i) {
            Segment s{loops[l][i], loops[l][(i + 1) % count], l, i, count};
            if (s.b < s.a) std::swap(s.a, s.b);
            segments.push_back(s);
        }
    }
    std::sort(segments.begin(), segments.end(), [](const Segment& s, const Segment& t) { return s.a < t.a; });
    std::vector<const Segment*> open;
    for (const Segment& segment : segments) {
        std::size_t kept = 0;
        for (const Segment* other : open) {
            if (other->b[0] < segment.a[0] - tolerance) continue;
            open[kept++] = other;
            const std::size_t gap = (segment.index + segment.count - other->index) % segment.count;
            const bool neighbours = segment.loop == other->loop && (gap == 1 || gap == segment.count - 1);
            if (!neighbours && touch(segment, *other, tolerance)) return false;
        }
        open.resize(kept);
        open.push_back(&segment);
    }
    return true;
}

/// Loops may share corners; the middle of an edge lies on one loop only.
Vec2 middle_of_longest_edge(const std::vector<Vec2>& loop) {
    Vec2 middle{};
    double longest = -1;
    for (std::size_t i = 0; i < loop.size(); ++i) {
        const Vec2& a = loop[i];
        const Vec2& b = loop[(i + 1) % loop.size()];
        const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
        if (length <= longest) continue;
        longest = length;
        middle = {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2};
    }
    return middle;
}

/// Outer loops counter-clockwise, each followed by its holes. Precondition: loops are simple, do not cross
/// and share no more than corners.
Contours nested(Contours loops) {
    const std::size_t count = loops.size();
    std::vector<Box2> boxes(count);
    for (std::size_t i = 0; i < count; ++i) {
        boxes[i] = {loops[i][0], loops[i][0]};
        for (const Vec2& point : loops[i]) {
            for (std::size_t k = 0; k < 2; ++k) {
                boxes[i].min[k] = std::min(boxes[i].min[k], point[k]);
                boxes[i].max[k] = std::max(boxes[i].max[k], point[k]);
            }
        }
    }
    // The parent of a hole is the smallest loop around it.
    std::vector<std::size_t> depth(count, 0);
    std::vector<std::size_t> parent(count, count);
    std::vector<double> area(count);
    for (std::size_t i = 0; i < count; ++i) area[i] = std::fabs(signed_area(loops[i]));
    for (std::size_t i = 0; i < count; ++i) {
        const Vec2 p = middle_of_longest_edge(loops[i]);
        for (std::size_t j = 0; j < count; ++j) {
            if (i == j || area[j] <= area[i] || p[0] < boxes[j].min[0] || p[0] > boxes[j].max[0] ||
                p[1] < boxes[j].min[1] || p[1] > boxes[j].max[1] || !is_inside(loops[j], p)) {
                continue;
            }
            ++depth[i];
            if (parent[i] == count || area[j] < area[parent[i]]) parent[i] = j;
        }
    }
    std::vector<std::vector<std::size_t>> holes(count);
    for (std::size_t i = 0; i < count; ++i) {
        const bool is_hole = depth[i] % 2 == 1;
        if ((signed_area(loops[i]) < 0) != is_hole) std::reverse(loops[i].begin(), loops[i].end());
        if (is_hole) holes[parent[i]].push_back(i);
    }
    Contours result;
    for (std::size_t i = 0; i < count; ++i) {
        if (depth[i] % 2 == 1) continue;
        result.push_back(loops[i]);
        for (const std::size_t hole : holes[i]) result.push_back(loops[hole]);
    }
    return result;
}

bool turns_left(const std::vector<Vec2>& loop) {
    for (std::size_t i = 0; i < loop.size(); ++i) {
        if (cross(loop[i], loop[(i + 1) % loop.size()], loop[(i + 2) % loop.size()]) < 0) return false;
    }
    return true;
}

/// One outer loop with its holes.
std::vector<Contours> components(const Contours& contours) {
    std::vector<Contours> result;
    for (const auto& loop : contours) {
        if (signed_area(loop) > 0 || result.empty()) result.emplace_back();
        result.back().push_back(loop);
    }
    return result;
}

LatticePaths filled(const LatticePaths& paths, ClipperLib::PolyFillType rule) {
    ClipperLib::Clipper clipper;
    clipper.StrictlySimple(true);
    clipper.AddPaths(paths, ClipperLib::ptSubject, true);
    LatticePaths result;
    clipper.Execute(ClipperLib::ctUnion, result, rule, rule);
    return result;
}

}  // namespace

PolygonLattice::PolygonLattice(double reach) : reach_(std::max(reach, kSmallestCoordinate)) {
    if (!(reach < kLargestCoordinate)) {
        throw Error(ExitCode::kInput, std::string("a 2D shape is larger than ") + kLargestCoordinateText +
                                          " in its units; choose other units");
    }
    step_ = std::ldexp(1.0, std::ilogb(reach_) + 1 - kLatticeBits);
}

LatticePaths PolygonLattice::rounded(const Contours& loops) const {
    LatticePaths rounded;
    for (const auto& loop : loops) {
        ClipperLib::Path path;
        for (const Vec2& point : loop) {
            path.emplace_back(static_cast<ClipperLib::cInt>(std::llround(point[0] / step_)),
                              static_cast<ClipperLib::cInt>(std::llround(point[1] / step_)));
        }
        rounded.push_back(std::move(path));
    }
    return rounded;
}

LatticePaths PolygonLattice::paths(const Contours& loops) const {
    return filled(rounded(loops), ClipperLib::pftEvenOdd);
}

LatticePaths PolygonLattice::wound_paths(const Contours& loops) const {
    // Clipper's time grows with the number of edges side by side: few loops at a time, then their unions.
    constexpr std::size_t kFew = 32;
    std::vector<LatticePaths> parts;
    for (auto& path : rounded(loops)) {
        if (parts.empty() || parts.back().size() == kFew) parts.emplace_back();
        parts.back().push_back(std::move(path));
    }
    // Only outer loops may be united in parts: a hole stays with what it is a hole of.
    const bool outer_only =
        std::all_of(loops.begin(), loops.end(), [](const auto& loop) { return signed_area(loop) >= 0; });
    if (!outer_only) {
        LatticePaths all;
        for (LatticePaths& part : parts) std::move(part.begin(), part.end(), std::back_inserter(all));
        return filled(all, ClipperLib::pftPositive);
    }
    while (parts.size() > 1) {
        std::vector<LatticePaths> next;
        for (std::size_t i = 0; i < parts.size(); i += 2) {
            LatticePaths pair = std::move(parts[i]);
            if (i + 1 < parts.size())
                std::move(parts[i + 1].begin(), parts[i + 1].end(), std::back_inserter(pair));
            next.push_back(filled(pair, ClipperLib::pftPositive));
        }
        parts = std::move(next);
    }
    return parts.empty() ? LatticePaths{} : filled(parts[0], ClipperLib::pftPositive);
}

LatticePaths PolygonLattice::combined(FlatNode::Op op, std::vector<LatticePaths> operands) const {
    if (operands.empty()) return {};
    LatticePaths result = std::move(operands[0]);
    const auto execute = [&](ClipperLib::ClipType type, const LatticePaths* clip) {
        ClipperLib::Clipper clipper;
        clipper.StrictlySimple(true);
        clipper.AddPaths(result, ClipperLib::ptSubject, true);
        if (clip != nullptr) clipper.AddPaths(*clip, ClipperLib::ptClip, true);
        LatticePaths next;
        clipper.Execute(type, next, ClipperLib::pftNonZero, ClipperLib::pftNonZero);
        result = std::move(next);
    };
    if (op == FlatNode::Op::kIntersection) {
        for (std::size_t i = 1; i < operands.size(); ++i) execute(ClipperLib::ctIntersection, &operands[i]);
        return result;
    }
    LatticePaths others;
    for (std::size_t i = 1; i < operands.size(); ++i) {
        others.insert(others.end(), operands[i].begin(), operands[i].end());
    }
    execute(op == FlatNode::Op::kDifference ? ClipperLib::ctDifference : ClipperLib::ctUnion, &others);
    return result;
}

Contours PolygonLattice::contours(const LatticePaths& paths) const {
    const double tolerance = kStraight * reach_;
    Contours loops;
    for (const ClipperLib::Path& path : paths) {
        std::vector<Vec2> loop;
        for (const ClipperLib::IntPoint& point : path) {
            loop.push_back({static_cast<double>(point.X) * step_, static_cast<double>(point.Y) * step_});
        }
        straighten(loop, tolerance);
        if (!loop.empty() && std::fabs(signed_area(loop)) > tolerance * perimeter(loop)) {
            loops.push_back(std::move(loop));
        }
    }
    return nested(std::move(loops));
}

double signed_area(const std::vector<Vec2>& loop) {
    double twice = 0;
    for (std::size_t i = 1; i + 1 < loop.size(); ++i) twice += cross(loop[0], loop[i], loop[i + 1]);
    return twice / 2;
}

Contours normalised(const Contours& loops) {
    const double reach = reach_of(loops);
    const PolygonLattice lattice(reach);
    const double tolerance = kStraight * std::max(reach, kSmallestCoordinate);
    Contours kept = loops;
    for (auto& loop : kept) straighten(loop, tolerance);
    kept.erase(std::remove_if(kept.begin(), kept.end(), [](const auto& loop) { return loop.empty(); }),
               kept.end());
    if (are_simple(kept, tolerance)) return nested(std::move(kept));
    return lattice.contours(lattice.paths(loops));
}

Contours wound(const Contours& loops) {
    const double reach = reach_of(loops);
    const double tolerance = kStraight * std::max(reach, kSmallestCoordinate);
    Contours kept = loops;
    for (auto& loop : kept) straighten(loop, tolerance);
    kept.erase(std::remove_if(kept.begin(), kept.end(), [](const auto& loop) { return loop.empty(); }),
               kept.end());
    const auto area = [](const Contours& contours) {
        double sum = 0;
        for (const auto& loop : contours) sum += signed_area(loop);
        return sum;
    };
    if (are_simple(kept, tolerance)) {
        // Outer loops and holes alternate already.
        Contours result = nested(kept);
        if (std::fabs(area(result) - area(kept)) <= tolerance * reach) return result;
    }
    const PolygonLattice lattice(reach);
    return lattice.contours(lattice.wound_paths(loops));
}

Contours convex_hull(const Contours& contours) {
    std::vector<Vec2> points;
    for (const auto& loop : contours) points.insert(points.end(), loop.begin(), loop.end());
    sort_unique(points);
    // Andrew's monotone chain: the lower hull, then the upper one.
    std::vector<Vec2> hull;
    for (int pass = 0; pass < 2; ++pass) {
        const std::size_t start = hull.size();
        for (const Vec2& point : points) {
            while (hull.size() >= start + 2 && cross(hull[hull.size() - 2], hull.back(), point) <= 0) {
                hull.pop_back();
            }
            hull.push_back(point);
        }
        if (!hull.empty()) hull.pop_back();
        std::reverse(points.begin(), points.end());
    }
    return normalised({hull});
}

Contours minkowski_sum(const Contours& a, const Contours& b) {
    constexpr std::size_t kMostSums = 1u << 20;
    const PolygonLattice lattice(reach_of(a) + reach_of(b));
    LatticePaths terms;
    for (const Contours& first : components(a)) {
        for (const Contours& second : components(b)) {
            if (first.size() == 1 && second.size() == 1 && turns_left(first[0]) && turns_left(second[0]) &&
                first[0].size() * second[0].size() <= kMostSums) {
                std::vector<Vec2> sums;
                for (const Vec2& p : first[0]) {
                    for (const Vec2& q : second[0]) sums.push_back({p[0] + q[0], p[1] + q[1]});
                }
                Contours hull = convex_hull({sums});
                if (components(a).size() == 1 && components(b).size() == 1) return hull;
                for (auto& path : lattice.paths(hull)) terms.push_back(std::move(path));
                continue;
            }
            // For connected shapes: the sum of the outlines, and each shape moved by one point of the other.
            const LatticePaths p = lattice.paths(first);
            const LatticePaths q = lattice.paths(second);
            if (p.empty() || q.empty()) continue;
            for (const ClipperLib::Path& pattern : p) {
                for (const ClipperLib::Path& path : q) {
                    LatticePaths sum;
                    ClipperLib::MinkowskiSum(pattern, path, sum, true);
                    terms.insert(terms.end(), sum.begin(), sum.end());
                }
            }
            const auto add_moved = [&terms](const LatticePaths& shape, const ClipperLib::IntPoint& by) {
                for (ClipperLib::Path path : shape) {
                    for (ClipperLib::IntPoint& point : path) {
                        point.X += by.X;
                        point.Y += by.Y;
                    }
                    terms.push_back(std::move(path));
                }
            };
            add_moved(p, q[0][0]);
            add_moved(q, p[0][0]);
        }
    }
    return lattice.contours(lattice.combined(FlatNode::Op::kUnion, {std::move(terms)}));
}

Contours filled(const Contours& contours) {
    Contours outer;
    for (const auto& loop : contours) {
        if (signed_area(loop) > 0) outer.push_back(loop);
    }
    // Islands in holes lie inside an outer loop.
    const PolygonLattice lattice(reach_of(outer));
    LatticePaths paths;
    for (const auto& loop : outer) {
        for (auto& path : lattice.paths({loop})) paths.push_back(std::move(path));
    }
    if (outer.size() <= 1) return outer;
    return lattice.contours(lattice.combined(FlatNode::Op::kUnion, {std::move(paths)}));
}

}  // namespace mortise::model_reader
