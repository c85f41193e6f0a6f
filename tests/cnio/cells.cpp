// See cells.hpp.
#include "tests/cnio/cells.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "kernels/shared/lattice.h"
#include "tests/model/membership.hpp"
#include "tests/tape/bound_models.hpp"

namespace mortise::test {
namespace {

cnio::CellCounters difference(const cnio::CellCounters& a, const cnio::CellCounters& b) {
    cnio::CellCounters d;
    d.snapped = a.snapped - b.snapped;
    d.refused = a.refused - b.refused;
    d.limited = a.limited - b.limited;
    d.unresolved = a.unresolved - b.unresolved;
    d.forced_caps = a.forced_caps - b.forced_caps;
    return d;
}

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3 minus(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

using Tetrahedron = std::array<Vec3, 4>;

double volume(const Tetrahedron& t) {
    const Vec3 a = minus(t[1], t[0]);
    const Vec3 b = minus(t[2], t[0]);
    const Vec3 c = minus(t[3], t[0]);
    const Vec3 normal = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    return std::fabs(dot(normal, c)) / 6;
}

/// The parts of a tetrahedron below and above a plane, as tetrahedra.
void cut(const Tetrahedron& t, const double* plane, std::vector<Tetrahedron>& out) {
    std::vector<Vec3> below;
    std::vector<Vec3> above;
    std::vector<double> f_below;
    std::vector<double> f_above;
    for (const Vec3& p : t) {
        const double f = plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2] + plane[3];
        (f <= 0 ? below : above).push_back(p);
        (f <= 0 ? f_below : f_above).push_back(f);
    }
    if (below.empty() || above.empty()) {
        out.push_back(t);
        return;
    }
    const auto crossing = [&](std::size_t i, std::size_t k) {
        const double s = f_below[i] / (f_below[i] - f_above[k]);
        Vec3 p{};
        for (std::size_t j = 0; j < 3; ++j) p[j] = below[i][j] + s * (above[k][j] - below[i][j]);
        return p;
    };
    // A prism on the triangles p and q: three tetrahedra.
    const auto prism = [&](const std::array<Vec3, 3>& p, const std::array<Vec3, 3>& q) {
        out.push_back({p[0], p[1], p[2], q[0]});
        out.push_back({p[1], p[2], q[0], q[1]});
        out.push_back({p[2], q[0], q[1], q[2]});
    };
    if (below.size() == 2) {
        const Vec3 ac = crossing(0, 0), ad = crossing(0, 1), bc = crossing(1, 0), bd = crossing(1, 1);
        prism({below[0], ac, ad}, {below[1], bc, bd});
        prism({above[0], ac, bc}, {above[1], ad, bd});
        return;
    }
    const bool single_below = below.size() == 1;
    std::array<Vec3, 3> roots{};
    for (std::size_t i = 0; i < 3; ++i) roots[i] = single_below ? crossing(0, i) : crossing(i, 0);
    const auto& one = single_below ? below : above;
    const auto& three = single_below ? above : below;
    out.push_back({one[0], roots[0], roots[1], roots[2]});
    prism({three[0], three[1], three[2]}, roots);
}

}  // namespace

MeshedTree::MeshedTree(device::Device& device, const Model& source, int level)
    : model(bind_model(source, level)), tree(octree::build(device, model, level, &on_device)) {
    cnio::Certificate certificate(model, tree);
    for (const TreeNode& leaf : tree.nio) {
        CellMesh cell;
        cell.morton = leaf.morton;
        for (int j = 0; j < 3; ++j) {
            cell.corner[static_cast<std::size_t>(j)] =
                static_cast<std::int64_t>(gather_bits(leaf.morton >> j)) << kCellUnitBits;
        }
        const cnio::CellCounters before = certificate.counters();
        cell.record = certificate.run(leaf, arena);
        cell.counters = difference(certificate.counters(), before);
        std::size_t at = cell.record.first_edge_root;
        for (std::size_t e = 0; e < 12; ++e) {
            cell.edge_roots[e] = (cell.record.used >> (8 + e) & 1u) != 0 ? arena.edge_roots.at(at++) : -1;
        }
        cells.push_back(cell);
    }
    counters = certificate.counters();
}

bool MeshedTree::locate(const CellMesh& cell, std::uint16_t code, Point& at) const {
    at = cell.corner;
    if (code < 8) {
        for (std::size_t j = 0; j < 3; ++j) at[j] += (code >> j & 1) != 0 ? kCellUnits : 0;
        return true;
    }
    if (code < cnio::kExtraCode) {
        const std::size_t e = code - 8u;
        if (cell.edge_roots[e] < 0) return false;
        for (std::size_t j = 0; j < 3; ++j) at[j] += (kEdgeCorners[e][0] >> j & 1) != 0 ? kCellUnits : 0;
        at[e / 4] += cell.edge_roots[e];
        return true;
    }
    const std::size_t i = code - std::size_t{cnio::kExtraCode};
    if (i >= cell.record.extra_count) return false;
    const cnio::NodeKey& key = arena.extras[cell.record.first_extra + i];
    at = {key.x, key.y, key.z};
    return true;
}

Point MeshedTree::position(const CellMesh& cell, std::uint16_t code) const {
    Point at{};
    REQUIRE(locate(cell, code, at));
    return at;
}

Exact six_volume(const Point& a, const Point& b, const Point& c, const Point& d) {
    Exact u[3];
    Exact v[3];
    Exact w[3];
    for (std::size_t j = 0; j < 3; ++j) {
        u[j] = b[j] - a[j];
        v[j] = c[j] - a[j];
        w[j] = d[j] - a[j];
    }
    return u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) +
           u[2] * (v[0] * w[1] - v[1] * w[0]);
}

std::vector<double> region_volumes(const Model& source, const tape::BoundModel& model,
                                   const std::vector<std::uint32_t>& planes, const Vec3& corner,
                                   double size) {
    // Six tetrahedra around the diagonal fill the cube.
    static constexpr int kAround[7] = {1, 3, 2, 6, 4, 5, 1};
    const auto vertex = [&](int c) {
        return Vec3{corner[0] + (c & 1) * size, corner[1] + (c >> 1 & 1) * size, corner[2] + (c >> 2) * size};
    };
    std::vector<Tetrahedron> pieces;
    for (int i = 0; i < 6; ++i) {
        pieces.push_back({vertex(0), vertex(kAround[i]), vertex(kAround[i + 1]), vertex(7)});
    }
    for (const std::uint32_t plane : planes) {
        REQUIRE(model.surfaces[plane].kind == kSurfacePlane);
        std::vector<Tetrahedron> next;
        for (const Tetrahedron& piece : pieces) cut(piece, model.surfaces[plane].map, next);
        pieces = std::move(next);
    }
    std::vector<double> volumes(source.regions.size() + 1, 0);
    for (const Tetrahedron& piece : pieces) {
        Vec3 centroid{};
        for (const Vec3& p : piece) {
            for (std::size_t j = 0; j < 3; ++j) centroid[j] += 0.25 * p[j];
        }
        volumes[region_at(source, to_model(model, centroid))] += volume(piece);
    }
    return volumes;
}

}  // namespace mortise::test
