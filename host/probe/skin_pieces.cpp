#include "host/probe/skin_pieces.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "host/common/disjoint_sets.hpp"
#include "host/common/index_set.hpp"
#include "host/common/vec3.hpp"

namespace mortise::probe {
namespace {

/// Numbers for the regions at each node: sides of facets belong together that share one.
class Corners {
  public:
    Corners(const FacetBlock& facets, std::size_t nodes) : nodes_(nodes) {
        for (const NodeId node : facets.nodes) nodes_.insert(node);
        nodes_.number();
        usual_.assign(kUsual * nodes_.size(), kNone);
        for (std::size_t f = 0; f < facets.size(); ++f) {
            for (const NodeId node : facets.facet(f)) {
                add(node, facets.inside[f]);
                add(node, facets.outside[f]);
            }
        }
    }

    std::size_t size() const { return usual_.size() + others_.size(); }

    std::uint32_t number(NodeId node, std::uint16_t region) const {
        const std::size_t first = kUsual * nodes_.place(node);
        for (std::size_t k = first; k < first + kUsual; ++k) {
            if (usual_[k] == region) return static_cast<std::uint32_t>(k);
        }
        return others_.find({node, region})->second;
    }

  private:
    static constexpr std::size_t kUsual = 2;  ///< regions at nearly all nodes
    static constexpr std::uint16_t kNone = 0xffff;

    void add(NodeId node, std::uint16_t region) {
        const std::size_t first = kUsual * nodes_.place(node);
        for (std::size_t k = first; k < first + kUsual; ++k) {
            if (usual_[k] == kNone) usual_[k] = region;
            if (usual_[k] == region) return;
        }
        others_.emplace(std::pair(node, region), static_cast<std::uint32_t>(usual_.size() + others_.size()));
    }

    IndexSet nodes_;
    std::vector<std::uint16_t> usual_;
    std::map<std::pair<NodeId, std::uint16_t>, std::uint32_t> others_;
};

/// Leaves out what has no volume of its own, and of each region without a large piece the largest: that is
/// its body.
void drop_main_pieces(const std::vector<std::uint8_t>& has_large, std::vector<SkinPiece>& pieces) {
    std::map<std::uint16_t, std::size_t> main;  // by region
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const std::uint16_t region = pieces[i].region;
        if (region == 0 || has_large[region] != 0) continue;
        const auto [largest, is_first] = main.emplace(region, i);
        if (!is_first && pieces[i].volume > pieces[largest->second].volume) largest->second = i;
    }
    for (const auto& [region, i] : main) pieces[i].volume = 0;
    pieces.erase(
        std::remove_if(pieces.begin(), pieces.end(), [](const SkinPiece& p) { return !(p.volume > 0); }),
        pieces.end());
}

}  // namespace

std::vector<SkinPiece> list_small_pieces(const Skin& skin, const FacetBlock& facets, std::size_t nodes,
                                         std::size_t most) {
    const Corners corners(facets, nodes);
    DisjointSets sets(corners.size());
    const auto for_sides = [&](const auto& visit) {
        for (std::uint32_t f = 0; f < facets.size(); ++f) {
            visit(SkinSide{f, true}, facets.inside[f]);
            visit(SkinSide{f, false}, facets.outside[f]);
        }
    };
    for_sides([&](const SkinSide& side, std::uint16_t region) {
        const FacetNodes nodes_of = facets.facet(side.facet);
        const std::uint32_t first = corners.number(nodes_of[0], region);
        for (std::size_t k = 1; k < nodes_of.size(); ++k)
            sets.join(first, corners.number(nodes_of[k], region));
    });
    std::vector<std::uint32_t> count(sets.size(), 0);
    const auto piece_of = [&](const SkinSide& side, std::uint16_t region) {
        return sets.find(corners.number(facets.facet(side.facet)[0], region));
    };
    for_sides([&](const SkinSide& side, std::uint16_t region) { ++count[piece_of(side, region)]; });
    std::map<std::uint32_t, std::size_t> place;
    std::vector<SkinPiece> pieces;
    std::vector<std::uint8_t> has_large(std::numeric_limits<std::uint16_t>::max() + std::size_t{1}, 0);
    constexpr double kFar = std::numeric_limits<double>::infinity();
    for_sides([&](const SkinSide& side, std::uint16_t region) {
        const std::uint32_t number = piece_of(side, region);
        if (count[number] > most) {
            has_large[region] = 1;
            return;
        }
        const auto [at, is_new] = place.emplace(number, pieces.size());
        if (is_new) pieces.push_back({region, 0, {kFar, kFar, kFar}, {-kFar, -kFar, -kFar}, {}});
        SkinPiece& piece = pieces[at->second];
        piece.sides.push_back(side);
        for (std::size_t part = 0; part < skin.triangles(side.facet); ++part) {
            const Triangle t = skin.triangle(side.facet, part);
            piece.volume += (side.is_inside ? 1 : -1) * dot(t[0], cross(t[1], t[2])) / 6;
            for (const Vec3& corner : t) {
                for (std::size_t j = 0; j < 3; ++j) {
                    piece.low[j] = std::min(piece.low[j], corner[j]);
                    piece.high[j] = std::max(piece.high[j], corner[j]);
                }
            }
        }
    });
    drop_main_pieces(has_large, pieces);
    return pieces;
}

}  // namespace mortise::probe
