#include <algorithm>

#include "host/improve/zone.hpp"

namespace mortise::improve {
namespace {

template <class T>
void keep(std::vector<T>& values, const std::vector<std::uint8_t>& taken, std::size_t stride) {
    std::size_t to = 0;
    for (std::size_t i = 0; i < taken.size(); ++i) {
        if (taken[i] != 0) continue;
        for (std::size_t k = 0; k < stride; ++k) values[to * stride + k] = values[i * stride + k];
        ++to;
    }
    values.resize(to * stride);
}

}  // namespace

Mesh close_zone(const Mesh& mesh, const CellFrame& frame, const Zone& zone) {
    Mesh result = mesh;
    std::vector<NodeId> node(zone.points.size());
    for (std::size_t i = 0; i < zone.points.size(); ++i) {
        const bool is_new = zone.mesh_node[i] == kNone;
        node[i] = is_new ? static_cast<NodeId>(result.node_count()) : zone.mesh_node[i];
        if (is_new) result.points.insert(result.points.end(), 3, 0.0);
        if (!is_new && zone.points[i] == zone.original[i]) continue;
        for (std::size_t j = 0; j < 3; ++j) {
            result.points[3 * std::size_t{node[i]} + j] = frame.origin[j] + frame.cell * zone.points[i][j];
        }
    }
    for (int t = 0; t < kElementTypes; ++t) {
        const auto type = static_cast<std::size_t>(t);
        ElementBlock& block = result.elements[type];
        keep(block.nodes, zone.taken[type], static_cast<std::size_t>(kElementNodes[type]));
        keep(block.region, zone.taken[type], 1);
        keep(block.kind, zone.taken[type], 1);
    }
    ElementBlock& pyramids = result.block(ElementType::kPyramid);
    for (const Pyramid& p : zone.pyramids) {
        for (const ZoneNode n : p.node) pyramids.nodes.push_back(node[n]);
        pyramids.region.push_back(p.region);
        pyramids.kind.push_back(p.kind);
    }
    FacetBlock& facets = result.facets;
    // Facets made anew need the region on their other side.
    struct Face {
        std::array<ZoneNode, 3> key;
        std::uint16_t region;
        bool operator<(const Face& other) const { return key < other.key; }
    };
    std::vector<Face> fronts;
    const auto sorted = [](std::array<ZoneNode, 3> key) {
        std::sort(key.begin(), key.end());
        return key;
    };
    for (const Tetrahedron& t : zone.tetrahedra) {
        for (std::size_t f = 0; f < 4; ++f) {
            if (t.tag[f] == 0 || (t.tag[f] & (kTagInside | kTagBorder)) != 0) continue;
            const auto& o = kOpposite[f];
            fronts.push_back({sorted({t.node[o[0]], t.node[o[1]], t.node[o[2]]}), t.region});
        }
    }
    std::sort(fronts.begin(), fronts.end());
    keep(facets.nodes, zone.facet_taken, 4);
    keep(facets.surface, zone.facet_taken, 1);
    keep(facets.inside, zone.facet_taken, 1);
    keep(facets.outside, zone.facet_taken, 1);
    ElementBlock& tetrahedra = result.block(ElementType::kTetrahedron);
    for (const Tetrahedron& t : zone.tetrahedra) {
        for (const ZoneNode n : t.node) tetrahedra.nodes.push_back(node[n]);
        tetrahedra.region.push_back(t.region);
        tetrahedra.kind.push_back(t.kind);
        for (std::size_t f = 0; f < 4; ++f) {
            if ((t.tag[f] & (kTagInside | kTagBorder)) != kTagInside) continue;
            const auto& o = kOpposite[f];
            const std::array<ZoneNode, 3> face = {t.node[o[0]], t.node[o[1]], t.node[o[2]]};
            for (const ZoneNode n : face) facets.nodes.push_back(node[n]);
            facets.nodes.push_back(node[face[2]]);
            facets.surface.push_back(tag_surface(t.tag[f]));
            facets.inside.push_back(t.region);
            std::uint16_t outside = 0;
            if ((t.tag[f] & kTagInterface) != 0) {
                const Face wanted{sorted(face), 0};
                const auto found = std::lower_bound(fronts.begin(), fronts.end(), wanted);
                if (found != fronts.end() && found->key == wanted.key) outside = found->region;
            }
            facets.outside.push_back(outside);
        }
    }
    // Nodes that no element uses any more go; the others keep their order.
    std::vector<NodeId> number(result.node_count(), kNone);
    for (const ElementBlock& block : result.elements) {
        for (const NodeId n : block.nodes) number[n] = 0;
    }
    NodeId next = 0;
    for (std::size_t i = 0; i < number.size(); ++i) {
        if (number[i] == kNone) continue;
        for (std::size_t j = 0; j < 3; ++j)
            result.points[3 * std::size_t{next} + j] = result.points[3 * i + j];
        number[i] = next++;
    }
    result.points.resize(3 * std::size_t{next});
    for (ElementBlock& block : result.elements) {
        for (NodeId& n : block.nodes) n = number[n];
    }
    for (NodeId& n : facets.nodes) n = number[n];
    return result;
}

}  // namespace mortise::improve
