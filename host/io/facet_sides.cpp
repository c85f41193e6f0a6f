// Facets are filed by their lowest node; only faces of elements all of whose nodes are on facets are looked
// up.
#include "host/io/facet_sides.hpp"

#include <algorithm>
#include <array>
#include <string>

#include "host/common/parallel.hpp"
#include "mortise/error.hpp"

namespace mortise::io {
namespace {

constexpr std::size_t kChunk = 8192;
constexpr NodeId kNoNode = 0xffffffffu;
constexpr std::uint32_t kNoElement = 0xffffffffu;

/// Nodes of a face, ascending; of a triangle the last is kNoNode.
using SideKey = std::array<NodeId, 4>;

SideKey side_key(SideKey corners) {
    std::sort(corners.begin(), corners.end());
    return corners;
}

class FacetsByNode {
  public:
    explicit FacetsByNode(const Mesh& mesh) : mesh_(mesh), first_(mesh.node_count() + 1, 0) {
        const FacetBlock& facets = mesh.facets;
        on_facet_.assign(mesh.node_count(), 0);
        for (const NodeId node : facets.nodes) on_facet_[node] = 1;
        for (std::size_t f = 0; f < facets.size(); ++f) ++first_[corners(f)[0] + 1];
        for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
        list_.resize(facets.size());
        std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
        for (std::size_t f = 0; f < facets.size(); ++f)
            list_[next[corners(f)[0]]++] = static_cast<std::uint32_t>(f);
    }

    bool is_on_facet(NodeId node) const { return on_facet_[node] != 0; }

    /// Calls visit(facet) for those with these nodes and this region behind them.
    template <class Visit>
    void find(const SideKey& face, std::uint16_t region, const Visit& visit) const {
        for (std::uint32_t i = first_[face[0]]; i < first_[face[0] + 1]; ++i) {
            const std::uint32_t f = list_[i];
            if (mesh_.facets.inside[f] == region && corners(f) == face) visit(f);
        }
    }

  private:
    SideKey corners(std::size_t f) const {
        const FacetNodes nodes = mesh_.facets.facet(f);
        return side_key({nodes[0], nodes[1], nodes[2], nodes.size() == 4 ? nodes[3] : kNoNode});
    }

    const Mesh& mesh_;
    std::vector<std::uint8_t> on_facet_;
    std::vector<std::uint32_t> first_;  ///< by node: the facets of which it is the lowest; and the end
    std::vector<std::uint32_t> list_;
};

}  // namespace

std::vector<FacetSide> facet_sides(const Mesh& mesh, int threads) {
    const FacetsByNode facets(mesh);
    std::vector<FacetSide> sides(mesh.facets.size(), {kNoElement, 0, ElementType::kHexahedron});
    std::size_t first = 0;
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const auto type = static_cast<ElementType>(t);
        const ElementBlock& block = mesh.elements[t];
        const LocalFaces local = local_faces(type);
        const auto find_faces = [&](std::size_t i) {
            const NodeId* const node = block.nodes.data() + nodes_per(type) * i;
            for (int f = 0; f < local.count; ++f) {
                SideKey face{kNoNode, kNoNode, kNoNode, kNoNode};
                const std::size_t count = corner_count(local.faces[f]);
                bool may_be_facet = true;
                for (std::size_t k = 0; k < count && may_be_facet; ++k) {
                    face[k] = node[local.faces[f][k]];
                    may_be_facet = facets.is_on_facet(face[k]);
                }
                if (!may_be_facet) continue;
                facets.find(side_key(face), block.region[i], [&](std::uint32_t facet) {
                    sides[facet] = {static_cast<std::uint32_t>(first + i), static_cast<std::uint8_t>(f),
                                    type};
                });
            }
        };
        parallel_chunks(block.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) find_faces(i);
        });
        first += block.size();
    }
    for (std::size_t f = 0; f < sides.size(); ++f) {
        if (sides[f].element == kNoElement)
            throw Error(ExitCode::kMeshing, "invalid mesh: facet " + std::to_string(f) +
                                                " is no face of an element; see check_mesh");
    }
    return sides;
}

}  // namespace mortise::io
