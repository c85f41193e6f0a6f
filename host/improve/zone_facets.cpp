#include "host/improve/zone_facets.hpp"

#include <algorithm>
#include <tuple>

#include "host/common/large_array.hpp"
#include "host/common/parallel.hpp"
#include "host/common/parallel_sort.hpp"
#include "host/improve/places.hpp"

namespace mortise::improve {
namespace {

constexpr std::size_t kFacetChunk = 4096;
constexpr std::uint8_t kBothParts = 3;
constexpr std::uint8_t kWrongPart = 4;

struct TriangleKey {
    std::array<std::uint32_t, 3> node;  ///< ascending
    std::uint32_t facet;
    bool even;           ///< the facet's own order is an even permutation of `node`
    std::uint8_t parts;  ///< of the facet: one half, or both

    bool operator<(const TriangleKey& other) const {
        return std::tie(node, facet, parts) < std::tie(other.node, other.facet, other.parts);
    }
};

/// The triangles of facets all of whose nodes the zone has, in order; facets are numbered in `near_facets`.
std::vector<TriangleKey> list_triangles(const FacetBlock& facets, const ZoneNodes& place,
                                        const std::vector<std::uint32_t>& near_facets, int threads) {
    std::vector<TriangleKey> triangles;
    const auto add = [&](std::size_t i, const std::array<NodeId, 3>& node, std::uint8_t parts) {
        TriangleKey key{
            {place[node[0]], place[node[1]], place[node[2]]}, static_cast<std::uint32_t>(i), true, parts};
        key.even = sort_three(key.node);
        triangles.push_back(key);
    };
    for (std::size_t i = 0; i < near_facets.size(); ++i) {
        const NodeId* node = facets.nodes.data() + 4 * std::size_t{near_facets[i]};
        if (std::any_of(node, node + 4, [&](NodeId n) { return !place.has(n); })) continue;
        if (corner_count(node) == 3) {
            add(i, {node[0], node[1], node[2]}, kBothParts);
        } else {
            const auto half = halves(node);
            for (std::uint8_t k = 0; k < 2; ++k) add(i, half[k], static_cast<std::uint8_t>(1u << k));
        }
    }
    parallel_sort(triangles, threads);
    return triangles;
}

/// A face of a tetrahedron with the nodes of a triangle.
struct Hit {
    std::size_t triangle;  ///< the first with these nodes
    std::size_t face;      ///< 4 × tetrahedron + face
    bool even;
};

/// Ordered by triangle, then by face.
std::vector<Hit> find_hits(const Zone& zone, const std::vector<TriangleKey>& triangles, int threads) {
    std::vector<std::vector<Hit>> found(chunk_count(zone.tetrahedra.size(), kFacetChunk));
    const auto find = [&](std::size_t i, std::vector<Hit>& list) {
        const Tetrahedron& t = zone.tetrahedra[i];
        for (std::size_t f = 0; f < 4; ++f) {
            TriangleKey key{
                {t.node[kOpposite[f][0]], t.node[kOpposite[f][1]], t.node[kOpposite[f][2]]}, 0, true, 0};
            if (zone.stratum_size(key.node[0]) == 0 || zone.stratum_size(key.node[1]) == 0 ||
                zone.stratum_size(key.node[2]) == 0)
                continue;
            const bool even = sort_three(key.node);
            const auto first = std::lower_bound(triangles.begin(), triangles.end(), key);
            if (first == triangles.end() || first->node != key.node) continue;
            list.push_back({static_cast<std::size_t>(first - triangles.begin()), 4 * i + f, even});
        }
    };
    parallel_chunks(zone.tetrahedra.size(), kFacetChunk, threads,
                    [&](std::size_t begin, std::size_t end, int) {
                        for (std::size_t i = begin; i < end; ++i) find(i, found[begin / kFacetChunk]);
                    });
    std::vector<Hit> hits;
    append_lists(found, threads, hits);
    parallel_sort(hits, threads, [](const Hit& x, const Hit& y) {
        return x.triangle != y.triangle ? x.triangle < y.triangle : x.face < y.face;
    });
    return hits;
}

/// Which parts of facets are faces of tetrahedra, on which side.
struct Matches {
    struct Match {
        std::size_t face;  ///< as Hit::face
        std::uint32_t facet;
        bool inside;
    };
    std::vector<Match> list;
    /// By facet: the parts that were found from within and from outside, and those that two tetrahedra of one
    /// region share.
    std::vector<std::uint8_t> inside, outside, lost;

    explicit Matches(std::size_t facets) : inside(facets), outside(facets), lost(facets) {}

    /// Whether both sides have the whole facet, or nothing of it.
    bool are_whole(std::uint32_t facet) const {
        const auto is_whole = [&](int parts) { return parts == 0 || (parts | lost[facet]) == kBothParts; };
        return is_whole(inside[facet]) && is_whole(outside[facet]);
    }
};

Matches match(const std::vector<Hit>& hits, const std::vector<TriangleKey>& triangles,
              const FacetBlock& facets, const std::vector<std::uint32_t>& near_facets, const Zone& zone) {
    const auto region_at = [&](const Hit& hit) { return zone.tetrahedra[hit.face / 4].region; };
    Matches matches(near_facets.size());
    for (std::size_t i = 0; i < hits.size();) {
        std::size_t end = i + 1;
        while (end < hits.size() && hits[end].triangle == hits[i].triangle) ++end;
        // Two quadrilaterals with three nodes in common may fold onto each other when they are split:
        // that half of both is inside the solid now.
        const bool is_inside = end == i + 2 && region_at(hits[i]) == region_at(hits[i + 1]);
        for (std::size_t k = hits[i].triangle;
             k < triangles.size() && triangles[k].node == triangles[hits[i].triangle].node; ++k) {
            const TriangleKey& triangle = triangles[k];
            if (is_inside) {
                matches.lost[triangle.facet] |= triangle.parts;
                continue;
            }
            for (std::size_t h = i; h < end; ++h) {
                const bool inside = triangle.even == hits[h].even;
                const std::uint16_t region =
                    (inside ? facets.inside : facets.outside)[near_facets[triangle.facet]];
                std::uint8_t& parts = (inside ? matches.inside : matches.outside)[triangle.facet];
                parts |= region == region_at(hits[h]) ? triangle.parts : kWrongPart;
                matches.list.push_back({hits[h].face, triangle.facet, inside});
            }
        }
        i = end;
    }
    return matches;
}

}  // namespace

std::array<std::array<NodeId, 3>, 2> halves(const NodeId* node) {
    const auto low = static_cast<std::size_t>(std::min_element(node, node + 4) - node);
    return {{{node[low], node[(low + 1) % 4], node[(low + 2) % 4]},
             {node[low], node[(low + 2) % 4], node[(low + 3) % 4]}}};
}

std::vector<std::uint32_t> find_near_facets(const Mesh& mesh, const CellFrame& frame, const CellSet& cells,
                                            const ZoneNodes& place, int threads, Known& known) {
    const std::vector<NodeId>& nodes = mesh.facets.nodes;
    std::vector<Chunk>& chunks = known.facet_chunks.of(mesh.facets.size());
    std::vector<std::vector<std::uint32_t>> found(chunks.size());
    parallel_chunks(chunks.size(), 4, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t c = begin; c < end; ++c) {
            Chunk& chunk = chunks[c];
            // What shares a node with the zone is near it.
            const bool is_uniform = !cells.is_graded();
            if (is_uniform && chunk.is_known && !cells.any_is_near(chunk.low, chunk.high)) continue;
            chunk.start();
            for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
                const NodeId* const node = nodes.data() + 4 * i;
                if (known.gone.facet[i] != 0) continue;
                bool is_in_zone = false;
                for (std::size_t k = 0; k < 4; ++k) {
                    is_in_zone = is_in_zone || place.has(node[k]);
                    if (is_uniform) chunk.include(in_cells(mesh, frame, node[k]));
                }
                if (is_in_zone) found[c].push_back(static_cast<std::uint32_t>(i));
            }
        }
    });
    std::vector<std::uint32_t> facets;
    append_lists(found, threads, facets);
    return facets;
}

/// Facets whose triangles are faces of the zone's tetrahedra. Equal nodes are not enough: half of a
/// quadrilateral that stays whole may have the nodes of a face inside the solid.
void tag_faces(const Mesh& mesh, const ZoneNodes& place, const std::vector<std::uint32_t>& near_facets,
               const std::vector<std::uint8_t>* held, int threads, std::vector<std::uint8_t>& is_gone,
               Zone& zone) {
    const FacetBlock& facets = mesh.facets;
    const std::vector<TriangleKey> triangles = list_triangles(facets, place, near_facets, threads);
    const Matches matches = match(find_hits(zone, triangles, threads), triangles, facets, near_facets, zone);
    // Facets between the zone and the rest of the mesh stay in the mesh's own list.
    const auto take = [&](std::size_t facet) {
        zone.facets_taken.push_back(static_cast<std::uint32_t>(facet));
        is_gone[facet] = 1;
    };
    for (std::size_t i = 0; i < near_facets.size(); ++i) {
        if (matches.lost[i] == kBothParts) take(near_facets[i]);
    }
    for (const Matches::Match& m : matches.list) {
        if (!matches.are_whole(m.facet)) continue;
        const std::size_t facet = near_facets[m.facet];
        FaceTag tag = make_tag(facets.surface[facet]);
        if (facets.outside[facet] != 0) tag |= kTagInterface;
        if (m.inside) tag |= kTagInside;
        const bool stays = held != nullptr && (*held)[facets.surface[facet]] != 0;
        const bool is_between = matches.inside[m.facet] != 0 && matches.outside[m.facet] != 0;
        if (!stays && (facets.outside[facet] == 0 || is_between)) {
            take(facet);
        } else {
            tag |= kTagBorder;
        }
        zone.tetrahedra[m.face / 4].tag[m.face % 4] = tag;
    }
}

}  // namespace mortise::improve
