// Node classification; rules in features.hpp.
#include "host/features/features.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/index_set.hpp"
#include "host/common/sort_unique.hpp"
#include "host/features/surfaces.hpp"

namespace mortise::features {
namespace {

constexpr std::uint8_t kAlwaysCorner = 2;  ///< a marked node, whatever its creases
constexpr std::uint8_t kCorner = 0, kCrease = 1, kFace = 2, kRegion = 3;

/// The crease edges of one node.
struct NodeCreases {
    NodeId node;
    std::uint32_t edges;
    double model_angle;
};

std::vector<NodeCreases> by_node(const std::vector<CreaseEdge>& edges) {
    std::vector<NodeCreases> ends;
    for (const CreaseEdge& e : edges) {
        ends.push_back({e.a, 1, e.model_angle});
        ends.push_back({e.b, 1, e.model_angle});
    }
    std::sort(ends.begin(), ends.end(),
              [](const NodeCreases& p, const NodeCreases& q) { return p.node < q.node; });
    std::size_t count = 0;
    for (const NodeCreases& end : ends) {
        if (count > 0 && ends[count - 1].node == end.node) {
            ++ends[count - 1].edges;
            ends[count - 1].model_angle = std::min(ends[count - 1].model_angle, end.model_angle);
        } else {
            ends[count++] = end;
        }
    }
    ends.resize(count);
    return ends;
}

/// A surface with a facet at a node.
struct Incidence {
    NodeId node;
    std::uint32_t bound, named;
    bool operator<(const Incidence& other) const {
        return node != other.node ? node < other.node : bound < other.bound;
    }
    bool operator==(const Incidence& other) const { return node == other.node && bound == other.bound; }
};

/// What is said of the nodes on facets: nothing, that they lie on a crease, or kAlwaysCorner.
class Marks {
  public:
    explicit Marks(const Mesh& mesh) : nodes_(mesh.node_count()) {
        for (const NodeId node : mesh.facets.nodes) nodes_.insert(node);
        nodes_.number();
        marks_.assign(nodes_.size(), 0);
    }
    std::uint8_t& operator[](NodeId node) { return marks_[nodes_.place(node)]; }
    std::uint8_t operator[](NodeId node) const { return marks_[nodes_.place(node)]; }

  private:
    IndexSet nodes_;
    std::vector<std::uint8_t> marks_;
};

/// Surfaces around the nodes that are marked, sorted by node, then surface.
std::vector<Incidence> surfaces_around(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                                       const Marks& marked) {
    std::vector<Incidence> list;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        for (std::size_t k = 0; k < 4; ++k) {
            const NodeId node = mesh.facets.nodes[4 * f + k];
            if (marked[node] != 0) list.push_back({node, facet_surface[f], mesh.facets.surface[f]});
        }
    }
    sort_unique(list);
    return list;
}

bool spans_a_corner(const tape::BoundModel& model, const Vector& local, const Incidence* list,
                    std::size_t count) {
    std::vector<Vector> normal;
    for (std::size_t i = 0; i < count; ++i) normal.push_back(unit_normal(model, list[i].bound, local));
    for (std::size_t i = 2; i < count; ++i) {
        for (std::size_t j = 1; j < i; ++j) {
            for (std::size_t k = 0; k < j; ++k) {
                if (is_corner(normal[i], normal[j], normal[k])) return true;
            }
        }
    }
    return false;
}

/// Marks nodes at singular points of a surface that has facets there.
void mark_singular(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                   const tape::BoundModel& model, double same_point, Marks& marked) {
    struct Singular {
        bool is = false;
        Vector point;
    };
    std::vector<Singular> singular(model.surfaces.size());
    bool any = false;
    for (std::size_t s = 0; s < singular.size(); ++s) {
        singular[s].is = singular_point(model.surfaces[s], &singular[s].point);
        any = any || singular[s].is;
    }
    if (!any) return;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const Singular& s = singular[facet_surface[f]];
        if (!s.is) continue;
        for (std::size_t k = 0; k < 4; ++k) {
            const NodeId node = mesh.facets.nodes[4 * f + k];
            const Vector local = to_local(model, point_of(mesh, node));
            if (length(local - s.point) < same_point) marked[node] = kAlwaysCorner;
        }
    }
}

}  // namespace

Features find_features(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                       const tape::BoundModel& model, int level) {
    Features features;
    std::vector<std::uint8_t>& dimension = features.model_dimension;
    dimension.assign(mesh.node_count(), kRegion);
    for (const NodeId node : mesh.facets.nodes) dimension[node] = kFace;

    const Creases found = find_creases(mesh, facet_surface, model, level);
    const std::vector<NodeCreases> creases = by_node(found.edges);
    Marks marked(mesh);
    for (const NodeCreases& c : creases) marked[c.node] = 1;
    for (const NodeId node : found.poles) marked[node] = kAlwaysCorner;
    mark_singular(mesh, facet_surface, model, same_point(level), marked);
    const std::vector<Incidence> around = surfaces_around(mesh, facet_surface, marked);

    std::vector<NodeId> ends;
    auto crease = creases.begin();
    for (std::size_t i = 0, j = 0; i < around.size(); i = j) {
        const NodeId node = around[i].node;
        while (j < around.size() && around[j].node == node) ++j;
        while (crease != creases.end() && crease->node < node) ++crease;
        const bool on_crease = crease != creases.end() && crease->node == node;
        dimension[node] = kCrease;
        if (marked[node] != kAlwaysCorner && crease->edges == 2 &&
            !spans_a_corner(model, to_local(model, point_of(mesh, node)), around.data() + i, j - i)) {
            continue;
        }
        dimension[node] = kCorner;
        ends.push_back(node);
        FeatureCorner corner{node, {}, on_crease ? crease->model_angle : 360};
        for (std::size_t k = i; k < j; ++k) corner.surfaces.push_back(around[k].named);
        sort_unique(corner.surfaces);
        features.corners.push_back(std::move(corner));
    }
    features.curves = chain(mesh, found.edges, ends);
    return features;
}

}  // namespace mortise::features
