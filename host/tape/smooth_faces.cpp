#include "host/tape/smooth_faces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <iterator>
#include <utility>
#include <vector>

#include "host/common/disjoint_sets.hpp"
#include "host/common/parting.hpp"
#include "host/common/sort_unique.hpp"
#include "host/tape/affine_map.hpp"

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

/// Two planes of a patch with an edge in common, the lower first.
using PlanePair = std::pair<std::uint32_t, std::uint32_t>;

double turn_between(const Facets& facets, std::uint32_t a, std::uint32_t b) {
    const glm::dvec3 n = normal_of(facets, a), m = normal_of(facets, b);
    return std::atan2(glm::length(glm::cross(n, m)), glm::dot(n, m));
}

/// Rings of planes that meet themselves at a crease, as the wall of a teardrop-shaped hole, must be parted:
/// the two sides of the crease are one patch otherwise, the other way around, and no sign would tell them
/// apart.
class Rings {
  public:
    Rings(const TriangleSurface& surface, const Facets& facets, DisjointSets& patches)
        : surface_(surface), facets_(facets), patches_(patches) {}

    /// The joints where they are parted, ascending. `smooth`: all smooth ones, ascending.
    std::vector<PlanePair> partings(const std::vector<PlanePair>& smooth) {
        std::vector<PlanePair> creases = pairs([&](std::uint32_t a, std::uint32_t b) {
            return turn_between(facets_, a, b) > kAlwaysSmooth * kDegree &&
                   !std::binary_search(smooth.begin(), smooth.end(), PlanePair{a, b});
        });
        if (creases.empty()) return {};
        find_neighbours(creases);
        std::vector<PlanePair> result;
        for (const PlanePair& crease : creases) {
            const std::vector<std::uint32_t> ring = ring_from(crease);
            if (ring.size() < 3) continue;
            std::vector<double> turns;
            for (std::size_t i = 0; i + 1 < ring.size(); ++i)
                turns.push_back(turn_between(facets_, ring[i], ring[i + 1]));
            const std::size_t at = best_parting(turns);
            result.push_back({std::min(ring[at - 1], ring[at]), std::max(ring[at - 1], ring[at])});
        }
        sort_unique(result);
        return result;
    }

  private:
    /// Those within a patch for which `holds`.
    template <class Holds>
    std::vector<PlanePair> pairs(const Holds& holds) {
        std::vector<PlanePair> result;
        for (std::size_t t = 0; t < facets_.across.size(); ++t) {
            for (const std::uint32_t next : facets_.across[t]) {
                if (next == Facets::kNone) continue;
                const std::uint32_t a = facets_.of_triangle[t], b = facets_.of_triangle[next];
                if (a == Facets::kNone || b == Facets::kNone || a >= b) continue;
                if (!surface_.group.empty() && surface_.group[t] != surface_.group[next]) continue;
                if (patches_.find(a) == patches_.find(b) && holds(a, b)) result.push_back({a, b});
            }
        }
        sort_unique(result);
        return result;
    }

    /// Of planes in patches with a crease, two at most: more are no ring.
    void find_neighbours(const std::vector<PlanePair>& creases) {
        std::vector<std::uint8_t> has_crease(patches_.size(), 0);
        for (const PlanePair& crease : creases) has_crease[patches_.find(crease.first)] = 1;
        count_.assign(patches_.size(), 0);
        beside_.resize(patches_.size());
        const auto add = [&](std::uint32_t to, std::uint32_t plane) {
            if (count_[to] < 2) beside_[to][count_[to]] = plane;
            ++count_[to];
        };
        for (const auto& [a, b] :
             pairs([&](std::uint32_t a, std::uint32_t) { return has_crease[patches_.find(a)] != 0; })) {
            add(a, b);
            add(b, a);
        }
    }

    /// From one side of a crease to the other; empty if that is no ring.
    std::vector<std::uint32_t> ring_from(const PlanePair& crease) const {
        std::vector<std::uint32_t> ring = {crease.second};
        std::uint32_t before = crease.first;
        while (ring.back() != crease.first) {
            const std::uint32_t at = ring.back();
            if (count_[at] != 2) return {};
            ring.push_back(beside_[at][0] == before ? beside_[at][1] : beside_[at][0]);
            before = at;
        }
        return count_[crease.first] == 2 ? ring : std::vector<std::uint32_t>{};
    }

    const TriangleSurface& surface_;
    const Facets& facets_;
    DisjointSets& patches_;
    std::vector<std::uint32_t> count_;  ///< of a plane's neighbours
    std::vector<std::array<std::uint32_t, 2>> beside_;
};

DisjointSets joined(std::size_t planes, const std::vector<PlanePair>& pairs) {
    DisjointSets sets(planes);
    for (const auto& [a, b] : pairs) sets.join(a, b);
    return sets;
}

}  // namespace

void find_patches(const TriangleSurface& surface, double sharp_angle, Facets& facets) {
    std::vector<PlanePair> smooth;
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
            if (is_smooth) smooth.push_back({turn.from, turn.to});
        }
        sort_unique(smooth);
    }
    DisjointSets sets = joined(facets.planes.size(), smooth);
    const std::vector<PlanePair> parted = Rings(surface, facets, sets).partings(smooth);
    if (!parted.empty()) {
        std::vector<PlanePair> rest;
        std::set_difference(smooth.begin(), smooth.end(), parted.begin(), parted.end(),
                            std::back_inserter(rest));
        sets = joined(facets.planes.size(), rest);
    }
    facets.patch_of_plane.resize(sets.size());
    for (std::uint32_t i = 0; i < sets.size(); ++i) {
        const std::uint32_t first = sets.find(i);
        facets.patch_of_plane[i] =
            first == i ? static_cast<std::uint32_t>(facets.patches++) : facets.patch_of_plane[first];
    }
}

}  // namespace mortise::tape
