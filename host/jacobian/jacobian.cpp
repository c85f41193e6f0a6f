// See jacobian.hpp.
#include "host/jacobian/jacobian.hpp"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <string>

#include "host/common/large_array.hpp"
#include "host/jacobian/in_lanes.hpp"
#include "kernels/shared/corners.h"
#include "mortise/error.hpp"

namespace mortise::jacobian {
namespace {

using device::Buffer;
using device::Device;

/// A node and its three neighbours.
using Corner = int[4];

#define MORTISE_ROW(node, first, second, third) {node, first, second, third},
constexpr Corner kHexahedronCorners[] = {MORTISE_HEXAHEDRON_CORNERS(MORTISE_ROW)};
constexpr Corner kWedgeCorners[] = {MORTISE_WEDGE_CORNERS(MORTISE_ROW)};
constexpr Corner kPyramidCorners[] = {MORTISE_PYRAMID_CORNERS(MORTISE_ROW)};
constexpr Corner kTetrahedronCorners[] = {MORTISE_TETRAHEDRON_CORNERS(MORTISE_ROW)};
#undef MORTISE_ROW

struct TypeTable {
    const char* entry;  ///< of own.cl
    const Corner* corners;
    std::size_t corner_count;
};
constexpr TypeTable kTypes[kElementTypes] = {{"hexahedron_jacobians", kHexahedronCorners, 8},
                                             {"wedge_jacobians", kWedgeCorners, 6},
                                             {"pyramid_jacobians", kPyramidCorners, 4},
                                             {"tetrahedron_jacobians", kTetrahedronCorners, 4}};

/// Elements from which on the device gains more than loading the kernels takes (7 ms, or 2.4 s once where
/// they are not in the cache).
constexpr std::size_t kWorthLoading = std::size_t{1} << 20;

/// Elements at a time: bounds the buffers of a launch, and the matrices of a product (600 bytes an element).
constexpr std::size_t kOwnChunk = std::size_t{1} << 24;
constexpr std::size_t kProductChunk = std::size_t{1} << 17;

/// Rows: nodes; three columns for each corner: from its node to each neighbour. Stored by columns.
std::vector<double> edge_matrix(const TypeTable& table, std::size_t nodes) {
    std::vector<double> matrix(nodes * 3 * table.corner_count, 0.0);
    for (std::size_t i = 0; i < table.corner_count; ++i) {
        for (std::size_t j = 0; j < 3; ++j) {
            double* const column = matrix.data() + nodes * (3 * i + j);
            column[table.corners[i][0]] = -1;
            column[table.corners[i][j + 1]] = 1;
        }
    }
    return matrix;
}

/// The matrices of one element type, kept from chunk to chunk.
class Product {
  public:
    Product(Device& device, const TypeTable& table, std::size_t nodes, std::size_t most)
        : device_(device),
          nodes_(nodes),
          corners_(table.corner_count),
          matrix_(device.upload(edge_matrix(table, nodes))),
          coordinates_(device.allocate(most * 3 * nodes * sizeof(double))),
          edges_(device.allocate(most * 9 * table.corner_count * sizeof(double))) {}

    void run(const Buffer& points, const Buffer& elements, std::size_t count, Buffer& values) {
        const auto nodes = static_cast<std::uint32_t>(nodes_);
        const auto corners = static_cast<std::uint32_t>(corners_);
        device_.launch(device_.kernel("jacobian/product.cl", "gather_coordinates"), count, points, elements,
                       nodes, coordinates_);
        device_.multiply(coordinates_, matrix_, edges_, 3 * count, 3 * corners_, nodes_);
        device_.launch(device_.kernel("jacobian/product.cl", "smallest_corner"), count, edges_, corners,
                       values);
    }

  private:
    Device& device_;
    std::size_t nodes_;
    std::size_t corners_;
    Buffer matrix_;
    Buffer coordinates_;
    Buffer edges_;
};

}  // namespace

std::optional<Method> wanted_method() {
    const char* const wanted = std::getenv("MORTISE_JACOBIANS");
    const std::string word = wanted != nullptr ? wanted : "";
    if (word.empty()) return std::nullopt;
    if (word == "host") return Method::kHost;
    if (word == "own") return Method::kOwn;
    if (word == "clblast") return Method::kProduct;
    throw Error(ExitCode::kUsage,
                "MORTISE_JACOBIANS is '" + word + "'; set it to host, own or clblast, or unset it");
}

Method usual_method(std::size_t elements) { return elements < kWorthLoading ? Method::kHost : Method::kOwn; }

std::vector<float> scaled_jacobians(Device& device, const Mesh& mesh, Method method, int threads,
                                    const KnownShapes& known, std::vector<float> old) {
    const std::size_t points_bytes = mesh.points.size() * sizeof(double);
    if (method == Method::kHost || points_bytes > device.info().max_allocation_bytes)
        return scaled_jacobians_in_lanes(mesh, threads, known);
    std::vector<float> values;
    take_memory(old, mesh.element_count(), values);
    resize_large(values, mesh.element_count(), threads);
    if (values.empty()) return values;
    const Buffer points = device.lend(mesh.points.data(), mesh.points.size());
    const std::size_t chunk = method == Method::kOwn ? kOwnChunk : kProductChunk;
    std::size_t before = 0;
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[t];
        const auto nodes = static_cast<std::size_t>(kElementNodes[t]);
        if (block.size() == 0) continue;
        std::optional<Product> product;
        if (method == Method::kProduct)
            product.emplace(device, kTypes[t], nodes, std::min(chunk, block.size()));
        const bool has_sixths = t == 3 && known.sixths != nullptr && method == Method::kOwn;
        const std::size_t done =
            has_sixths ? tetrahedra_with_sixths(mesh, *known.sixths, threads, values.data() + before) : 0;
        for (std::size_t begin = done; begin < block.size(); begin += chunk) {
            const std::size_t count = std::min(chunk, block.size() - begin);
            const Buffer elements = device.lend(block.nodes.data() + nodes * begin, nodes * count);
            Buffer results = device.wrap(values.data() + before + begin, count * sizeof(float));
            if (product) {
                product->run(points, elements, count, results);
            } else {
                const std::size_t width = device.lanes() == 8 ? 8 : 1;  // WIDTH of own.cl
                const Buffer kinds = device.lend(block.kind.data() + begin, count);
                device.launch(device.kernel("jacobian/own.cl", kTypes[t].entry), (count + width - 1) / width,
                              points, elements, kinds, results, static_cast<std::uint32_t>(count),
                              std::int32_t{known.moved_cubes != nullptr});
            }
            device.sync_to_host(results);
        }
        before += block.size();
    }
    if (known.moved_cubes != nullptr && method == Method::kOwn)
        correct_cubes(mesh, *known.moved_cubes, values.data());
    return values;
}

}  // namespace mortise::jacobian
