// Pieces of a mesh: which leaves a range needs, and how pieces become one mesh.
#include "host/assembly/pieces.hpp"

#include <algorithm>

#include "host/common/large_array.hpp"
#include "host/common/parallel.hpp"

namespace mortise::assembly {
namespace {

/// Numbers of a piece's foreign nodes in the merged mesh.
class Resolver {
  public:
    explicit Resolver(const std::vector<Piece>& pieces) : pieces_(pieces) {
        for (const Piece& piece : pieces) {
            first_.push_back(total_);
            total_ += piece.mesh.node_count();
        }
    }

    NodeId first(std::size_t piece) const { return static_cast<NodeId>(first_[piece]); }

    template <class Name>
    NodeId find(const std::vector<std::pair<Name, NodeId>> Piece::*frontier, const Name& name) const {
        for (std::size_t p = 0; p < pieces_.size(); ++p) {
            const auto& list = pieces_[p].*frontier;
            const auto found =
                std::lower_bound(list.begin(), list.end(), name,
                                 [](const auto& entry, const Name& wanted) { return entry.first < wanted; });
            if (found != list.end() && !(name < found->first))
                return static_cast<NodeId>(first_[p] + found->second);
        }
        throw Error(ExitCode::kMeshing,
                    "internal error: a node of another piece is missing; please report the model");
    }

    std::size_t total() const { return total_; }

  private:
    const std::vector<Piece>& pieces_;
    std::vector<std::size_t> first_;
    std::size_t total_ = 0;
};

/// Appends what `change` makes of each value of `from`, whose memory is given back: with room reserved in
/// `to`, both together take no more than the longer.
template <class T, class Change>
void move_to(std::vector<T>& to, std::vector<T>& from, int threads, const Change& change) {
    constexpr std::size_t kValues = 65536;
    const std::size_t before = to.size();
    resize_large(to, before + from.size(), threads);
    parallel_chunks(from.size(), kValues, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) to[before + i] = change(from[i]);
    });
    from = {};
}

/// Words of a block of 4³ cells of a uniform tree.
constexpr std::size_t kBlockWords = 2;
constexpr std::size_t kWordChunk = 256;  ///< words, whole blocks

constexpr std::uint64_t kBlockCells = 32 * kBlockWords;

/// Whether a block of a uniform tree, and all blocks around it, lie in the range (`inside`), or beyond it.
bool is_apart(const Tree& view, const MortonRange& range, std::uint64_t block, bool inside) {
    constexpr u32 kEdge = 4;
    for (int k = 0; k < 27; ++k) {
        const u64 place = code_at(&view, gather_bits(block) + kEdge * static_cast<u32>(k % 3 - 1),
                                  gather_bits(block >> 1) + kEdge * static_cast<u32>(k / 3 % 3 - 1),
                                  gather_bits(block >> 2) + kEdge * static_cast<u32>(k / 9 - 1));
        if (place == kNoOwner) continue;
        const bool is_there = inside ? range.holds(place) && range.holds(place + kBlockCells - 1)
                                     : place + kBlockCells <= range.begin || place >= range.end;
        if (!is_there) return false;
    }
    return true;
}

}  // namespace

bool touches_outside(const octree::Octree& tree, const MortonRange& range, std::uint64_t code) {
    const Tree view = tree.view();
    const bool inside = range.holds(code);
    const int level = leaf_level(&view, code);
    const std::uint64_t cells = std::uint64_t{1} << (3 * (tree.level - level));
    const u32 edge = leaf_edge(&view, level);
    for (int k = 0; k < 27; ++k) {
        const u64 place = code_at(&view, gather_bits(code) + edge * static_cast<u32>(k % 3 - 1),
                                  gather_bits(code >> 1) + edge * static_cast<u32>(k / 3 % 3 - 1),
                                  gather_bits(code >> 2) + edge * static_cast<u32>(k / 9 - 1));
        if (place == kNoOwner) continue;
        if (range.holds(place) != inside || range.holds(place + cells - 1) != inside) return true;
        if (!tree.graded) continue;
        const Leaf leaf = leaf_at(&view, place);
        if (leaf.kind != kLeafNone && range.holds(leaf.code) != inside) return true;
    }
    return false;
}

std::vector<std::uint64_t> border_leaves(const octree::Octree& tree, const MortonRange& range, int threads) {
    const std::size_t first = tree.words_below(range.begin);
    const std::size_t last =
        range.end >= std::uint64_t{1} << (3 * tree.level) ? tree.words() : tree.words_below(range.end);
    const Tree view = tree.view();
    std::vector<std::vector<std::uint64_t>> found(chunk_count(last - first, kWordChunk));
    parallel_chunks(last - first, kWordChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        bool deep = false;
        for (std::size_t word = first + begin; word < first + end; ++word) {
            const std::uint64_t start = tree.code_of_word(word);
            if (!tree.graded && (word % kBlockWords == 0 || word == first + begin))
                deep = is_apart(view, range, start / kBlockCells * kBlockCells, true);
            if (deep) continue;
            for (u32 bits = tree.in_bits[word] | tree.nio_bits[word]; bits != 0; bits &= bits - 1) {
                const std::uint64_t code = start + count_bits((bits & (0u - bits)) - 1);
                if (touches_outside(tree, range, code)) found[begin / kWordChunk].push_back(code);
            }
        }
    });
    std::vector<std::uint64_t> result;
    for (const auto& list : found) result.insert(result.end(), list.begin(), list.end());
    return result;
}

std::vector<std::uint32_t> leaves_needed(const octree::Octree& tree, const std::vector<std::uint32_t>& cnio,
                                         const MortonRange& range) {
    std::vector<std::uint32_t> result;
    const Tree view = tree.view();
    std::uint64_t block = ~std::uint64_t{0};
    bool is_far = false;
    for (const std::uint32_t nio : cnio) {
        const std::uint64_t morton = tree.nio[nio].morton;
        if (!tree.graded && morton / kBlockCells != block) {
            block = morton / kBlockCells;
            is_far = is_apart(view, range, block * kBlockCells, false);
        }
        if (is_far) continue;
        if (range.holds(morton) || touches_outside(tree, range, morton)) result.push_back(nio);
    }
    return result;
}

Mesh merge(std::vector<Piece> pieces, int threads) {
    if (pieces.size() == 1) return std::move(pieces[0].mesh);
    const Resolver resolver(pieces);
    if (resolver.total() > 0xffffffffu) {
        throw Error(ExitCode::kMeshing, "more than 2^32 nodes; use a lower --level");
    }
    Mesh result;
    result.points.reserve(3 * (resolver.total() + resolver.total() / kSpareNodes));
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        std::size_t count = 0;
        for (const Piece& piece : pieces) count += piece.mesh.elements[t].size();
        result.elements[t].nodes.reserve(count * static_cast<std::size_t>(kElementNodes[t]));
        result.elements[t].region.reserve(count);
        result.elements[t].kind.reserve(count);
    }
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        Piece& piece = pieces[p];
        std::vector<NodeId> foreign;
        for (const std::uint64_t key : piece.foreign_grid)
            foreign.push_back(resolver.find(&Piece::grid_frontier, key));
        for (const ExtraName& name : piece.foreign_extras) {
            foreign.push_back(resolver.find(&Piece::extra_frontier, name));
        }
        const auto own = static_cast<NodeId>(piece.mesh.node_count());
        const NodeId first = resolver.first(p);
        const auto same = [](const auto& value) { return value; };
        const auto numbered = [&](NodeId id) { return id < own ? first + id : foreign[id - own]; };
        move_to(result.points, piece.mesh.points, threads, same);
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            move_to(result.elements[t].nodes, piece.mesh.elements[t].nodes, threads, numbered);
            move_to(result.elements[t].region, piece.mesh.elements[t].region, threads, same);
            move_to(result.elements[t].kind, piece.mesh.elements[t].kind, threads, same);
        }
        move_to(result.facets.nodes, piece.mesh.facets.nodes, threads, numbered);
        move_to(result.facets.surface, piece.mesh.facets.surface, threads, same);
        move_to(result.facets.inside, piece.mesh.facets.inside, threads, same);
        move_to(result.facets.outside, piece.mesh.facets.outside, threads, same);
    }
    return result;
}

}  // namespace mortise::assembly
