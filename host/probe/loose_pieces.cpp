#include "host/probe/loose_pieces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "host/common/constants.hpp"
#include "host/common/parallel.hpp"
#include "host/common/vec3.hpp"
#include "host/probe/regions.hpp"
#include "host/probe/skin_pieces.hpp"

namespace mortise::probe {
namespace {

/// Of a piece that is looked at. Larger ones are bodies of their own, or torn at places that others tell of.
constexpr std::size_t kMostFacets = 300;
constexpr double kInward = 0.05;      ///< cells, from a facet into its piece
constexpr double kBeyond = 0.5;       ///< cells: chords of round bodies leave out less
constexpr double kStride = 1.0 / 16;  ///< cells, of the walk through the model
/// Of a walk: a pin that samples miss has a few thousand places in half a cell beyond a piece and as many in
/// it. Where there are more, nothing is so thin.
constexpr std::size_t kMostSteps = 6'000;
constexpr int kHalvings = 12;           ///< of a step that crosses two surfaces: films are thicker
constexpr std::size_t kPieceChunk = 8;  ///< pieces
constexpr std::size_t kMostStarts = 4;  ///< facets from which a piece's region is walked through
constexpr double kLongestChord = 3;     ///< cells: chords are not measured beyond

/// The 26 neighbours of a place on a lattice, and it itself in their middle.
constexpr std::size_t kAround = 27;
std::array<int, 3> neighbour(std::size_t k) {
    const int i = static_cast<int>(k);
    return {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
}

enum class Way : std::uint8_t {
    kEnds,    ///< the model's region ends within half a cell of the piece
    kGoesOn,  ///< it goes on beyond
    kThick,   ///< it has so many places that nothing there is thin
    kNone,    ///< the model has none of it at the start
};

/// Walks through the model's region of a piece.
class Walk {
  public:
    Walk(Regions& regions, const SkinPiece& piece, double edge)
        : regions_(regions), piece_(piece), edge_(edge), step_(kStride * edge) {}

    Way from(const Vec3& start) {
        if (!is_there(start)) return Way::kNone;
        start_ = start;
        known_ = {{key({0, 0, 0}), true}};
        std::vector<std::array<int, 3>> open = {{0, 0, 0}};
        std::size_t places = 1;
        while (!open.empty()) {
            const std::array<int, 3> at = open.back();
            open.pop_back();
            for (std::size_t k = 0; k < kAround; ++k) {
                const std::array<int, 3> by = neighbour(k);
                const std::array<int, 3> next = {at[0] + by[0], at[1] + by[1], at[2] + by[2]};
                const auto known = known_.find(key(next));
                if (known != known_.end()) continue;
                const Vec3 x = place(start, next);
                const bool is_in = is_there(x);
                // What is there may be another body, but for the way to it.
                if (is_in && !is_open(place(start, at), x, kHalvings)) continue;
                known_.emplace(key(next), is_in);
                if (!is_in) continue;
                if (is_beyond(x)) return Way::kGoesOn;
                if (++places > kMostSteps) return Way::kThick;
                open.push_back(next);
            }
        }
        return Way::kEnds;
    }

    /// Whether the last walk has come by.
    bool has_passed(const Vec3& x) const {
        std::array<int, 3> at{};
        for (std::size_t j = 0; j < 3; ++j) at[j] = static_cast<int>(std::lround((x[j] - start_[j]) / step_));
        const auto known = known_.find(key(at));
        return known != known_.end() && known->second;
    }

    /// Whether nothing else lies between two places that are there: a film, or a gap, has a surface on either
    /// side, whose signs change.
    bool is_open(const Vec3& a, const Vec3& b, int halvings) const {
        const Vec3 middle = scaled(sum(a, b), 0.5);
        if (!is_there(middle)) return false;
        if (halvings == 0) return true;
        const auto is_half_open = [&](const Vec3& from, const Vec3& to) {
            return regions_.crossings(from, to) < 2 || is_open(from, to, halvings - 1);
        };
        return is_half_open(a, middle) && is_half_open(middle, b);
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
    const SkinPiece& piece_;
    const double edge_;  ///< of the cells there
    const double step_;
    Vec3 start_{};
    std::unordered_map<std::uint64_t, bool> known_;  ///< places of the walk, and those beside it
};

/// What the model has at a piece; `torn` tells more where it goes on beyond it.
Way find_way(Regions& regions, const Skin& skin, const SkinPiece& piece, MissedFeature& torn) {
    const SkinSide& first = piece.sides.front();
    const double edge = octree::Octree::edge_of(regions.leaf_at_point(skin.middle(first.facet)).level);
    const double step = kStride * edge;
    if (piece.volume > static_cast<double>(kMostSteps) * step * step * step) return Way::kThick;
    Walk walk(regions, piece, edge);
    Way way = Way::kNone;
    std::size_t starts = 0;
    for (const SkinSide& side : piece.sides) {
        const Vec3 inward = scaled(skin.normal(side.facet), side.is_inside ? -1 : 1);
        const Vec3 start = sum(skin.middle(side.facet), scaled(inward, kInward * edge));
        if (walk.has_passed(start)) continue;
        const Way here = walk.from(start);
        if (here == Way::kNone) continue;
        way = here;
        if (here == Way::kThick) break;
        if (here == Way::kGoesOn) {
            torn.position = sum(start, scaled(inward, 0.5 * walk.reach(start, inward)));
            torn.thickness = walk.thickness(torn.position);
            break;
        }
        if (++starts == kMostStarts) break;
    }
    return way;
}

/// Whether the facets of a piece go around x: the angles under which it sees them add up to all directions.
bool holds(const Skin& skin, const SkinPiece& piece, const Vec3& x) {
    double angle = 0;
    for (const SkinSide& side : piece.sides) {
        for (std::size_t part = 0; part < skin.triangles(side.facet); ++part) {
            const Triangle t = skin.triangle(side.facet, part);
            std::array<Vec3, 3> to;
            std::array<double, 3> far;
            for (std::size_t k = 0; k < 3; ++k) {
                to[k] = difference(t[k], x);
                far[k] = length(to[k]);
            }
            const double below = far[0] * far[1] * far[2] + dot(to[0], to[1]) * far[2] +
                                 dot(to[1], to[2]) * far[0] + dot(to[2], to[0]) * far[1];
            angle += (side.is_inside ? 2 : -2) * std::atan2(dot(to[0], cross(to[1], to[2])), below);
        }
    }
    return angle > kTurn;  // of 2 turns
}

}  // namespace

std::vector<MissedFeature> find_torn_pieces(const tape::BoundModel& model, const octree::Octree& tree,
                                            const std::vector<double>& points, const FacetBlock& facets,
                                            int threads, std::vector<MissedFeature>& missed) {
    const Skin skin(model, points, facets);
    const std::vector<SkinPiece> pieces = list_small_pieces(skin, facets, points.size() / 3, kMostFacets);
    std::vector<MissedFeature> found(pieces.size());
    std::vector<Way> way(pieces.size(), Way::kNone);
    parallel_chunks(pieces.size(), kPieceChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        Regions regions(model, tree);
        for (std::size_t i = begin; i < end; ++i) way[i] = find_way(regions, skin, pieces[i], found[i]);
    });
    std::vector<MissedFeature> torn;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const SkinPiece& piece = pieces[i];
        const bool is_material = piece.region != 0;
        if (way[i] == Way::kEnds) {
            for (MissedFeature& feature : missed) {
                const Vec3 x = scaled(difference(feature.position, model.origin), 1 / model.side);
                feature.kept |= feature.material == is_material && holds(skin, piece, x);
            }
        }
        if (way[i] != Way::kGoesOn) continue;
        const Vec3 extent = difference(piece.high, piece.low);
        MissedFeature& feature = found[i];
        feature.position = sum(model.origin, scaled(feature.position, model.side));
        feature.thickness *= model.side;
        feature.size = model.side * std::max({extent[0], extent[1], extent[2]});
        feature.material = is_material;
        torn.push_back(feature);
    }
    return torn;
}

}  // namespace mortise::probe
