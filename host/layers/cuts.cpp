#include "host/layers/cuts.hpp"

#include <algorithm>
#include <utility>

#include "host/common/parallel.hpp"
#include "host/layers/stack.hpp"

namespace mortise::layers {
namespace {

const CutFace* find_face(const std::vector<CutFace>& faces, const NodeId* nodes, const LocalFace& face) {
    if (face[3] < 0) return nullptr;
    CutFace wanted;
    for (std::size_t k = 0; k < 4; ++k) wanted.key[k] = nodes[face[k]];
    std::sort(wanted.key.begin(), wanted.key.end());
    const auto found = std::lower_bound(faces.begin(), faces.end(), wanted);
    return found != faces.end() && found->key == wanted.key ? &*found : nullptr;
}

}  // namespace

std::vector<CutFace> find_cut_faces(const Walls& walls, const std::vector<std::uint8_t>& is_bare) {
    std::vector<CutFace> faces;
    for (std::size_t f = 0; f < walls.facets.size(); ++f) {
        const WallFacet& facet = walls.facets[f];
        const std::optional<std::size_t> cut = cut_of(facet, bare_corners(facet, walls.place, is_bare));
        if (!cut) continue;
        CutFace face;
        face.key = facet.node;
        std::sort(face.key.begin(), face.key.end());
        face.diagonal = {facet.node[*cut], facet.node[(*cut + 2) % 4]};
        face.wall = static_cast<std::uint32_t>(f);
        faces.push_back(face);
    }
    std::sort(faces.begin(), faces.end());
    return faces;
}

std::vector<std::uint32_t> find_folded_cuts(const Mesh& mesh, const Walls& walls,
                                            const std::vector<CutFace>& faces) {
    // Facets that share three nodes with some cut one, by these.
    std::vector<std::uint8_t> is_cut(mesh.node_count(), 0);
    for (const CutFace& face : faces) {
        for (const NodeId node : face.key) is_cut[node] = 1;
    }
    using Triple = std::array<NodeId, 3>;
    const auto sorted = [](Triple nodes) {
        std::sort(nodes.begin(), nodes.end());
        return nodes;
    };
    std::vector<std::pair<Triple, std::uint32_t>> triples;
    for (std::size_t f = 0; f < mesh.facets.size() && !faces.empty(); ++f) {
        const FacetNodes node = mesh.facets.facet(f);
        for (std::size_t k = 0; k < (node.size() == 3 ? 1u : 4u); ++k) {
            const Triple nodes = sorted({node.before(k), node[k], node.after(k)});
            if (is_cut[nodes[0]] + is_cut[nodes[1]] + is_cut[nodes[2]] == 3)
                triples.emplace_back(nodes, static_cast<std::uint32_t>(f));
        }
    }
    std::sort(triples.begin(), triples.end());
    std::vector<std::uint32_t> folded;
    for (const CutFace& face : faces) {
        bool is_alone = true;
        for (const NodeId third : face.key) {
            if (third == face.diagonal[0] || third == face.diagonal[1]) continue;
            const Triple nodes = sorted({face.diagonal[0], face.diagonal[1], third});
            const auto last = triples.end();
            for (auto other =
                     std::lower_bound(triples.begin(), last, std::make_pair(nodes, std::uint32_t{0}));
                 other != last && other->first == nodes; ++other)
                is_alone = is_alone && other->second == walls.facets[face.wall].facet;
        }
        if (!is_alone) folded.push_back(face.wall);
    }
    return folded;
}

std::vector<CutElement> find_cut_elements(const Mesh& mesh, const std::vector<CutFace>& faces, int threads) {
    std::vector<CutElement> elements;
    if (faces.empty()) return elements;
    for (const ElementType type : {ElementType::kHexahedron, ElementType::kWedge, ElementType::kPyramid}) {
        const ElementBlock& block = mesh.block(type);
        const LocalFaces local = local_faces(type);
        const auto nodes = nodes_per(type);
        std::vector<std::vector<CutElement>> parts(chunk_count(block.size(), kElementChunk));
        parallel_numbered(
            block.size(), kElementChunk, threads, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i) {
                    const NodeId* const node = block.nodes.data() + nodes * i;
                    const bool has_cut = std::any_of(
                        local.faces, local.faces + local.count,
                        [&](const LocalFace& face) { return find_face(faces, node, face) != nullptr; });
                    if (has_cut) parts[chunk].push_back({type, static_cast<std::uint32_t>(i)});
                }
            });
        for (const auto& part : parts) elements.insert(elements.end(), part.begin(), part.end());
    }
    return elements;
}

std::vector<CutPart> cut_element(ElementType type, const NodeId* nodes, const std::vector<CutFace>& faces) {
    const LocalFaces local = local_faces(type);
    const int top = type == ElementType::kPyramid ? 4 : kCentre;
    std::vector<CutPart> parts;
    for (int f = 0; f < local.count; ++f) {
        const LocalFace& face = local.faces[f];
        const CutFace* const cut = find_face(faces, nodes, face);
        if (type == ElementType::kPyramid && cut == nullptr) continue;  // a side
        // Faces are outward: seen from the centre the other way round.
        if (face[3] < 0) {
            parts.push_back({ElementType::kTetrahedron, {face[0], face[2], face[1], top}});
        } else if (cut == nullptr) {
            parts.push_back({ElementType::kPyramid, {face[0], face[3], face[2], face[1], top}});
        } else {
            std::size_t k = 0;
            while (nodes[face[k]] != cut->diagonal[0] && nodes[face[k]] != cut->diagonal[1]) ++k;
            const auto at = [&](std::size_t i) { return face[(k + i) % 4]; };
            parts.push_back({ElementType::kTetrahedron, {at(0), at(2), at(1), top}});
            parts.push_back({ElementType::kTetrahedron, {at(0), at(3), at(2), top}});
        }
    }
    return parts;
}

}  // namespace mortise::layers
