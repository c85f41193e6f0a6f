#include "host/assembly/facets.hpp"

#include <algorithm>

#include "kernels/shared/lattice.h"

namespace mortise::assembly {
namespace {

/// First surface of a leaf: the name of last resort for a facet that lies on none.
std::uint32_t any_surface(const octree::Octree& tree, std::uint32_t nio) {
    const TreeNode& node = tree.nio[nio];
    for (std::uint32_t i = 0; i < node.tape_length; ++i) {
        const std::uint32_t word = tree.tapes[node.tape_offset + i];
        if (tape_operation(word) == kTapeLiteral) return tape_surface(word);
    }
    return 0;
}

/// What lies across a patch of a CNIO cell's face.
struct Neighbour {
    enum class Kind { kNothing, kIn, kSnio, kCnio } kind = Kind::kNothing;
    std::uint16_t region = 0;        ///< kIn, kSnio
    const SnioLeaf* leaf = nullptr;  ///< kSnio
    std::uint32_t used = 0;          ///< the same: its nodes
    const cnio::CellRecord* record = nullptr;
    int patch = 0;  ///< kCnio: the same patch, among its own
};

/// A CNIO cell whose facets are wanted.
struct Here {
    const Input& input;
    const CnioCells& cells;
    std::uint64_t code;
    int level;
};

/// Patch p of the cell, which is a quarter of its face if `quarter` is set.
Neighbour across(const Here& here, int p, bool quarter) {
    Neighbour result;
    const Tree tree = here.input.tree.view();
    const int f = p / 4;
    const int axis = f / 2;
    const int u = first_other(axis);
    const int v = second_other(axis);
    Leaf leaf;
    if (quarter) {
        int half[3];
        half[axis] = (f & 1) != 0 ? 2 : -1;
        half[u] = p & 1;
        half[v] = (p >> 1) & 1;
        leaf = octree::leaf_at_half(tree, here.code, here.level, half[0], half[1], half[2]);
    } else {
        leaf = leaf_beyond(&tree, here.code, here.level, f);
    }
    if (leaf.kind == kLeafIn) {
        result.kind = Neighbour::Kind::kIn;
        result.region = here.input.in_regions.of(leaf.index);
    } else if (leaf.kind == kLeafNio) {
        result.record = here.cells.record(leaf.index);
        result.kind = result.record != nullptr ? Neighbour::Kind::kCnio : Neighbour::Kind::kSnio;
        result.leaf = &here.input.classification.leaves[leaf.index];
        result.used = here.input.classification.used[leaf.index];
        result.region = result.leaf->region;
        result.patch = 4 * (f ^ 1);
        if (leaf.level < here.level) {  // this cell lies beside a quarter of the other's face
            const int depth = here.input.tree.level - here.level;
            result.patch += static_cast<int>(((gather_bits(here.code >> u) >> depth) & 1) +
                                             2 * ((gather_bits(here.code >> v) >> depth) & 1));
        }
    }
    return result;
}

/// Region of a template behind a facet of the common face, told by a corner of the facet that is not on the
/// surface: a polygon of a cut face holds corners of one side only. Where all are on it, by whether the
/// template has volume.
std::uint16_t template_region(const Neighbour& other, const cnio::FaceFacet& facet, int f) {
    const SnioLeaf& leaf = *other.leaf;
    if (leaf.method == kMethodHexahedron) return other.region;
    for (const std::uint8_t place : facet.corner) {
        if (place == 4) continue;
        const int corner = kFaceCorners[f ^ 1][place];  // a template's leaf shares the whole patch
        if (((leaf.on >> corner) & 1) != 0) continue;
        return ((leaf.pattern >> corner) & 1) != 0 ? other.region : std::uint16_t{0};
    }
    return leaf.pattern != 0 ? other.region : std::uint16_t{0};
}

}  // namespace

void facets_of(const Input& input, const CnioCells& cells, const NodeLookup& lookup, std::uint32_t nio,
               std::vector<AssembledFacet>& out) {
    const cnio::CellRecord& record = *cells.record(nio);
    const cnio::CellArena& arena = cells.arena(record);
    for (std::uint32_t i = 0; i < record.facet_count; ++i) {
        const cnio::InnerFacet& facet = arena.facets[record.first_facet + i];
        AssembledFacet made{{}, facet.surface, facet.inside, facet.outside};
        if (made.surface == cnio::kNoSurface) made.surface = any_surface(input.tree, nio);
        for (std::size_t k = 0; k < 4; ++k) made.node[k] = lookup.node(nio, record, facet.node[k]);
        out.push_back(made);
    }
    const std::uint64_t code = input.tree.nio[nio].morton;
    const Here here{input, cells, code, input.tree.level_of(code)};
    const auto& first = record.first_face_facet;
    for (int p = 0; p < cnio::kPatches; ++p) {
        const auto at = static_cast<std::size_t>(p);
        const std::uint32_t begin = first[at];
        const std::uint32_t end = first[at + 1];
        if (begin == end) continue;
        const int f = p / 4;
        const bool quarter = first[at / 4 * 4 + 1] != first[at / 4 * 4 + 4];
        const Neighbour other = across(here, p, quarter);
        const bool both = other.kind == Neighbour::Kind::kCnio;
        const cnio::FaceFacet* theirs =
            both ? cells.arena(*other.record).face_facets.data() +
                       other.record->first_face_facet[static_cast<std::size_t>(other.patch)]
                 : nullptr;
        for (std::uint32_t i = begin; i < end; ++i) {
            const cnio::FaceFacet& mine = arena.face_facets[i];
            std::uint16_t region = 0;
            if (both) region = theirs[i - begin].region;
            if (other.kind == Neighbour::Kind::kIn) region = other.region;
            if (other.kind == Neighbour::Kind::kSnio) region = template_region(other, mine, f);
            if (region == mine.region) continue;
            AssembledFacet made{};
            const bool mine_inside = mine.region != 0 && (region == 0 || mine.region < region);
            if (both && !mine_inside) continue;  // the other cell lists it
            made.inside = mine_inside ? mine.region : region;
            made.outside = mine_inside ? region : mine.region;
            made.surface = mine.surface;
            if (made.surface == cnio::kNoSurface && both) made.surface = theirs[i - begin].surface;
            if (made.surface == cnio::kNoSurface && other.kind == Neighbour::Kind::kSnio)
                made.surface = other.leaf->surface;
            if (made.surface == cnio::kNoSurface) made.surface = any_surface(input.tree, nio);
            for (std::size_t k = 0; k < 4; ++k) made.node[k] = lookup.node(nio, record, mine.node[k]);
            if (frame_points_outward(f) != mine_inside) {
                if (made.node[3] == made.node[2]) {
                    std::swap(made.node[0], made.node[1]);
                } else {
                    std::reverse(made.node.begin(), made.node.end());
                }
            }
            out.push_back(made);
        }
    }
}

std::uint32_t corners_of_facets(const Input& input, const CnioCells& cells, std::uint32_t nio) {
    const cnio::CellRecord& record = *cells.record(nio);
    const std::uint64_t code = input.tree.nio[nio].morton;
    const Here here{input, cells, code, input.tree.level_of(code)};
    std::uint32_t result = 0;
    for (int f = 0; f < 6; ++f) {
        const auto p = static_cast<std::size_t>(4 * f);
        const std::uint32_t facet = record.first_face_facet[p];
        if (record.first_face_facet[p + 4] - facet != 1) continue;
        if (cells.arena(record).face_facets[facet].region != 0) continue;
        const Neighbour other = across(here, 4 * f, false);
        if (other.kind == Neighbour::Kind::kNothing || other.kind == Neighbour::Kind::kCnio) continue;
        std::uint32_t own = 0;
        std::uint32_t theirs = 0;
        for (const std::uint8_t c : kFaceCorners[f]) {
            own |= 1u << c;
            theirs |= 1u << (c ^ (1u << (f / 2)));
        }
        const bool is_in = other.kind == Neighbour::Kind::kIn;
        if (is_in || (other.leaf->pattern != kPatternCnio && (other.used & theirs) == theirs)) result |= own;
    }
    return result;
}

}  // namespace mortise::assembly
