// Creases near poles: edges that are too flat there to be told from their angle.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "host/features/features.hpp"
#include "host/features/surfaces.hpp"
#include "host/tape/pole.hpp"

namespace mortise::features {
namespace {

constexpr double kTouching = 1e-5;  ///< sine between normals, and distance in edges of the root box

class PoleJoiner {
  public:
    PoleJoiner(const Mesh& mesh, const tape::BoundModel& model, const SurfaceEdges& edges)
        : mesh_(mesh), model_(model), edges_(edges), taken_(edges.smooth.size(), false) {
        for (std::uint32_t i = 0; i < edges.smooth.size(); ++i) list(edges.smooth[i], i);
        if (ends_.empty()) return;
        for (const CreaseEdge& crease : edges.creases) list(crease, kCrease);
        std::sort(ends_.begin(), ends_.end());
    }

    Creases run(double same_point) {
        Creases result;
        for (std::size_t i = 0, j = 0; i < ends_.size(); i = j) {
            while (j < ends_.size() && ends_[j].node == ends_[i].node) ++j;
            for (std::size_t k = i; k < j && ends_[k].smooth != kCrease; ++k) {
                if (!is_pole(ends_[k], same_point)) continue;
                if (result.poles.empty() || result.poles.back() != ends_[k].node)
                    result.poles.push_back(ends_[k].node);
                follow(ends_[k]);
            }
        }
        result.edges = edges_.creases;
        for (std::size_t i = 0; i < taken_.size(); ++i) {
            if (taken_[i]) result.edges.push_back(edges_.smooth[i]);
        }
        std::sort(result.edges.begin(), result.edges.end(), [](const CreaseEdge& a, const CreaseEdge& b) {
            return std::tie(a.a, a.b) < std::tie(b.a, b.b);
        });
        return result;
    }

  private:
    static constexpr std::uint32_t kCrease = 0xffffffffu;

    struct End {
        NodeId node;
        std::uint32_t smooth;  ///< index of the edge; kCrease: a crease edge
        std::array<std::uint32_t, 2> bound;
        bool operator<(const End& other) const {
            return std::tie(node, smooth, bound) < std::tie(other.node, other.smooth, other.bound);
        }
    };

    void list(const CreaseEdge& edge, std::uint32_t smooth) {
        ends_.push_back({edge.a, smooth, edge.bound});
        ends_.push_back({edge.b, smooth, edge.bound});
    }

    /// Whether the two surfaces of a smooth edge have a pole at its end.
    bool is_pole(const End& end, double same_point) const {
        if (end.bound[0] == end.bound[1]) return false;
        const Vector x = to_local(model_, point_of(mesh_, end.node));
        Vector normal[2];
        for (std::size_t i = 0; i < 2; ++i) {
            const SurfaceSample s = sample(model_, end.bound[i], x);
            const Vector gradient{s.gradient[0], s.gradient[1], s.gradient[2]};
            if (!(std::fabs(s.value) <= kTouching * length(gradient))) return false;
            normal[i] = unit(gradient);
        }
        if (!(length(cross(normal[0], normal[1])) < kTouching)) return false;
        const CreaseEdge& edge = edges_.smooth[end.smooth];
        const double reach = length(point_of(mesh_, edge.a) - point_of(mesh_, edge.b)) / model_.side;
        tape::Pole pole;
        return tape::find_pole(model_, end.bound[0], end.bound[1], {x.x, x.y, x.z}, reach, &pole) &&
               length(Vector{pole.at[0], pole.at[1], pole.at[2]} - x) < same_point;
    }

    /// Takes the smooth edges of a branch, from its end at the pole to where it is sharp.
    void follow(End from) {
        while (from.smooth != kCrease && !taken_[from.smooth]) {
            const CreaseEdge& edge = edges_.smooth[from.smooth];
            taken_[from.smooth] = true;
            const NodeId next = edge.a == from.node ? edge.b : edge.a;
            const auto begin = std::lower_bound(ends_.begin(), ends_.end(), End{next, 0, {}});
            auto other = ends_.end();
            std::size_t count = 0;
            for (auto end = begin; end != ends_.end() && end->node == next; ++end, ++count) {
                if (end->smooth != from.smooth) other = end;
            }
            if (count != 2 || other->bound != from.bound) return;
            from = *other;
        }
    }

    const Mesh& mesh_;
    const tape::BoundModel& model_;
    const SurfaceEdges& edges_;
    std::vector<bool> taken_;
    std::vector<End> ends_;  ///< sorted
};

}  // namespace

Creases find_creases(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                     const tape::BoundModel& model, int level) {
    const SurfaceEdges edges = find_surface_edges(mesh, facet_surface, model);
    return PoleJoiner(mesh, model, edges).run(same_point(level));
}

}  // namespace mortise::features
