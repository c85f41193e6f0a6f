#include "host/probe/loose_pieces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_set>
#include <utility>

#include "host/common/disjoint_sets.hpp"
#include "host/common/index_set.hpp"
#include "host/common/parallel.hpp"
#include "host/common/vec3.hpp"
#include "host/probe/regions.hpp"
#include "host/probe/skin.hpp"

namespace mortise::probe {
namespace {

/// Of a piece that is looked at. Larger ones are bodies of their own, or torn at places that others tell of.
constexpr std::size_t kMostFacets = 300;
constexpr double kInward = 0.05;      ///< cells, from a facet into its piece
constexpr double kBeyond = 0.5;       ///< cells: chords of round bodies leave out less
constexpr double kStride = 1.0 / 16;  ///< cells, of the walk through the model
constexpr std::size_t kMostSteps = 200'000;
constexpr std::size_t kMostStarts = 4;  ///< facets from which a piece's region is walked through
constexpr double kLongestChord = 3;     ///< cells: chords are not measured beyond

/// The 26 neighbours of a place on a lattice, and it itself in their middle.
constexpr std::size_t kAround = 27;
std::array<int, 3> neighbour(std::size_t k) {
    const int i = static_cast<int>(k);
    return {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
}

/// A facet seen from one of its two sides.
struct Side {
    std::uint32_t facet;
    bool is_inside;
};

struct Piece {
    std::uint16_t region = 0;
    double volume = 0;  ///< of the root box; negative for what lies around others
    Vec3 low{}, high{};
    std::vector<Side> sides;
};

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

/// Pieces of few facets with a volume, by their first facet.
std::vector<Piece> list_pieces(const Skin& skin, const FacetBlock& facets, std::size_t nodes) {
    const Corners corners(facets, nodes);
    DisjointSets sets(corners.size());
    const auto for_sides = [&](const auto& visit) {
        for (std::uint32_t f = 0; f < facets.size(); ++f) {
            visit(Side{f, true}, facets.inside[f]);
            visit(Side{f, false}, facets.outside[f]);
        }
    };
    for_sides([&](const Side& side, std::uint16_t region) {
        const FacetNodes nodes_of = facets.facet(side.facet);
        const std::uint32_t first = corners.number(nodes_of[0], region);
        for (std::size_t k = 1; k < nodes_of.size(); ++k)
            sets.join(first, corners.number(nodes_of[k], region));
    });
    std::vector<std::uint32_t> count(sets.size(), 0);
    const auto piece_of = [&](const Side& side, std::uint16_t region) {
        return sets.find(corners.number(facets.facet(side.facet)[0], region));
    };
    for_sides([&](const Side& side, std::uint16_t region) { ++count[piece_of(side, region)]; });
    std::map<std::uint32_t, std::size_t> place;
    std::vector<Piece> pieces;
    constexpr double kFar = std::numeric_limits<double>::infinity();
    for_sides([&](const Side& side, std::uint16_t region) {
        const std::uint32_t number = piece_of(side, region);
        if (count[number] > kMostFacets) return;
        const auto [at, is_new] = place.emplace(number, pieces.size());
        if (is_new) pieces.push_back({region, 0, {kFar, kFar, kFar}, {-kFar, -kFar, -kFar}, {}});
        Piece& piece = pieces[at->second];
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
    pieces.erase(std::remove_if(pieces.begin(), pieces.end(), [](const Piece& p) { return !(p.volume > 0); }),
                 pieces.end());
    return pieces;
}

/// Walks through the model's region of a piece.
class Walk {
  public:
    Walk(Regions& regions, const Piece& piece, double edge)
        : regions_(regions), piece_(piece), edge_(edge), step_(kStride * edge) {}

    /// Whether the region goes on from here beyond the piece.
    bool goes_on(const Vec3& start) {
        std::unordered_set<std::uint64_t> seen = {key({0, 0, 0})};
        std::vector<std::array<int, 3>> open = {{0, 0, 0}};
        while (!open.empty() && seen.size() < kMostSteps) {
            const std::array<int, 3> at = open.back();
            open.pop_back();
            for (std::size_t k = 0; k < kAround; ++k) {
                const std::array<int, 3> by = neighbour(k);
                const std::array<int, 3> next = {at[0] + by[0], at[1] + by[1], at[2] + by[2]};
                if (seen.count(key(next)) != 0) continue;
                const Vec3 x = place(start, next);
                // What is there may be another body, but for the way to it.
                if (!is_there(x) || !is_there(scaled(sum(place(start, at), x), 0.5))) continue;
                seen.insert(key(next));
                if (is_beyond(x)) return true;
                open.push_back(next);
            }
        }
        return false;
    }

    bool is_there(const Vec3& x) const {
        const bool is_in_root = std::all_of(x.begin(), x.end(), [](double v) { return v >= 0 && v < 1; });
        return (is_in_root ? regions_.at(x) : 0) == piece_.region;
    }

    /// How far the region goes from x, at most kLongestChord cells.
    double reach(const Vec3& x, const Vec3& along) const {
        int n = 1;
        while (n * step_ < kLongestChord * edge_ && is_there(sum(x, scaled(along, n * step_)))) ++n;
        return (n - 0.5) * step_;
    }

    /// The shortest way through the region that x is on.
    double thickness(const Vec3& x) const {
        double least = 2 * kLongestChord * edge_;
        for (std::size_t k = kAround / 2 + 1; k < kAround; ++k) {
            const std::array<int, 3> d = neighbour(k);
            const Vec3 along = unit({double(d[0]), double(d[1]), double(d[2])});
            least = std::min(least, reach(x, along) + reach(x, scaled(along, -1)));
        }
        return least;
    }

  private:
    static std::uint64_t key(const std::array<int, 3>& at) {
        constexpr int kBits = 21;
        std::uint64_t key = 0;
        for (const int v : at) key = key << kBits | static_cast<std::uint64_t>(v + (1 << (kBits - 1)));
        return key;
    }
    Vec3 place(const Vec3& start, const std::array<int, 3>& at) const {
        return {start[0] + at[0] * step_, start[1] + at[1] * step_, start[2] + at[2] * step_};
    }
    bool is_beyond(const Vec3& x) const {
        for (std::size_t j = 0; j < 3; ++j) {
            if (x[j] < piece_.low[j] - kBeyond * edge_ || x[j] > piece_.high[j] + kBeyond * edge_)
                return true;
        }
        return false;
    }

    Regions& regions_;
    const Piece& piece_;
    const double edge_;  ///< of the cells there
    const double step_;
};

/// What the model has at a piece, if it goes on beyond it.
bool find_way_on(Regions& regions, const Skin& skin, const Piece& piece, MissedFeature& torn) {
    const Side& first = piece.sides.front();
    const double edge = octree::Octree::edge_of(regions.leaf_at_point(skin.middle(first.facet)).level);
    Walk walk(regions, piece, edge);
    std::size_t starts = 0;
    for (const Side& side : piece.sides) {
        const Vec3 inward = scaled(skin.normal(side.facet), side.is_inside ? -1 : 1);
        const Vec3 start = sum(skin.middle(side.facet), scaled(inward, kInward * edge));
        if (!walk.is_there(start)) continue;
        if (walk.goes_on(start)) {
            torn.position = sum(start, scaled(inward, 0.5 * walk.reach(start, inward)));
            torn.thickness = walk.thickness(torn.position);
            return true;
        }
        if (++starts == kMostStarts) break;
    }
    return false;
}

}  // namespace

SmallPieces find_small_pieces(const tape::BoundModel& model, const octree::Octree& tree,
                              const std::vector<double>& points, const FacetBlock& facets, int threads) {
    const Skin skin(model, points, facets);
    const std::vector<Piece> pieces = list_pieces(skin, facets, points.size() / 3);
    std::vector<MissedFeature> torn(pieces.size());
    std::vector<std::uint8_t> is_torn(pieces.size());
    parallel_chunks(pieces.size(), 1, threads, [&](std::size_t i, std::size_t, int) {
        Regions regions(model, tree);
        is_torn[i] = find_way_on(regions, skin, pieces[i], torn[i]) ? 1 : 0;
    });
    const auto in_model = [&model](const Vec3& x) { return sum(model.origin, scaled(x, model.side)); };
    SmallPieces result;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const Piece& piece = pieces[i];
        const bool is_material = piece.region != 0;
        if (is_torn[i] == 0) {
            result.sound.push_back({in_model(piece.low), in_model(piece.high), is_material});
            continue;
        }
        const Vec3 extent = difference(piece.high, piece.low);
        torn[i].position = in_model(torn[i].position);
        torn[i].thickness *= model.side;
        torn[i].size = model.side * std::max({extent[0], extent[1], extent[2]});
        torn[i].material = is_material;
        result.torn.push_back(torn[i]);
    }
    return result;
}

}  // namespace mortise::probe
