// Writes .vtu: VTK XML UnstructuredGrid, arrays appended raw, zlib-compressed blocks, UInt64 headers.
//
// Elements come by type, in the order of ElementType. Connectivity and offsets are Int32 where all their
// values fit and Int64 otherwise: half the bytes to compress, and every reader takes both. Cell arrays:
// region (Int32), kind (UInt8, see ElementKind), scaled_jacobian (Float32). Point array, if it is known:
// model_dimension (UInt8, see Features). VTK has no facets beside cells, so these travel in FieldData:
// facet_nodes (4 per facet, a triangle repeats its last node), facet_surface, facet_inside, facet_outside (as
// in FacetBlock), and the names as VTK string arrays region_names and surface_names, inline as character
// codes.
#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "host/io/compressed_array.hpp"
#include "host/io/element_table.hpp"
#include "host/io/formats.hpp"
#include "host/io/vtk_xml.hpp"
#include "mortise/check.hpp"

namespace mortise::io {
namespace {

/// Source of an array of Value whose items [first, last) are made by fill(first, last, Value* out).
template <class Value, class Fill>
ByteSource value_source(const Fill& fill) {
    return [fill](std::size_t begin, std::size_t end, char* space) {
        fill(begin / sizeof(Value), end / sizeof(Value), reinterpret_cast<Value*>(space));
        return static_cast<const char*>(space);
    };
}

/// Calls visit(type, begin, end) for the parts of [first, last) in each type's run; runs[t] is where it
/// starts.
template <class Visit>
void split_by_type(const std::array<std::size_t, kElementTypes + 1>& runs, std::size_t first,
                   std::size_t last, const Visit& visit) {
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const std::size_t begin = std::max(first, runs[t]), end = std::min(last, runs[t + 1]);
        if (begin < end) visit(t, begin - runs[t], end - runs[t]);
    }
}

template <class Index>
void add_cells(const Mesh& mesh, const char* type_name, VtkXmlWriter& writer) {
    std::array<std::size_t, kElementTypes + 1> node_runs{}, element_runs{};
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        node_runs[t + 1] = node_runs[t] + mesh.elements[t].nodes.size();
        element_runs[t + 1] = element_runs[t] + mesh.elements[t].size();
    }
    const std::size_t count = element_runs.back();
    writer.text("<Cells>");
    writer.array(
        type_name, "connectivity", "", node_runs.back() * sizeof(Index),
        value_source<Index>([&mesh, node_runs](std::size_t first, std::size_t last, Index* out) {
            split_by_type(node_runs, first, last, [&](std::size_t t, std::size_t begin, std::size_t end) {
                const NodeId* nodes = mesh.elements[t].nodes.data();
                const std::array<int, 8>& order = kElementTable[t].vtk.nodes;
                const std::size_t per_element = nodes_per_element(t);
                std::size_t local = begin % per_element;
                for (std::size_t i = begin - local; i < end; i += per_element, local = 0) {
                    const std::size_t last_local = std::min(per_element, end - i);
                    for (; local < last_local; ++local)
                        *out++ = static_cast<Index>(nodes[i + static_cast<std::size_t>(order[local])]);
                }
            });
        }));
    writer.array(
        type_name, "offsets", "", count * sizeof(Index),
        value_source<Index>([node_runs, element_runs](std::size_t first, std::size_t last, Index* out) {
            split_by_type(element_runs, first, last, [&](std::size_t t, std::size_t begin, std::size_t end) {
                for (std::size_t i = begin; i < end; ++i)
                    *out++ = static_cast<Index>(node_runs[t] + (i + 1) * nodes_per_element(t));
            });
        }));
    writer.array(
        "UInt8", "types", "", count,
        value_source<std::uint8_t>([element_runs](std::size_t first, std::size_t last, std::uint8_t* out) {
            split_by_type(element_runs, first, last, [&](std::size_t t, std::size_t begin, std::size_t end) {
                out = std::fill_n(out, end - begin, static_cast<std::uint8_t>(kElementTable[t].vtk.type));
            });
        }));
    writer.text("</Cells>");
    writer.text("<CellData Scalars=\"region\">");
    writer.array("Int32", "region", "", count * sizeof(std::int32_t),
                 value_source<std::int32_t>(
                     [&mesh, element_runs](std::size_t first, std::size_t last, std::int32_t* out) {
                         split_by_type(element_runs, first, last,
                                       [&](std::size_t t, std::size_t begin, std::size_t end) {
                                           const std::uint16_t* region = mesh.elements[t].region.data();
                                           out = std::copy(region + begin, region + end, out);
                                       });
                     }));
    writer.array("UInt8", "kind", "", count,
                 value_source<std::uint8_t>(
                     [&mesh, element_runs](std::size_t first, std::size_t last, std::uint8_t* out) {
                         split_by_type(element_runs, first, last,
                                       [&](std::size_t t, std::size_t begin, std::size_t end) {
                                           const std::uint8_t* kind = mesh.elements[t].kind.data();
                                           out = std::copy(kind + begin, kind + end, out);
                                       });
                     }));
}

}  // namespace

void write_vtu(const Mesh& mesh, const std::vector<float>& jacobians, TemporaryFile& file) {
    VtkXmlWriter writer(file, "UnstructuredGrid");
    writer.text("<UnstructuredGrid>");
    writer.text("<FieldData>");
    writer.names("region_names", mesh.region_names);
    writer.names("surface_names", mesh.surface_names);
    writer.field("UInt32", "facet_nodes", 4, mesh.facets.nodes);
    writer.field("UInt32", "facet_surface", 1, mesh.facets.surface);
    writer.field("UInt16", "facet_inside", 1, mesh.facets.inside);
    writer.field("UInt16", "facet_outside", 1, mesh.facets.outside);
    writer.text("</FieldData>");
    writer.text("<Piece NumberOfPoints=\"" + std::to_string(mesh.node_count()) + "\" NumberOfCells=\"" +
                std::to_string(mesh.element_count()) + "\">");
    writer.text("<Points>");
    writer.array("Float64", "Points", " NumberOfComponents=\"3\"", mesh.points.size() * sizeof(double),
                 memory_source(mesh.points.data()));
    writer.text("</Points>");
    if (!mesh.model_dimension.empty()) {
        writer.text("<PointData>");
        writer.array("UInt8", "model_dimension", "", mesh.model_dimension.size(),
                     memory_source(mesh.model_dimension.data()));
        writer.text("</PointData>");
    }
    std::size_t entries = 0;
    for (const ElementBlock& block : mesh.elements) entries += block.nodes.size();
    constexpr std::size_t limit = std::numeric_limits<std::int32_t>::max();
    if (std::max(entries, mesh.node_count()) <= limit) {
        add_cells<std::int32_t>(mesh, "Int32", writer);
    } else {
        add_cells<std::int64_t>(mesh, "Int64", writer);
    }
    const std::vector<float> computed = jacobians.empty() ? scaled_jacobians(mesh) : std::vector<float>{};
    const std::vector<float>& quality = jacobians.empty() ? computed : jacobians;
    writer.array("Float32", "scaled_jacobian", "", quality.size() * sizeof(float),
                 memory_source(quality.data()));
    writer.text("</CellData>");
    writer.text("</Piece>");
    writer.text("</UnstructuredGrid>");
    writer.finish();
}

}  // namespace mortise::io
