#include "host/probe/overlaps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "host/common/constants.hpp"
#include "host/common/parallel.hpp"
#include "host/common/sort_unique.hpp"
#include "host/common/watch.hpp"
#include "host/tape/local_tape.hpp"
#include "host/tape/projection.hpp"
#include "host/tape/reference.hpp"
#include "kernels/shared/surface.h"
#include "kernels/shared/tape.h"

namespace mortise::probe {
namespace {

/// Edges of the root box; less deep overlaps are rounding.
constexpr double kLeastDepth = 1e-6;
/// Cells of this level are searched apart, on any thread.
constexpr int kTaskLevel = 3;
/// Surfaces of a leaf beside which, and between which, points are tried.
constexpr std::size_t kMostSurfaces = 12;
/// Of such points from their surface, in edges of the leaf.
constexpr double kBeside = 1.0 / 16;

/// A region that may hold in a cell.
struct Candidate {
    std::int32_t region;
    std::vector<std::uint32_t> tape;  ///< what is undecided of its own formula; empty: it holds everywhere
};

/// A cell and the regions that are not known to be outside it.
struct Node {
    tape::Cell cell;
    std::uint64_t code = 0;  ///< Morton code among cells of its level
    int level = 0;
    std::vector<Candidate> candidates;
};

/// How deep a point lies in a region, to first order (negative outside), and which surface tells.
struct Depth {
    double value;
    std::uint32_t surface;  ///< kNoSurface: none
    double side;            ///< 1: the region is where the surface's value is negative; -1: positive
};
constexpr std::uint32_t kNoSurface = 0xffffffffu;

using Pair = std::pair<std::int32_t, std::int32_t>;
struct Place {
    Vec3 at;
    double depth;
};
using Found = std::map<Pair, Place>;

/// The regions' own formulas: what lies between the selects of the whole tape.
std::vector<Candidate> regions_of(const std::vector<std::uint32_t>& tape) {
    std::vector<Candidate> regions;
    std::vector<std::uint32_t> words;
    for (const std::uint32_t word : tape) {
        const std::uint32_t operation = tape_operation(word);
        if (operation != kTapeSelect && operation != kTapeSelectConst) {
            words.push_back(word);
            continue;
        }
        const std::int32_t region = tape_region(word);
        words.push_back(make_operation(kTapeSelectConst, region, 0));
        regions.push_back({region, std::move(words)});
        words.clear();
    }
    std::sort(regions.begin(), regions.end(),
              [](const Candidate& a, const Candidate& b) { return a.region < b.region; });
    return regions;
}

/// Searches cells one after the other, until each pair of regions is found once.
class Search {
  public:
    Search(const tape::BoundModel& model, const octree::Octree& tree, Found found)
        : model_(model), tree_(tree), found_(std::move(found)) {}

    const Found& found() const { return found_; }

    /// Everything below a node.
    void run(const Node& node) {
        std::vector<Node> children;
        split(node, children);
        for (const Node& child : children) run(child);
    }

    /// Appends the children of a node that are to be searched further; leaves are searched at once.
    void split(const Node& node, std::vector<Node>& children) {
        keep_watch();
        for (std::uint64_t c = 0; c < 8; ++c) {
            Node child;
            child.cell.half = 0.5 * node.cell.half;
            for (int j = 0; j < 3; ++j) {
                child.cell.centre[j] =
                    node.cell.centre[j] + (((c >> j) & 1) != 0 ? child.cell.half : -child.cell.half);
            }
            child.code = 8 * node.code + c;
            child.level = node.level + 1;
            if (!look_into(node, child)) continue;
            if (is_leaf(child))
                search_leaf(child);
            else
                children.push_back(std::move(child));
        }
    }

  private:
    /// Whether two regions may overlap in the child that are not known to.
    bool look_into(const Node& node, Node& child) {
        for (const Candidate& candidate : node.candidates) {
            Candidate kept{candidate.region, {}};
            if (!candidate.tape.empty()) {
                const std::int32_t value =
                    tape::classify_cell(model_, candidate.tape, child.cell, &kept.tape);
                if (value == 0) continue;
                if (value != kUnknown) kept.tape.clear();
            }
            child.candidates.push_back(std::move(kept));
        }
        if (!has_open_pair(child)) return false;
        try_point(child, {child.cell.centre[0], child.cell.centre[1], child.cell.centre[2]});
        return has_open_pair(child);
    }

    bool has_open_pair(const Node& node) const {
        for (std::size_t i = 0; i < node.candidates.size(); ++i) {
            for (std::size_t j = i + 1; j < node.candidates.size(); ++j) {
                if (found_.count({node.candidates[i].region, node.candidates[j].region}) == 0) return true;
            }
        }
        return false;
    }

    /// Outside all regions there are no leaves, and cells of any level may be one.
    bool is_leaf(const Node& node) const {
        if (node.level >= tree_.level) return true;
        const Leaf leaf = tree_.at(node.code << (3 * (tree_.level - node.level)));
        return leaf.kind != kLeafNone && leaf.level <= node.level;
    }

    /// Points beside each surface, and midway between two: where thin overlaps are.
    void search_leaf(const Node& node) {
        surfaces_.clear();
        for (const Candidate& candidate : node.candidates) {
            tape::list_surfaces(candidate.tape.data(), candidate.tape.size(), own_);
            surfaces_.insert(surfaces_.end(), own_.begin(), own_.end());
        }
        sort_unique(surfaces_);
        if (surfaces_.size() > kMostSurfaces) surfaces_.resize(kMostSurfaces);
        const double edge = 2 * node.cell.half;
        const tape::ProjectionLimits limits{edge, 0.5, 1e-3 * kLeastDepth};
        for (std::size_t s = 0; s < surfaces_.size(); ++s) {
            Vec3 foot = {node.cell.centre[0], node.cell.centre[1], node.cell.centre[2]};
            if (!tape::project(model_, &surfaces_[s], 1, limits, foot.data())) continue;
            const SurfaceSample sample = surface_sample(
                &model_.surfaces[surfaces_[s]], model_.expression_ops.data(), foot[0], foot[1], foot[2]);
            const double slope = std::hypot(sample.gradient[0], sample.gradient[1], sample.gradient[2]);
            for (const double step : {-kBeside * edge, kBeside * edge}) {
                Vec3 beside = foot;
                for (std::size_t j = 0; j < 3; ++j) beside[j] += step / slope * sample.gradient[j];
                try_point(node, beside);
            }
            for (std::size_t t = 0; t < surfaces_.size(); ++t) {
                Vec3 other = foot;
                if (t == s || !tape::project(model_, &surfaces_[t], 1, limits, other.data())) continue;
                Vec3 middle{};
                for (std::size_t j = 0; j < 3; ++j) middle[j] = 0.5 * (foot[j] + other[j]);
                try_point(node, middle);
            }
        }
        for (const Candidate& a : node.candidates) {
            for (const Candidate& b : node.candidates) {
                if (a.region < b.region && found_.count({a.region, b.region}) == 0) climb(node, a, b);
            }
        }
    }

    /// From the middle of a leaf to where it is deepest in both regions, by ever shorter steps: to where it
    /// is as deep in one as in the other, and along there to where both are deeper. A ball that dips into a
    /// plate is narrower than what it passes by.
    void climb(const Node& node, const Candidate& a, const Candidate& b) {
        constexpr int kSteps = 24;
        constexpr double kShorter = 0.8;
        constexpr double kSameWay = 1e-12;
        Vec3 x = {node.cell.centre[0], node.cell.centre[1], node.cell.centre[2]};
        double step = node.cell.half;
        for (int k = 0; k < kSteps; ++k, step *= kShorter) {
            const Depth in_a = depth_in(node, a, x);
            const Depth in_b = depth_in(node, b, x);
            if (std::min(in_a.value, in_b.value) > kLeastDepth) return try_point(node, x);
            Vec3 into_a{}, into_b{};
            if (!direction_into(in_a, x, into_a) || !direction_into(in_b, x, into_b)) return;
            double apart = 0, along = 0;  // squared
            for (std::size_t j = 0; j < 3; ++j) {
                apart += (into_a[j] - into_b[j]) * (into_a[j] - into_b[j]);
                along += (into_a[j] + into_b[j]) * (into_a[j] + into_b[j]);
            }
            if (k > 0 && along <= kSameWay) return;  // face to face, as where one surface parts them
            const double even = apart > kSameWay ? (in_b.value - in_a.value) / apart : 0;
            const double up = along > kSameWay ? step / std::sqrt(along) : 0;
            for (std::size_t j = 0; j < 3; ++j) {
                const double to = x[j] + even * (into_a[j] - into_b[j]) + up * (into_a[j] + into_b[j]);
                x[j] = std::clamp(to, node.cell.centre[j] - node.cell.half,
                                  node.cell.centre[j] + node.cell.half);
            }
        }
    }

    /// The direction in which a point gets deeper, of unit length; false if there is none.
    bool direction_into(const Depth& depth, const Vec3& x, Vec3& direction) const {
        if (depth.surface == kNoSurface) return false;
        const SurfaceSample s =
            surface_sample(&model_.surfaces[depth.surface], model_.expression_ops.data(), x[0], x[1], x[2]);
        const double slope = std::hypot(s.gradient[0], s.gradient[1], s.gradient[2]);
        for (std::size_t j = 0; j < 3; ++j) direction[j] = -depth.side / slope * s.gradient[j];
        return slope > 0 && slope < kInfinity;
    }

    /// Notes the pairs of regions that both hold a point of the cell.
    void try_point(const Node& node, const Vec3& x) {
        for (std::size_t j = 0; j < 3; ++j) {
            if (!(std::fabs(x[j] - node.cell.centre[j]) <= node.cell.half)) return;
        }
        depths_.clear();
        for (const Candidate& candidate : node.candidates)
            depths_.push_back(depth_in(node, candidate, x).value);
        for (std::size_t i = 0; i < depths_.size(); ++i) {
            if (!(depths_[i] > kLeastDepth)) continue;
            for (std::size_t j = i + 1; j < depths_.size(); ++j) {
                if (!(depths_[j] > kLeastDepth)) continue;
                found_.insert({{node.candidates[i].region, node.candidates[j].region},
                               {x, std::min({depths_[i], depths_[j], node.cell.half})}});
            }
        }
    }

    Depth depth_in(const Node& node, const Candidate& candidate, const Vec3& x) {
        const std::vector<std::uint32_t>& tape = candidate.tape;
        if (tape.empty()) return {node.cell.half, kNoSurface, 0};
        stack_.clear();
        for (std::size_t i = 0; i + 1 < tape.size(); ++i) {
            const std::uint32_t operation = tape_operation(tape[i]);
            if (operation == kTapeLiteral) {
                const double side = tape_negated(tape[i]) != 0 ? -1 : 1;
                const std::uint32_t surface = tape_surface(tape[i]);
                stack_.push_back({side * depth_below(surface, x), surface, side});
            } else if (operation == kTapeSpatial) {
                stack_.push_back({-kInfinity, kNoSurface, 0});  // smaller cells tell
            } else {
                const Depth top = stack_.back();
                stack_.pop_back();
                if ((top.value < stack_.back().value) == (operation == kTapeAnd)) stack_.back() = top;
            }
        }
        return stack_.back();
    }

    double depth_below(std::uint32_t surface, const Vec3& x) const {
        const SurfaceSample s =
            surface_sample(&model_.surfaces[surface], model_.expression_ops.data(), x[0], x[1], x[2]);
        const double slope = std::hypot(s.gradient[0], s.gradient[1], s.gradient[2]);
        // In the middle of a ball the gradient vanishes, but the value tells.
        const double depth = slope > 0 ? -s.value / slope : -s.value;
        return std::isfinite(depth) ? depth : 0;
    }

    const tape::BoundModel& model_;
    const octree::Octree& tree_;
    Found found_;
    std::vector<std::uint32_t> surfaces_, own_;
    std::vector<double> depths_;
    std::vector<Depth> stack_;
};

}  // namespace

std::vector<Overlap> find_overlaps(const tape::BoundModel& model, const octree::Octree& tree, int threads) {
    std::vector<Overlap> overlaps;
    std::vector<Node> nodes = {{{{0.5, 0.5, 0.5}, 0.5}, 0, 0, regions_of(model.tape)}};
    if (nodes[0].candidates.size() < 2) return overlaps;
    Search coarse(model, tree, {});
    for (int level = 0; level < kTaskLevel; ++level) {
        std::vector<Node> children;
        for (const Node& node : nodes) coarse.split(node, children);
        nodes = std::move(children);
    }
    // What coarse cells tell is known to all; what fine ones tell depends on no other cell.
    std::vector<Found> found(nodes.size());
    parallel_chunks(nodes.size(), 1, threads, [&](std::size_t begin, std::size_t, int) {
        Search search(model, tree, coarse.found());
        search.run(nodes[begin]);
        found[begin] = search.found();
    });
    Found all = coarse.found();
    for (const Found& part : found) {
        for (const auto& [pair, place] : part) {
            const auto [known, is_new] = all.insert({pair, place});
            if (!is_new && place.depth > known->second.depth) known->second = place;
        }
    }
    for (const auto& [pair, place] : all) {
        Overlap overlap{pair.first, pair.second, {}, model.side * place.depth};
        for (std::size_t j = 0; j < 3; ++j) overlap.at[j] = model.origin[j] + model.side * place.at[j];
        overlaps.push_back(overlap);
    }
    return overlaps;
}

}  // namespace mortise::probe
