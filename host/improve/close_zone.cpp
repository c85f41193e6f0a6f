#include <algorithm>

#include "host/common/compaction.hpp"
#include "host/common/large_array.hpp"
#include "host/common/parallel.hpp"
#include "host/improve/zone.hpp"

namespace mortise::improve {
namespace {

constexpr std::size_t kCloseChunk = 65536;

/// Nodes of the mesh for those of the zone. New nodes take the numbers of nodes that are gone; `unused`
/// receives the numbers that are left over, ascending.
std::vector<NodeId> number_nodes(const Zone& zone, std::size_t count, std::vector<NodeId>* unused) {
    std::vector<std::uint8_t> used = zone.frozen;
    for (const Tetrahedron& t : zone.tetrahedra) {
        for (const ZoneNode n : t.node) used[n] = 1;
    }
    for (const Pyramid& p : zone.pyramids) {
        for (const ZoneNode n : p.node) used[n] = 1;
    }
    for (std::size_t i = 0; i < used.size(); ++i) {
        if (used[i] == 0 && zone.mesh_node[i] != kNone) unused->push_back(zone.mesh_node[i]);
    }
    std::vector<NodeId> node = zone.mesh_node;
    std::size_t taken = 0;
    for (std::size_t i = 0; i < used.size(); ++i) {
        if (used[i] == 0 || node[i] != kNone) continue;
        node[i] = taken < unused->size() ? (*unused)[taken++] : static_cast<NodeId>(count++);
    }
    unused->erase(unused->begin(), unused->begin() + static_cast<std::ptrdiff_t>(taken));
    return node;
}

/// Takes nodes out that no element uses; the others keep their order. Their new numbers, by the old ones;
/// empty if all stay.
std::vector<NodeId> remove_nodes(const std::vector<NodeId>& unused, int threads, Mesh& mesh, Trace* trace) {
    std::vector<NodeId> number;
    if (unused.empty()) return number;
    const std::size_t count = mesh.node_count();
    resize_large(number, count, threads);
    std::vector<std::uint8_t> is_gone(count, 0);
    parallel_chunks(count, kCloseChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        auto next = std::lower_bound(unused.begin(), unused.end(), begin);
        for (std::size_t i = begin; i < end; ++i) {
            number[i] = static_cast<NodeId>(i - static_cast<std::size_t>(next - unused.begin()));
            if (next == unused.end() || *next != i) continue;
            is_gone[i] = 1;
            ++next;
        }
    });
    const Compaction compaction(is_gone, threads);
    compaction.keep(mesh.points, 3);
    if (trace != nullptr) compaction.keep(trace->node, 1);
    return number;
}

/// The nodes of the zone that have moved, or are new.
void place_nodes(const Zone& zone, const std::vector<NodeId>& node, const CellFrame& frame, Mesh& mesh) {
    for (std::size_t i = 0; i < zone.points.size(); ++i) {
        if (node[i] == kNone) continue;
        if (zone.mesh_node[i] != kNone && zone.points[i] == zone.original[i]) continue;
        if (node[i] >= mesh.node_count()) mesh.points.resize(3 * (std::size_t{node[i]} + 1));
        for (std::size_t j = 0; j < 3; ++j)
            mesh.points[3 * std::size_t{node[i]} + j] = frame.origin[j] + frame.cell * zone.points[i][j];
    }
}

void append_pyramids(const Zone& zone, const std::vector<NodeId>& node, ElementBlock& block) {
    for (const Pyramid& p : zone.pyramids) {
        for (const ZoneNode n : p.node) block.nodes.push_back(node[n]);
        block.region.push_back(p.region);
        block.kind.push_back(p.kind);
    }
}

using FaceKey = std::array<ZoneNode, 3>;

FaceKey face_of(const Tetrahedron& t, std::size_t face) {
    const auto& o = kOpposite[face];
    return {t.node[o[0]], t.node[o[1]], t.node[o[2]]};
}

/// Regions in front of interfaces of the zone: facets made anew need the one on their other side.
class Fronts {
  public:
    explicit Fronts(const Zone& zone) {
        for (const Tetrahedron& t : zone.tetrahedra) {
            for (std::size_t f = 0; f < 4; ++f) {
                if (t.tag[f] == 0 || (t.tag[f] & (kTagInside | kTagBorder)) != 0) continue;
                faces_.push_back({sorted(face_of(t, f)), t.region});
            }
        }
        std::sort(faces_.begin(), faces_.end());
    }

    /// 0: there is none.
    std::uint16_t region(const FaceKey& face) const {
        const Face wanted{sorted(face), 0};
        const auto found = std::lower_bound(faces_.begin(), faces_.end(), wanted);
        return found != faces_.end() && found->key == wanted.key ? found->region : std::uint16_t{0};
    }

  private:
    struct Face {
        FaceKey key;
        std::uint16_t region;
        bool operator<(const Face& other) const { return key < other.key; }
    };
    static FaceKey sorted(FaceKey key) {
        std::sort(key.begin(), key.end());
        return key;
    }
    std::vector<Face> faces_;
};

void append_facets(const Tetrahedron& t, const std::vector<NodeId>& node, const Fronts& fronts,
                   FacetBlock& facets) {
    for (std::size_t f = 0; f < 4; ++f) {
        if ((t.tag[f] & (kTagInside | kTagBorder)) != kTagInside) continue;
        const FaceKey face = face_of(t, f);
        for (const ZoneNode n : face) facets.nodes.push_back(node[n]);
        facets.nodes.push_back(node[face[2]]);
        facets.surface.push_back(tag_surface(t.tag[f]));
        facets.inside.push_back(t.region);
        facets.outside.push_back((t.tag[f] & kTagInterface) != 0 ? fronts.region(face) : std::uint16_t{0});
    }
}

}  // namespace

Mesh close_zone(Mesh mesh, const CellFrame& frame, const Zone& zone, Trace* trace, Known& known) {
    Mesh result = std::move(mesh);
    std::vector<NodeId> unused;
    const std::vector<NodeId> node = number_nodes(zone, result.node_count(), &unused);
    known.gone.nodes.insert(known.gone.nodes.end(), unused.begin(), unused.end());
    place_nodes(zone, node, frame, result);
    for (std::size_t t = 0; t < kElementTypes; ++t) known.old[t] = result.elements[t].size();
    known.poor = zone.left_poor;
    append_pyramids(zone, node, result.block(ElementType::kPyramid));
    const Fronts fronts(zone);
    ElementBlock& tetrahedra = result.block(ElementType::kTetrahedron);
    for (const Tetrahedron& t : zone.tetrahedra) {
        for (const ZoneNode n : t.node) tetrahedra.nodes.push_back(node[n]);
        tetrahedra.region.push_back(t.region);
        tetrahedra.kind.push_back(t.kind);
        append_facets(t, node, fronts, result.facets);
    }
    if (trace != nullptr) {
        trace->node.resize(result.node_count(), kNone);
        for (std::size_t t = 0; t < kElementTypes; ++t)
            trace->element[t].resize(result.elements[t].size(), kNone);
        trace->facet.resize(result.facets.size(), kNone);
    }
    return result;
}

void drop_zone(const Zone& zone, Known& known) {
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        for (const std::uint32_t i : zone.taken[t]) known.gone.element[t][i] = 0;
    }
    for (const std::uint32_t i : zone.facets_taken) known.gone.facet[i] = 0;
}

Mesh remove_gone(Mesh mesh, Gone gone, int threads, Trace* trace) {
    gone.make_room(mesh);
    std::sort(gone.nodes.begin(), gone.nodes.end());
    const std::vector<NodeId> number = remove_nodes(gone.nodes, threads, mesh, trace);
    const auto keep_nodes = [&](std::vector<NodeId>& nodes, const Compaction& compaction,
                                std::size_t stride) {
        if (number.empty())
            compaction.keep(nodes, stride);
        else
            compaction.keep(nodes, stride, [&number](NodeId n) { return number[n]; });
    };
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        ElementBlock& block = mesh.elements[t];
        const Compaction compaction(gone.element[t], threads);
        keep_nodes(block.nodes, compaction, static_cast<std::size_t>(kElementNodes[t]));
        compaction.keep(block.region, 1);
        compaction.keep(block.kind, 1);
        if (trace != nullptr) compaction.keep(trace->element[t], 1);
    }
    FacetBlock& facets = mesh.facets;
    const Compaction compaction(gone.facet, threads);
    keep_nodes(facets.nodes, compaction, 4);
    compaction.keep(facets.surface, 1);
    compaction.keep(facets.inside, 1);
    compaction.keep(facets.outside, 1);
    if (trace != nullptr) compaction.keep(trace->facet, 1);
    return mesh;
}

}  // namespace mortise::improve
