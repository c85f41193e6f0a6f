// The parts of the report put together, with model faces and expected corners.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "host/common/disjoint_sets.hpp"
#include "host/features/features.hpp"
#include "host/report/causes.hpp"
#include "host/report/corners.hpp"
#include "host/report/distance.hpp"
#include "host/report/elements.hpp"
#include "host/report/report.hpp"

namespace mortise::report {
namespace {

constexpr std::size_t kMostMissing = 20;

Vector normal_times_area(const Mesh& mesh, const NodeId* n) {
    const Vector a = features::point_of(mesh, n[0]), b = features::point_of(mesh, n[1]);
    const Vector c = features::point_of(mesh, n[2]), d = features::point_of(mesh, n[3]);
    return corner_count(n) == 3 ? 0.5 * cross(b - a, c - a) : 0.5 * cross(c - a, d - b);
}

/// Groups facets of one surface that share an edge which is no crease.
class Components {
  public:
    explicit Components(const Mesh& mesh) : mesh_(mesh), sets_(mesh.facets.size()) {}

    void join(const std::vector<features::CreaseEdge>& creases) {
        struct Edge {
            NodeId a, b;
            std::uint32_t facet;
        };
        std::vector<Edge> edges;
        for (std::size_t f = 0; f < sets_.size(); ++f) {
            const FacetNodes n = mesh_.facets.facet(f);
            for (std::size_t k = 0; k < n.size(); ++k) {
                const NodeId a = n[k], b = n.after(k);
                edges.push_back({std::min(a, b), std::max(a, b), static_cast<std::uint32_t>(f)});
            }
        }
        std::sort(edges.begin(), edges.end(), [](const Edge& p, const Edge& q) {
            return std::tie(p.a, p.b, p.facet) < std::tie(q.a, q.b, q.facet);
        });
        auto crease = creases.begin();
        for (std::size_t i = 1; i < edges.size(); ++i) {
            const Edge &p = edges[i - 1], &q = edges[i];
            if (p.a != q.a || p.b != q.b) continue;
            while (crease != creases.end() && std::tie(crease->a, crease->b) < std::tie(p.a, p.b)) ++crease;
            if (crease != creases.end() && crease->a == p.a && crease->b == p.b) continue;
            if (mesh_.facets.surface[p.facet] == mesh_.facets.surface[q.facet]) sets_.join(p.facet, q.facet);
        }
    }

    bool is_first(std::size_t facet) const { return sets_.is_first(static_cast<std::uint32_t>(facet)); }

  private:
    const Mesh& mesh_;
    DisjointSets sets_;
};

void report_surfaces(const Mesh& mesh, const std::vector<features::CreaseEdge>& creases,
                     QualityReport& report) {
    Components components(mesh);
    components.join(creases);
    report.surfaces.resize(mesh.surface_names.size());
    for (std::size_t s = 0; s < report.surfaces.size(); ++s) report.surfaces[s].name = mesh.surface_names[s];
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        SurfaceFigures& figures = report.surfaces[mesh.facets.surface[f]];
        ++figures.facets;
        figures.area += length(normal_times_area(mesh, mesh.facets.nodes.data() + 4 * f));
        if (components.is_first(f)) ++figures.components;
    }
}

/// Nearest of some points to a given one, by their order along x.
class NearestPoint {
  public:
    explicit NearestPoint(std::vector<Vector> points) : points_(std::move(points)) {
        std::sort(points_.begin(), points_.end(), [](const Vector& a, const Vector& b) { return a.x < b.x; });
    }

    /// Infinite if there are no points.
    double distance(const Vector& p) const {
        const auto middle = std::lower_bound(points_.begin(), points_.end(), p,
                                             [](const Vector& a, const Vector& b) { return a.x < b.x; });
        double best = HUGE_VAL;
        for (auto i = middle; i != points_.end() && i->x - p.x < best; ++i) {
            best = std::min(best, length(*i - p));
        }
        for (auto i = middle; i != points_.begin() && p.x - (i - 1)->x < best; --i) {
            best = std::min(best, length(*(i - 1) - p));
        }
        return best;
    }

  private:
    std::vector<Vector> points_;
};

/// The name under which a mesh lists a bound surface: known from the facets on it. Others have none.
std::vector<std::string> names_by_surface(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                                          std::size_t surfaces) {
    std::vector<std::string> names(surfaces, "?");
    for (std::size_t f = 0; f < facet_surface.size(); ++f) {
        names[facet_surface[f]] = mesh.surface_names[mesh.facets.surface[f]];
    }
    return names;
}

void report_corners(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                    const tape::BoundModel& model, const Features& features,
                    const std::vector<Corner>& expected, double same_point, QualityReport& report) {
    std::vector<Vector> in_mesh, in_model;
    for (const FeatureCorner& corner : features.corners) {
        in_mesh.push_back(features::to_local(model, features::point_of(mesh, corner.node)));
    }
    for (const Corner& corner : expected) in_model.push_back(corner.local);
    const NearestPoint mesh_corners(in_mesh), model_corners(std::move(in_model));
    const std::vector<std::string> names = names_by_surface(mesh, facet_surface, model.surfaces.size());
    report.corners_expected = expected.size();
    for (const Corner& corner : expected) {
        const double nearest = mesh_corners.distance(corner.local);
        if (nearest <= same_point) {
            ++report.corners_found;
        } else if (report.missing.size() < kMostMissing) {
            const Vector place = features::to_model(model, corner.local);
            ModelCorner missing{{place.x, place.y, place.z}, {}, -1};
            if (std::isfinite(nearest)) missing.nearest = model.side * nearest;
            for (const std::uint32_t s : corner.surfaces) missing.surfaces.push_back(names[s]);
            report.missing.push_back(std::move(missing));
        }
    }
    for (const Vector& corner : in_mesh) {
        if (model_corners.distance(corner) > same_point) ++report.corners_extra;
    }
}

/// What one subtree of leaves gives.
struct Gathered {
    std::vector<BoundaryPoint> points;
    std::vector<Corner> corners;
};

}  // namespace

QualityReport assess(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                     const tape::BoundModel& model, const Features& features, const Options& options) {
    QualityReport report;
    report.has_model = true;
    report.cell_size = std::ldexp(model.side, -options.level);
    report_elements(mesh, options.worst, options.threads, report);
    find_causes(mesh, facet_surface, model, features, report);
    report_surfaces(mesh, features::find_creases(mesh, facet_surface, model, options.level).edges, report);
    for (const FeatureCurve& curve : features.curves) report.crease_length += curve.length;
    report_facets(mesh, facet_surface, model, options.threads, report);

    const Depth depth = Depth::of(options.level, options.leaves);
    std::vector<Gathered> parts =
        visit_leaves<Gathered>(model, depth, options.threads, [&](const Leaf& leaf, Gathered& gathered) {
            sample_boundary(model, leaf, depth, gathered.points);
            find_corners(model, leaf, gathered.corners);
        });
    Gathered all;
    for (Gathered& part : parts) {
        all.points.insert(all.points.end(), part.points.begin(), part.points.end());
        all.corners.insert(all.corners.end(), part.corners.begin(), part.corners.end());
        part = {};
    }
    report.model_to_mesh = distance_to_facets(mesh, model, all.points, options.threads);
    merge_corners(all.corners);
    report_corners(mesh, facet_surface, model, features, all.corners, features::same_point(options.level),
                   report);
    return report;
}

}  // namespace mortise::report
