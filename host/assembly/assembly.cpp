#include "host/assembly/assembly.hpp"

#include <algorithm>
#include <functional>
#include <string>

#include "host/assembly/facets.hpp"
#include "host/assembly/nodes.hpp"
#include "host/assembly/pieces.hpp"
#include "host/common/large_array.hpp"
#include "host/common/parallel.hpp"
#include "host/common/sort_unique.hpp"
#include "host/snio/face_plans.hpp"

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
        : device_(device), input_(input), cells_(input.tree, input.extraction.leaves, input.extraction) {
        find_range();
    }

    Piece run() {
        count_elements();
        number();
        name_foreign_nodes();
        make_room();
        launch_fills();
        place_cnio_nodes();
        place_snapped();
        fill_cnio_elements();
        fill_regions();
        finish_fills();
        fill_facets();
        list_frontier();
        if (input_.arena != nullptr) {
            device_.finish();
            owned_ = Buffer();
            base_ = Buffer();
            input_.arena->owned = std::move(numbering_.owned);
            input_.arena->base = std::move(numbering_.base);
        }
        piece_.mesh = std::move(mesh_);
        return std::move(piece_);
    }

  private:
    /// Words, NIO leaves and IN leaves of the range.
    void find_range() {
        const auto& tree = input_.tree;
        const std::uint64_t cells = std::uint64_t{1} << (3 * tree.level);
        numbering_.range = {std::min(input_.range.begin, cells), std::min(input_.range.end, cells)};
        is_whole_ = numbering_.range.begin == 0 && numbering_.range.end == cells;
        first_word_ = tree.words_below(numbering_.range.begin);
        word_count_ = (is_whole_ ? tree.words() : tree.words_below(numbering_.range.end)) - first_word_;
        nio_begin_ = tree.nio_rank[first_word_];
        nio_end_ = tree.nio_rank[first_word_ + word_count_];
        in_begin_ = tree.in_rank[first_word_];
        in_end_ = tree.in_rank[first_word_ + word_count_];
    }

    bool in_range(std::uint32_t nio) const { return nio >= nio_begin_ && nio < nio_end_; }

    /// Of the range; arrays over leaves hold these only (PieceRange).
    std::size_t nio_count() const { return nio_end_ - nio_begin_; }
    std::size_t meshed_count() const { return in_end_ - in_begin_ + nio_count(); }

    template <class T>
    std::vector<T> of_range(const std::vector<T>& per_nio) const {
        return {per_nio.begin() + static_cast<std::ptrdiff_t>(nio_begin_),
                per_nio.begin() + static_cast<std::ptrdiff_t>(nio_end_)};
    }

    /// Elements of each type before each NIO leaf; IN hexahedra come on top (their rank).
    void count_elements() {
        numbering_.used = input_.classification.used;
        const auto& list = input_.extraction.leaves;
        for (std::size_t t = 0; t < kElementTypes; ++t)
            offsets_[t] = of_range(input_.classification.elements[t]);
        facet_offsets_ = of_range(input_.classification.facets);
        for (std::size_t i = 0; i < list.size(); ++i) {
            const cnio::CellRecord& record = input_.extraction.records[i];
            numbering_.used[list[i]] = record.used | corners_of_facets(input_, cells_, list[i]);
            if (!in_range(list[i])) continue;
            for (std::size_t t = 0; t < kElementTypes; ++t)
                offsets_[t][list[i] - nio_begin_] = record.element_count[t];
        }
        for (std::size_t t = 0; t < kElementTypes; ++t) totals_[t] = scan(offsets_[t], "elements");
        totals_[0] += in_end_ - in_begin_;
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
        extras_ = rank_extras(input_, cells_, numbering_.used);
        const std::size_t meshed = meshed_count();
        used_ = device_.lend(numbering_.used.data(), numbering_.used.size());
        const Buffer extra_counts = device_.lend(extras_.owned_count.data() + nio_begin_, nio_count());
        const auto share = [&](std::vector<std::uint32_t>& values, std::vector<std::uint32_t> Arena::*old,
                               std::size_t count) {
            if (input_.arena != nullptr) take_memory(input_.arena->*old, count, values);
            resize_large(values, count, input_.threads);
            return device_.wrap(values.data(), count * sizeof(std::uint32_t));
        };
        owned_ = share(numbering_.owned, &Arena::owned, meshed);
        base_ = share(numbering_.base, &Arena::base, meshed + 1);
        numbering_.first_rank = static_cast<std::uint32_t>(in_begin_ + nio_begin_);
        launch("own_nodes", word_count_, used_, extra_counts, owned_, base_, piece_range(), first_word());
        nodes_ = device_.exclusive_scan_u32(base_, base_, meshed);
        numbering_.nodes = static_cast<std::uint32_t>(nodes_);
        device_.sync_to_host(owned_);
        device_.sync_to_host(base_);
    }

    void make_room() {
        // The largest arrays, each of which one thread fills with zeros.
        std::vector<std::function<void()>> resizes;
        Mesh none;
        Mesh& old = input_.arena != nullptr ? input_.arena->mesh : none;
        const auto grow = [&](auto& values, auto& old_values, std::size_t count, std::size_t spare = 0) {
            take_memory(old_values, count, values, spare);
            touch_large(values, count, input_.threads, spare);
            resizes.emplace_back([&values, count] { values.resize(count); });
        };
        grow(mesh_.points, old.points, 3 * nodes_, 3 * (nodes_ / kSpareNodes));
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            ElementBlock& block = mesh_.elements[t];
            ElementBlock& old_block = old.elements[t];
            grow(block.nodes, old_block.nodes, totals_[t] * static_cast<std::size_t>(kElementNodes[t]));
            grow(block.region, old_block.region, totals_[t]);
            grow(block.kind, old_block.kind, totals_[t]);
        }
        parallel_chunks(resizes.size(), 1, input_.threads,
                        [&](std::size_t i, std::size_t, int) { resizes[i](); });
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
        const PieceRange range = piece_range();
        foreign_ = device_.upload(numbering_.foreign_grid);
        leaves_ = device_.lend(input_.classification.leaves.data() + nio_begin_, nio_count());
        plans_ = device_.allocate(sizeof(FacePlans));
        device_.upload(plans_, &snio::face_plans(), 1);
        offset_buffer_ =
            device_.allocate(kElementTypes * std::max<std::size_t>(1, stride + 1) * sizeof(std::uint32_t));
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            device_.upload(offset_buffer_, offsets_[t].data(), stride + 1, t * (stride + 1));
        }
        facet_offset_buffer_ = device_.lend(facet_offsets_.data(), facet_offsets_.size());
        launch("place_nodes", word_count_, leaves_, tree.surfaces, tree.ops, owned_, base_, points_, box,
               range, first_word());
        launch("write_hexahedra", word_count_, used_, owned_, base_, offset_buffer_, foreign_,
               connectivity_[0], range, first_word());
        launch("write_templates", stride, tree.nio, plans_, leaves_, used_, owned_, base_, offset_buffer_,
               facet_offset_buffer_, foreign_, connectivity_[0], connectivity_[1], connectivity_[2],
               connectivity_[3], facet_buffer_, range, static_cast<std::uint32_t>(stride + 1));
        // The host adds the certificate's part to the same arrays.
        device_.sync_to_host(points_);
        for (Buffer& buffer : connectivity_) device_.sync_to_host(buffer);
        device_.sync_to_host(facet_buffer_);
    }

    void finish_fills() {
        device_.finish();  // a piece without nodes has waited for nothing, and its arrays are the host's
        points_ = Buffer();
        for (Buffer& buffer : connectivity_) buffer = Buffer();
        facet_buffer_ = Buffer();
    }

    template <class... Arguments>
    void launch(const char* entry, std::size_t items, const Arguments&... arguments) {
        octree::launch_on(device_, input_.on_device, device_.kernel("assembly/number.cl", entry), items,
                          arguments...);
    }
    std::uint32_t first_word() const { return static_cast<std::uint32_t>(first_word_); }
    PieceRange piece_range() const {
        return {numbering_.range.begin,
                numbering_.range.end,
                numbering_.nodes,
                static_cast<std::uint32_t>(numbering_.foreign_grid.size()),
                static_cast<std::uint32_t>(in_begin_),
                static_cast<std::uint32_t>(nio_begin_)};
    }

    /// Calls work(leaf, record) for the range's CNIO leaves on all threads.
    template <class Work>
    void for_each_cnio(const Work& work) {
        const auto& list = input_.extraction.leaves;
        parallel_chunks(list.size(), kChunk, input_.threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i) {
                if (in_range(list[i])) work(list[i], input_.extraction.records[i]);
            }
        });
    }

    NodeLookup lookup() const { return {input_.tree, cells_, extras_, numbering_}; }

    void store_point(NodeId id, double x, double y, double z) {
        const Vec3 local = {x, y, z};
        for (std::size_t j = 0; j < 3; ++j)
            mesh_.points[3 * std::size_t{id} + j] =
                model_coordinate(input_.model.origin[j], input_.model.side, local[j]);
    }

    /// Owned roots and extra nodes of CNIO leaves; their owned grid vertices come from the device.
    void place_cnio_nodes() {
        const NodeLookup nodes = lookup();
        const double unit = std::ldexp(1.0, -(input_.tree.level + kCellUnitBits));
        for_each_cnio([&](std::uint32_t nio, const cnio::CellRecord& record) {
            const cnio::CellArena& arena = cells_.arena(record);
            const std::uint64_t morton = input_.tree.nio[nio].morton;
            const std::uint32_t rank = nodes.rank_of(morton);
            const std::uint32_t owned = numbering_.owned[rank];
            const int level = input_.tree.level_of(morton);
            const double cell = octree::Octree::edge_of(level);
            const int depth = input_.tree.level - level;
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
                            ((gather_bits(morton) >> depth) + offset[0]) * cell,
                            ((gather_bits(morton >> 1) >> depth) + offset[1]) * cell,
                            ((gather_bits(morton >> 2) >> depth) + offset[2]) * cell);
            }
            for (std::uint32_t k = 0; k < record.extra_count; ++k) {
                const std::uint32_t extra = extras_.rank[record.arena][record.first_extra + k];
                if (extra == ExtraRanks::kNotOwned) continue;
                const cnio::NodeKey& key = arena.extras[record.first_extra + k];
                const cnio::LatticePoint& move = arena.extra_moves[record.first_extra + k];
                store_point(nodes.first_extra(nio) + extra, static_cast<double>(key.x + move[0]) * unit,
                            static_cast<double>(key.y + move[1]) * unit,
                            static_cast<double>(key.z + move[2]) * unit);
            }
        });
    }

    /// Grid vertices that snap beside complex leaves, over what the device has written.
    void place_snapped() {
        const Tree tree = input_.tree.view();
        for (const octree::SnappedVertex& vertex : input_.tree.snapped) {
            u32 bit = 0;
            const u64 owner =
                vertex_owner(&tree, numbering_.used.data(), gather_bits(vertex.code),
                             gather_bits(vertex.code >> 1), gather_bits(vertex.code >> 2), &bit);
            if (owner == kNoOwner || !numbering_.range.holds(owner)) continue;
            const auto at = vertex.target(input_.tree.finest_edge());
            store_point(lookup().owned_node(owner, bit), at[0], at[1], at[2]);
        }
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
            const std::size_t before = input_.tree.in_index(input_.tree.nio[nio].morton) - in_begin_;
            const auto kind = static_cast<std::uint8_t>(record.is_transition ? ElementKind::kTransition
                                                                             : ElementKind::kCnio);
            for (std::size_t t = 0; t < kElementTypes; ++t) {
                const auto size = static_cast<std::size_t>(kElementNodes[t]);
                const std::size_t first = offsets_[t][nio - nio_begin_] + (t == 0 ? before : 0);
                ElementBlock& block = mesh_.elements[t];
                for (std::size_t k = 0; k < record.element_count[t]; ++k) {
                    for (std::size_t j = 0; j < size; ++j) {
                        block.nodes[(first + k) * size + j] =
                            ids[arena.nodes[t][(record.first_element[t] + k) * size + j]];
                    }
                    block.region[first + k] = arena.regions[t][record.first_element[t] + k];
                    block.kind[first + k] = kind;
                }
            }
        });
    }

    /// Regions and kinds of IN and SNIO elements.
    void fill_regions() {
        const auto& tree = input_.tree;
        ElementBlock& hexahedra = mesh_.elements[0];
        std::size_t next = 0;
        auto in = static_cast<std::uint32_t>(in_begin_);
        const auto fill_in = [&](std::size_t until) {
            while (next < until) {
                const octree::InRegions::Run run = input_.in_regions.run(in);
                const std::size_t count = std::min<std::size_t>(until - next, run.end - in);
                const auto at = static_cast<std::ptrdiff_t>(next);
                std::fill_n(hexahedra.region.begin() + at, count, run.region);
                std::fill_n(hexahedra.kind.begin() + at, count, static_cast<std::uint8_t>(ElementKind::kIn));
                next += count;
                in += static_cast<std::uint32_t>(count);
            }
        };
        for (std::size_t i = 0; i < nio_count(); ++i) {
            const TreeNode& node = tree.nio[nio_begin_ + i];
            const SnioLeaf& leaf = input_.classification.leaves[nio_begin_ + i];
            const bool is_snio = leaf.pattern != kPatternCnio;
            const std::size_t hexahedra_here = offsets_[0][i + 1] - offsets_[0][i];
            if (hexahedra_here > 0) {
                fill_in(tree.in_index(node.morton) - in_begin_ + offsets_[0][i]);
                next += hexahedra_here;
            }
            if (!is_snio) continue;
            // IN leaves that were promoted for nothing are what they were.
            const bool is_in = node.tape_length == 0 && (leaf.displaced | leaf.snapped) == 0;
            const auto kind = static_cast<std::uint8_t>(is_in ? ElementKind::kIn : ElementKind::kSnio);
            for (std::size_t t = 0; t < kElementTypes; ++t) {
                const std::size_t begin =
                    offsets_[t][i] +
                    (t == 0 && hexahedra_here > 0 ? next - hexahedra_here - offsets_[0][i] : 0);
                for (std::size_t k = 0; k < offsets_[t][i + 1] - offsets_[t][i]; ++k) {
                    mesh_.elements[t].region[begin + k] = leaf.region;
                    mesh_.elements[t].kind[begin + k] = kind;
                }
            }
        }
        fill_in(hexahedra.size());
    }

    /// Facets of templates and of the certificate's cells, by leaf in Morton order.
    void fill_facets() {
        const NodeLookup nodes = lookup();
        const auto& list = input_.extraction.leaves;
        std::vector<std::vector<AssembledFacet>> parts((list.size() + kChunk - 1) / kChunk);
        std::vector<std::uint32_t> counts(list.size());
        parallel_chunks(list.size(), kChunk, input_.threads, [&](std::size_t begin, std::size_t end, int) {
            auto& part = parts[begin / kChunk];
            for (std::size_t i = begin; i < end; ++i) {
                if (!in_range(list[i])) continue;
                const std::size_t before = part.size();
                facets_of(input_, cells_, nodes, list[i], part);
                counts[i] = static_cast<std::uint32_t>(part.size() - before);
            }
        });
        FacetBlock& out = mesh_.facets;
        auto cnio =
            static_cast<std::size_t>(std::lower_bound(list.begin(), list.end(), nio_begin_) - list.begin());
        std::size_t in_part = 0;  // leaves of the ring before the range left nothing in their parts
        for (std::size_t i = 0; i < nio_count(); ++i) {
            const SnioLeaf& leaf = input_.classification.leaves[nio_begin_ + i];
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

    /// Nodes that elements or facets of the range use but other leaves own.
    void name_foreign_nodes() {
        if (is_whole_) return;
        border_ = border_leaves(input_.tree, numbering_.range, input_.threads);
        const auto& tree = input_.tree;
        const NodeLookup nodes = lookup();
        auto& grid = numbering_.foreign_grid;
        const auto add_grid = [&](std::uint64_t morton, std::uint16_t code) {
            std::uint64_t owner = 0;
            std::uint32_t bit = 0;
            if (nodes.grid_owner(morton, code, &owner, &bit) && !numbering_.range.holds(owner)) {
                grid.push_back(node_key(owner, bit));
            }
        };
        for (const std::uint64_t morton : border_) {
            const bool is_nio = tree.is_nio(morton);
            const std::uint32_t nio = is_nio ? tree.nio_index(morton) : 0;
            const std::uint32_t mask = is_nio ? numbering_.used[nio] : 0xffu;
            for (std::uint16_t code = 0; code < kInteriorNodeBit; ++code) {
                if (((mask >> code) & 1) != 0) add_grid(morton, code);
            }
            if (!is_nio) continue;
            const cnio::CellRecord* record = cells_.record(nio);
            if (record == nullptr) continue;
            for (std::uint32_t k = 0; k < record->extra_count; ++k) {
                const CnioCells::Owner owner = cells_.owner(nio, k, numbering_.used);
                if (owner.grid != kNoOwner) {
                    if (!numbering_.range.holds(owner.grid)) grid.push_back(node_key(owner.grid, owner.bit));
                } else if (!in_range(owner.nio)) {
                    numbering_.foreign_extras.push_back({owner.nio, owner.place});
                }
            }
        }
        sort_unique(grid);
        auto& extras = numbering_.foreign_extras;
        std::sort(extras.begin(), extras.end());
        extras.erase(std::unique(extras.begin(), extras.end(),
                                 [](const ExtraName& a, const ExtraName& b) { return !(a < b) && !(b < a); }),
                     extras.end());
    }

    /// Own nodes of leaves at the border: what other pieces may name.
    void list_frontier() {
        piece_.foreign_grid = numbering_.foreign_grid;
        piece_.foreign_extras = numbering_.foreign_extras;
        if (is_whole_) return;
        const NodeLookup nodes = lookup();
        for (const std::uint64_t morton : border_) {
            const std::uint32_t rank = nodes.rank_of(morton);
            const std::uint32_t owned = numbering_.owned[rank];
            for (u32 bit = 0; bit < kInteriorNodeBit; ++bit) {
                if (((owned >> bit) & 1) == 0) continue;
                piece_.grid_frontier.push_back(
                    {node_key(morton, bit), numbering_.base[rank] + mask_rank(owned, bit)});
            }
            if (!input_.tree.is_nio(morton)) continue;
            const std::uint32_t nio = input_.tree.nio_index(morton);
            const cnio::CellRecord* record = cells_.record(nio);
            if (record == nullptr) continue;
            for (std::uint32_t k = 0; k < record->extra_count; ++k) {
                const std::uint32_t extra = extras_.rank[record->arena][record->first_extra + k];
                if (extra == ExtraRanks::kNotOwned) continue;
                piece_.extra_frontier.push_back({{nio, k}, nodes.first_extra(nio) + extra});
            }
        }
    }

    device::Device& device_;
    const Input& input_;
    Piece piece_;
    bool is_whole_ = true;
    std::size_t first_word_ = 0, word_count_ = 0, nio_begin_ = 0, nio_end_ = 0, in_begin_ = 0, in_end_ = 0;
    std::vector<std::uint64_t> border_;  ///< codes of leaves that touch others outside the range
    Buffer foreign_;
    CnioCells cells_;
    Numbering numbering_;
    ExtraRanks extras_;
    std::array<std::vector<std::uint32_t>, kElementTypes> offsets_;
    std::array<std::uint64_t, kElementTypes> totals_{};
    std::vector<std::uint32_t> facet_offsets_;
    std::uint64_t snio_facets_ = 0;
    std::vector<NodeId> snio_facet_nodes_;
    std::uint64_t nodes_ = 0;
    Buffer used_, owned_, base_, leaves_, plans_, offset_buffer_, facet_offset_buffer_, points_,
        facet_buffer_;
    std::array<Buffer, kElementTypes> connectivity_;
    Mesh mesh_;
    const device::KernelsEnd kernels_end_{device_};  ///< goes first: kernels write into the arrays above
};

}  // namespace

Piece assemble(device::Device& device, const Input& input) { return Assembler(device, input).run(); }

}  // namespace mortise::assembly
