// Facets are filed by their lowest node; only faces of elements all of whose nodes are on facets are looked
// up.
#include "host/io/facet_sides.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <string>

#include "host/common/face_key.hpp"
#include "host/common/parallel.hpp"
#include "mortise/error.hpp"

namespace mortise::io {
namespace {

constexpr std::size_t kChunk = 8192;
constexpr std::uint64_t kMostFaces = 8;  ///< of an element, and more
constexpr std::uint64_t kNoSide = ~std::uint64_t{0};

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
    void find(const FaceKey& face, std::uint16_t region, const Visit& visit) const {
        for (std::uint32_t i = first_[face[0]]; i < first_[face[0] + 1]; ++i) {
            const std::uint32_t f = list_[i];
            if (mesh_.facets.inside[f] == region && corners(f) == face) visit(f);
        }
    }

  private:
    FaceKey corners(std::size_t f) const {
        const FacetNodes nodes = mesh_.facets.facet(f);
        return face_key(nodes.begin(), nodes.size());
    }

    const Mesh& mesh_;
    std::vector<std::uint8_t> on_facet_;
    std::vector<std::uint32_t> first_;  ///< by node: the facets of which it is the lowest; and the end
    std::vector<std::uint32_t> list_;
};

}  // namespace

std::vector<FacetSide> facet_sides(const Mesh& mesh, int threads) {
    const FacetsByNode facets(mesh);
    // Element and face in one number, of which the least stays, whoever comes first.
    const std::size_t count = mesh.facets.size();
    const std::unique_ptr<std::atomic<std::uint64_t>[]> found(new std::atomic<std::uint64_t>[count]);
    for (std::size_t f = 0; f < count; ++f) found[f].store(kNoSide, std::memory_order_relaxed);
    const auto note = [&found](std::uint32_t facet, std::uint64_t side) {
        std::uint64_t known = found[facet].load(std::memory_order_relaxed);
        while (side < known && !found[facet].compare_exchange_weak(known, side, std::memory_order_relaxed)) {
        }
    };
    std::array<std::uint64_t, kElementTypes + 1> first{};
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[t];
        const LocalFaces local = local_faces(static_cast<ElementType>(t));
        const auto find_faces = [&](std::size_t i) {
            const NodeId* const node = block.nodes.data() + static_cast<std::size_t>(kElementNodes[t]) * i;
            for (int f = 0; f < local.count; ++f) {
                std::array<NodeId, 4> face{};
                const std::size_t corners = corner_count(local.faces[f]);
                bool may_be_facet = true;
                for (std::size_t k = 0; k < corners && may_be_facet; ++k) {
                    face[k] = node[local.faces[f][k]];
                    may_be_facet = facets.is_on_facet(face[k]);
                }
                if (!may_be_facet) continue;
                const std::uint64_t side = kMostFaces * (first[t] + i) + static_cast<std::uint64_t>(f);
                facets.find(face_key(face.data(), corners), block.region[i],
                            [&](std::uint32_t facet) { note(facet, side); });
            }
        };
        parallel_chunks(block.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) find_faces(i);
        });
        first[t + 1] = first[t] + block.size();
    }
    std::vector<FacetSide> sides(count);
    for (std::size_t f = 0; f < count; ++f) {
        const std::uint64_t side = found[f].load(std::memory_order_relaxed);
        if (side == kNoSide)
            throw Error(ExitCode::kMeshing, "invalid mesh: facet " + std::to_string(f) +
                                                " is no face of an element; see check_mesh");
        std::size_t type = 0;
        while (side / kMostFaces >= first[type + 1]) ++type;
        sides[f] = {side / kMostFaces, static_cast<std::uint8_t>(side % kMostFaces),
                    static_cast<ElementType>(type)};
    }
    return sides;
}

}  // namespace mortise::io
