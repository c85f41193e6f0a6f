#include "host/model/outlines/convex_parts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

#include "host/model/outlines/contour_triangles.hpp"
#include "host/model/outlines/polygons.hpp"

namespace mortise::model_reader {
namespace {

/// Sine of the angle by which a corner may turn to the right and count as straight.
constexpr double kStraightSine = 1e-9;

double sine_of_turn(const Vec2& a, const Vec2& b, const Vec2& c) {
    const double length = std::hypot(b[0] - a[0], b[1] - a[1]) * std::hypot(c[0] - b[0], c[1] - b[1]);
    return ((b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])) / length;
}

/// Of shapes with r reentrant corners and h holes: a cut ends two such corners at most, and makes a part more
/// or a hole less, so there are r / 2 + 1 - h parts at least.
std::size_t least_parts(const Contours& shape) {
    std::size_t reentrant = 0, holes = 0;
    for (const auto& loop : shape) {
        const std::size_t n = loop.size();
        if (signed_area(loop) < 0) ++holes;
        for (std::size_t i = 0; i < n; ++i) {
            if (sine_of_turn(loop[i], loop[(i + 1) % n], loop[(i + 2) % n]) < -kStraightSine) ++reentrant;
        }
    }
    return std::max(reentrant / 2 + 1, holes + 1) - holes;
}

using Part = std::vector<std::uint32_t>;  ///< numbers of corners

/// Parts that are joined two by two along the edges between them.
class Joiner {
  public:
    explicit Joiner(const Contours& shape) {
        for (const auto& loop : shape) points_.insert(points_.end(), loop.begin(), loop.end());
        for (const auto& [a, b, c] : triangulate(shape)) parts_.push_back({a, b, c});
    }

    Contours run() {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> behind;  // of which part an edge is
        std::vector<std::size_t> into(parts_.size());
        for (std::size_t t = 0; t < parts_.size(); ++t) {
            into[t] = t;
            for (std::size_t k = 0; k < 3; ++k) behind[{parts_[t][k], parts_[t][(k + 1) % 3]}] = t;
        }
        const auto find = [&into](std::size_t t) {
            while (into[t] != t) t = into[t] = into[into[t]];
            return t;
        };
        for (const auto& [edge, t] : behind) {
            const auto other = behind.find({edge.second, edge.first});
            if (edge.first > edge.second || other == behind.end()) continue;
            const std::size_t first = find(t), second = find(other->second);
            if (first == second) continue;
            Part joined = join(parts_[first], parts_[second], edge.first, edge.second);
            if (joined.empty()) continue;
            parts_[first] = std::move(joined);
            into[second] = first;
        }
        Contours result;
        for (std::size_t t = 0; t < parts_.size(); ++t) {
            if (into[t] != t) continue;
            result.emplace_back();
            for (const std::uint32_t corner : parts_[t]) result.back().push_back(points_[corner]);
        }
        return result;
    }

  private:
    /// Both parts without the edge a, b between them, which the first one passes from a to b; empty: that is
    /// not convex.
    Part join(const Part& first, const Part& second, std::uint32_t a, std::uint32_t b) const {
        const auto from = [](const Part& part, std::uint32_t begin) {
            Part turned = part;
            std::rotate(turned.begin(), std::find(turned.begin(), turned.end(), begin), turned.end());
            return turned;
        };
        Part joined = from(first, b);       // b … a
        const Part rest = from(second, a);  // a … b
        joined.insert(joined.end(), rest.begin() + 1, rest.end() - 1);
        const std::size_t n = joined.size();
        for (std::size_t i = 0; i < n; ++i) {
            const Vec2 &p = points_[joined[i]], &q = points_[joined[(i + 1) % n]],
                       &r = points_[joined[(i + 2) % n]];
            const std::uint32_t corner = joined[(i + 1) % n];
            if ((corner == a || corner == b) && sine_of_turn(p, q, r) < -kStraightSine) return {};
        }
        return joined;
    }

    std::vector<Vec2> points_;
    std::vector<Part> parts_;
};

}  // namespace

std::optional<Contours> convex_parts(const Contours& shape, std::size_t most) {
    if (shape.empty()) return Contours{};
    if (least_parts(shape) > most) return std::nullopt;
    Contours parts = Joiner(shape).run();
    if (parts.size() > most) return std::nullopt;
    return parts;
}

}  // namespace mortise::model_reader
