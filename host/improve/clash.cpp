#include "host/improve/clash.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "host/common/large_array.hpp"
#include "host/common/parallel.hpp"
#include "host/common/parallel_sort.hpp"
#include "host/common/sort_unique.hpp"
#include "host/improve/crossing.hpp"

namespace mortise::improve {
namespace {

constexpr std::size_t kClashChunk = 4096;

/// Nodes are sorted along a direction in which no plane of usual models, nor of the grid, is level.
constexpr Point kAcross = {0.5257, 0.7433, 0.4136};

struct MovedNode {
    double along;
    Point at;
    std::uint32_t block;

    bool operator<(const MovedNode& other) const {
        return std::tie(along, at, block) < std::tie(other.along, other.at, other.block);
    }
};

/// Two blocks that do not go together; the same one twice if it alone is wrong.
using Pair = std::pair<std::uint32_t, std::uint32_t>;

/// Where moved nodes lie along kAcross, as bits that fit into a cache: most nodes are near none, and need no
/// search.
class Strip {
  public:
    /// `moved`, ascending, not empty; `reach`: how far from one is near.
    Strip(const std::vector<MovedNode>& moved, double reach)
        : first_(moved.front().along - reach), last_(moved.back().along + reach) {
        const double most = static_cast<double>(kBitsEach * moved.size());
        // Wider than what is near, so that a node marks two bits at most.
        per_bit_ = 1 / std::max((last_ - first_) / most, 2 * reach);
        bits_.assign(static_cast<std::size_t>((last_ - first_) * per_bit_) / 64 + 1, 0);
        for (const MovedNode& node : moved) {
            for (const double end : {node.along - reach, node.along + reach}) {
                const std::size_t bit = bit_of(end);
                bits_[bit / 64] |= std::uint64_t{1} << (bit % 64);
            }
        }
    }

    /// False only if no moved node is near.
    bool holds(double along) const {
        if (!(along >= first_ && along <= last_)) return false;
        const std::size_t bit = bit_of(along);
        return ((bits_[bit / 64] >> (bit % 64)) & 1) != 0;
    }

  private:
    static constexpr std::size_t kBitsEach = 64;
    std::size_t bit_of(double along) const { return static_cast<std::size_t>((along - first_) * per_bit_); }

    double first_, last_, per_bit_;
    std::vector<std::uint64_t> bits_;
};

void find_coincident(const PassResult& pass, int threads, std::vector<Pair>& clashing) {
    const double same = kSameNode * pass.unit;
    std::vector<MovedNode> moved;
    for (std::size_t n = 0; n < pass.after.size(); ++n) {
        const Point& at = pass.after[n];
        if (at != pass.before[n]) moved.push_back({dot(kAcross, at), at, pass.owner[n]});
    }
    if (moved.empty()) return;
    parallel_sort(moved, threads);
    const Strip strip(moved, 2 * same);
    std::vector<std::vector<Pair>> found(chunk_count(pass.after.size(), kClashChunk));
    parallel_chunks(pass.after.size(), kClashChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t n = begin; n < end; ++n) {
            if (pass.owner[n] == kNone) continue;  // no element has it any more
            const Point& at = pass.after[n];
            const bool moves = at != pass.before[n];
            const double along = dot(kAcross, at);
            if (!strip.holds(along)) continue;
            const double reach = 2 * same;  // kAcross is about 1 long
            const auto first =
                std::lower_bound(moved.begin(), moved.end(), along - reach,
                                 [](const MovedNode& node, double low) { return node.along < low; });
            for (auto m = first; m != moved.end() && m->along <= along + reach; ++m) {
                if (m->block != pass.owner[n] && squared_length(m->at - at) < same * same)
                    found[begin / kClashChunk].push_back({m->block, moves ? pass.owner[n] : m->block});
            }
        }
    });
    for (const auto& list : found) clashing.insert(clashing.end(), list.begin(), list.end());
}

/// A face all of whose nodes other blocks have, too.
struct SharedFace {
    std::array<ZoneNode, 3> node;  ///< ascending
    std::uint32_t block;
    bool even;

    bool operator<(const SharedFace& other) const {
        return std::tie(node, block, even) < std::tie(other.node, other.block, other.even);
    }
};

/// What `list(block, result)` appends for each block, in order.
template <class Value, class List>
std::vector<Value> list_by_block(const PassResult& pass, int threads, const List& list) {
    constexpr std::size_t kBlocks = 16;
    std::vector<std::vector<Value>> found(chunk_count(pass.changed.size(), kBlocks));
    parallel_chunks(pass.changed.size(), kBlocks, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t block = begin; block < end; ++block)
            list(static_cast<std::uint32_t>(block), found[begin / kBlocks]);
    });
    std::vector<Value> all;
    append_lists(found, threads, all);
    return all;
}

/// Shared nodes that changed blocks have: other faces are as they were.
std::vector<std::uint8_t> find_touched(const PassResult& pass) {
    std::vector<std::uint8_t> touched(pass.owner.size(), 0);
    for (std::size_t block = 0; block < pass.changed.size(); ++block) {
        if (pass.changed[block] == 0) continue;
        for (std::size_t i = pass.first[block]; i < pass.first[block + 1]; ++i) {
            for (const ZoneNode n : pass.tetrahedra[i].node) touched[n] = pass.owner[n] >= pass.shared;
        }
    }
    return touched;
}

void find_crowded_faces(const PassResult& pass, int threads, std::vector<Pair>& clashing) {
    const std::vector<std::uint8_t> touched = find_touched(pass);
    std::vector<SharedFace> faces =
        list_by_block<SharedFace>(pass, threads, [&](std::uint32_t block, std::vector<SharedFace>& list) {
            for (std::size_t i = pass.first[block]; i < pass.first[block + 1]; ++i) {
                const Tetrahedron& t = pass.tetrahedra[i];
                for (const auto& o : kOpposite) {
                    std::array<ZoneNode, 3> n = {t.node[o[0]], t.node[o[1]], t.node[o[2]]};
                    if (touched[n[0]] == 0 || touched[n[1]] == 0 || touched[n[2]] == 0) continue;
                    const bool even = sort_three(n);
                    list.push_back({n, block, even});
                }
            }
        });
    parallel_sort(faces, threads);
    for (std::size_t i = 0; i < faces.size();) {
        std::size_t end = i + 1;
        while (end < faces.size() && faces[end].node == faces[i].node) ++end;
        if (end - i > 2 || (end - i == 2 && faces[i].even == faces[i + 1].even)) {
            for (std::size_t k = i + 1; k < end; ++k)
                clashing.push_back({faces[k - 1].block, faces[k].block});
        }
        i = end;
    }
}

struct OuterFacet {
    std::array<ZoneNode, 3> node;
    std::uint32_t block;
};

/// Outer facets within the bounds of another block's, one of the two changed.
std::vector<OuterFacet> facets_near_others(const PassResult& pass, int threads) {
    const std::size_t blocks = pass.changed.size();
    const auto for_facets = [&](std::uint32_t block, const auto& visit) {
        for (std::size_t i = pass.first[block]; i < pass.first[block + 1]; ++i) {
            const Tetrahedron& t = pass.tetrahedra[i];
            for (std::size_t f = 0; f < 4; ++f) {
                if (!is_outer(t.tag[f])) continue;
                const std::array<ZoneNode, 3> n = face_nodes(t, f);
                visit(n, bounds({pass.after[n[0]], pass.after[n[1]], pass.after[n[2]]}));
            }
        }
    };
    const std::vector<Bounds> of_block =
        list_by_block<Bounds>(pass, threads, [&](std::uint32_t block, std::vector<Bounds>& list) {
            list.push_back(kNoBounds);
            for_facets(block, [&](const auto&, const Bounds& at) { list.back().include(at); });
        });
    Bounds all = kNoBounds;
    for (const Bounds& one : of_block) all.include(one);
    FacetGrid grid;
    grid.reset(all, blocks);
    for (std::uint32_t block = 0; block < blocks; ++block) {
        if (of_block[block].low[0] <= of_block[block].high[0]) grid.add(of_block[block], block, 0);
    }
    return list_by_block<OuterFacet>(pass, threads, [&](std::uint32_t block, std::vector<OuterFacet>& list) {
        for_facets(block, [&](const auto& node, const Bounds& at) {
            if (grid.any(at, [&](std::uint32_t other, std::uint32_t) {
                    return other != block && (pass.changed[block] | pass.changed[other]) != 0;
                }))
                list.push_back({node, block});
        });
    });
}

/// Those of one block have been looked at with the block. Of two, one that has moved is wrong if the other
/// has not.
void find_crossing(const PassResult& pass, int threads, std::vector<Pair>& clashing) {
    const std::vector<OuterFacet> facets = facets_near_others(pass, threads);
    const auto triangle = [&](const OuterFacet& f) -> Triangle {
        return {pass.after[f.node[0]], pass.after[f.node[1]], pass.after[f.node[2]]};
    };
    Bounds all = kNoBounds;
    for (const OuterFacet& facet : facets) all.include(bounds(triangle(facet)));
    const auto moves = [&](const OuterFacet& f) {
        return std::any_of(f.node.begin(), f.node.end(),
                           [&](ZoneNode n) { return pass.after[n] != pass.before[n]; });
    };
    FacetGrid grid;
    grid.reset(all, facets.size());
    for (std::uint32_t f = 0; f < facets.size(); ++f) grid.add(bounds(triangle(facets[f])), f, 0);
    const double depth = kCrossingDepth * pass.unit;
    std::vector<std::vector<Pair>> found(chunk_count(facets.size(), kClashChunk));
    parallel_chunks(facets.size(), kClashChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t f = begin; f < end; ++f) {
            const OuterFacet& facet = facets[f];
            if (pass.changed[facet.block] == 0) continue;
            const Triangle at = triangle(facet);
            grid.any(bounds(at), [&](std::uint32_t g, std::uint32_t) {
                const OuterFacet& other = facets[g];
                if (other.block == facet.block || common_nodes(facet.node, other.node) > 1) return false;
                const Triangle there = triangle(other);
                if (!stabs(at, there, depth) && !stabs(there, at, depth)) return false;
                const bool only_this = moves(facet) && !moves(other);
                const bool only_other = !moves(facet) && moves(other);
                found[begin / kClashChunk].push_back(
                    {only_other ? other.block : facet.block, only_this ? facet.block : other.block});
                return false;
            });
        }
    });
    for (const auto& list : found) clashing.insert(clashing.end(), list.begin(), list.end());
}

}  // namespace

std::vector<std::uint32_t> find_clashes(const PassResult& pass, int threads) {
    std::vector<Pair> clashing;
    find_coincident(pass, threads, clashing);
    find_crowded_faces(pass, threads, clashing);
    find_crossing(pass, threads, clashing);
    for (Pair& pair : clashing) {
        if (pair.second < pair.first) std::swap(pair.first, pair.second);
    }
    sort_unique(clashing);
    const auto is_changed = [&](std::uint32_t block) {
        return block < pass.changed.size() && pass.changed[block] != 0;
    };
    // Whether one goes back depends on its own pairs alone: what is far away is not there in a part of a
    // mesh.
    std::vector<std::uint32_t> back;
    for (const Pair& pair : clashing) {
        if (is_changed(pair.second))
            back.push_back(pair.second);
        else if (is_changed(pair.first))
            back.push_back(pair.first);
    }
    sort_unique(back);
    return back;
}

}  // namespace mortise::improve
