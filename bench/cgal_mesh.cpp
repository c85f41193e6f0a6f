// Meshes a benchmark model with CGAL's Mesh_3:  cgal_mesh MODEL SIZE THREADS plain|optimised OUT.msh
//
// MODEL is sphere or bracket, as an implicit function; the bracket's creases are given as polylines, which
// Mesh_3 protects. SIZE bounds edges on creases, circumradii of facets and of tetrahedra. THREADS 1 takes
// Mesh_3's sequential code, more its parallel code (TBB). "optimised" adds perturbation and exudation,
// make_mesh_3's defaults. Prints the seconds that meshing took; writes Gmsh 2.2 text. No part of Mortise:
// built by run.sh where CGAL is installed.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_domain_with_polyline_features_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/make_mesh_3.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <list>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace {

namespace params = CGAL::parameters;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Polyline = std::vector<Point>;
using Domain = CGAL::Mesh_domain_with_polyline_features_3<CGAL::Labeled_mesh_domain_3<Kernel>>;

constexpr double kHole = 0.4;  // radius of the bracket's holes

/// Negative inside. The solid of models/bracket.geo.
double bracket(const Point& p) {
    const auto box = [&p](double x, double y, double z) {
        return std::max({-p.x(), p.x() - x, -p.y(), p.y() - y, -p.z(), p.z() - z});
    };
    const double plates = std::min(box(4, 2, 1), box(1, 2, 3));
    return std::max({plates, kHole - std::hypot(p.x() - 1.8, p.y() - 1),
                     kHole - std::hypot(p.x() - 3.1, p.y() - 1), kHole - std::hypot(p.y() - 1, p.z() - 2.1)});
}

double sphere(const Point& p) { return p.x() * p.x() + p.y() * p.y() + p.z() * p.z() - 1; }

/// A closed circle about `centre` in the plane of u and v (unit vectors times the radius).
Polyline circle(const Point& centre, const Kernel::Vector_3& u, const Kernel::Vector_3& v) {
    constexpr int kSteps = 2000;  // a chord's height is far below any cell
    const double pi = std::acos(-1.0);
    Polyline line;
    for (int i = 0; i < kSteps; ++i) {
        const double angle = 2 * pi * i / kSteps;
        line.push_back(centre + std::cos(angle) * u + std::sin(angle) * v);
    }
    line.push_back(line.front());
    return line;
}

std::list<Polyline> bracket_creases() {
    std::list<Polyline> lines;
    const std::vector<std::pair<double, double>> outline = {{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 3}, {0, 3}};
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const auto [x, z] = outline[i];
        const auto [next_x, next_z] = outline[(i + 1) % outline.size()];
        lines.push_back({Point(x, 0, z), Point(x, 2, z)});
        for (const double y : {0.0, 2.0}) lines.push_back({Point(x, y, z), Point(next_x, y, next_z)});
    }
    const Kernel::Vector_3 x(kHole, 0, 0);
    const Kernel::Vector_3 y(0, kHole, 0);
    const Kernel::Vector_3 z(0, 0, kHole);
    for (const double height : {0.0, 1.0}) {
        lines.push_back(circle(Point(1.8, 1, height), x, y));
        lines.push_back(circle(Point(3.1, 1, height), x, y));
        lines.push_back(circle(Point(height, 1, 2.1), y, z));
    }
    return lines;
}

template <class Mesh>
bool write(const Mesh& mesh, const char* path) {
    std::FILE* file = std::fopen(path, "w");
    if (file == nullptr) return false;
    const auto& triangulation = mesh.triangulation();
    std::vector<typename Mesh::Vertex_handle> nodes;
    std::unordered_map<const void*, int> numbers;
    std::vector<int> elements;
    for (auto cell = mesh.cells_in_complex_begin(); cell != mesh.cells_in_complex_end(); ++cell) {
        for (int i = 0; i < 4; ++i) {
            const auto vertex = cell->vertex(i);
            const auto [place, added] = numbers.emplace(&*vertex, static_cast<int>(nodes.size()) + 1);
            if (added) nodes.push_back(vertex);
            elements.push_back(place->second);
        }
    }
    std::fprintf(file, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%zu\n", nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const auto& p = triangulation.point(nodes[i]);
        std::fprintf(file, "%zu %.17g %.17g %.17g\n", i + 1, p.x(), p.y(), p.z());
    }
    std::fprintf(file, "$EndNodes\n$Elements\n%zu\n", elements.size() / 4);
    for (std::size_t i = 0; i < elements.size(); i += 4) {
        std::fprintf(file, "%zu 4 2 1 1 %d %d %d %d\n", i / 4 + 1, elements[i], elements[i + 1],
                     elements[i + 2], elements[i + 3]);
    }
    std::fputs("$EndElements\n", file);
    return std::fclose(file) == 0;
}

template <class Concurrency>
bool mesh(const Domain& domain, double size, bool optimised, const char* path) {
    using Triangulation = typename CGAL::Mesh_triangulation_3<Domain, CGAL::Default, Concurrency>::type;
    using Complex =
        CGAL::Mesh_complex_3_in_triangulation_3<Triangulation, Domain::Corner_index, Domain::Curve_index>;
    using Criteria = CGAL::Mesh_criteria_3<Triangulation>;
    const Criteria criteria(params::edge_size = size, params::facet_angle = 25, params::facet_size = size,
                            params::facet_distance = 0.1 * size, params::cell_radius_edge_ratio = 2,
                            params::cell_size = size);
    const auto begin = std::chrono::steady_clock::now();
    const Complex complex =
        optimised ? CGAL::make_mesh_3<Complex>(domain, criteria, params::perturb(), params::exude())
                  : CGAL::make_mesh_3<Complex>(domain, criteria, params::no_perturb(), params::no_exude());
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
    std::printf("meshing %.6f\n", wall.count());
    return complex.number_of_cells_in_complex() > 0 && write(complex, path);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 6) {
        std::fputs("cgal_mesh MODEL SIZE THREADS plain|optimised OUT.msh\n", stderr);
        return 2;
    }
    const bool is_sphere = argv[1] == std::string("sphere");
    const double size = std::atof(argv[2]);
    const int threads = std::atoi(argv[3]);
    const bool optimised = argv[4] == std::string("optimised");
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism,
                                      static_cast<std::size_t>(std::max(1, threads)));
    // The function is negative inside; the ball that bounds the domain has its centre in the solid.
    Domain domain =
        is_sphere ? Domain::create_implicit_mesh_domain(sphere, Kernel::Sphere_3(Point(0, 0, 0), 2.0),
                                                        params::relative_error_bound = 1e-6)
                  : Domain::create_implicit_mesh_domain(bracket, Kernel::Sphere_3(Point(0.6, 0.4, 0.6), 36.0),
                                                        params::relative_error_bound = 1e-6);
    if (!is_sphere) {
        const std::list<Polyline> creases = bracket_creases();
        domain.add_features(creases.begin(), creases.end());
    }
    const bool made = threads > 1 ? mesh<CGAL::Parallel_tag>(domain, size, optimised, argv[5])
                                  : mesh<CGAL::Sequential_tag>(domain, size, optimised, argv[5]);
    return made ? 0 : 1;
}
