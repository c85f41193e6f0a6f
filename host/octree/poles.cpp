#include "host/octree/poles.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "host/common/parallel.hpp"
#include "host/common/vec3.hpp"
#include "host/tape/local_tape.hpp"

namespace mortise::octree {
namespace {

constexpr std::size_t kPoleChunk = 256;
constexpr std::size_t kMostSurfaces = 16;  ///< of a leaf; all pairs are looked at
constexpr std::size_t kMostThrough = 6;    ///< of a pole
// In edges of the leaf.
constexpr double kPoleReach = 1;    ///< of the search, from the leaf's centre
constexpr double kSame = 1e-6;      ///< closer poles are one
constexpr double kThrough = 1e-4;   ///< so close a surface passes through a pole: models have rounded figures
constexpr double kNearFace = 0.1;   ///< so close to a face a pole becomes the face's middle
constexpr double kUpright = 0.75;   ///< square of the normal along an axis; the tangent plane is across it
constexpr double kDeep = 0.2;       ///< of the apex then
constexpr double kTouching = 0.99;  ///< cosine between the normals of surfaces that touch
constexpr double kLeast = 1e-3;     ///< distance that it keeps from everything else

Vec3 corner_of(const Octree& tree, std::uint64_t morton) {
    Vec3 x{};
    for (std::size_t j = 0; j < 3; ++j) x[j] = gather_bits(morton >> j) * tree.finest_edge();
    return x;
}

class LeafSearch {
  public:
    LeafSearch(const tape::BoundModel& model, const Octree& tree) : model_(model), tree_(tree) {}

    /// Appends the poles that are found from the leaf's centre and lie in the leaf, nearly.
    void run(const TreeNode& leaf, std::vector<tape::Pole>& out) {
        if (!load(leaf)) return;
        const double edge = Octree::edge_of(tree_.level_of(leaf.morton));
        const Vec3 low = corner_of(tree_, leaf.morton);
        const Vec3 centre = {low[0] + 0.5 * edge, low[1] + 0.5 * edge, low[2] + 0.5 * edge};
        for (std::size_t a = 0; a < surfaces_.size(); ++a) {
            for (std::size_t b = a + 1; b < surfaces_.size(); ++b) {
                tape::Pole pole;
                if (!tape::find_pole(model_, surfaces_[a], surfaces_[b], centre, kPoleReach * edge, &pole))
                    continue;
                bool near = true;
                for (std::size_t j = 0; j < 3; ++j)
                    near = near && std::fabs(pole.at[j] - centre[j]) <= (0.5 + kSame) * edge;
                if (near && bounds_solid(a, b, pole, edge)) out.push_back(std::move(pole));
            }
        }
    }

    /// Surfaces of the leaf that pass through the pole; none if its own are not all among them.
    std::vector<std::uint32_t> through(const TreeNode& leaf, const tape::Pole& pole) {
        std::vector<std::uint32_t> result;
        if (!load(leaf)) return result;
        const double edge = Octree::edge_of(tree_.level_of(leaf.morton));
        for (const std::uint32_t s : surfaces_) {
            if (std::fabs(distance_to(s, pole.at)) < kThrough * edge) result.push_back(s);
        }
        const bool all =
            std::includes(result.begin(), result.end(), pole.surfaces.begin(), pole.surfaces.end());
        return all ? result : std::vector<std::uint32_t>{};
    }

  private:
    bool load(const TreeNode& leaf) {
        surfaces_.clear();
        if (leaf.tape_length < 3 || tree_.joint_in(leaf.morton) != nullptr) return false;
        const std::uint32_t* words = tree_.tapes.data() + leaf.tape_offset;
        tape::list_surfaces(words, leaf.tape_length, surfaces_);
        if (surfaces_.size() > kMostSurfaces) return false;
        words_ = words;
        length_ = leaf.tape_length;
        return surfaces_.size() > 1;
    }

    /// Whether both surfaces bound the solid at the pole; adds the others that do.
    bool bounds_solid(std::size_t a, std::size_t b, tape::Pole& pole, double edge) {
        std::vector<std::size_t> through = {a, b};
        std::vector<std::int8_t> signs(surfaces_.size(), 0);
        for (std::size_t s = 0; s < surfaces_.size(); ++s) {
            if (s == a || s == b) continue;
            const double distance = distance_to(surfaces_[s], pole.at) / edge;
            if (!(std::fabs(distance) > kLeast)) {
                if (!(std::fabs(distance) < kThrough) || through.size() == kMostThrough) return false;
                through.push_back(s);
            }
            signs[s] = distance < 0 ? -1 : 1;
        }
        local_tape_.load(words_, length_, surfaces_);
        std::vector<std::int32_t> region(std::size_t{1} << through.size());
        for (std::size_t k = 0; k < region.size(); ++k) {
            for (std::size_t i = 0; i < through.size(); ++i) signs[through[i]] = ((k >> i) & 1) != 0 ? 1 : -1;
            region[k] = local_tape_.resolve(signs.data());
        }
        for (std::size_t i = 0; i < through.size(); ++i) {
            bool matters = false;
            for (std::size_t k = 0; k < region.size(); ++k)
                matters = matters || region[k] != region[k ^ (std::size_t{1} << i)];
            if (i < 2 && !matters) return false;
            if (i >= 2 && matters) pole.surfaces.push_back(surfaces_[through[i]]);
        }
        std::sort(pole.surfaces.begin(), pole.surfaces.end());
        for (const std::size_t s : through) pole.through.push_back(surfaces_[s]);
        pole.is_skin = is_skin(through, region, pole);
        pole.region = std::move(region);
        return true;
    }

    /// Whether all sectors of the pole have one region below the surfaces that touch there and another above:
    /// then, moved along the tangent plane, it still parts nothing but these.
    bool is_skin(const std::vector<std::size_t>& through, const std::vector<std::int32_t>& region,
                 const tape::Pole& pole) const {
        std::size_t touching = 0;  // bits of surfaces whose normal is the pole's
        std::size_t below = 0;     // of those, which are positive below
        for (std::size_t i = 0; i < through.size(); ++i) {
            const SurfaceSample f = sample(surfaces_[through[i]], pole.at);
            const Vec3 gradient = {f.gradient[0], f.gradient[1], f.gradient[2]};
            const double along = dot(gradient, pole.normal) / std::sqrt(dot(gradient, gradient));
            if (std::fabs(along) < kTouching) continue;
            touching |= std::size_t{1} << i;
            if (along < 0) below |= std::size_t{1} << i;
        }
        const std::size_t above = touching & ~below;
        for (std::size_t k = 0; k < region.size(); ++k) {
            if ((k & touching) == below && region[k] != region[below]) return false;
            if ((k & touching) == above && region[k] != region[above]) return false;
        }
        return region[below] != region[above];
    }

    SurfaceSample sample(std::uint32_t surface, const Vec3& x) const {
        return surface_sample(&model_.surfaces[surface], model_.expression_ops.data(), x[0], x[1], x[2]);
    }

    double distance_to(std::uint32_t surface, const Vec3& x) const {
        const SurfaceSample f = sample(surface, x);
        return f.value / std::sqrt(f.gradient[0] * f.gradient[0] + f.gradient[1] * f.gradient[1] +
                                   f.gradient[2] * f.gradient[2]);
    }

    const tape::BoundModel& model_;
    const Octree& tree_;
    tape::LocalTape local_tape_;
    std::vector<std::uint32_t> surfaces_;
    const std::uint32_t* words_ = nullptr;
    std::size_t length_ = 0;
};

/// Gives each pole to the leaf that holds it, or to the two leaves at a face.
class Placing {
  public:
    Placing(const tape::BoundModel& model, Octree& tree) : tree_(tree), search_(model, tree) {}

    void add(const tape::Pole& pole) {
        const double cells = std::ldexp(1.0, tree_.level);
        std::uint32_t at[3];
        for (std::size_t j = 0; j < 3; ++j)
            at[j] = static_cast<std::uint32_t>(std::clamp(std::floor(pole.at[j] * cells), 0.0, cells - 1));
        const Leaf leaf = tree_.at(morton_encode(at[0], at[1], at[2]));
        if (leaf.kind != kLeafNio) return;
        const std::vector<std::uint32_t> own = search_.through(tree_.nio[leaf.index], pole);
        if (own.empty()) return;
        const double edge = Octree::edge_of(leaf.level);
        const Vec3 low = corner_of(tree_, leaf.code);
        Vec3 local{};
        for (std::size_t j = 0; j < 3; ++j) local[j] = (pole.at[j] - low[j]) / edge;
        if (!add_to_face(pole, own, leaf, local) && is_inside(local, 3)) {
            if (!is_taken(leaf.code)) take(entry(leaf.code, LeafPole::kInside, local, local, true, own));
        }
    }

  private:
    static bool is_inside(const Vec3& local, std::size_t except) {
        bool inside = true;
        for (std::size_t j = 0; j < 3; ++j)
            inside = inside && (j == except || (local[j] >= kLeast && local[j] <= 1 - kLeast));
        return inside;
    }

    bool is_taken(std::uint64_t morton) const { return taken_.count(morton) != 0; }

    void take(LeafPole pole) {
        taken_.insert(pole.morton);
        tree_.leaf_poles.push_back(std::move(pole));
    }

    static LeafPole::Point on_lattice(const Vec3& local) {
        LeafPole::Point at{};
        for (std::size_t j = 0; j < 3; ++j)
            at[j] = static_cast<std::int32_t>(std::rint(local[j] * kCellUnits));
        return at;
    }

    /// The apex counts only inside the leaf.
    static LeafPole entry(std::uint64_t morton, int face, const Vec3& local, const Vec3& apex, bool has_apex,
                          const std::vector<std::uint32_t>& through) {
        bool inside = has_apex;
        for (const double x : apex) inside = inside && x >= kLeast && x <= 1 - kLeast;
        return {morton, face, on_lattice(local), inside, on_lattice(apex), through};
    }

    /// The pole, moved along its tangent plane to where a coordinate has this value.
    static Vec3 slide(const tape::Pole& pole, const Vec3& local, std::size_t axis, double to) {
        const double way = to - local[axis];
        const double upright = pole.normal[axis] * pole.normal[axis];
        Vec3 slid = local;
        if (upright < kUpright) {
            for (std::size_t j = 0; j < 3; ++j) {
                const double tangent = (j == axis ? 1 : 0) - pole.normal[axis] * pole.normal[j];
                slid[j] += way / (1 - upright) * tangent;
            }
        }
        slid[axis] = to;
        return slid;
    }

    /// Close to a face, the cone's elements there would be flat: the pole slides onto the face, along its
    /// surfaces, and improvement moves the node back.
    bool add_to_face(const tape::Pole& pole, const std::vector<std::uint32_t>& own, const Leaf& leaf,
                     const Vec3& local) {
        std::size_t axis = 0;
        const auto gap = [&](std::size_t j) { return std::min(local[j], 1 - local[j]); };
        for (std::size_t j = 1; j < 3; ++j) {
            if (gap(j) < gap(axis)) axis = j;
        }
        if (gap(axis) > kNearFace) return false;
        const bool high = local[axis] > 0.5;
        Vec3 slid = slide(pole, local, axis, high ? 1 : 0);
        if (!is_inside(slid, axis)) return false;
        const int face = 2 * static_cast<int>(axis) + (high ? 1 : 0);
        const Tree tree = tree_.view();
        const Leaf beyond = leaf_beyond(&tree, leaf.code, leaf.level, face);
        if (beyond.kind != kLeafNio || beyond.level != leaf.level || is_taken(leaf.code) ||
            is_taken(beyond.code))
            return false;
        const std::vector<std::uint32_t> other = search_.through(tree_.nio[beyond.index], pole);
        if (other.empty()) return false;
        const bool has_apex =
            pole.is_skin && own.size() > 2 && pole.normal[axis] * pole.normal[axis] < kUpright;
        take(entry(leaf.code, face, slid, slide(pole, slid, axis, high ? 1 - kDeep : kDeep), has_apex, own));
        slid[axis] = high ? 0 : 1;
        take(entry(beyond.code, face ^ 1, slid, slide(pole, slid, axis, high ? kDeep : 1 - kDeep), has_apex,
                   other));
        return true;
    }

    Octree& tree_;
    LeafSearch search_;
    std::set<std::uint64_t> taken_;
};

}  // namespace

void find_poles(const tape::BoundModel& model, Octree& tree, int threads) {
    std::vector<std::vector<tape::Pole>> found(chunk_count(tree.nio.size(), kPoleChunk));
    parallel_chunks(tree.nio.size(), kPoleChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        LeafSearch search(model, tree);
        for (std::size_t i = begin; i < end; ++i) search.run(tree.nio[i], found[begin / kPoleChunk]);
    });
    tree.poles.clear();
    tree.leaf_poles.clear();
    for (auto& part : found) {
        tree.poles.insert(tree.poles.end(), std::make_move_iterator(part.begin()),
                          std::make_move_iterator(part.end()));
    }
    // Neighbours find the same pole.
    std::stable_sort(tree.poles.begin(), tree.poles.end(),
                     [](const tape::Pole& a, const tape::Pole& b) { return a.surfaces < b.surfaces; });
    std::vector<tape::Pole> once;
    std::size_t first = 0;  // with the surfaces at hand
    for (tape::Pole& pole : tree.poles) {
        if (!once.empty() && once.back().surfaces != pole.surfaces) first = once.size();
        const auto is_same = [&](const tape::Pole& other) {
            bool near = true;
            for (std::size_t j = 0; j < 3; ++j)
                near = near && std::fabs(pole.at[j] - other.at[j]) <= kSame * tree.finest_edge();
            return near;
        };
        const auto same = once.begin() + static_cast<std::ptrdiff_t>(first);
        if (std::none_of(same, once.end(), is_same)) once.push_back(std::move(pole));
    }
    tree.poles = std::move(once);
    Placing placing(model, tree);
    for (const tape::Pole& pole : tree.poles) placing.add(pole);
    std::sort(tree.leaf_poles.begin(), tree.leaf_poles.end(),
              [](const LeafPole& a, const LeafPole& b) { return a.morton < b.morton; });
}

}  // namespace mortise::octree
