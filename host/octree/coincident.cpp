#include "host/octree/coincident.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "host/common/constants.hpp"
#include "host/common/parallel.hpp"
#include "host/common/vec3.hpp"
#include "host/common/watch.hpp"
#include "host/octree/leaf_formula.hpp"
#include "host/octree/tangent.hpp"
#include "host/tape/projection.hpp"

namespace mortise::octree {
namespace {

constexpr std::size_t kCoincidentChunk = 512;
constexpr std::size_t kFewest = 3;    ///< words of a tape with two surfaces
constexpr double kOnSurface = 1e-6;   ///< edges: closer than signs can tell (kSignTolerance)
constexpr double kIndependent = 0.1;  ///< sine between two gradients
constexpr double kAlong = 1e-3;       ///< sine between the crease and the third surface
constexpr double kReach = 1.5;        ///< edges from the leaf's centre, along each axis
constexpr int kDirections = 360;

struct Frame {
    Vec3 at{};     ///< on the crease of two surfaces
    Vec3 first{};  ///< their unit normals
    Vec3 second{};
    Vec3 along{};  ///< unit direction of the crease
};

/// Between unit vectors, in radians.
double angle(const Vec3& a, const Vec3& b) {
    const Vec3 normal = cross(a, b);
    return std::atan2(length(normal), dot(a, b));
}

class LeafSimplifier {
  public:
    LeafSimplifier(const tape::BoundModel& model, const Octree& tree) : model_(model), tree_(tree) {}

    /// The leaf's new tape; nothing if it stays.
    std::optional<std::vector<std::uint32_t>> run(const TreeNode& leaf) {
        const std::uint32_t* words = tree_.tapes.data() + leaf.tape_offset;
        if (!formula_.load({words, words + leaf.tape_length})) return std::nullopt;
        edge_ = Octree::edge_of(tree_.level_of(leaf.morton));
        for (std::size_t j = 0; j < 3; ++j)
            centre_[j] = gather_bits(leaf.morton >> j) * tree_.finest_edge() + 0.5 * edge_;
        bool changed = false;
        while (drop_one()) changed = true;
        const LeafBox box = {centre_, edge_};
        changed = join_tangent(model_, box, formula_, joint_) || changed;
        joint_.morton = leaf.morton;
        if (!changed) return std::nullopt;
        return formula_.tape();
    }

    /// Of the leaf that was rewritten last; its tape is empty if it has none.
    const LeafJoint& joint() const { return joint_; }

  private:
    bool drop_one() {
        const std::size_t n = formula_.count();
        for (std::size_t a = 0; a < n && n > 2; ++a) {
            for (std::size_t b = a + 1; b < n; ++b) {
                Frame frame;
                if (!find_crease(a, b, centre_, frame)) continue;
                for (std::size_t c = 0; c < n; ++c) {
                    if (c == a || c == b || !holds_crease(a, b, c, frame)) continue;
                    if (may_meet_again({a, b, c}, frame.at)) continue;
                    if (replace(a, b, c, frame)) return true;
                }
            }
        }
        return false;
    }

    /// Value over the length of the gradient, and the unit gradient.
    bool sample(std::size_t surface, const Vec3& x, double& distance, Vec3& normal) const {
        const SurfaceSample s = surface_sample(&model_.surfaces[formula_.surfaces()[surface]],
                                               model_.expression_ops.data(), x[0], x[1], x[2]);
        normal = {s.gradient[0], s.gradient[1], s.gradient[2]};
        const double length = std::sqrt(dot(normal, normal));
        if (!(length > 0 && length < kMortiseInfinity)) return false;
        for (double& x_j : normal) x_j /= length;
        distance = s.value / length;
        return std::isfinite(distance);
    }

    /// The foot of a point on two surfaces, with their normals there; false if they do not cross near the
    /// leaf.
    bool find_crease(std::size_t a, std::size_t b, const Vec3& start, Frame& frame) const {
        const std::uint32_t both[2] = {formula_.surfaces()[a], formula_.surfaces()[b]};
        const tape::ProjectionLimits limits = {2 * kReach * edge_, kIndependent, 1e-9 * edge_};
        frame.at = start;
        if (!tape::project(model_, both, 2, limits, frame.at.data()) || !is_near(frame.at)) return false;
        double distance = 0;
        if (!sample(a, frame.at, distance, frame.first) || !sample(b, frame.at, distance, frame.second))
            return false;
        frame.along = cross(frame.first, frame.second);
        const double sine = std::sqrt(dot(frame.along, frame.along));
        for (double& x : frame.along) x /= sine;
        return sine > 0;
    }

    bool is_near(const Vec3& x) const {
        bool near = true;
        for (std::size_t j = 0; j < 3; ++j) near = near && std::fabs(x[j] - centre_[j]) <= kReach * edge_;
        return near;
    }

    /// Whether a third surface passes through the crease here and half an edge to both sides.
    bool holds_crease(std::size_t a, std::size_t b, std::size_t c, const Frame& middle) const {
        for (const double along : {0.0, -0.5, 0.5}) {
            Frame frame = middle;
            if (along != 0) {
                Vec3 start = middle.at;
                for (std::size_t j = 0; j < 3; ++j) start[j] += along * edge_ * middle.along[j];
                if (!find_crease(a, b, start, frame)) continue;  // ends, or leaves the neighbourhood
            }
            double distance = 0;
            Vec3 normal{};
            if (!sample(c, frame.at, distance, normal) || std::fabs(distance) > kOnSurface * edge_)
                return false;
            if (std::fabs(dot(normal, frame.along)) > kAlong) return false;
            for (const Vec3& other : {frame.first, frame.second}) {
                const Vec3 turn = cross(normal, other);
                if (dot(turn, turn) < kIndependent * kIndependent) return false;
            }
        }
        return true;
    }

    /// Whether surfaces that share a crease may meet beside it in the leaf, too, as a chord and its circle
    /// do: other signs would occur there than around the crease. They cannot where their normals turn by
    /// less than the angle between them.
    bool may_meet_again(const std::array<std::size_t, 3>& three, const Vec3& on_crease) const {
        std::array<Vec3, 3> normal;
        std::array<double, 3> turn{};
        double distance = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            if (!sample(three[i], on_crease, distance, normal[i])) return true;
            for (int k = 0; k < 27; ++k) {
                const Vec3 step = {0.5 * (k % 3 - 1), 0.5 * (k / 3 % 3 - 1), 0.5 * (k / 9 - 1)};
                Vec3 at = centre_;
                for (std::size_t j = 0; j < 3; ++j) at[j] += step[j] * edge_;
                Vec3 there;
                if (!sample(three[i], at, distance, there)) return true;
                turn[i] = std::max(turn[i], angle(normal[i], there));
            }
        }
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t k = (i + 1) % 3;
            const double between = angle(normal[i], normal[k]);
            if (turn[i] + turn[k] >= std::min(between, kPi - between)) return true;
        }
        return false;
    }

    /// Puts another literal for that of c, if the solid stays the same for all signs that occur.
    bool replace(std::size_t a, std::size_t b, std::size_t c, const Frame& frame) {
        double distance = 0;
        Vec3 normal{};
        if (!sample(c, frame.at, distance, normal)) return false;
        bool occurs[8] = {};  // bit 0: inside a, 1: inside b, 2: inside c
        const Vec3 across = cross(frame.along, frame.first);
        for (int i = 0; i < kDirections; ++i) {
            const double angle = 2 * kPi * i / kDirections;
            Vec3 d{};
            for (std::size_t j = 0; j < 3; ++j)
                d[j] = std::cos(angle) * frame.first[j] + std::sin(angle) * across[j];
            const double at[3] = {dot(d, frame.first), dot(d, frame.second), dot(d, normal)};
            if (std::min({std::fabs(at[0]), std::fabs(at[1]), std::fabs(at[2])}) < 0.01) continue;
            occurs[(at[0] < 0 ? 1 : 0) | (at[1] < 0 ? 2 : 0) | (at[2] < 0 ? 4 : 0)] = true;
        }
        const auto can_occur = [&](std::uint32_t choice) {
            const auto inside = [choice](std::size_t s) { return (choice >> s) & 1u; };
            return occurs[inside(a) | (inside(b) << 1) | (inside(c) << 2)];
        };
        for (const std::size_t by : {a, b}) {
            for (const bool negated : {false, true}) {
                const LeafFormula::Substitution substitution = {c, by, negated};
                if (!formula_.allows(substitution, can_occur)) continue;
                formula_.substitute(substitution);
                return true;
            }
        }
        return false;
    }

    const tape::BoundModel& model_;
    const Octree& tree_;
    LeafFormula formula_;
    LeafJoint joint_;
    Vec3 centre_{};
    double edge_ = 0;
};

}  // namespace

std::uint64_t drop_coincident(device::Device& device, const tape::BoundModel& model, Octree& tree,
                              DeviceTree& on_device, int threads) {
    struct Change {
        std::uint32_t leaf;
        std::vector<std::uint32_t> tape;
        LeafJoint joint;
    };
    std::vector<std::vector<Change>> found(chunk_count(tree.nio.size(), kCoincidentChunk));
    parallel_chunks(tree.nio.size(), kCoincidentChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        LeafSimplifier simplifier(model, tree);
        for (std::size_t i = begin; i < end; ++i) {
            if (tree.nio[i].tape_length < kFewest) continue;
            keep_watch();
            if (auto tape = simplifier.run(tree.nio[i]))
                found[begin / kCoincidentChunk].push_back(
                    {static_cast<std::uint32_t>(i), std::move(*tape), simplifier.joint()});
        }
    });
    std::uint64_t changed = 0;
    for (const auto& list : found) {
        for (const Change& change : list) {
            TreeNode& leaf = tree.nio[change.leaf];
            leaf.tape_offset = static_cast<std::uint32_t>(tree.tapes.size());
            leaf.tape_length = static_cast<std::uint32_t>(change.tape.size());
            tree.tapes.insert(tree.tapes.end(), change.tape.begin(), change.tape.end());
            if (!change.joint.tape.empty()) tree.joints.push_back(change.joint);
            ++changed;
        }
    }
    if (changed > 0) {
        on_device.nio = device.upload(tree.nio);
        on_device.tapes = device.upload(tree.tapes);
    }
    return changed;
}

}  // namespace mortise::octree
