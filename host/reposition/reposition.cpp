#include "host/reposition/reposition.hpp"

#include <algorithm>

#include "host/common/disjoint_sets.hpp"
#include "host/common/parallel.hpp"
#include "host/reposition/stars.hpp"

namespace mortise::reposition {
namespace {

using device::Buffer;
using device::Device;

constexpr std::size_t kChunk = 64;
/// Movable nodes from which on a GPU is faster: an H100 takes as long for 30,000 as 16 host threads, 65 ms.
constexpr std::size_t kWorthLoading = std::size_t{1} << 15;

/// What changes from round to round.
struct Progress {
    std::vector<double> points;
    std::vector<std::uint8_t> moved;  ///< per movable node
    std::vector<std::uint8_t> rests;  ///< per movable node: nothing around it has changed since it was tried
};

class OnDevice {
  public:
    OnDevice(Device& device, const tape::BoundModel& model, const Stars& stars)
        : device_(device),
          surfaces_(device.upload(model.surfaces)),
          ops_(device.upload(model.expression_ops)),
          movable_(device.upload(stars.movable)),
          star_(device.upload(stars.star)),
          movable_at_(device.upload(stars.movable_at)) {}

    void run(const RepositionScale& scale, int rounds, Progress& progress) {
        const std::size_t count = progress.moved.size();
        Buffer points = device_.upload(progress.points);
        Buffer moved = device_.upload(progress.moved);
        const Buffer rests = device_.upload(progress.rests);
        const Buffer moves = device_.allocate(count * sizeof(NodeMove));
        for (int round = 0; round < rounds; ++round) {
            device_.launch(device_.kernel("reposition/reposition.cl", "propose"), count, movable_, star_,
                           points, surfaces_, ops_, scale, rests, moves);
            device_.launch(device_.kernel("reposition/reposition.cl", "settle"), count, movable_, star_,
                           movable_at_, moves, points, rests, moved);
        }
        device_.download(points, progress.points.data(), progress.points.size());
        device_.download(moved, progress.moved.data(), count);
    }

  private:
    Device& device_;
    Buffer surfaces_, ops_, movable_, star_, movable_at_;
};

class OnHost {
  public:
    OnHost(const tape::BoundModel& model, const Stars& stars, int threads)
        : model_(model), stars_(stars), threads_(threads) {}

    void run(const RepositionScale& scale, int rounds, Progress& progress) {
        const std::size_t count = stars_.movable.size();
        std::vector<std::uint8_t>& rests = progress.rests;
        std::vector<NodeMove> moves(count);
        bool any = true;
        for (int round = 0; round < rounds && any; ++round) {
            parallel_chunks(count, kChunk, threads_, [&](std::size_t begin, std::size_t end, int) {
                for (std::size_t i = begin; i < end; ++i) {
                    moves[i] = rests[i] == 0 ? propose(scale, progress.points, i) : NodeMove{};
                }
            });
            std::fill(rests.begin(), rests.end(), std::uint8_t{1});
            any = false;
            for (std::uint32_t i = 0; i < count; ++i) {
                if (moves[i].wanted == 0) continue;
                any = true;
                settle(i, moves, progress);
            }
        }
    }

  private:
    NodeMove propose(const RepositionScale& scale, const std::vector<double>& points, std::size_t i) const {
        const MovableNode& node = stars_.movable[i];
        const NodeStar star = {stars_.star.data(),
                               points.data(),
                               node.surface != kFreeNode ? &model_.surfaces[node.surface] : nullptr,
                               model_.expression_ops.data(),
                               scale,
                               node};
        return find_move(&star);
    }

    void settle(std::uint32_t i, const std::vector<NodeMove>& moves, Progress& progress) const {
        const MovableNode& node = stars_.movable[i];
        progress.rests[i] = 0;
        if (goes_first(stars_.star.data(), node, stars_.movable_at.data(), moves.data(), i) == 0) return;
        for (std::size_t j = 0; j < 3; ++j)
            progress.points[3 * std::size_t{node.node} + j] = moves[i].point[j];
        progress.moved[i] = 1;
        for (u32 n = 0; n < node.elements; ++n) {
            const StarElement& e = stars_.star[node.first + n];
            for (u32 k = 0; k < kStarNodes[e.type]; ++k) {
                const u32 other = stars_.movable_at[e.node[k]];
                if (other != kNotMovable) progress.rests[other] = 0;
            }
        }
    }

    const tape::BoundModel& model_;
    const Stars& stars_;
    int threads_;
};

/// Of the elements around a movable node, none is poor.
bool is_mended(const Stars& stars, const RepositionScale& scale, const std::vector<double>& points,
               const MovableNode& node) {
    for (u32 n = 0; n < node.elements; ++n) {
        const StarElement& e = stars.star[node.first + n];
        double p[8][3];
        for (u32 k = 0; k < kStarNodes[e.type]; ++k)
            std::copy_n(points.data() + 3 * std::size_t{e.node[k]}, 3, p[k]);
        if (!(repositioned_quality(e.type, -1, p, moved_jacobian_scale(e.type), scale.shortest, 1) >= 1))
            return false;
    }
    return true;
}

/// Sets of movable nodes that have elements in common. All elements around a group must become good, or none
/// of its nodes moves: improvement would take the cells there apart anyway, and finds more room in those of
/// the templates.
class Groups {
  public:
    explicit Groups(const Stars& stars) : stars_(stars), sets_(stars.movable.size()) {
        for (std::uint32_t i = 0; i < stars.movable.size(); ++i) {
            const MovableNode& node = stars.movable[i];
            for (u32 n = 0; n < node.elements; ++n) {
                const StarElement& e = stars.star[node.first + n];
                for (u32 k = 0; k < kStarNodes[e.type]; ++k) {
                    const u32 other = stars.movable_at[e.node[k]];
                    if (other != kNotMovable) sets_.join(i, other);
                }
            }
        }
    }

    /// From nodes to all of their groups.
    void spread(std::vector<std::uint8_t>& flags) {
        for (std::uint32_t i = 0; i < flags.size(); ++i) flags[sets_.find(i)] |= flags[i];
        for (std::uint32_t i = 0; i < flags.size(); ++i) flags[i] = flags[sets_.find(i)];
    }

    void undo_failures(const RepositionScale& scale, int threads, Progress& progress) {
        std::vector<std::uint8_t> has_failed(stars_.movable.size());
        parallel_chunks(has_failed.size(), kChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            for (std::size_t i = begin; i < end; ++i)
                has_failed[i] = is_mended(stars_, scale, progress.points, stars_.movable[i]) ? 0 : 1;
        });
        spread(has_failed);
        for (std::size_t i = 0; i < has_failed.size(); ++i) {
            if (has_failed[i] == 0) continue;
            const std::size_t at = 3 * std::size_t{stars_.movable[i].node};
            for (std::size_t j = at; j < at + 3; ++j) progress.points[j] = stars_.points[j];
            progress.moved[i] = 0;
        }
    }

  private:
    const Stars& stars_;
    DisjointSets sets_;
};

/// Hexahedra of kind kIn around nodes that have moved.
IndexRuns find_moved_cubes(const Mesh& mesh, const Stars& stars, const std::vector<std::uint8_t>& moved) {
    std::vector<std::uint32_t> cubes;
    for (std::size_t i = 0; i < moved.size(); ++i) {
        const MovableNode& node = stars.movable[i];
        for (u32 n = node.first; n < node.first + node.elements && moved[i] != 0; ++n) {
            const bool is_cube = stars.star[n].type == 0 && mesh.elements[0].kind[stars.index[n]] ==
                                                                static_cast<std::uint8_t>(ElementKind::kIn);
            if (is_cube) cubes.push_back(stars.index[n]);
        }
    }
    std::sort(cubes.begin(), cubes.end());
    IndexRuns runs;
    for (const std::size_t cube : cubes) {
        if (runs.empty() || runs.back().end < cube) runs.push_back({cube, cube});
        runs.back().end = cube + 1;
    }
    return runs;
}

}  // namespace

Counters reposition(Device& device, const tape::BoundModel& model, const Options& options, Mesh& mesh) {
    Counters counters;
    const Frame frame = make_frame(model, options);
    const PoorElements poor = find_poor(mesh, frame, options.threads);
    counters.poor = poor.apart.size();
    counters.left = counters.poor;
    if (poor.apart.empty() || options.rounds == 0) return counters;
    const Stars stars = gather_stars(mesh, frame, poor, options);
    const std::size_t count = stars.movable.size();
    Groups groups(stars);
    Progress progress{stars.points, std::vector<std::uint8_t>(count, 0), stars.is_hopeless};
    groups.spread(progress.rests);
    const auto awake = static_cast<std::size_t>(std::count(progress.rests.begin(), progress.rests.end(), 0));
    if (awake == 0) return counters;
    // The threads of a CPU device are the host's, whose code needs no compiler at run time.
    const bool is_worth_it = device.info().is_gpu && awake >= kWorthLoading;
    if (options.method.value_or(is_worth_it ? Method::kDevice : Method::kHost) == Method::kDevice) {
        OnDevice(device, model, stars).run(frame.scale, options.rounds, progress);
    } else {
        OnHost(model, stars, options.threads).run(frame.scale, options.rounds, progress);
    }
    groups.undo_failures(frame.scale, options.threads, progress);
    for (std::size_t i = 0; i < count; ++i) {
        if (progress.moved[i] == 0) continue;
        const std::size_t local = stars.movable[i].node;
        frame.to_model(progress.points.data() + 3 * local,
                       mesh.points.data() + 3 * std::size_t{stars.node[local]});
        ++counters.moved;
    }
    counters.moved_cubes = find_moved_cubes(mesh, stars, progress.moved);
    counters.left = static_cast<std::uint64_t>(
        std::count_if(poor.apart.begin(), poor.apart.end(),
                      [&](const ElementNumber& e) { return is_poor(mesh, frame, e); }));
    return counters;
}

}  // namespace mortise::reposition
