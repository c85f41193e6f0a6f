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
#include "host/probe/regions.hpp"
#include "host/probe/skin.hpp"

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
constexpr double kWidest = 2;             ///< cells, from the middle of a film to its end
constexpr double kSpacing = 0.18;         ///< cells, of the places in a facet, at most
constexpr int kMostParts = 12;            ///< of a facet's edge
constexpr double kFarthest = 3;           ///< cells: chords are not measured beyond
constexpr double kStep = 1.0 / 16;        ///< of chords, in cells
constexpr std::size_t kFacetChunk = 512;  ///< facets
constexpr std::size_t kPlaces = 64;
/// Deep places that are looked at further, evenly chosen: where nearly all is thinner than cells, whoever is
/// told of some needs smaller cells.
constexpr std::size_t kMostLooked = 20000;
constexpr double kAside = 0.01;  ///< cells, from a facet into its leaves

/// A place of a facet where the model has no boundary.
struct DeepPlace {
    Vec3 at;
    Vec3 normal;  ///< of the facet, to its outside
    double edge;  ///< of the leaf
    std::int32_t region;
    std::uint32_t facet;
    Vec3 film{};  ///< a place in the film behind it, once that is found
};

/// Whether this is the region at x and around it.
bool is_alike_around(Regions& regions, const Vec3& x, std::int32_t region, double distance) {
    if (regions.at(x) != region) return false;
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
bool reaches_walls(Regions& regions, const Rays& rays, const DeepPlace& place, const Vec3& from) {
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
        const double end = rays.first_hit(from, along, kWidest * place.edge, Rays::kNoFacet);
        if (is_alike_along(regions, from, along, end, place.region)) return false;
    }
    return true;
}

/// Whether behind a place lies a film of what the mesh alone has, and closes the way. Where it leaves a way,
/// a narrow bar is pinched, or a hole has a shelf; that is how cells of their size show them.
bool find_film(Regions& regions, const Skin& skin, const Rays& rays, DeepPlace& place) {
    const bool is_outside = place.region == skin.outside(place.facet);
    if (!is_outside && place.region != skin.inside(place.facet)) return false;
    const Vec3 direction = scaled(place.normal, is_outside ? -1 : 1);
    const double reach = kThickest * place.edge;
    const double thickness = rays.first_hit(place.at, direction, reach, place.facet);
    if (thickness >= reach || !is_alike_along(regions, place.at, direction, thickness, place.region))
        return false;
    // Its other side may be a wedge.
    return std::any_of(std::begin(kDepths), std::end(kDepths), [&](double depth) {
        place.film = sum(place.at, scaled(direction, depth * thickness));
        return reaches_walls(regions, rays, place, place.film);
    });
}

/// Appends places deep in the model, or outside of it, inside a triangle, away from its edges: other facets
/// may meet there at any angle.
void find_deep_places(Regions& regions, const Triangle& p, double edge, std::uint32_t facet,
                      std::vector<DeepPlace>& found) {
    const Vec3 across = cross(difference(p[1], p[0]), difference(p[2], p[0]));
    if (!(dot(across, across) > 0)) return;
    const Vec3 normal = unit(across);
    double longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 side = difference(p[(k + 1) % 3], p[k]);
        longest = std::max(longest, length(side));
    }
    const std::size_t before = found.size();
    const int parts = std::min(kMostParts, 3 + static_cast<int>(longest / (kSpacing * edge)));
    const double distance = kDeep * edge;
    std::vector<Vec3> places;
    std::vector<Vec3> beside;
    for (int i = 1; i < parts; ++i) {
        for (int j = 1; i + j < parts; ++j) {
            const double a = static_cast<double>(i) / parts;
            const double b = static_cast<double>(j) / parts;
            const Vec3 x = sum(scaled(p[0], 1 - a - b), sum(scaled(p[1], a), scaled(p[2], b)));
            places.push_back(x);
            beside.push_back(sum(x, scaled(normal, distance)));
            beside.push_back(sum(x, scaled(normal, -distance)));
        }
    }
    // Along its normal a true facet has two regions.
    std::vector<std::int32_t> region;
    regions.at(beside, region);
    for (std::size_t k = 0; k < places.size(); ++k) {
        if (region[2 * k] == region[2 * k + 1] &&
            is_alike_around(regions, places[k], region[2 * k], distance))
            found.push_back({places[k], normal, edge, region[2 * k], facet});
    }
    // Where struts are thinner than cells most places are deep, and films are wider than their distance.
    const std::size_t count = found.size() - before;
    if (count <= kMostPlaces) return;
    for (std::size_t i = 0; i < kMostPlaces; ++i)
        found[before + i] = found[before + (i + 1) * count / (kMostPlaces + 1)];
    found.resize(before + kMostPlaces);
}

/// Length of the region of a film along a direction, both ways from the film.
double chord(Regions& regions, const DeepPlace& place, const Vec3& direction) {
    double length = 0;
    for (const double side : {-1.0, 1.0}) {
        double reach = 0;
        while (reach < kFarthest * place.edge &&
               regions.at(sum(place.film, scaled(direction, side * (reach + kStep * place.edge)))) ==
                   place.region)
            reach += kStep * place.edge;
        length += reach;
    }
    return length;
}

MissedFeature describe_false(const tape::BoundModel& model, Regions& regions, const DeepPlace& place) {
    MissedFeature feature;
    feature.thickness = std::numeric_limits<double>::max();
    for (int k = 14; k < 27; ++k) {
        const Vec3 d = {k % 3 - 1.0, k / 3 % 3 - 1.0, k / 9 - 1.0};
        const double length = chord(regions, place, unit(d));
        feature.thickness = std::min(feature.thickness, model.side * length);
        feature.size = std::max(feature.size, model.side * length);
    }
    for (std::size_t j = 0; j < 3; ++j) feature.position[j] = model.origin[j] + model.side * place.film[j];
    feature.material = place.region != 0;
    return feature;
}

bool are_close(const DeepPlace& a, const DeepPlace& b) {
    const double reach = std::max(a.edge, b.edge);
    return std::fabs(a.at[0] - b.at[0]) <= reach && std::fabs(a.at[1] - b.at[1]) <= reach &&
           std::fabs(a.at[2] - b.at[2]) <= reach;
}

/// Places deep in the model, or outside of it, in the facets of these leaves, by facet.
std::vector<DeepPlace> find_all_deep(const tape::BoundModel& model, const octree::Octree& tree,
                                     const std::vector<std::uint64_t>& folded, const Skin& skin,
                                     int threads) {
    const auto is_folded = [&folded](std::uint64_t code) {
        return std::binary_search(folded.begin(), folded.end(), code);
    };
    std::vector<std::vector<DeepPlace>> found(chunk_count(skin.size(), kFacetChunk));
    parallel_chunks(skin.size(), kFacetChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        Regions regions(model, tree);
        for (auto f = static_cast<std::uint32_t>(begin); f < end; ++f) {
            // A facet may lie between two leaves.
            const Vec3 aside = scaled(skin.normal(f), kAside * tree.finest_edge());
            Leaf leaf = regions.leaf_at_point(sum(skin.middle(f), aside));
            if (!is_folded(leaf.code)) leaf = regions.leaf_at_point(difference(skin.middle(f), aside));
            if (!is_folded(leaf.code) || tree.is_crowded(leaf.code)) continue;
            for (std::size_t part = 0; part < skin.triangles(f); ++part)
                find_deep_places(regions, skin.triangle(f, part), octree::Octree::edge_of(leaf.level), f,
                                 found[begin / kFacetChunk]);
        }
    });
    std::vector<DeepPlace> deep;
    for (const std::vector<DeepPlace>& part : found) deep.insert(deep.end(), part.begin(), part.end());
    if (deep.size() <= kMostLooked) return deep;
    const std::size_t stride = deep.size() / kMostLooked + 1;
    std::vector<DeepPlace> some;
    for (std::size_t i = 0; i < deep.size(); i += stride) some.push_back(deep[i]);
    return some;
}

double widest_cell(const std::vector<DeepPlace>& places) {
    double widest = 0;
    for (const DeepPlace& place : places) widest = std::max(widest, place.edge);
    return widest;
}

/// Of these, those with a film behind them, one for each facet.
std::vector<DeepPlace> with_films(const tape::BoundModel& model, const octree::Octree& tree, const Skin& skin,
                                  std::vector<DeepPlace> deep, int threads) {
    std::vector<Vec3> starts;
    for (const DeepPlace& place : deep) starts.push_back(place.at);
    const Rays rays(skin, starts, kWidest * widest_cell(deep));
    std::vector<std::uint8_t> is_film(deep.size());
    parallel_chunks(deep.size(), kPlaces, threads, [&](std::size_t begin, std::size_t end, int) {
        Regions regions(model, tree);
        for (std::size_t i = begin; i < end; ++i)
            is_film[i] = find_film(regions, skin, rays, deep[i]) ? 1 : 0;
    });
    std::vector<DeepPlace> films;
    for (std::size_t i = 0; i < deep.size(); ++i) {
        if (is_film[i] != 0 && (films.empty() || films.back().facet != deep[i].facet))
            films.push_back(deep[i]);
    }
    return films;
}

/// The first of those that lie within a cell of each other, in the same region.
std::vector<DeepPlace> first_of_each(const std::vector<DeepPlace>& places) {
    DisjointSets sets(places.size());
    std::vector<std::uint32_t> order(places.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&places](std::uint32_t a, std::uint32_t b) {
        return places[a].at[0] != places[b].at[0] ? places[a].at[0] < places[b].at[0] : a < b;
    });
    const double widest = widest_cell(places);
    for (std::size_t i = 0; i < order.size(); ++i) {
        const DeepPlace& place = places[order[i]];
        for (std::size_t k = i; k-- > 0 && place.at[0] - places[order[k]].at[0] <= widest;) {
            const DeepPlace& other = places[order[k]];
            if (other.region == place.region && are_close(place, other)) sets.join(order[k], order[i]);
        }
    }
    std::vector<DeepPlace> first;
    for (std::uint32_t i = 0; i < places.size(); ++i) {
        if (sets.is_first(i)) first.push_back(places[i]);
    }
    return first;
}

}  // namespace

std::vector<MissedFeature> find_false_facets(const tape::BoundModel& model, const octree::Octree& tree,
                                             const std::vector<std::uint64_t>& folded,
                                             const std::vector<double>& points, const FacetBlock& facets,
                                             int threads) {
    if (folded.empty()) return {};
    const Skin skin(model, points, facets);
    std::vector<DeepPlace> deep = find_all_deep(model, tree, folded, skin, threads);
    if (deep.empty()) return {};
    Regions regions(model, tree);
    std::vector<MissedFeature> result;
    for (const DeepPlace& place : first_of_each(with_films(model, tree, skin, std::move(deep), threads)))
        result.push_back(describe_false(model, regions, place));
    return result;
}

}  // namespace mortise::probe
