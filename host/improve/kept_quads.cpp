#include "host/improve/kept_quads.hpp"

#include <algorithm>

#include "host/common/large_array.hpp"
#include "host/common/parallel_sort.hpp"

namespace mortise::improve {
namespace {

constexpr std::size_t kQuadChunk = 4096;

QuadKey quad_key(const NodeId* node) {
    QuadKey key = {node[0], node[1], node[2], node[3]};
    std::sort(key.begin(), key.end());
    return key;
}

struct QuadUse {
    QuadKey key;
    std::uint32_t face;  ///< 8 × (element of the zone's list) + local face

    bool operator<(const QuadUse& other) const {
        // Most differ in the first node, and comparing all four is a call.
        if (key[0] != other.key[0]) return key[0] < other.key[0];
        return key != other.key ? key < other.key : face < other.face;
    }
};

}  // namespace

std::vector<QuadKey> outer_quads(const Mesh& mesh, const CellFrame& frame, const CellSet& cells, int threads,
                                 Known& known) {
    const FacetBlock& facets = mesh.facets;
    const std::vector<Chunk>& chunks = known.facet_chunks.of(facets.size());
    std::vector<std::vector<QuadKey>> found(chunks.size());
    parallel_chunks(chunks.size(), 4, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t c = begin; c < end; ++c) {
            const Chunk& chunk = chunks[c];
            if (!cells.is_graded() && chunk.is_known && !cells.any_is_near(chunk.low, chunk.high)) continue;
            for (std::size_t i = chunk.begin; i < chunk.end; ++i) {
                const NodeId* node = facets.nodes.data() + 4 * i;
                if (known.gone.facet[i] != 0 || corner_count(node) == 3 || facets.outside[i] != 0) continue;
                if (cells.is_graded() || cells.is_near(in_cells(mesh, frame, *node)))
                    found[c].push_back(quad_key(node));
            }
        }
    });
    std::vector<QuadKey> quads;
    append_lists(found, threads, quads);
    parallel_sort(quads, threads);
    return quads;
}

std::vector<QuadKey> held_quads(const Mesh& mesh, const std::vector<std::uint8_t>* held) {
    const FacetBlock& facets = mesh.facets;
    std::vector<QuadKey> quads;
    for (std::size_t i = 0; i < facets.size() && held != nullptr; ++i) {
        const NodeId* node = facets.nodes.data() + 4 * i;
        if (corner_count(node) == 4 && (*held)[facets.surface[i]] != 0) quads.push_back(quad_key(node));
    }
    std::sort(quads.begin(), quads.end());
    return quads;
}

void mark_kept_quads(const Mesh& mesh, const std::vector<QuadKey>& outer, const std::vector<QuadKey>& held,
                     int threads, std::vector<ElementRef>& elements) {
    const auto list_quads = [&](std::size_t i, std::vector<QuadUse>& list) {
        elements[i].kept = 0;
        if (elements[i].type == static_cast<std::uint8_t>(ElementType::kTetrahedron)) return;
        const Element e = element(mesh, elements[i].type, elements[i].index);
        const LocalFaces faces = local_faces(e.type);
        for (int f = 0; f < faces.count; ++f) {
            const LocalFace& face = faces.faces[f];
            if (face[3] < 0) continue;
            NodeId node[4];
            for (std::size_t k = 0; k < 4; ++k) node[k] = e.node[face[k]];
            list.push_back(
                {quad_key(node), static_cast<std::uint32_t>(8 * i) + static_cast<std::uint32_t>(f)});
        }
    };
    std::vector<std::vector<QuadUse>> found(chunk_count(elements.size(), kQuadChunk));
    parallel_chunks(elements.size(), kQuadChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) list_quads(i, found[begin / kQuadChunk]);
    });
    std::vector<QuadUse> uses;
    append_lists(found, threads, uses);
    parallel_sort(uses, threads);
    for (std::size_t i = 0; i < uses.size();) {
        std::size_t end = i + 1;
        while (end < uses.size() && uses[end].key == uses[i].key) ++end;
        const auto is_in = [&](const std::vector<QuadKey>& list) {
            return std::binary_search(list.begin(), list.end(), uses[i].key);
        };
        const bool kept = is_in(held) || (end == i + 1 && !is_in(outer));
        for (std::size_t k = i; k < end && kept; ++k)
            elements[uses[k].face / 8].kept |= static_cast<std::uint8_t>(1u << (uses[k].face % 8));
        i = end;
    }
}

}  // namespace mortise::improve
