#include "tests/improve/graded_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "mortise/model.hpp"

namespace mortise::test {
namespace {

using Place = std::array<int, 3>;

struct Cube {
    Place low;
    int edge;
    bool operator<(const Cube& other) const { return low != other.low ? low < other.low : edge < other.edge; }
};

/// Corners of the face of a cube, outward.
std::array<Place, 4> face_of(const Cube& c, int face) {
    std::array<Place, 4> result;
    const LocalFace& local = kHexahedronFaces[static_cast<std::size_t>(face)];
    const int corner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                              {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    for (std::size_t k = 0; k < 4; ++k) {
        for (std::size_t j = 0; j < 3; ++j) result[k][j] = c.low[j] + c.edge * corner[local[k]][j];
    }
    return result;
}

Place middle(const Place& a, const Place& b) {
    return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
}

class Maker {
  public:
    explicit Maker(std::vector<Cube> cubes) : cubes_(std::move(cubes)) {
        for (const Cube& c : cubes_) {
            for (int f = 0; f < 6; ++f) {
                for (const Place& p : face_of(c, f)) corners_.insert(p);
            }
        }
    }

    Mesh make() {
        for (const Cube& c : cubes_) add(c);
        mesh_.region_names = {"solid"};
        return std::move(mesh_);
    }

  private:
    bool is_node(const Place& p) const { return corners_.count(p) != 0; }

    NodeId node(const Place& p) {
        const auto found = number_.find(p);
        if (found != number_.end()) return found->second;
        const auto n = static_cast<NodeId>(mesh_.node_count());
        for (const int x : p) mesh_.points.push_back(x);
        number_[p] = n;
        return n;
    }

    /// Polygons of a face: its quarters if they are faces of finer leaves, else itself with nodes on its
    /// edges.
    void add_polygons(const std::array<Place, 4>& face, int edge,
                      std::vector<std::vector<Place>>& out) const {
        const Place centre = middle(face[0], face[2]);
        if (edge > 1 && is_node(centre)) {
            for (std::size_t k = 0; k < 4; ++k) {
                out.push_back({face[k], middle(face[k], face[(k + 1) % 4]), centre,
                               middle(face[(k + 3) % 4], face[k])});
            }
            return;
        }
        std::vector<Place> polygon;
        for (std::size_t k = 0; k < 4; ++k) {
            polygon.push_back(face[k]);
            const Place m = middle(face[k], face[(k + 1) % 4]);
            if (edge > 1 && is_node(m)) polygon.push_back(m);
        }
        out.push_back(std::move(polygon));
    }

    /// Triangles about the least node on an edge's middle, so that both sides cut alike; quadrilaterals stay.
    static void divide(const std::vector<Place>& polygon, std::vector<std::vector<Place>>& out) {
        if (polygon.size() == 4) {
            out.push_back(polygon);
            return;
        }
        const std::size_t n = polygon.size();
        std::size_t first = n;
        for (std::size_t k = 0; k < n; ++k) {
            const Place m = middle(polygon[(k + n - 1) % n], polygon[(k + 1) % n]);
            if (m == polygon[k] && (first == n || polygon[k] < polygon[first])) first = k;
        }
        for (std::size_t k = 1; k + 1 < n; ++k) {
            out.push_back({polygon[first], polygon[(first + k) % n], polygon[(first + k + 1) % n]});
        }
    }

    void add_element(ElementType type, const std::vector<NodeId>& nodes, ElementKind kind) {
        ElementBlock& block = mesh_.block(type);
        block.nodes.insert(block.nodes.end(), nodes.begin(), nodes.end());
        block.region.push_back(1);
        block.kind.push_back(static_cast<std::uint8_t>(kind));
    }

    void add(const Cube& c) {
        std::vector<std::vector<Place>> faces;
        bool whole = true;
        for (int f = 0; f < 6; ++f) {
            std::vector<std::vector<Place>> polygons;
            add_polygons(face_of(c, f), c.edge, polygons);
            whole = whole && polygons.size() == 1 && polygons[0].size() == 4;
            const std::size_t before = faces.size();
            for (const auto& polygon : polygons) divide(polygon, faces);
            if (is_covered(c, f)) continue;
            for (std::size_t i = before; i < faces.size(); ++i) add_facet(faces[i]);
        }
        if (whole) {
            std::vector<NodeId> nodes;
            for (const int f : {0, 1}) {
                auto corners = face_of(c, f);
                if (f == 0) std::swap(corners[1], corners[3]);
                for (const Place& p : corners) nodes.push_back(node(p));
            }
            add_element(ElementType::kHexahedron, nodes, ElementKind::kSnio);
            return;
        }
        const auto centre = static_cast<NodeId>(mesh_.node_count());
        for (const int x : c.low) mesh_.points.push_back(x + 0.5 * c.edge);
        for (const auto& face : faces) {
            std::vector<NodeId> nodes;
            for (std::size_t k = face.size(); k-- > 0;) nodes.push_back(node(face[k]));
            nodes.push_back(centre);
            add_element(face.size() == 4 ? ElementType::kPyramid : ElementType::kTetrahedron, nodes,
                        ElementKind::kIn);
        }
    }

    bool is_covered(const Cube& c, int face) const {
        const auto corners = face_of(c, face);
        for (std::size_t j = 0; j < 3; ++j) {
            if (std::any_of(corners.begin(), corners.end(),
                            [&](const Place& p) { return p[j] != corners[0][j]; }))
                continue;
            return corners[0][j] != low_ && corners[0][j] != high_;
        }
        return true;
    }

    void add_facet(const std::vector<Place>& face) {
        for (std::size_t k = 0; k < 4; ++k)
            mesh_.facets.nodes.push_back(node(face[std::min(k, face.size() - 1)]));
        mesh_.facets.surface.push_back(0);
        mesh_.facets.inside.push_back(1);
        mesh_.facets.outside.push_back(0);
    }

    std::vector<Cube> cubes_;
    std::set<Place> corners_;
    std::map<Place, NodeId> number_;
    Mesh mesh_;

  public:
    int low_ = 0, high_ = 0;
};

}  // namespace

GradedMesh graded_mesh(int level, const std::function<bool(const Vec3& low, double edge)>& wanted) {
    const int side = 1 << level;
    std::set<Cube> leaves;
    std::vector<Cube> open = {{{0, 0, 0}, side}};
    const auto split = [&](const Cube& c, auto&& add) {
        const int half = c.edge / 2;
        for (int k = 0; k < 8; ++k) {
            add(Cube{{c.low[0] + (k & 1) * half, c.low[1] + (k >> 1 & 1) * half, c.low[2] + (k >> 2) * half},
                     half});
        }
    };
    while (!open.empty()) {
        const Cube c = open.back();
        open.pop_back();
        const Vec3 low = {double(c.low[0]), double(c.low[1]), double(c.low[2])};
        if (c.edge > 4 || (c.edge > 1 && wanted(low, c.edge))) {
            split(c, [&](const Cube& child) { open.push_back(child); });
        } else {
            leaves.insert(c);
        }
    }
    const auto touches = [](const Cube& a, const Cube& b) {
        for (std::size_t j = 0; j < 3; ++j) {
            if (a.low[j] > b.low[j] + b.edge || b.low[j] > a.low[j] + a.edge) return false;
        }
        return true;
    };
    for (bool again = true; again;) {
        again = false;
        for (auto a = leaves.begin(); a != leaves.end() && !again; ++a) {
            again = std::any_of(leaves.begin(), leaves.end(),
                                [&](const Cube& b) { return 2 * b.edge < a->edge && touches(*a, b); });
            if (!again) continue;
            const Cube c = *a;
            leaves.erase(a);
            split(c, [&](const Cube& child) { leaves.insert(child); });
            break;
        }
    }
    GradedMesh result;
    result.leaves.level = level;
    const int low = 4, high = side - 4;
    std::vector<std::pair<std::uint64_t, Cube>> order;
    for (const Cube& c : leaves) {
        if (*std::min_element(c.low.begin(), c.low.end()) < low) continue;
        if (*std::max_element(c.low.begin(), c.low.end()) + c.edge > high) continue;
        order.push_back(
            {morton_encode(static_cast<std::uint32_t>(c.low[0]), static_cast<std::uint32_t>(c.low[1]),
                           static_cast<std::uint32_t>(c.low[2])),
             c});
    }
    std::sort(order.begin(), order.end());
    std::vector<Cube> cubes;
    for (const auto& entry : order) {
        cubes.push_back(entry.second);
        result.leaves.code.push_back(entry.first);
        int leaf_level = level;
        for (int edge = 1; edge < entry.second.edge; edge *= 2) --leaf_level;
        result.leaves.leaf_level.push_back(static_cast<std::uint8_t>(leaf_level));
    }
    Maker maker(std::move(cubes));
    maker.low_ = low;
    maker.high_ = high;
    result.mesh = maker.make();
    Model model;
    const auto from = static_cast<double>(low), to = static_cast<double>(high);
    const std::uint32_t box = model.add_primitive(mortise::box({from, from, from}, {to, to, to}), "box");
    model.regions.push_back({"solid", box, 0, {}});
    result.model = tape::bind(tape::compile(model), {0, 0, 0}, side);
    for (std::size_t i = 0; i < result.model.surfaces.size(); ++i)
        result.mesh.surface_names.push_back("surface" + std::to_string(i));
    for (std::size_t f = 0; f < result.mesh.facets.size(); ++f) {
        for (std::uint32_t s = 0; s < result.model.surfaces.size(); ++s) {
            const double* plane = result.model.surfaces[s].map;
            double worst = 0;
            for (std::size_t k = 0; k < 4; ++k) {
                double value = plane[3];
                for (std::size_t j = 0; j < 3; ++j)
                    value +=
                        plane[j] * result.mesh.points[3 * result.mesh.facets.nodes[4 * f + k] + j] / side;
                worst = std::max(worst, std::fabs(value));
            }
            if (worst < 1e-12) result.mesh.facets.surface[f] = s;
        }
    }
    return result;
}

}  // namespace mortise::test
