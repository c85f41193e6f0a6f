// See stage_bytes.hpp. In each sum reads come first, then writes, in the order of the kernels' parameters.
#include "bench/stage_bytes.hpp"

#include "kernels/shared/snio.h"

namespace mortise::bench {
namespace {

constexpr double kWord = sizeof(std::uint32_t);
constexpr double kNode = sizeof(TreeNode);
constexpr double kCandidate = sizeof(SnioCandidate);
constexpr double kPoints = sizeof(SnioPoints);
constexpr double kLeaf = sizeof(SnioLeaf);
/// An exclusive scan of words: two passes read, one writes.
constexpr double kScan = 3 * kWord;

template <class T>
double bytes_of(const std::vector<T>& array) {
    return static_cast<double>(array.size() * sizeof(T));
}

double arena_bytes(const cnio::Extraction& extraction) {
    double sum = bytes_of(extraction.records);
    for (const cnio::CellArena& arena : extraction.arenas) {
        sum += bytes_of(arena.edge_roots) + bytes_of(arena.extras) + bytes_of(arena.extra_used) +
               bytes_of(arena.facets) + bytes_of(arena.face_facets);
        for (std::size_t t = 0; t < kElementTypes; ++t)
            sum += bytes_of(arena.nodes[t]) + bytes_of(arena.regions[t]);
    }
    return sum;
}

}  // namespace

double geometry_bytes(const Mesh& mesh) {
    double sum = bytes_of(mesh.points);
    for (const ElementBlock& block : mesh.elements) sum += bytes_of(block.nodes);
    return sum;
}

double mesh_bytes(const Mesh& mesh) {
    double sum = geometry_bytes(mesh) + bytes_of(mesh.facets.nodes) + bytes_of(mesh.facets.surface) +
                 bytes_of(mesh.facets.inside) + bytes_of(mesh.facets.outside) +
                 bytes_of(mesh.model_dimension);
    for (const ElementBlock& block : mesh.elements) sum += bytes_of(block.region) + bytes_of(block.kind);
    return sum;
}

StageBytes stage_bytes(const octree::Octree& tree, const cnio::Extraction& extraction, const Mesh& before,
                       const Mesh& after, std::uint64_t zone_elements) {
    double found = 0;  // NIO leaves of the descent; those that were promoted later have no tape
    double leaf_tapes = 0;
    for (const TreeNode& node : tree.nio) {
        if (node.tape_length == 0) continue;
        found += 1;
        leaf_tapes += kWord * node.tape_length;
    }
    double complex_tapes = 0;
    for (const std::uint32_t leaf : extraction.leaves) complex_tapes += kWord * tree.nio[leaf].tape_length;
    const double cells = static_cast<double>(tree.cells_evaluated);
    const double parents = cells / 8;
    const double undecided = parents - 1 + found;  // each is a parent itself, but on the last level
    const double in_nodes = bytes_of(tree.in_nodes);
    const double words = kWord * static_cast<double>(tree.words());
    const double leaves = static_cast<double>(tree.nio.size());
    const double meshed = leaves + static_cast<double>(tree.in_count);
    const double complex = static_cast<double>(extraction.leaves.size());
    const double tapes = bytes_of(tree.tapes);

    StageBytes bytes;
    // descend: nodes, tapes; children, tapes, two counts. gather_children: nodes, children and the counts'
    // scans; nodes, IN nodes.
    constexpr double child = sizeof(ChildNode);
    bytes.descent = parents * kNode + tapes + cells * child + tapes + 2 * parents * kWord + parents * kNode +
                    cells * child + 2 * parents * kWord + undecided * kNode + in_nodes;
    // classify: node, tape; candidate, points. mark_vertices: node, candidate; vetoes, promoted bits.
    // test_subsets: node, candidate, points; candidate, vetoes. veto_needs: candidate.
    bytes.entities = found * (kNode + kCandidate + kPoints) + leaf_tapes + found * (kNode + kCandidate + 1) +
                     words + leaves * (kNode + 2 * kCandidate + kPoints + 1) + leaves * kCandidate;
    // Scans of the descent (two counts a parent), bitmaps (mark_in, mark_nio on cleared words), their ranks
    // (count and scan), promoted leaves (three bitmaps; two; ranks; old and new leaves with candidates; the
    // places of points, and those of promoted leaves), and the scan that numbers nodes.
    bytes.compaction = 2 * parents * kScan + in_nodes + found * kNode + 4 * words +
                       2 * (2 * words + 3 * words) + 3 * words + 2 * words + 2 * (2 * words + 3 * words) +
                       4 * words + (found + leaves) * (kNode + kCandidate) + leaves * kWord +
                       (leaves - found) * kPoints + meshed * kScan;
    // own_nodes: tree, masks, extras; owned masks, counts.
    bytes.numbering = 4 * words + 2 * leaves * kWord + 2 * meshed * kWord;
    // fill: node, candidate, vetoes, points; leaf, mask, counts. write_templates: node, leaf, mask, offsets,
    // owned, base; elements, facets.
    double template_elements = 0;
    double complex_elements = 0;
    double hexahedra = 0;
    double all_elements = 0;
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = before.elements[t];
        const double nodes = kElementNodes[t] * kWord;
        all_elements += static_cast<double>(block.size());
        for (const std::uint8_t kind : block.kind) {
            if (kind == static_cast<std::uint8_t>(ElementKind::kSnio)) template_elements += nodes;
            if (kind == static_cast<std::uint8_t>(ElementKind::kCnio)) complex_elements += nodes;
            if (kind == static_cast<std::uint8_t>(ElementKind::kIn)) hexahedra += nodes;
        }
    }
    const double facets = static_cast<double>(before.facets.size());
    const double simple = leaves - complex;
    bytes.templates = leaves * (kNode + kCandidate + 1 + kPoints + kLeaf + (2 + kElementTypes) * kWord) +
                      leaves * (kNode + kLeaf + kWord + (1 + kElementTypes) * kWord) + 2 * simple * kWord +
                      template_elements + facets * 4 * kWord;
    const double arenas = arena_bytes(extraction);
    bytes.extraction = complex * kNode + complex_tapes + arenas;
    // place_nodes: tree, owned, base, leaves; points. write_hexahedra: tree, owned, base, masks; nodes. Host:
    // cells of the certificate; their elements; regions and kinds; facets.
    bytes.assembly = 4 * words + 2 * meshed * kWord + leaves * kLeaf + bytes_of(before.points) + 4 * words +
                     2 * meshed * kWord + leaves * kWord + hexahedra + arenas + complex_elements +
                     all_elements * 3 + facets * (4 * kWord + 2 * kWord) +
                     facets * (4 * kWord + kWord + 2 * sizeof(std::uint16_t));
    // All elements are looked at once; the zone's become tetrahedra, which are read and written.
    bytes.repositioning = mesh_bytes(before) + 2 * static_cast<double>(zone_elements) * 4 * kWord +
                          (zone_elements > 0 ? mesh_bytes(after) : 0);
    return bytes;
}

}  // namespace mortise::bench
