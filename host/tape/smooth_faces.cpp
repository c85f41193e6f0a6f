#include "host/tape/smooth_faces.hpp"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "host/common/disjoint_sets.hpp"

namespace mortise::tape {
namespace {

constexpr double kDegree = 0.017453292519943295;
constexpr double kAlwaysSmooth = 10;          ///< degrees
constexpr std::uint32_t kFacetTriangles = 2;  ///< of a curve's facet, at most
constexpr double kAlike = 1.6;                ///< ratio of turns in a row
constexpr double kStraightOn = 0.3;           ///< cosine

/// Where one plane passes into another; each edge is listed from both sides.
struct Turn {
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    double angle = 0;  ///< radians; negative: concave
    glm::dvec3 middle{};
    glm::dvec3 onward{};  ///< in `to`, across the edge, unit length
};

glm::dvec3 to_vector(const Vec3& p) { return {p[0], p[1], p[2]}; }

glm::dvec3 normal_of(const Facets& facets, std::uint32_t plane) {
    const auto& p = facets.planes[plane];
    return {p[0], p[1], p[2]};
}

/// Turns by at most `most` degrees, those from a plane together.
std::vector<Turn> find_turns(const TriangleSurface& surface, const Facets& facets, double most) {
    std::vector<Turn> turns;
    // Equal angles count as sharp or smooth alike, whatever their rounding.
    const double limit = (most + 1e-6) * kDegree;
    for (std::size_t t = 0; t < facets.across.size(); ++t) {
        const std::uint32_t from = facets.of_triangle[t];
        if (from == Facets::kNone) continue;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t next = facets.across[t][k];
            if (next == Facets::kNone || facets.of_triangle[next] == Facets::kNone) continue;
            if (!surface.group.empty() && surface.group[t] != surface.group[next]) continue;
            Turn turn;
            turn.from = from;
            turn.to = facets.of_triangle[next];
            if (turn.from == turn.to) continue;
            const glm::dvec3 n = normal_of(facets, turn.from), m = normal_of(facets, turn.to);
            turn.angle = std::atan2(glm::length(glm::cross(n, m)), glm::dot(n, m));
            if (turn.angle > limit) continue;
            const glm::dvec3 a = to_vector(surface.points[surface.triangles[t][k]]);
            const glm::dvec3 b = to_vector(surface.points[surface.triangles[t][(k + 1) % 3]]);
            turn.middle = 0.5 * (a + b);
            // Counter-clockwise around `from`, the edge runs clockwise around `to`.
            const glm::dvec3 across = glm::cross(b - a, m);
            const double length = glm::length(across);
            if (!(length > 0)) continue;
            turn.onward = across / length;
            if (glm::dot(turn.onward, n) > 0) turn.angle = -turn.angle;
            turns.push_back(turn);
        }
    }
    std::stable_sort(turns.begin(), turns.end(),
                     [](const Turn& x, const Turn& y) { return x.from < y.from; });
    return turns;
}

class Turns {
  public:
    Turns(const TriangleSurface& surface, const Facets& facets, double most)
        : turns_(find_turns(surface, facets, most)), first_(facets.planes.size() + 1) {
        for (const Turn& turn : turns_) ++first_[turn.from + 1];
        for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    }

    const std::vector<Turn>& all() const { return turns_; }

    /// Whether the turn is one of three in a row.
    bool goes_on(const Turn& turn) const {
        const Turn back = opposite(turn);
        for (const Turn& next : after(turn)) {
            if (!follows(turn, next)) continue;
            for (const Turn& third : after(next)) {
                if (follows(next, third) && is_alike(turn, third) && third.to != turn.from) return true;
            }
            for (const Turn& before : after(back)) {
                if (follows(back, before) && before.to != next.to) return true;
            }
        }
        for (const Turn& before : after(back)) {
            if (!follows(back, before)) continue;
            for (const Turn& third : after(before)) {
                if (follows(before, third) && is_alike(turn, third) && third.to != turn.to) return true;
            }
        }
        return false;
    }

  private:
    struct Range {
        const Turn* first;
        const Turn* last;
        const Turn* begin() const { return first; }
        const Turn* end() const { return last; }
    };
    Range after(const Turn& turn) const {
        return {turns_.data() + first_[turn.to], turns_.data() + first_[turn.to + 1]};
    }

    /// The same edge from the other side.
    Turn opposite(const Turn& turn) const {
        for (const Turn& other : after(turn)) {
            if (other.to == turn.from && other.middle == turn.middle) return other;
        }
        return {turn.to, turn.from, turn.angle, turn.middle, glm::dvec3(0.0)};
    }

    static bool is_alike(const Turn& a, const Turn& b) {
        return a.angle * b.angle > 0 && std::fabs(a.angle) <= kAlike * std::fabs(b.angle) &&
               std::fabs(b.angle) <= kAlike * std::fabs(a.angle);
    }

    static bool follows(const Turn& turn, const Turn& next) {
        if (next.to == turn.from || !is_alike(turn, next)) return false;
        const glm::dvec3 way = next.middle - turn.middle;
        return glm::dot(way, turn.onward) > kStraightOn * glm::length(way);
    }

    std::vector<Turn> turns_;
    std::vector<std::size_t> first_;  ///< per plane, and behind the last
};

}  // namespace

void find_patches(const TriangleSurface& surface, double sharp_angle, Facets& facets) {
    DisjointSets sets(facets.planes.size());
    if (sharp_angle > 0) {
        std::vector<std::uint32_t> triangles(facets.planes.size());
        for (const std::uint32_t plane : facets.of_triangle) {
            if (plane != Facets::kNone) ++triangles[plane];
        }
        const Turns turns(surface, facets, sharp_angle);
        for (const Turn& turn : turns.all()) {
            if (turn.from > turn.to) continue;
            const bool is_smooth = std::fabs(turn.angle) <= (kAlwaysSmooth + 1e-6) * kDegree ||
                                   std::max(triangles[turn.from], triangles[turn.to]) <= kFacetTriangles ||
                                   turns.goes_on(turn);
            if (is_smooth) sets.join(turn.from, turn.to);
        }
    }
    facets.patch_of_plane.resize(sets.size());
    for (std::uint32_t i = 0; i < sets.size(); ++i) {
        const std::uint32_t first = sets.find(i);
        facets.patch_of_plane[i] =
            first == i ? static_cast<std::uint32_t>(facets.patches++) : facets.patch_of_plane[first];
    }
}

}  // namespace mortise::tape
