// Chains of crease edges.
#include <algorithm>

#include "host/features/features.hpp"
#include "host/quality/vector.hpp"

namespace mortise::features {
namespace {

class Chainer {
  public:
    Chainer(const Mesh& mesh, const std::vector<CreaseEdge>& edges, const std::vector<NodeId>& ends)
        : mesh_(mesh), edges_(edges), used_(edges.size(), false) {
        for (std::size_t e = 0; e < edges.size(); ++e) {
            ends_.push_back({edges[e].a, e});
            ends_.push_back({edges[e].b, e});
        }
        std::sort(ends_.begin(), ends_.end());
        for (std::size_t i = 0, j = 0; i < ends_.size(); i = j) {
            while (j < ends_.size() && ends_[j].node == ends_[i].node) ++j;
            if (j - i != 2 || !is_same_curve(edges[ends_[i].edge], edges[ends_[i + 1].edge]) ||
                std::binary_search(ends.begin(), ends.end(), ends_[i].node)) {
                breaks_.push_back(ends_[i].node);
            }
        }
    }

    std::vector<FeatureCurve> run() {
        for (const End& end : ends_) {
            if (!used_[end.edge] && is_break(end.node)) follow(end.node, end.edge);
        }
        for (const End& end : ends_) {
            if (!used_[end.edge]) follow(end.node, end.edge);
        }
        name();
        return std::move(curves_);
    }

  private:
    struct End {
        NodeId node;
        std::size_t edge;
        bool operator<(const End& other) const {
            return node != other.node ? node < other.node : edge < other.edge;
        }
    };

    /// Surfaces of the same names, or the same ones under other names.
    static bool is_same_curve(const CreaseEdge& a, const CreaseEdge& b) {
        return a.surfaces == b.surfaces || (a.bound[0] != a.bound[1] && a.bound == b.bound);
    }

    bool is_break(NodeId node) const { return std::binary_search(breaks_.begin(), breaks_.end(), node); }

    void follow(NodeId node, std::size_t edge) {
        FeatureCurve curve;
        curve.surfaces = edges_[edge].surfaces;
        curve.model_angle = 360;
        const NodeId start = node;
        curve.nodes.push_back(node);
        for (;;) {
            const CreaseEdge& e = edges_[edge];
            used_[edge] = true;
            curve.surfaces = std::min(curve.surfaces, e.surfaces);
            curve.model_angle = std::min(curve.model_angle, e.model_angle);
            curve.length += length(quality::point_of(mesh_, e.b) - quality::point_of(mesh_, e.a));
            node = e.a == node ? e.b : e.a;
            if (node == start && !is_break(node)) {
                curve.closed = true;
                break;
            }
            curve.nodes.push_back(node);
            if (is_break(node)) break;
            // Two ends here: the one that is not behind us.
            const auto at = std::lower_bound(ends_.begin(), ends_.end(), End{node, 0});
            edge = at->edge == edge ? (at + 1)->edge : at->edge;
        }
        curves_.push_back(std::move(curve));
    }

    void name() {
        std::stable_sort(curves_.begin(), curves_.end(), [](const FeatureCurve& p, const FeatureCurve& q) {
            return p.surfaces < q.surfaces;
        });
        for (std::size_t i = 0, j = 0; i < curves_.size(); i = j) {
            while (j < curves_.size() && curves_[j].surfaces == curves_[i].surfaces) ++j;
            const std::string pair = mesh_.surface_names[curves_[i].surfaces[0]] + "+" +
                                     mesh_.surface_names[curves_[i].surfaces[1]];
            for (std::size_t k = i; k < j; ++k) {
                curves_[k].name = j - i == 1 ? pair : pair + "." + std::to_string(k - i + 1);
            }
        }
    }

    const Mesh& mesh_;
    const std::vector<CreaseEdge>& edges_;
    std::vector<bool> used_;
    std::vector<End> ends_;       ///< sorted
    std::vector<NodeId> breaks_;  ///< nodes where curves end, ascending
    std::vector<FeatureCurve> curves_;
};

}  // namespace

std::vector<FeatureCurve> chain(const Mesh& mesh, const std::vector<CreaseEdge>& edges,
                                const std::vector<NodeId>& ends) {
    return Chainer(mesh, edges, ends).run();
}

}  // namespace mortise::features
