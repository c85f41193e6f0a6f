#include "host/assembly/assembly.hpp"

#include <algorithm>
#include <string>

#include "host/assembly/facets.hpp"
#include "host/assembly/nodes.hpp"
#include "host/common/parallel.hpp"

namespace mortise::assembly {
namespace {

using device::Buffer;

/// Layout of the kernels' argument: origin and edge length of the root box.
struct OriginSide {
    double x, y, z, side;
};

constexpr std::size_t kChunk = 512;

class Assembler {
  public:
    Assembler(device::Device& device, const Input& input)
        : device_(device), input_(input), cells_(input.tree, input.classification, input.extraction) {
        in_regions_ = octree::in_regions(input.tree, &single_in_region_);
    }

    Mesh run() {
        count_elements();
        number();
        make_room();
        launch_fills();
        place_cnio_nodes();
        fill_cnio_elements();
        fill_regions();
        finish_fills();
        fill_facets();
        return std::move(mesh_);
    }

  private:
    std::size_t nio_count() const { return input_.tree.nio.size(); }
    std::size_t meshed_count() const { return input_.tree.in_count + nio_count(); }

    /// Elements of each type before each NIO leaf; IN hexahedra come on top (their rank).
    void count_elements() {
        numbering_.used = input_.classification.used;
        const auto& list = input_.classification.cnio;
        for (std::size_t t = 0; t < kElementTypes; ++t) offsets_[t] = input_.classification.elements[t];
        facet_offsets_ = input_.classification.facets;
        for (std::size_t i = 0; i < list.size(); ++i) {
            const cnio::CellRecord& record = input_.extraction.records[i];
            numbering_.used[list[i]] = record.used;
            for (std::size_t t = 0; t < kElementTypes; ++t) offsets_[t][list[i]] = record.element_count[t];
        }
        for (std::size_t t = 0; t < kElementTypes; ++t) totals_[t] = scan(offsets_[t], "elements");
        totals_[0] += input_.tree.in_count;
        snio_facets_ = scan(facet_offsets_, "facets");
    }

    /// In-place exclusive scan with the total appended.
    static std::uint64_t scan(std::vector<std::uint32_t>& counts, const char* what) {
        std::uint64_t sum = 0;
        for (std::uint32_t& count : counts) {
            const std::uint32_t here = count;
            count = static_cast<std::uint32_t>(sum);
            sum += here;
        }
        if (sum > 0xffffffffu) {
            throw Error(ExitCode::kMeshing,
                        "more than 2^32 " + std::string(what) + " at the boundary; use a lower --level");
        }
        counts.push_back(static_cast<std::uint32_t>(sum));
        return sum;
    }

    void number() {
        extras_ = rank_extras(input_, cells_);
        auto& tree = input_.on_device;
        const std::size_t meshed = meshed_count();
        used_ = device_.upload(numbering_.used);
        Buffer extra_counts = device_.upload(extras_.owned_count);
        owned_ = device_.allocate(meshed * sizeof(std::uint32_t));
        base_ = device_.allocate((meshed + 1) * sizeof(std::uint32_t));
        device_.launch(device_.kernel("assembly/number.cl", "own_nodes"), input_.tree.words(), tree.in_bits,
                       tree.nio_bits, tree.in_rank, tree.nio_rank, used_, extra_counts, owned_, base_,
                       level());
        nodes_ = device_.exclusive_scan_u32(base_, base_, meshed);
        numbering_.owned = device_.download<std::uint32_t>(owned_, meshed);
        numbering_.base = device_.download<std::uint32_t>(base_, meshed + 1);
    }

    void make_room() {
        mesh_.points.resize(3 * nodes_);
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            ElementBlock& block = mesh_.elements[t];
            block.nodes.resize(totals_[t] * static_cast<std::size_t>(kElementNodes[t]));
            block.region.resize(totals_[t]);
            block.kind.resize(totals_[t]);
        }
        snio_facet_nodes_.resize(4 * snio_facets_);
        points_ = device_.wrap(mesh_.points.data(), mesh_.points.size() * sizeof(double));
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            auto& nodes = mesh_.elements[t].nodes;
            connectivity_[t] = device_.wrap(nodes.data(), nodes.size() * sizeof(NodeId));
        }
        facet_buffer_ = device_.wrap(snio_facet_nodes_.data(), snio_facet_nodes_.size() * sizeof(NodeId));
    }

    void launch_fills() {
        auto& tree = input_.on_device;
        const std::size_t stride = nio_count();
        const auto& origin = input_.model.origin;
        const OriginSide box{origin[0], origin[1], origin[2], input_.model.side};
        leaves_ = device_.upload(input_.classification.leaves);
        offset_buffer_ =
            device_.allocate(kElementTypes * std::max<std::size_t>(1, stride + 1) * sizeof(std::uint32_t));
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            device_.upload(offset_buffer_, offsets_[t].data(), stride + 1, t * (stride + 1));
        }
        facet_offset_buffer_ = device_.upload(facet_offsets_);
        device_.launch(device_.kernel("assembly/number.cl", "place_nodes"), input_.tree.words(), tree.in_bits,
                       tree.nio_bits, tree.in_rank, tree.nio_rank, leaves_, tree.surfaces, tree.ops, owned_,
                       base_, points_, box, level());
        device_.launch(device_.kernel("assembly/number.cl", "write_hexahedra"), input_.tree.words(),
                       tree.in_bits, tree.nio_bits, tree.in_rank, tree.nio_rank, used_, owned_, base_,
                       offset_buffer_, connectivity_[0], level());
        device_.launch(device_.kernel("assembly/number.cl", "write_templates"), stride, tree.in_bits,
                       tree.nio_bits, tree.in_rank, tree.nio_rank, tree.nio, leaves_, used_, owned_, base_,
                       offset_buffer_, facet_offset_buffer_, connectivity_[0], connectivity_[1],
                       connectivity_[2], connectivity_[3], facet_buffer_,
                       static_cast<std::uint32_t>(stride + 1), level());
        // The host adds the certificate's part to the same arrays.
        device_.sync_to_host(points_);
        for (Buffer& buffer : connectivity_) device_.sync_to_host(buffer);
        device_.sync_to_host(facet_buffer_);
    }

    void finish_fills() {
        points_ = Buffer();
        for (Buffer& buffer : connectivity_) buffer = Buffer();
        facet_buffer_ = Buffer();
    }

    std::int32_t level() const { return input_.tree.level; }

    /// Calls work(leaf, record) for all CNIO leaves on all threads.
    template <class Work>
    void for_each_cnio(const Work& work) {
        const auto& list = input_.classification.cnio;
        parallel_chunks(list.size(), kChunk, input_.threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) work(list[i], input_.extraction.records[i]);
        });
    }

    NodeLookup lookup() const { return {input_.tree, cells_, extras_, numbering_}; }

    void store_point(NodeId id, double x, double y, double z) {
        const auto& origin = input_.model.origin;
        mesh_.points[3 * std::size_t{id}] = origin[0] + input_.model.side * x;
        mesh_.points[3 * std::size_t{id} + 1] = origin[1] + input_.model.side * y;
        mesh_.points[3 * std::size_t{id} + 2] = origin[2] + input_.model.side * z;
    }

    /// Owned roots and extra nodes of CNIO leaves; their owned grid vertices come from the device.
    void place_cnio_nodes() {
        const NodeLookup nodes = lookup();
        const double cell = input_.tree.cell_size();
        const double unit = std::ldexp(1.0, -(input_.tree.level + kCellUnitBits));
        for_each_cnio([&](std::uint32_t nio, const cnio::CellRecord& record) {
            const cnio::CellArena& arena = cells_.arena(record);
            const std::uint64_t morton = input_.tree.nio[nio].morton;
            const std::uint32_t rank = nodes.meshed_rank(morton);
            const std::uint32_t owned = numbering_.owned[rank];
            std::uint32_t at = record.first_edge_root;
            for (u32 e = 0; e < 12; ++e) {
                if (((record.used >> (8 + e)) & 1) == 0) continue;
                const std::int32_t root = arena.edge_roots[at++];
                if (((owned >> (8 + e)) & 1) == 0) continue;
                const u32 c = kEdgeCorners[e][0];
                double offset[3] = {static_cast<double>(c & 1), static_cast<double>((c >> 1) & 1),
                                    static_cast<double>(c >> 2)};
                offset[e / 4] = static_cast<double>(root) / static_cast<double>(kCellUnits);
                store_point(numbering_.base[rank] + mask_rank(owned, 8 + e),
                            (gather_bits(morton) + offset[0]) * cell,
                            (gather_bits(morton >> 1) + offset[1]) * cell,
                            (gather_bits(morton >> 2) + offset[2]) * cell);
            }
            for (std::uint32_t k = 0; k < record.extra_count; ++k) {
                const std::uint32_t extra = extras_.rank[record.arena][record.first_extra + k];
                if (extra == ExtraRanks::kNotOwned) continue;
                const cnio::NodeKey& key = arena.extras[record.first_extra + k];
                store_point(nodes.first_extra(nio) + extra, static_cast<double>(key.x) * unit,
                            static_cast<double>(key.y) * unit, static_cast<double>(key.z) * unit);
            }
        });
    }

    void fill_cnio_elements() {
        const NodeLookup nodes = lookup();
        for_each_cnio([&](std::uint32_t nio, const cnio::CellRecord& record) {
            const cnio::CellArena& arena = cells_.arena(record);
            std::vector<NodeId> ids(cnio::kExtraCode + record.extra_count);
            for (std::uint16_t code = 0; code < ids.size(); ++code) {
                if (code >= cnio::kExtraCode || ((record.used >> code) & 1) != 0)
                    ids[code] = nodes.node(nio, record, code);
            }
            const std::uint32_t before = input_.tree.in_index(input_.tree.nio[nio].morton);
            for (std::size_t t = 0; t < kElementTypes; ++t) {
                const auto size = static_cast<std::size_t>(kElementNodes[t]);
                const std::size_t first = offsets_[t][nio] + (t == 0 ? before : 0);
                ElementBlock& block = mesh_.elements[t];
                for (std::size_t k = 0; k < record.element_count[t]; ++k) {
                    for (std::size_t j = 0; j < size; ++j) {
                        block.nodes[(first + k) * size + j] =
                            ids[arena.nodes[t][(record.first_element[t] + k) * size + j]];
                    }
                    block.region[first + k] = arena.regions[t][record.first_element[t] + k];
                    block.kind[first + k] = static_cast<std::uint8_t>(ElementKind::kCnio);
                }
            }
        });
    }

    /// Regions and kinds of IN and SNIO elements.
    void fill_regions() {
        const auto& tree = input_.tree;
        ElementBlock& hexahedra = mesh_.elements[0];
        std::size_t next = 0;
        std::size_t in = 0;
        const auto fill_in = [&](std::size_t until) {
            for (; next < until; ++next, ++in) {
                hexahedra.region[next] = in_regions_.empty() ? single_in_region_ : in_regions_[in];
                hexahedra.kind[next] = static_cast<std::uint8_t>(ElementKind::kIn);
            }
        };
        for (std::uint32_t i = 0; i < nio_count(); ++i) {
            const SnioLeaf& leaf = input_.classification.leaves[i];
            const bool is_snio = leaf.pattern != kPatternCnio;
            const std::size_t hexahedra_here = offsets_[0][i + 1] - offsets_[0][i];
            if (hexahedra_here > 0) {
                fill_in(tree.in_index(tree.nio[i].morton) + offsets_[0][i]);
                next += hexahedra_here;
            }
            if (!is_snio) continue;
            for (std::size_t t = 0; t < kElementTypes; ++t) {
                const std::size_t begin =
                    offsets_[t][i] +
                    (t == 0 && hexahedra_here > 0 ? next - hexahedra_here - offsets_[0][i] : 0);
                for (std::size_t k = 0; k < offsets_[t][i + 1] - offsets_[t][i]; ++k) {
                    mesh_.elements[t].region[begin + k] = leaf.region;
                    mesh_.elements[t].kind[begin + k] = static_cast<std::uint8_t>(ElementKind::kSnio);
                }
            }
        }
        fill_in(hexahedra.size());
    }

    /// Facets of templates and of the certificate's cells, by leaf in Morton order.
    void fill_facets() {
        const NodeLookup nodes = lookup();
        const auto& list = input_.classification.cnio;
        std::vector<std::vector<AssembledFacet>> parts((list.size() + kChunk - 1) / kChunk);
        std::vector<std::uint32_t> counts(list.size());
        parallel_chunks(list.size(), kChunk, input_.threads, [&](std::size_t begin, std::size_t end, int) {
            auto& part = parts[begin / kChunk];
            for (std::size_t i = begin; i < end; ++i) {
                const std::size_t before = part.size();
                facets_of(input_, cells_, nodes, single_in_region_, in_regions_, list[i], part);
                counts[i] = static_cast<std::uint32_t>(part.size() - before);
            }
        });
        FacetBlock& out = mesh_.facets;
        std::size_t cnio = 0;
        std::size_t in_part = 0;
        for (std::uint32_t i = 0; i < nio_count(); ++i) {
            const SnioLeaf& leaf = input_.classification.leaves[i];
            for (std::uint32_t k = facet_offsets_[i]; k < facet_offsets_[i + 1]; ++k) {
                out.nodes.insert(out.nodes.end(), snio_facet_nodes_.begin() + 4 * std::ptrdiff_t{k},
                                 snio_facet_nodes_.begin() + 4 * std::ptrdiff_t{k} + 4);
                out.surface.push_back(leaf.surface);
                out.inside.push_back(leaf.region);
                out.outside.push_back(0);
            }
            if (leaf.pattern != kPatternCnio) continue;
            if (cnio % kChunk == 0) in_part = 0;
            const auto& part = parts[cnio / kChunk];
            for (std::uint32_t k = 0; k < counts[cnio]; ++k) {
                const AssembledFacet& facet = part[in_part++];
                out.nodes.insert(out.nodes.end(), facet.node.begin(), facet.node.end());
                out.surface.push_back(facet.surface);
                out.inside.push_back(facet.inside);
                out.outside.push_back(facet.outside);
            }
            ++cnio;
        }
    }

    device::Device& device_;
    const Input& input_;
    CnioCells cells_;
    std::uint16_t single_in_region_ = 1;
    std::vector<std::uint16_t> in_regions_;
    Numbering numbering_;
    ExtraRanks extras_;
    std::array<std::vector<std::uint32_t>, kElementTypes> offsets_;
    std::array<std::uint64_t, kElementTypes> totals_{};
    std::vector<std::uint32_t> facet_offsets_;
    std::uint64_t snio_facets_ = 0;
    std::vector<NodeId> snio_facet_nodes_;
    std::uint64_t nodes_ = 0;
    Buffer used_, owned_, base_, leaves_, offset_buffer_, facet_offset_buffer_, points_, facet_buffer_;
    std::array<Buffer, kElementTypes> connectivity_;
    Mesh mesh_;
};

}  // namespace

Mesh assemble(device::Device& device, const Input& input) { return Assembler(device, input).run(); }

}  // namespace mortise::assembly
