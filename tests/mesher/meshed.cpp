// Meshing with checks, and measures that use points and facets only: see meshed.hpp.
#include "tests/mesher/meshed.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace mortise::test {
namespace {

/// Corners of the triangles of a facet. A quadrilateral gives all four of its triangles, each of which counts
/// half: the mean of both diagonals is exact for the volume under a bilinear patch.
template <typename Visit>
void for_triangles(const Mesh& mesh, std::size_t facet, Visit visit) {
    const NodeId* nodes = mesh.facets.nodes.data() + 4 * facet;
    const auto at = [&](std::size_t corner) { return mesh.points.data() + 3 * nodes[corner]; };
    if (nodes[3] == nodes[2]) {
        visit(at(0), at(1), at(2), 1.0);
        return;
    }
    visit(at(0), at(1), at(2), 0.5);
    visit(at(0), at(2), at(3), 0.5);
    visit(at(0), at(1), at(3), 0.5);
    visit(at(1), at(2), at(3), 0.5);
}

Vec3 cross(const double* a, const double* b, const double* c) {
    const Vec3 u = {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
    const Vec3 v = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}

template <typename T>
bool is_same(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

bool are_close(const std::vector<float>& a, const std::vector<float>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](float x, float y) { return std::fabs(x - y) <= 1e-5f; });
}

}  // namespace

Mesh generate(const Model& model, const MeshOptions& options, MeshReport* report) {
    if (!options.device.empty() || options.work_group_size != 0) return generate_mesh(model, options, report);
    static Mesher& mesher = *new Mesher;  // left to the system: OpenCL may be gone when statics are destroyed
    return mesher.generate(model, options, report);
}

Meshed mesh_and_check(const Model& model, const MeshOptions& options) {
    Meshed result;
    result.mesh = generate(model, options, &result.report);
    result.check = check_mesh(result.mesh);
    for (const Defect& defect : result.check.defects) {
        result.defects += defect.what + " x" + std::to_string(defect.count) + " (" + defect.first + "); ";
    }
    if (!are_close(result.report.scaled_jacobians, scaled_jacobians(result.mesh)))
        result.defects += "scaled Jacobians that are reported are not the elements'; ";
    return result;
}

Meshed mesh_and_check(const Model& model, int level, bool templates) {
    MeshOptions options;
    options.level = level;
    options.templates = templates;
    return mesh_and_check(model, options);
}

MeshOptions at_level(int level) {
    MeshOptions options;
    options.level = level;
    return options;
}

std::int64_t lost_features(const MeshReport& report) {
    return std::count_if(report.missed.begin(), report.missed.end(),
                         [](const MissedFeature& feature) { return !feature.kept; });
}

float worst(const Meshed& meshed) {
    const std::vector<float>& all = meshed.report.scaled_jacobians;
    return *std::min_element(all.begin(), all.end());
}

double worst_jacobian(const CheckReport& check) {
    return *std::min_element(check.min_scaled_jacobian.begin(), check.min_scaled_jacobian.end());
}

double enclosed_volume(const Mesh& mesh, std::size_t region) {
    const double* origin = mesh.points.data();  // near the mesh: little cancels
    double sum = 0;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const double side = mesh.facets.inside[f] == region ? 1 : mesh.facets.outside[f] == region ? -1 : 0;
        if (side == 0) continue;
        for_triangles(mesh, f, [&](const double* a, const double* b, const double* c, double weight) {
            const Vec3 n = cross(a, b, c);
            const double height =
                n[0] * (a[0] - origin[0]) + n[1] * (a[1] - origin[1]) + n[2] * (a[2] - origin[2]);
            sum += side * weight * height / 6;
        });
    }
    return sum;
}

double facet_area(const Mesh& mesh, std::size_t first, std::size_t second) {
    double sum = 0;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const std::size_t inside = mesh.facets.inside[f], outside = mesh.facets.outside[f];
        if (std::minmax(inside, outside) != std::minmax(first, second)) continue;
        for_triangles(mesh, f, [&](const double* a, const double* b, const double* c, double weight) {
            const Vec3 n = cross(a, b, c);
            sum += 0.5 * weight * std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        });
    }
    return sum;
}

double nearest_node(const Mesh& mesh, const Vec3& point) {
    double least = HUGE_VAL;
    for (std::size_t i = 0; i < mesh.points.size(); i += 3) {
        const double x = mesh.points[i] - point[0], y = mesh.points[i + 1] - point[1],
                     z = mesh.points[i + 2] - point[2];
        least = std::min(least, x * x + y * y + z * z);
    }
    return std::sqrt(least);
}

bool is_same_mesh(const Mesh& a, const Mesh& b) {
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const ElementBlock &first = a.elements[t], &second = b.elements[t];
        if (!is_same(first.nodes, second.nodes) || !is_same(first.region, second.region) ||
            !is_same(first.kind, second.kind) || !is_same(first.middles, second.middles)) {
            return false;
        }
    }
    return is_same(a.points, b.points) && is_same(a.facets.nodes, b.facets.nodes) &&
           is_same(a.facets.middles, b.facets.middles) && is_same(a.facets.surface, b.facets.surface) &&
           is_same(a.facets.inside, b.facets.inside) && is_same(a.facets.outside, b.facets.outside) &&
           a.region_names == b.region_names && a.surface_names == b.surface_names &&
           a.hanging.node == b.hanging.node && a.hanging.masters == b.hanging.masters;
}

std::uint64_t environment_number(const char* name, std::uint64_t fallback) {
    const char* text = std::getenv(name);
    return text == nullptr ? fallback : std::strtoull(text, nullptr, 10);
}

}  // namespace mortise::test
