#include "host/probe/false_facets.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "host/common/constants.hpp"
#include "host/common/disjoint_sets.hpp"
#include "host/common/parallel.hpp"
#include "host/common/vec3.hpp"
#include "host/tape/local_tape.hpp"
#include "kernels/shared/surface.h"

namespace mortise::probe {
namespace {

/// Cells: how far the model is the same around a false place.
constexpr double kDeep = 0.12;
/// Cells: films and gaps are not thicker. What is deep without a film behind it is what chords cut off of
/// surfaces whose radius is half a cell: not pretty, but no hole is closed.
constexpr double kThickest = 1.5;
constexpr double kDepths[] = {0.5, 0.1};  ///< of a film, at which its walls are looked for
constexpr std::size_t kMostPlaces = 6;    ///< of a triangle that are looked at further
constexpr int kSamples = 12;              ///< of the model on a way
constexpr int kDirections = 16;           ///< in a film
constexpr double kBox = 0.5;              ///< cells, of the grid that holds the facets
constexpr double kWidest = 2;             ///< cells, from the middle of a film to its end
constexpr std::uint32_t kNoFacet = std::numeric_limits<std::uint32_t>::max();
/// Distance of the places that are looked at in a facet, at most.
constexpr double kSpacing = 0.18;
constexpr int kMostParts = 12;       ///< of a facet's edge
constexpr double kFarthest = 3;      ///< cells: chords are not measured beyond
constexpr double kStep = 1.0 / 16;   ///< of chords, in cells
constexpr std::size_t kChunk = 512;  ///< facets
constexpr std::size_t kPlaces = 64;
/// Deep places that are looked at further, evenly chosen: where nearly all is thinner than cells, whoever is
/// told of some needs smaller cells.
constexpr std::size_t kMostLooked = 20000;
constexpr double kAside = 0.01;  ///< cells, from a facet into its leaves

Vec3 unit(const Vec3& v) {
    const double length = std::sqrt(dot(v, v));
    return length > 0 ? scaled(v, 1 / length) : v;
}

/// The model's region at points of its root box.
class Regions {
  public:
    Regions(const tape::BoundModel& model, const octree::Octree& tree)
        : model_(model), tree_(tree), view_(tree.view()) {}

    Leaf leaf_at_point(const Vec3& x) const {
        const auto cells = static_cast<double>(std::uint64_t{1} << tree_.level);
        std::array<u32, 3> cell{};
        for (std::size_t j = 0; j < 3; ++j)
            cell[j] = static_cast<u32>(std::min(std::max(std::floor(x[j] * cells), 0.0), cells - 1));
        return leaf_at(&view_, morton_encode(cell[0], cell[1], cell[2]));
    }

    std::int32_t at(const Vec3& x) {
        const Leaf leaf = leaf_at_point(x);
        if (leaf.kind == kLeafNone) return 0;
        if (leaf.kind == kLeafIn) return octree::in_region(tree_, leaf.code);
        const TreeNode& node = tree_.nio[leaf.index];
        if (node.tape_length == 0) return octree::in_region(tree_, leaf.code);
        const Known& known = load(leaf.index, node);
        signs_.resize(known.surfaces.size());
        for (std::size_t s = 0; s < known.surfaces.size(); ++s) {
            const double value = surface_value(&model_.surfaces[known.surfaces[s]],
                                               model_.expression_ops.data(), x[0], x[1], x[2]);
            signs_[s] = value <= 0 ? std::int8_t{-1} : std::int8_t{1};
        }
        return known.tape.resolve(signs_.data());
    }

  private:
    /// Points come in the neighbourhood of facet after facet, so few leaves are asked again and again.
    struct Known {
        std::uint32_t leaf = std::numeric_limits<std::uint32_t>::max();
        std::vector<std::uint32_t> surfaces;
        tape::LocalTape tape;
    };
    const Known& load(std::uint32_t leaf, const TreeNode& node) {
        Known& known = known_[leaf % known_.size()];
        if (known.leaf == leaf) return known;
        const std::uint32_t* words = tree_.tapes.data() + node.tape_offset;
        tape::list_surfaces(words, node.tape_length, known.surfaces);
        known.tape.load(words, node.tape_length, known.surfaces);
        known.leaf = leaf;
        return known;
    }

    const tape::BoundModel& model_;
    const octree::Octree& tree_;
    const Tree view_;
    std::array<Known, 64> known_;
    std::vector<std::int8_t> signs_;
};

/// A place of a facet where the model has no boundary.
struct Place {
    Vec3 at;
    Vec3 normal;  ///< of the facet, to its outside
    double edge;  ///< of the leaf
    std::int32_t region;
    std::uint32_t facet;
};

using Triangle = std::array<Vec3, 3>;

/// The facets of a mesh as triangles in the root box.
class Skin {
  public:
    Skin(const tape::BoundModel& model, const std::vector<double>& points, const FacetBlock& facets)
        : model_(model), points_(points), facets_(facets) {}

    /// Triangle 0 or 1 of a facet; 1: of quadrilaterals only.
    Triangle triangle(std::uint32_t facet, std::size_t part) const {
        const NodeId* node = facets_.nodes.data() + 4 * std::size_t{facet};
        return {corner(node[0]), corner(node[1 + part]), corner(node[2 + part])};
    }
    std::size_t triangles(std::uint32_t facet) const {
        const NodeId* node = facets_.nodes.data() + 4 * std::size_t{facet};
        return node[3] != node[2] ? 2 : 1;
    }
    Vec3 middle(std::uint32_t facet) const {
        const Triangle t = triangle(facet, triangles(facet) - 1);
        return scaled(sum(sum(t[0], t[1]), t[2]), 1.0 / 3);
    }
    Vec3 normal(std::uint32_t facet) const {
        const Triangle t = triangle(facet, 0);
        return unit(cross(difference(t[1], t[0]), difference(t[2], t[0])));
    }
    std::uint16_t inside(std::uint32_t facet) const { return facets_.inside[facet]; }
    std::uint16_t outside(std::uint32_t facet) const { return facets_.outside[facet]; }
    std::uint32_t size() const { return static_cast<std::uint32_t>(facets_.size()); }

  private:
    Vec3 corner(NodeId node) const {
        Vec3 x{};
        for (std::size_t j = 0; j < 3; ++j)
            x[j] = (points_[3 * std::size_t{node} + j] - model_.origin[j]) / model_.side;
        return x;
    }

    const tape::BoundModel& model_;
    const std::vector<double>& points_;
    const FacetBlock& facets_;
};

/// Finds the facet that a ray hits first, by a grid of boxes that holds each facet in all that it may pass.
class Rays {
  public:
    /// `cell`: the largest at the starts of rays, of which none is longer than kWidest.
    Rays(const Skin& skin, double cell, const std::vector<Place>& starts) : skin_(skin), box_(kBox * cell) {
        const double near_box = kWidest * cell;  // rays, and facets that they hit, reach the next at most
        std::vector<Key> near;
        for (const Place& place : starts) near.push_back(key_of(place.at, near_box));
        make_unique(near);
        for (std::size_t i = near.size(); i-- > 0;) {
            const Key own = near[i];
            for (int k = 0; k < 27; ++k)
                near.push_back({own[0] + k % 3 - 1, own[1] + k / 3 % 3 - 1, own[2] + k / 9 - 1});
        }
        make_unique(near);
        for (std::uint32_t f = 0; f < skin.size(); ++f) {
            if (std::binary_search(near.begin(), near.end(), key_of(skin.middle(f), near_box))) list(f);
        }
        std::sort(listed_.begin(), listed_.end());
    }

    /// Distance to the first facet behind x, or `reach` if there is none before.
    double first_hit(const Vec3& x, const Vec3& direction, double reach, std::uint32_t own) const {
        // From box to box (Amanatides & Woo 1987).
        Key key = key_of(x, box_);
        Key step{};
        std::array<double, 3> next{};
        std::array<double, 3> stride{};
        for (std::size_t j = 0; j < 3; ++j) {
            const bool up = direction[j] > 0;
            step[j] = up ? 1 : -1;
            if (direction[j] == 0) {
                next[j] = stride[j] = std::numeric_limits<double>::max();
                continue;
            }
            stride[j] = box_ / std::fabs(direction[j]);
            next[j] = ((key[j] + (up ? 1 : 0)) * box_ - x[j]) / direction[j];
        }
        double first = reach;
        for (double entered = 0; entered < first;) {
            auto at = std::lower_bound(listed_.begin(), listed_.end(), std::make_pair(key, 0u));
            for (; at != listed_.end() && at->first == key; ++at) {
                if (at->second == own) continue;
                for (std::size_t part = 0; part < skin_.triangles(at->second); ++part)
                    first = std::min(first, hit(skin_.triangle(at->second, part), x, direction, first));
            }
            const std::size_t axis = next[0] <= next[1]   ? (next[0] <= next[2] ? 0 : 2)
                                     : next[1] <= next[2] ? 1
                                                          : 2;
            entered = next[axis];
            next[axis] += stride[axis];
            key[axis] += step[axis];
        }
        return first;
    }

  private:
    using Key = std::array<std::int32_t, 3>;

    static Key key_of(const Vec3& x, double box) {
        Key key{};
        for (std::size_t j = 0; j < 3; ++j) key[j] = static_cast<std::int32_t>(std::floor(x[j] / box));
        return key;
    }

    static void make_unique(std::vector<Key>& keys) {
        std::sort(keys.begin(), keys.end());
        keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    }

    /// In all boxes that the facet's bounds touch.
    void list(std::uint32_t facet) {
        Vec3 low = skin_.triangle(facet, 0)[0];
        Vec3 high = low;
        for (std::size_t part = 0; part < skin_.triangles(facet); ++part) {
            for (const Vec3& corner : skin_.triangle(facet, part)) {
                for (std::size_t j = 0; j < 3; ++j) {
                    low[j] = std::min(low[j], corner[j]);
                    high[j] = std::max(high[j], corner[j]);
                }
            }
        }
        const Key first = key_of(low, box_);
        const Key last = key_of(high, box_);
        for (std::int32_t i = first[0]; i <= last[0]; ++i) {
            for (std::int32_t j = first[1]; j <= last[1]; ++j) {
                for (std::int32_t k = first[2]; k <= last[2]; ++k) listed_.push_back({{i, j, k}, facet});
            }
        }
    }

    /// Distance along the ray to a triangle (Möller & Trumbore 1997), or `most` if it is missed.
    static double hit(const Triangle& t, const Vec3& x, const Vec3& direction, double most) {
        const Vec3 a = difference(t[1], t[0]);
        const Vec3 b = difference(t[2], t[0]);
        const Vec3 p = cross(direction, b);
        const double determinant = dot(a, p);
        if (determinant == 0) return most;
        const Vec3 from = difference(x, t[0]);
        const double u = dot(from, p) / determinant;
        const Vec3 q = cross(from, a);
        const double v = dot(direction, q) / determinant;
        const double at = dot(b, q) / determinant;
        return u >= 0 && v >= 0 && u + v <= 1 && at > 0 && at < most ? at : most;
    }

    const Skin& skin_;
    const double box_;
    std::vector<std::pair<Key, std::uint32_t>> listed_;
};

/// The same region at x and around it, along a facet's normal first, where a true one has two.
bool is_alike_around(Regions& regions, const Vec3& x, const Vec3& normal, double distance) {
    const std::int32_t region = regions.at(sum(x, scaled(normal, distance)));
    if (regions.at(sum(x, scaled(normal, -distance))) != region || regions.at(x) != region) return false;
    for (int k = 0; k < 27; ++k) {
        const Vec3 d = {k % 3 - 1.0, k / 3 % 3 - 1.0, k / 9 - 1.0};
        const double length = std::sqrt(dot(d, d));
        if (length != 1 && length < 1.7) continue;  // axes and diagonals
        if (regions.at(sum(x, scaled(d, distance / length))) != region) return false;
    }
    return true;
}

/// Whether the model has no boundary on the way from x, up to a distance.
bool is_alike_along(Regions& regions, const Vec3& x, const Vec3& direction, double distance,
                    std::int32_t region) {
    for (int k = 1; k <= kSamples; ++k) {
        if (regions.at(sum(x, scaled(direction, distance * k / (kSamples + 1)))) != region) return false;
    }
    return true;
}

/// Whether a film goes on to the model's boundary, in all directions across the normal.
bool reaches_walls(Regions& regions, const Rays& rays, const Place& place, const Vec3& from) {
    // The axis that is least along the normal spans the film with it.
    std::size_t least = 0;
    for (std::size_t j = 1; j < 3; ++j) {
        if (std::fabs(place.normal[j]) < std::fabs(place.normal[least])) least = j;
    }
    Vec3 axis{};
    axis[least] = 1;
    const Vec3 u = unit(cross(place.normal, axis));
    const Vec3 v = cross(place.normal, u);
    for (int k = 0; k < kDirections; ++k) {
        const double turn = 2 * kPi * k / kDirections;
        const Vec3 along = sum(scaled(u, std::cos(turn)), scaled(v, std::sin(turn)));
        const double end = rays.first_hit(from, along, kWidest * place.edge, kNoFacet);
        if (is_alike_along(regions, from, along, end, place.region)) return false;
    }
    return true;
}

/// Whether behind a place lies a film of what the mesh alone has, and closes the way. Where it leaves a way,
/// a narrow bar is pinched, or a hole has a shelf; that is how cells of their size show them.
bool has_film(Regions& regions, const Skin& skin, const Rays& rays, const Place& place) {
    const bool is_outside = place.region == skin.outside(place.facet);
    if (!is_outside && place.region != skin.inside(place.facet)) return false;
    const Vec3 direction = scaled(place.normal, is_outside ? -1 : 1);
    const double reach = kThickest * place.edge;
    const double thickness = rays.first_hit(place.at, direction, reach, place.facet);
    if (thickness >= reach || !is_alike_along(regions, place.at, direction, thickness, place.region))
        return false;
    // Its other side may be a wedge.
    return std::any_of(std::begin(kDepths), std::end(kDepths), [&](double depth) {
        return reaches_walls(regions, rays, place, sum(place.at, scaled(direction, depth * thickness)));
    });
}

/// Appends places deep in the model, or outside of it, inside a triangle, away from its edges: other facets
/// may meet there at any angle.
void find_deep_places(Regions& regions, const Triangle& p, double edge, std::uint32_t facet,
                      std::vector<Place>& found) {
    const Vec3 across = cross(difference(p[1], p[0]), difference(p[2], p[0]));
    if (!(dot(across, across) > 0)) return;
    const Vec3 normal = unit(across);
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 side = difference(p[(k + 1) % 3], p[k]);
        longest = std::max(longest, std::sqrt(dot(side, side)));
    }
    const std::size_t before = found.size();
    const int parts = std::min(kMostParts, 3 + static_cast<int>(longest / (kSpacing * edge)));
    for (int i = 1; i < parts; ++i) {
        for (int j = 1; i + j < parts; ++j) {
            const double a = static_cast<double>(i) / parts;
            const double b = static_cast<double>(j) / parts;
            const Vec3 x = sum(scaled(p[0], 1 - a - b), sum(scaled(p[1], a), scaled(p[2], b)));
            if (is_alike_around(regions, x, normal, kDeep * edge))
                found.push_back({x, normal, edge, regions.at(x), facet});
        }
    }
    // Where struts are thinner than cells most places are deep, and films are wider than their distance.
    const std::size_t count = found.size() - before;
    if (count <= kMostPlaces) return;
    for (std::size_t i = 0; i < kMostPlaces; ++i)
        found[before + i] = found[before + (i + 1) * count / (kMostPlaces + 1)];
    found.resize(before + kMostPlaces);
}

/// Length of what holds x along a direction, both ways.
double chord(Regions& regions, const Place& place, const Vec3& direction) {
    double length = 0;
    for (const double side : {-1.0, 1.0}) {
        double reach = 0;
        while (reach < kFarthest * place.edge &&
               regions.at(sum(place.at, scaled(direction, side * (reach + kStep * place.edge)))) ==
                   place.region)
            reach += kStep * place.edge;
        length += reach;
    }
    return length;
}

MissedFeature describe(const tape::BoundModel& model, Regions& regions, const Place& place) {
    MissedFeature feature;
    feature.thickness = std::numeric_limits<double>::max();
    for (int k = 14; k < 27; ++k) {
        const Vec3 d = {k % 3 - 1.0, k / 3 % 3 - 1.0, k / 9 - 1.0};
        const double length = chord(regions, place, unit(d));
        feature.thickness = std::min(feature.thickness, model.side * length);
        feature.size = std::max(feature.size, model.side * length);
    }
    for (std::size_t j = 0; j < 3; ++j) feature.position[j] = model.origin[j] + model.side * place.at[j];
    feature.material = place.region != 0;
    return feature;
}

bool touch(const Place& a, const Place& b) {
    const double reach = std::max(a.edge, b.edge);
    return std::fabs(a.at[0] - b.at[0]) <= reach && std::fabs(a.at[1] - b.at[1]) <= reach &&
           std::fabs(a.at[2] - b.at[2]) <= reach;
}

}  // namespace

std::vector<MissedFeature> find_false_facets(const tape::BoundModel& model, const octree::Octree& tree,
                                             const std::vector<std::uint64_t>& folded,
                                             const std::vector<double>& points, const FacetBlock& facets,
                                             int threads) {
    std::vector<MissedFeature> result;
    if (folded.empty()) return result;
    const Skin skin(model, points, facets);
    const auto is_folded = [&folded](std::uint64_t code) {
        return std::binary_search(folded.begin(), folded.end(), code);
    };
    std::vector<std::vector<Place>> found(chunk_count(facets.size(), kChunk));
    parallel_chunks(facets.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        Regions regions(model, tree);
        for (auto f = static_cast<std::uint32_t>(begin); f < end; ++f) {
            // A facet may lie between two leaves.
            const Vec3 aside = scaled(skin.normal(f), kAside * tree.finest_edge());
            Leaf leaf = regions.leaf_at_point(sum(skin.middle(f), aside));
            if (!is_folded(leaf.code)) leaf = regions.leaf_at_point(difference(skin.middle(f), aside));
            if (!is_folded(leaf.code) || tree.is_crowded(leaf.code)) continue;
            for (std::size_t part = 0; part < skin.triangles(f); ++part)
                find_deep_places(regions, skin.triangle(f, part), octree::Octree::edge_of(leaf.level), f,
                                 found[begin / kChunk]);
        }
    });
    std::vector<Place> deep;
    for (const std::vector<Place>& part : found) deep.insert(deep.end(), part.begin(), part.end());
    if (deep.empty()) return result;
    if (deep.size() > kMostLooked) {
        const std::size_t stride = deep.size() / kMostLooked + 1;
        for (std::size_t i = 0; i * stride < deep.size(); ++i) deep[i] = deep[i * stride];
        deep.resize((deep.size() + stride - 1) / stride);
    }
    double widest = 0;
    for (const Place& place : deep) widest = std::max(widest, place.edge);
    const Rays rays(skin, widest, deep);
    std::vector<std::uint8_t> is_film(deep.size());
    parallel_chunks(deep.size(), kPlaces, threads, [&](std::size_t begin, std::size_t end, int) {
        Regions regions(model, tree);
        for (std::size_t i = begin; i < end; ++i) is_film[i] = has_film(regions, skin, rays, deep[i]) ? 1 : 0;
    });
    std::vector<Place> places;
    for (std::size_t i = 0; i < deep.size(); ++i) {
        if (is_film[i] != 0 && (places.empty() || places.back().facet != deep[i].facet))
            places.push_back(deep[i]);
    }
    Regions regions(model, tree);
    DisjointSets sets(places.size());
    std::vector<std::uint32_t> order(places.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&places](std::uint32_t a, std::uint32_t b) {
        return places[a].at[0] != places[b].at[0] ? places[a].at[0] < places[b].at[0] : a < b;
    });
    for (std::size_t i = 0; i < order.size(); ++i) {
        const Place& place = places[order[i]];
        for (std::size_t k = i; k-- > 0 && place.at[0] - places[order[k]].at[0] <= widest;) {
            const Place& other = places[order[k]];
            if (other.region == place.region && touch(place, other)) sets.join(order[k], order[i]);
        }
    }
    std::vector<std::uint8_t> told(places.size());
    for (std::uint32_t i = 0; i < places.size(); ++i) {
        const std::uint32_t set = sets.find(i);
        if (told[set] != 0) continue;
        told[set] = 1;
        result.push_back(describe(model, regions, places[i]));
    }
    return result;
}

}  // namespace mortise::probe
