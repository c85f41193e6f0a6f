#include "host/probe/probe.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>

#include "host/common/disjoint_sets.hpp"
#include "host/common/parallel.hpp"
#include "host/common/sort_unique.hpp"
#include "host/probe/leaf.hpp"
#include "host/probe/regions.hpp"
#include "kernels/shared/surface.h"

namespace mortise::probe {
namespace {

/// A part that reaches no further than this from what is meshed, in pieces, is how a mesh approximates a
/// curved surface; no feature is lost.
constexpr int kShallow = kSide / 4;

/// Bases of a cap are one where their pieces lie within so many pieces: its rim is rough.
constexpr std::int32_t kBesides = 2;

/// The same for a groove's tip, of whose surface so much touches what is meshed, by pieces there for each
/// face of a piece at its surface.
constexpr int kShallowGroove = kSide / 2;
constexpr double kLeastOpen = 0.25;

constexpr std::size_t kChunk = 256;

/// Nothing thinner than this, in cells, is a feature: signs are known to kSignTolerance only.
constexpr double kThinnest = 8 * kSignTolerance;

/// Pieces on a face of the leaf, and where they continue in the next leaf.
bool on_face(std::uint16_t piece, int f) {
    const int at = (piece >> (kDepth * (f / 2))) & (kSide - 1);
    return at == ((f & 1) != 0 ? kSide - 1 : 0);
}
std::uint16_t across(std::uint16_t piece, int f) {
    return static_cast<std::uint16_t>(piece ^ ((kSide - 1) << (kDepth * (f / 2))));
}

bool holds(const Component& component, std::uint16_t piece) {
    return std::binary_search(component.pieces.begin(), component.pieces.end(), piece);
}

/// Joins the components of all leaves into features.
class Clusters {
  public:
    Clusters(const tape::BoundModel& model, const octree::Octree& tree, std::vector<Component> components)
        : model_(model),
          tree_(tree),
          regions_(model, tree),
          components_(std::move(components)),
          sets_(components_.size()),
          joined_(components_.size()) {}

    void run(Probe& out) {
        for (std::size_t i = 0; i < components_.size(); ++i) {
            for (int f = 0; f < 6; ++f) look_across(i, f);
        }
        std::vector<std::vector<std::size_t>> members(components_.size());
        for (std::size_t i = 0; i < components_.size(); ++i)
            members[sets_.find(static_cast<std::uint32_t>(i))].push_back(i);
        for (const auto& cluster : members) {
            if (!cluster.empty()) report(cluster, out);
        }
        std::sort(out.features.begin(), out.features.end(),
                  [](const MissedFeature& a, const MissedFeature& b) {
                      return a.size != b.size ? a.size > b.size : a.position < b.position;
                  });
        std::sort(out.apexes.begin(), out.apexes.end(),
                  [](const Apex& a, const Apex& b) { return a.morton < b.morton; });
        std::sort(out.leaves.begin(), out.leaves.end());
    }

  private:
    Vec3 corner(const Component& component) const {
        Vec3 x{};
        for (int j = 0; j < 3; ++j) {
            x[static_cast<std::size_t>(j)] =
                gather_bits(tree_.nio[component.leaf].morton >> j) * tree_.finest_edge();
        }
        return x;
    }

    double edge(const Component& component) const {
        return octree::Octree::edge_of(tree_.level_of(tree_.nio[component.leaf].morton));
    }

    /// Where a component goes on beyond face f of its leaf: in components of the next leaf, or in what that
    /// leaf meshes rightly.
    void look_across(std::size_t i, int f) {
        Component& component = components_[i];
        const auto touches = [f](std::uint16_t piece) { return on_face(piece, f); };
        if (std::none_of(component.pieces.begin(), component.pieces.end(), touches)) return;
        const std::uint64_t own = tree_.nio[component.leaf].morton;
        const Tree tree = tree_.view();
        const int level = leaf_level(&tree, own);
        const double size = octree::Octree::edge_of(level);
        i32 direction[3] = {0, 0, 0};
        direction[f / 2] = (f & 1) != 0 ? 1 : -1;
        const Leaf beyond = leaf_beside(&tree, own, level, direction);
        if (beyond.code == kNoOwner) return;
        // A larger leaf, or smaller ones of which this is the first, may be joined only where it is meshed.
        const bool alike = beyond.level == level;
        const bool nio = beyond.kind == kLeafNio;
        const std::uint32_t leaf = beyond.index;
        Vec3 low = corner(component);
        low[static_cast<std::size_t>(f / 2)] += direction[f / 2] * size;
        const auto begin = std::lower_bound(components_.begin(), components_.end(), leaf,
                                            [](const Component& c, std::uint32_t l) { return c.leaf < l; });
        for (const std::uint16_t piece : component.pieces) {
            if (!touches(piece)) continue;
            if (!nio) {
                if ((beyond.kind == kLeafIn) == (component.region != 0)) component.open.push_back(piece);
                continue;
            }
            const std::uint16_t next = across(piece, f);
            bool missed = false;
            for (auto c = begin; alike && c != components_.end() && c->leaf == leaf; ++c) {
                if (!holds(*c, next)) continue;
                missed = true;
                if (c->region != component.region) continue;
                const auto k = static_cast<std::size_t>(c - components_.begin());
                sets_.join(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(k));
                joined_[i].push_back({piece, k, next});
            }
            if (!missed && regions_.at(middle(low, size, next)) == component.region)
                component.open.push_back(piece);
        }
        component.attached = component.attached || !component.open.empty();
    }

    /// Middle of a piece of the leaf with this corner and edge.
    static Vec3 middle(const Vec3& low, double size, std::uint16_t piece) {
        Vec3 x{};
        for (std::size_t j = 0; j < 3; ++j) {
            const int k = (piece >> (kDepth * static_cast<int>(j))) & (kSide - 1);
            x[j] = low[j] + (k + 0.5) / kSide * size;
        }
        return x;
    }

    /// Whether every piece of a cluster lies within so many pieces of what is meshed, on ways through the
    /// cluster.
    bool is_shallow(const std::vector<std::size_t>& cluster, int most) const {
        struct Step {
            std::size_t component;
            std::uint16_t piece;
        };
        std::map<std::size_t, std::vector<int>> distance;  // parallel to the pieces of each component
        std::size_t pieces = 0;
        for (const std::size_t i : cluster) {
            distance[i].assign(components_[i].pieces.size(), -1);
            pieces += components_[i].pieces.size();
        }
        std::vector<Step> queue;
        const auto reach = [&](std::size_t i, std::uint16_t piece, int from) {
            const std::vector<std::uint16_t>& list = components_[i].pieces;
            const auto at = std::lower_bound(list.begin(), list.end(), piece);
            if (at == list.end() || *at != piece) return;
            int& known = distance[i][static_cast<std::size_t>(at - list.begin())];
            if (known >= 0) return;
            known = from + 1;
            queue.push_back({i, piece});
        };
        for (const std::size_t i : cluster) {
            for (const std::uint16_t piece : components_[i].open) reach(i, piece, -1);
        }
        for (std::size_t q = 0; q < queue.size(); ++q) {
            const auto [i, piece] = queue[q];
            const std::vector<std::uint16_t>& list = components_[i].pieces;
            const auto place = std::lower_bound(list.begin(), list.end(), piece) - list.begin();
            const int here = distance[i][static_cast<std::size_t>(place)];
            if (here >= most) return false;
            for (int f = 0; f < 6; ++f) {
                if (on_face(piece, f)) continue;
                const int step = 1 << (kDepth * (f / 2));
                reach(i, static_cast<std::uint16_t>((f & 1) != 0 ? piece + step : piece - step), here);
            }
            for (const Join& join : joined_[i]) {
                if (join.piece == piece) reach(join.component, join.next, here);
            }
        }
        return queue.size() == pieces;
    }

    /// Whether so much of a cluster's surface touches what is meshed that it is the tip of a groove, or a
    /// ridge, between walls that part; a rod or hole has a base that is small beside its sides.
    bool is_open(const std::vector<std::size_t>& cluster) const {
        std::size_t faces = 0, open = 0;
        for (const std::size_t i : cluster) {
            const Component& component = components_[i];
            open += component.open.size();
            for (const std::uint16_t piece : component.pieces) {
                for (int f = 0; f < 6; ++f) {
                    const int step = 1 << (kDepth * (f / 2));
                    const int next = (f & 1) != 0 ? piece + step : piece - step;
                    const bool ends =
                        on_face(piece, f) || !holds(component, static_cast<std::uint16_t>(next));
                    faces += ends ? 1 : 0;
                }
            }
            faces -= joined_[i].size();
        }
        return static_cast<double>(open) >= kLeastOpen * static_cast<double>(faces);
    }

    /// Whether a cluster touches what is meshed in places apart from each other: a hole through a plate, a
    /// bar between two walls. However short, it is no cap, which has one base.
    bool joins_apart(const std::vector<std::size_t>& cluster) const {
        using Base = std::array<std::int32_t, 3>;  // in the cluster's largest pieces
        double widest = 0;
        for (const std::size_t i : cluster) widest = std::max(widest, edge(components_[i]) / kSide);
        std::vector<Base> bases;
        for (const std::size_t i : cluster) {
            const Component& component = components_[i];
            for (const std::uint16_t piece : component.open) {
                const Vec3 x = middle(corner(component), edge(component), piece);
                Base base{};
                for (std::size_t j = 0; j < 3; ++j)
                    base[j] = static_cast<std::int32_t>(std::floor(x[j] / widest));
                bases.push_back(base);
            }
        }
        sort_unique(bases);
        DisjointSets sets(bases.size());
        for (std::uint32_t i = 0; i < bases.size(); ++i) {
            const Base& at = bases[i];
            for (std::int32_t x = at[0]; x <= at[0] + kBesides; ++x) {
                for (std::int32_t y = at[1] - kBesides; y <= at[1] + kBesides; ++y) {
                    auto k = std::lower_bound(bases.begin(), bases.end(), Base{x, y, at[2] - kBesides});
                    for (; k != bases.end() && *k <= Base{x, y, at[2] + kBesides}; ++k)
                        sets.join(i, static_cast<std::uint32_t>(k - bases.begin()));
                }
            }
        }
        for (std::uint32_t i = 0; i < bases.size(); ++i) {
            if (sets.find(i) != 0) return true;
        }
        return false;
    }

    void report(const std::vector<std::size_t>& cluster, Probe& out) {
        bool attached = false;
        bool torn = false;
        std::size_t deepest = cluster.front();
        std::array<double, 3> low = {1, 1, 1};
        std::array<double, 3> high = {0, 0, 0};
        for (const std::size_t i : cluster) {
            const Component& component = components_[i];
            attached = attached || component.attached;
            torn = torn || component.torn;
            if (component.depth > components_[deepest].depth) deepest = i;
            const Vec3 from = corner(component);
            const double size = edge(component);
            for (const std::uint16_t piece : component.pieces) {
                for (std::size_t j = 0; j < 3; ++j) {
                    const int k = (piece >> (kDepth * static_cast<int>(j))) & (kSide - 1);
                    low[j] = std::min(low[j], from[j] + size * k / kSide);
                    high[j] = std::max(high[j], from[j] + size * (k + 1) / kSide);
                }
            }
        }
        const bool has_base = attached && !torn && !joins_apart(cluster);
        if (has_base && is_shallow(cluster, is_open(cluster) ? kShallowGroove : kShallow)) return;
        const Component& main = components_[deepest];
        MissedFeature feature;
        double size = 0;
        for (std::size_t j = 0; j < 3; ++j) {
            feature.position[j] = model_.origin[j] + model_.side * main.point[j];
            size = std::max(size, high[j] - low[j]);
        }
        if (main.thickness < kThinnest * edge(main)) return;
        feature.thickness = model_.side * main.thickness;
        feature.size = std::max(feature.thickness, model_.side * size);
        feature.material = main.region != 0;
        feature.kept = cluster.size() == 1 && !attached && !torn && main.usable;
        if (feature.kept) {
            if (main.pieces.size() <= 8) feature.size = feature.thickness;  // less than two pieces wide
            const Vec3 from = corner(main);
            Apex apex{tree_.nio[main.leaf].morton, {}};
            for (std::size_t j = 0; j < 3; ++j) {
                apex.at[j] =
                    static_cast<std::int32_t>(std::rint((main.point[j] - from[j]) / edge(main) * kCellUnits));
            }
            out.apexes.push_back(apex);
            out.leaves.push_back(main.leaf);
        }
        out.features.push_back(feature);
    }

    const tape::BoundModel& model_;
    const octree::Octree& tree_;
    Regions regions_;
    std::vector<Component> components_;  ///< by leaf
    DisjointSets sets_;                  ///< of components: features
    /// A piece that goes on in a component of the next leaf.
    struct Join {
        std::uint16_t piece;
        std::size_t component;
        std::uint16_t next;
    };
    std::vector<std::vector<Join>> joined_;  ///< per component
};

}  // namespace

Probe find_features(const tape::BoundModel& model, const octree::Octree& tree, int threads) {
    Probe result;
    const std::size_t chunks = chunk_count(tree.nio.size(), kChunk);
    std::vector<std::vector<Component>> found(chunks);
    std::vector<std::vector<std::uint64_t>> folded(chunks);
    std::vector<std::optional<std::uint64_t>> flat(chunks);
    const int workers = thread_count(threads);
    std::vector<std::unique_ptr<LeafProbe>> probes(static_cast<std::size_t>(workers));
    parallel_chunks(tree.nio.size(), kChunk, workers, [&](std::size_t begin, std::size_t end, int thread) {
        std::unique_ptr<LeafProbe>& probe = probes[static_cast<std::size_t>(thread)];
        if (!probe) probe = std::make_unique<LeafProbe>(model, tree);
        probe->prepare_batch(static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end));
        for (std::size_t i = begin; i < end; ++i) {
            probe->run(static_cast<std::uint32_t>(i), found[begin / kChunk]);
            if (!flat[begin / kChunk] && probe->is_flat(tree.nio[i]))
                flat[begin / kChunk] = tree.nio[i].morton;
            if (probe->folds()) folded[begin / kChunk].push_back(tree.nio[i].morton);
        }
    });
    for (const auto& probe : probes) {
        if (probe) result.probed += probe->probed();
    }
    for (const auto& part : folded) result.folded.insert(result.folded.end(), part.begin(), part.end());
    const auto first =
        std::find_if(flat.begin(), flat.end(), [](const auto& code) { return code.has_value(); });
    if (first != flat.end()) result.flat = *first;
    std::vector<Component> components;
    for (std::vector<Component>& part : found) {
        components.insert(components.end(), std::make_move_iterator(part.begin()),
                          std::make_move_iterator(part.end()));
    }
    if (!components.empty()) Clusters(model, tree, std::move(components)).run(result);
    return result;
}

}  // namespace mortise::probe
