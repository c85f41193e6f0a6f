#include "host/assembly/facets.hpp"

#include <algorithm>

namespace mortise::assembly {
namespace {

/// Whether the frame of face f (kernels/shared/lattice.h) is counter-clockwise seen from outside its cell.
bool frame_points_outward(int f) { return (f / 2 != 1) == ((f & 1) != 0); }

/// First surface of a leaf: the name of last resort for a facet that lies on none.
std::uint32_t any_surface(const octree::Octree& tree, std::uint32_t nio) {
    const TreeNode& node = tree.nio[nio];
    for (std::uint32_t i = 0; i < node.tape_length; ++i) {
        const std::uint32_t word = tree.tapes[node.tape_offset + i];
        if (tape_operation(word) == kTapeLiteral) return tape_surface(word);
    }
    return 0;
}

/// What lies across a face of a CNIO cell.
struct Neighbour {
    enum class Kind { kNothing, kIn, kSnio, kCnio } kind = Kind::kNothing;
    std::uint64_t morton = 0;
    std::uint32_t nio = 0;
    std::uint16_t region = 0;        ///< kIn, kSnio
    const SnioLeaf* leaf = nullptr;  ///< kSnio
    const cnio::CellRecord* record = nullptr;
};

Neighbour across(const Input& input, const CnioCells& cells, std::uint16_t single_in_region,
                 const std::vector<std::uint16_t>& in_regions, std::uint64_t morton, int f) {
    Neighbour result;
    std::int64_t at[3] = {gather_bits(morton), gather_bits(morton >> 1), gather_bits(morton >> 2)};
    at[f / 2] += (f & 1) != 0 ? 1 : -1;
    if (at[f / 2] < 0 || at[f / 2] >= std::int64_t{1} << input.tree.level) return result;
    result.morton = morton_encode(static_cast<u32>(at[0]), static_cast<u32>(at[1]), static_cast<u32>(at[2]));
    if (input.tree.is_in(result.morton)) {
        result.kind = Neighbour::Kind::kIn;
        result.region =
            in_regions.empty() ? single_in_region : in_regions[input.tree.in_index(result.morton)];
    } else if (input.tree.is_nio(result.morton)) {
        result.nio = input.tree.nio_index(result.morton);
        result.record = cells.record(result.nio);
        result.kind = result.record != nullptr ? Neighbour::Kind::kCnio : Neighbour::Kind::kSnio;
        result.leaf = &input.classification.leaves[result.nio];
        result.region = result.leaf->region;
    }
    return result;
}

/// Region of a template's element behind a facet of face f, told by a corner of the facet that is not on the
/// surface: a polygon of a cut face holds corners of one side only. Where all are on it, by whether the
/// template has volume.
std::uint16_t template_region(const Neighbour& other, const cnio::FaceFacet& facet, int f) {
    const SnioLeaf& leaf = *other.leaf;
    if (leaf.method == kMethodHexahedron) return other.region;
    for (const std::uint16_t code : facet.node) {
        const int corner = code ^ (1 << (f / 2));
        if (code >= 8 || ((leaf.on >> corner) & 1) != 0) continue;
        return ((leaf.pattern >> corner) & 1) != 0 ? other.region : std::uint16_t{0};
    }
    return leaf.pattern != 0 ? other.region : std::uint16_t{0};
}

}  // namespace

void facets_of(const Input& input, const CnioCells& cells, const NodeLookup& lookup,
               std::uint16_t single_in_region, const std::vector<std::uint16_t>& in_regions,
               std::uint32_t nio, std::vector<AssembledFacet>& out) {
    const cnio::CellRecord& record = *cells.record(nio);
    const cnio::CellArena& arena = cells.arena(record);
    for (std::uint32_t i = 0; i < record.facet_count; ++i) {
        const cnio::InnerFacet& facet = arena.facets[record.first_facet + i];
        AssembledFacet made{{}, facet.surface, facet.inside, facet.outside};
        if (made.surface == cnio::kNoSurface) made.surface = any_surface(input.tree, nio);
        for (std::size_t k = 0; k < 4; ++k) made.node[k] = lookup.node(nio, record, facet.node[k]);
        out.push_back(made);
    }
    const std::uint64_t morton = input.tree.nio[nio].morton;
    for (int f = 0; f < 6; ++f) {
        const Neighbour other = across(input, cells, single_in_region, in_regions, morton, f);
        const bool both = other.kind == Neighbour::Kind::kCnio;
        const std::uint32_t begin = record.first_face_facet[static_cast<std::size_t>(f)];
        const std::uint32_t end = record.first_face_facet[static_cast<std::size_t>(f) + 1];
        const cnio::FaceFacet* theirs =
            both ? cells.arena(*other.record).face_facets.data() +
                       other.record->first_face_facet[static_cast<std::size_t>(f ^ 1)]
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

}  // namespace mortise::assembly
