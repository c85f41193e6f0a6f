// See causes.hpp. Only the nodes of the worst elements are looked at.
#include "host/report/causes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "host/common/constants.hpp"
#include "host/common/message_text.hpp"
#include "host/features/surfaces.hpp"

namespace mortise::report {
namespace {

using features::Vector;

constexpr double kStrongTurn = 15;  // degrees that a surface turns in one element

std::string degrees(double angle) { return rounded_text(angle, 3) + " degrees"; }

/// What the model has at a node.
struct NodeFacts {
    std::set<std::uint32_t> bound;            ///< surfaces of facets around it
    std::set<std::uint32_t> named;            ///< the same by name
    const FeatureCorner* corner = nullptr;    ///< if it is one
    std::vector<const FeatureCurve*> curves;  ///< through it
};

std::vector<NodeId> nodes_of(const Mesh& mesh, const WorstElement& element) {
    const auto type = static_cast<std::size_t>(element.type);
    const auto count = static_cast<std::size_t>(kElementNodes[type]);
    const auto first = mesh.elements[type].nodes.begin() + static_cast<std::ptrdiff_t>(count * element.index);
    return {first, first + static_cast<std::ptrdiff_t>(count)};
}

std::string join(const Mesh& mesh, const std::set<std::uint32_t>& surfaces) {
    std::string text;
    std::size_t listed = 0;
    for (const std::uint32_t s : surfaces) {
        if (listed++ == 4) return text + ", …";
        text += (text.empty() ? "" : ", ") + mesh.surface_names[s];
    }
    return text;
}

class Judge {
  public:
    Judge(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface, const tape::BoundModel& model,
          const Features& features, const QualityReport& report)
        : mesh_(mesh), model_(model) {
        for (const WorstElement& element : report.worst) {
            for (const NodeId node : nodes_of(mesh, element)) facts_[node];
        }
        for (std::size_t i = 0; i < mesh.facets.nodes.size(); ++i) {
            if (features.model_dimension[mesh.facets.nodes[i]] == 3) continue;
            const auto found = facts_.find(mesh.facets.nodes[i]);
            if (found == facts_.end()) continue;
            found->second.bound.insert(facet_surface[i / 4]);
            found->second.named.insert(mesh.facets.surface[i / 4]);
        }
        for (const FeatureCorner& corner : features.corners) {
            const auto found = facts_.find(corner.node);
            if (found != facts_.end()) found->second.corner = &corner;
        }
        for (const FeatureCurve& curve : features.curves) {
            for (const NodeId node : curve.nodes) {
                const auto found = facts_.find(node);
                if (found != facts_.end()) found->second.curves.push_back(&curve);
            }
        }
    }

    std::string cause(const WorstElement& element) const {
        std::set<std::uint32_t> bound, named;
        const FeatureCorner* corner = nullptr;
        const FeatureCurve* curve = nullptr;
        double angle = 360;
        for (const NodeId node : nodes_of(mesh_, element)) {
            const NodeFacts& facts = facts_.at(node);
            bound.insert(facts.bound.begin(), facts.bound.end());
            named.insert(facts.named.begin(), facts.named.end());
            if (facts.corner != nullptr && (corner == nullptr || facts.corner->model_angle < angle)) {
                corner = facts.corner;
                angle = corner->model_angle;
            }
            for (const FeatureCurve* c : facts.curves) {
                if (curve == nullptr || c->model_angle < curve->model_angle) curve = c;
            }
        }
        if (corner != nullptr) {
            const std::string sharpest = angle < 360 ? ", smallest model angle " + degrees(angle) : "";
            return "touches corner of " + join(mesh_, {corner->surfaces.begin(), corner->surfaces.end()}) +
                   sharpest;
        }
        if (curve != nullptr) return "crease " + curve->name + ", model angle " + degrees(curve->model_angle);
        if (named.size() > 1) return "between surfaces " + join(mesh_, named);
        if (named.empty()) return "touches no surface";
        const double turn = largest_turn(element, *bound.begin());
        const std::string name = "surface " + mesh_.surface_names[*named.begin()];
        return turn > kStrongTurn ? name + ", turns by " + degrees(turn) + " in the element" : name;
    }

  private:
    /// Largest angle between a surface's normals at the nodes of an element.
    double largest_turn(const WorstElement& element, std::uint32_t surface) const {
        std::vector<Vector> normals;
        for (const NodeId node : nodes_of(mesh_, element)) {
            if (facts_.at(node).bound.count(surface) == 0) continue;
            const Vector local = features::to_local(model_, features::point_of(mesh_, node));
            normals.push_back(features::unit_normal(model_, surface, local));
        }
        double largest = 0;
        for (std::size_t i = 1; i < normals.size(); ++i) {
            for (std::size_t j = 0; j < i; ++j) {
                const Vector &p = normals[i], &q = normals[j];
                largest = std::max(largest, kDegrees * std::atan2(length(cross(p, q)), dot(p, q)));
            }
        }
        return largest;
    }

    const Mesh& mesh_;
    const tape::BoundModel& model_;
    std::map<NodeId, NodeFacts> facts_;
};

}  // namespace

void find_causes(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                 const tape::BoundModel& model, const Features& features, QualityReport& report) {
    const Judge judge(mesh, facet_surface, model, features, report);
    for (WorstElement& element : report.worst) element.cause = judge.cause(element);
}

}  // namespace mortise::report
