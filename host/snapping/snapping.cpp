#include "host/snapping/snapping.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/parallel.hpp"
#include "host/common/sort_unique.hpp"
#include "host/tape/local_tape.hpp"
#include "host/tape/projection.hpp"
#include "kernels/shared/lattice.h"
#include "kernels/shared/snap.h"

namespace mortise::snapping {
namespace {

using octree::SnappedVertex;

constexpr std::size_t kChunk = 128;
constexpr std::size_t kMostSurfaces = 16;  ///< around a vertex
// In edges of the leaf.
constexpr double kNear = 0.4;             ///< farther surfaces are not looked at
constexpr double kCreaseReach = 0.42;     ///< to where two surfaces meet
constexpr double kCornerReach = 0.45;     ///< or three
constexpr double kClear = 0.02;           ///< distance to all other surfaces
constexpr double kTangent = 0.2;          ///< as tape::ProjectionLimits
constexpr double kThickness = 2.5;        ///< of a curved part around a vertex, or chords cut off too much
constexpr double kThicknessBeyond = 1.5;  ///< of what lies behind the surface, seen from the vertex
constexpr double kSettled = 1e-10;

double dot(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// One vertex at a time.
class VertexSearch {
  public:
    VertexSearch(const tape::BoundModel& model, const octree::Octree& tree) : model_(model), tree_(tree) {}

    bool run(std::uint64_t code, const std::vector<std::uint32_t>& strict, SnappedVertex* out) {
        if (!load(code, strict)) return false;
        find_near();
        for (std::size_t count = std::min<std::size_t>(near_.size(), 3); count > 0; --count) {
            if (try_sets(count)) {
                out->code = code;
                out->level = static_cast<std::uint8_t>(level_);
                for (std::size_t j = 0; j < 3; ++j)
                    out->moved[j] =
                        static_cast<std::int32_t>(std::rint((target_[j] - x_[j]) / cell_ * kCellUnits));
                out->surface_count = static_cast<std::uint8_t>(set_.size());
                for (std::size_t i = 0; i < set_.size(); ++i) out->surface[i] = surfaces_[set_[i]];
                return out->moved != std::array<std::int32_t, 3>{};
            }
        }
        return false;
    }

  private:
    struct Sample {
        int sign;
        double distance;  ///< from the vertex, to first order, cells
    };

    const Surface* surface(std::size_t s) const { return &model_.surfaces[surfaces_[s]]; }
    int sign_at(std::size_t s, const double* x) const {
        return surface_sign(surface(s), model_.expression_ops.data(), x[0], x[1], x[2], cell_);
    }
    SurfaceSample sample_at(std::size_t s, const double* x) const {
        return surface_sample(surface(s), model_.expression_ops.data(), x[0], x[1], x[2]);
    }
    double distance_at(std::size_t s, const double* x) const {
        const SurfaceSample at = sample_at(s, x);
        const double distance = std::fabs(at.value) / (std::sqrt(dot(at.gradient, at.gradient)) * cell_);
        return std::isfinite(distance) ? distance : kMortiseInfinity;
    }

    /// The leaves around and their surfaces; false if the vertex must not move.
    bool load(std::uint64_t code, const std::vector<std::uint32_t>& strict) {
        const Tree tree = tree_.view();
        const u32 x = gather_bits(code), y = gather_bits(code >> 1), z = gather_bits(code >> 2);
        leaves_.clear();
        surfaces_.clear();
        int level = -1;
        for (u32 d = 0; d < 8; ++d) {
            const Leaf leaf = leaf_at_vertex(&tree, x, y, z, d);
            if (leaf.kind == kLeafNone) continue;
            if (level >= 0 && leaf.level != level) return false;
            level = leaf.level;
            if (leaf.kind != kLeafNio) continue;
            if (std::binary_search(strict.begin(), strict.end(), leaf.index)) return false;
            const TreeNode& node = tree_.nio[leaf.index];
            tape::list_surfaces(tree_.tapes.data() + node.tape_offset, node.tape_length, own_);
            surfaces_.insert(surfaces_.end(), own_.begin(), own_.end());
            leaves_.push_back(leaf.index);
        }
        level_ = level;
        sort_unique(surfaces_);
        if (surfaces_.size() > kMostSurfaces) return false;
        cell_ = octree::Octree::edge_of(level);
        x_[0] = x * tree_.finest_edge();
        x_[1] = y * tree_.finest_edge();
        x_[2] = z * tree_.finest_edge();
        return true;
    }

    void find_near() {
        here_.clear();
        near_.clear();
        for (std::size_t s = 0; s < surfaces_.size(); ++s) {
            here_.push_back({sign_at(s, x_), distance_at(s, x_)});
            if (here_[s].distance < kNear) near_.push_back(s);
        }
        std::stable_sort(near_.begin(), near_.end(), [this](std::size_t a, std::size_t b) {
            return here_[a].distance < here_[b].distance;
        });
    }

    bool try_sets(std::size_t count) {
        const std::size_t n = near_.size();
        std::size_t at[3] = {0, 1, 2};
        for (;;) {
            set_.clear();
            for (std::size_t i = 0; i < count; ++i) set_.push_back(near_[at[i]]);
            if (try_set()) return true;
            std::size_t i = count;
            while (i > 0 && at[i - 1] == n - count + i - 1) --i;
            if (i == 0) return false;
            ++at[i - 1];
            for (; i < count; ++i) at[i] = at[i - 1] + 1;
        }
    }

    bool find_target() {
        for (int j = 0; j < 3; ++j) target_[j] = x_[j];
        if (set_.size() == 1) {
            i32 moved[3] = {0, 0, 0};
            if (here_[set_[0]].sign == 0) return true;
            if (!snap_displacement(surface(set_[0]), model_.expression_ops.data(), x_, cell_, moved))
                return false;
            for (int j = 0; j < 3; ++j) target_[j] += moved[j] * cell_ / kCellUnits;
            return !is_thin(set_[0]);
        }
        std::uint32_t on[3];
        for (std::size_t i = 0; i < set_.size(); ++i) on[i] = surfaces_[set_[i]];
        const double reach = set_.size() == 2 ? kCreaseReach : kCornerReach;
        if (!tape::project(model_, on, set_.size(), {reach * cell_, kTangent, kSettled * cell_}, target_))
            return false;
        return std::none_of(set_.begin(), set_.end(), [this](std::size_t s) { return is_thin(s); });
    }

    /// Whether the part on one side of a curved surface is a rod, or a hole, that few vertices know of.
    bool is_thin(std::size_t s) const {
        if (surface(s)->kind == kSurfacePlane || here_[s].sign == 0) return false;
        const SurfaceSample sample = sample_at(s, target_);
        const double slope = std::sqrt(dot(sample.gradient, sample.gradient));
        const auto ends_within = [&](const double* from, int side, double thickness) {
            double far[3];
            for (int j = 0; j < 3; ++j)
                far[j] = from[j] + side * thickness * cell_ / slope * sample.gradient[j];
            return (sample_at(s, far).value < 0) != (side < 0);
        };
        return ends_within(x_, here_[s].sign, kThickness) ||
               ends_within(target_, -here_[s].sign, kThicknessBeyond);
    }

    bool try_set() {
        if (!find_target()) return false;
        // What the target tells of each surface; 0 for those that are near, or have another sign there.
        signs_.assign(surfaces_.size(), 0);
        for (std::size_t s = 0; s < surfaces_.size(); ++s) {
            if (std::find(set_.begin(), set_.end(), s) != set_.end()) continue;
            const int there = sign_at(s, target_);
            if (there == here_[s].sign && distance_at(s, target_) > kClear)
                signs_[s] = static_cast<std::int8_t>(there);
        }
        for (std::size_t s = 0; s < surfaces_.size(); ++s) {
            if (signs_[s] != 0) continue;
            const bool is_wanted = std::find(set_.begin(), set_.end(), s) != set_.end();
            if (matters(s) != is_wanted) return false;
        }
        return true;
    }

    bool matters(std::size_t s) {
        for (const std::uint32_t leaf : leaves_) {
            const TreeNode& node = tree_.nio[leaf];
            tape_.load(tree_.tapes.data() + node.tape_offset, node.tape_length, surfaces_);
            if (tape_.names(s) && tape_.depends_on(s, signs_.data())) return true;
        }
        return false;
    }

    const tape::BoundModel& model_;
    const octree::Octree& tree_;
    int level_ = 0;
    double cell_ = 0;  ///< edge of the leaves around
    double x_[3] = {};
    double target_[3] = {};
    std::vector<std::uint32_t> leaves_;
    std::vector<std::uint32_t> surfaces_, own_;
    std::vector<Sample> here_;
    std::vector<std::size_t> near_, set_;
    std::vector<std::int8_t> signs_;
    tape::LocalTape tape_;
};

}  // namespace

std::vector<SnappedVertex> find_snapped(const tape::BoundModel& model, const octree::Octree& tree,
                                        const std::vector<std::uint32_t>& complex,
                                        const std::vector<std::uint32_t>& strict, int threads) {
    std::vector<std::uint64_t> codes;
    for (const std::uint32_t leaf : complex) {
        const std::uint64_t code = tree.nio[leaf].morton;
        for (u32 c = 0; c < 8; ++c) codes.push_back(tree.vertex_of(code, tree.level_of(code), c));
    }
    sort_unique(codes);
    std::vector<std::vector<SnappedVertex>> found(chunk_count(codes.size(), kChunk));
    parallel_chunks(codes.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        VertexSearch search(model, tree);
        for (std::size_t i = begin; i < end; ++i) {
            SnappedVertex vertex;
            if (search.run(codes[i], strict, &vertex)) found[begin / kChunk].push_back(vertex);
        }
    });
    std::vector<SnappedVertex> result;
    for (const auto& part : found) result.insert(result.end(), part.begin(), part.end());
    return result;
}

}  // namespace mortise::snapping
