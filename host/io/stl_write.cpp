// Binary STL of the outer boundary: what slicers and viewers of surfaces read.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "host/io/coordinates.hpp"
#include "host/io/formats.hpp"
#include "mortise/error.hpp"

namespace mortise::io {
namespace {

using Point = std::array<float, 3>;
using Corners = std::array<NodeId, 3>;

/// What a file of ours begins with; not "solid", which begins text.
constexpr std::string_view kOwn = "Binary STL by Mortise";
constexpr char kHeader[80] = "Binary STL by Mortise: the outer boundary, in the units of the model";

double squared_distance(const Coordinates& points, NodeId a, NodeId b) {
    double sum = 0;
    for (std::size_t j = 0; j < 3; ++j) {
        const double d = points[3 * std::size_t{a} + j] - points[3 * std::size_t{b} + j];
        sum += d * d;
    }
    return sum;
}

/// Along the shorter diagonal.
void add_quadrilateral(const Coordinates& points, const std::array<NodeId, 4>& n, std::vector<Corners>& out) {
    const bool first = squared_distance(points, n[0], n[2]) <= squared_distance(points, n[1], n[3]);
    if (first) {
        out.push_back({n[0], n[1], n[2]});
        out.push_back({n[0], n[2], n[3]});
    } else {
        out.push_back({n[1], n[2], n[3]});
        out.push_back({n[1], n[3], n[0]});
    }
}

/// The triangles of one facet; of second order also through the middles of its edges, which lie on the model.
void add_facet(const Mesh& mesh, const Coordinates& points, std::size_t facet, std::vector<Corners>& out) {
    const FacetNodes n = mesh.facets.facet(facet);
    if (!mesh.is_second_order()) {
        if (n.size() == 3) {
            out.push_back({n[0], n[1], n[2]});
        } else {
            add_quadrilateral(points, {n[0], n[1], n[2], n[3]}, out);
        }
        return;
    }
    const NodeId* const middle = mesh.facets.middles.data() + 4 * facet;
    for (std::size_t k = 0; k < n.size(); ++k)
        out.push_back({n[k], middle[k], middle[(k + n.size() - 1) % n.size()]});
    if (n.size() == 3) {
        out.push_back({middle[0], middle[1], middle[2]});
    } else {
        add_quadrilateral(points, {middle[0], middle[1], middle[2], middle[3]}, out);
    }
}

/// One triangle as the file has it: its normal, its corners and two bytes without a meaning.
void put_triangle(const std::array<Point, 3>& corner, TemporaryFile& file) {
    std::array<double, 3> a{}, b{};
    for (std::size_t j = 0; j < 3; ++j) {
        a[j] = double{corner[1][j]} - double{corner[0][j]};
        b[j] = double{corner[2][j]} - double{corner[0][j]};
    }
    const std::array<double, 3> across = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                                          a[0] * b[1] - a[1] * b[0]};
    const double length = std::hypot(across[0], across[1], across[2]);
    std::array<char, 50> bytes{};
    std::array<float, 12> numbers{};
    for (std::size_t j = 0; j < 3; ++j) {
        if (length > 0) numbers[j] = static_cast<float>(across[j] / length);
        for (std::size_t k = 0; k < 3; ++k) numbers[3 + 3 * k + j] = corner[k][j];
    }
    std::memcpy(bytes.data(), numbers.data(), sizeof numbers);
    file.write(bytes.data(), bytes.size());
}

}  // namespace

void check_stl_is_own(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::array<char, kOwn.size()> begin{};
    if (!file.read(begin.data(), begin.size()) && !file.eof()) return;  // none, or told when it is written
    if (file.gcount() == 0 || std::equal(kOwn.begin(), kOwn.end(), begin.begin())) return;
    throw Error(ExitCode::kUsage, "cannot write '" + path +
                                      "': it is there, and not made by Mortise, so that it may belong to a "
                                      "model; give another name, or remove it first");
}

void write_stl(const Mesh& mesh, const MeshFileOptions& options, TemporaryFile& file) {
    const Coordinates points(mesh.points, options.scale);
    std::vector<Corners> triangles;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        if (mesh.facets.outside[f] == 0) add_facet(mesh, points, f, triangles);
    }
    const auto place = [&points](NodeId node) {
        Point p{};
        for (std::size_t j = 0; j < 3; ++j) p[j] = static_cast<float>(points[3 * std::size_t{node} + j]);
        return p;
    };
    // Where single precision makes one point of two nodes, the edge between them is gone, on both its sides.
    triangles.erase(std::remove_if(triangles.begin(), triangles.end(),
                                   [&place](const Corners& n) {
                                       const Point a = place(n[0]), b = place(n[1]), c = place(n[2]);
                                       return a == b || b == c || c == a;
                                   }),
                    triangles.end());
    if (triangles.size() > std::numeric_limits<std::uint32_t>::max())
        throw Error(ExitCode::kUsage, "more than 2^32 triangles, which .stl cannot number; use larger cells");
    file.write(kHeader, sizeof kHeader);
    file.put(static_cast<std::uint32_t>(triangles.size()));
    for (const Corners& n : triangles) put_triangle({place(n[0]), place(n[1]), place(n[2])}, file);
}

}  // namespace mortise::io
