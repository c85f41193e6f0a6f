// Writes .vtu: VTK XML UnstructuredGrid, arrays appended raw, compressed or not, UInt64 headers.
//
// Elements come by type, in the order of ElementType. Connectivity and offsets are Int32 where all their
// values fit and Int64 otherwise: half the bytes to compress, and every reader takes both. Cell arrays:
// region (Int32), kind (UInt8, see ElementKind), scaled_jacobian (Float32). Point array, if it is known:
// model_dimension (UInt8, see Features). VTK has no facets beside cells, so these travel in FieldData:
// facet_nodes (4 per facet, a triangle repeats its last node), facet_surface, facet_inside, facet_outside
// and, of second order, facet_middles (as in FacetBlock), and the names as VTK string arrays region_names and
// surface_names, inline as character codes; so do, if there are any, hanging_nodes and hanging_masters (4 per
// node, as in HangingNodes), and for periodic planes periodic_counts and periodic_shifts (by pair),
// periodic_nodes and periodic_originals (one pair's after the other, as in PeriodicNodes).
#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "host/io/coordinates.hpp"
#include "host/io/formats.hpp"
#include "host/io/vtu_layout.hpp"
#include "mortise/check.hpp"

namespace mortise::io {
namespace {

/// Calls visit(type, begin, end) for the parts of [first, last) in each type's run; runs[t] is where it
/// starts.
template <class Visit>
void split_by_type(const std::array<std::uint64_t, kElementTypes + 1>& runs, std::size_t first,
                   std::size_t last, const Visit& visit) {
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const std::size_t begin = std::max<std::size_t>(first, runs[t]);
        const std::size_t end = std::min<std::size_t>(last, runs[t + 1]);
        if (begin < end) visit(t, begin - runs[t], end - runs[t]);
    }
}

/// Whether VTK numbers the nodes of elements of type t as we do.
bool has_vtk_order(std::size_t t) {
    const std::array<int, 8>& order = kElementTable[t].vtk.nodes;
    return std::is_sorted(order.begin(), order.end());
}

template <class Index>
ByteSource connectivity_source(const Mesh& mesh, const TypeRuns& runs) {
    const ByteSource made =
        value_source<Index>([&mesh, runs](std::size_t first, std::size_t last, Index* out) {
            split_by_type(runs.nodes, first, last, [&](std::size_t t, std::size_t begin, std::size_t end) {
                vtk_connectivity(mesh.elements[t], t, begin, end, out);
                out += end - begin;
            });
        });
    if (sizeof(Index) != sizeof(mesh.elements[0].nodes[0])) return made;
    if (mesh.is_second_order()) return made;
    // A mesh has most of them as they are stored; those need not be copied.
    return [&mesh, runs, made](std::size_t begin, std::size_t end, char* space) {
        const std::size_t first = begin / sizeof(Index), last = end / sizeof(Index);
        const char* stored = nullptr;
        split_by_type(runs.nodes, first, last, [&](std::size_t t, std::size_t from, std::size_t to) {
            if (to - from == last - first && has_vtk_order(t))
                stored = reinterpret_cast<const char*>(mesh.elements[t].nodes.data() + from);
        });
        return stored != nullptr ? stored : made(begin, end, space);
    };
}

template <class Index>
ByteSource offsets_source(const TypeRuns& runs, bool second_order) {
    return value_source<Index>([runs, second_order](std::size_t first, std::size_t last, Index* out) {
        split_by_type(runs.elements, first, last, [&](std::size_t t, std::size_t begin, std::size_t end) {
            const std::size_t nodes = all_nodes_per_element(t, second_order);
            for (std::size_t i = begin; i < end; ++i)
                *out++ = static_cast<Index>(runs.nodes[t] + (i + 1) * nodes);
        });
    });
}

/// One value per element, from `member` of each block.
template <class Value, class Member>
ByteSource element_source(const Mesh& mesh, const TypeRuns& runs, Member member) {
    return value_source<Value>([&mesh, runs, member](std::size_t first, std::size_t last, Value* out) {
        split_by_type(runs.elements, first, last, [&](std::size_t t, std::size_t begin, std::size_t end) {
            const auto* values = (mesh.elements[t].*member).data();
            out = std::copy(values + begin, values + end, out);
        });
    });
}

}  // namespace

PeriodicArrays::PeriodicArrays(const std::vector<PeriodicNodes>& pairs, double scale) {
    for (const PeriodicNodes& pair : pairs) {
        counts.push_back(static_cast<std::uint32_t>(pair.size()));
        for (const double along : pair.shift) shifts.push_back(along * scale);
        nodes.insert(nodes.end(), pair.node.begin(), pair.node.end());
        originals.insert(originals.end(), pair.original.begin(), pair.original.end());
    }
}

std::size_t index_bytes(const MeshTotals& totals, bool second_order) {
    constexpr std::uint64_t limit = std::numeric_limits<std::int32_t>::max();
    const std::uint64_t connectivity = TypeRuns(totals, second_order).nodes.back();
    return std::max(connectivity, totals.nodes) <= limit ? sizeof(std::int32_t) : sizeof(std::int64_t);
}

void write_vtu_file(const MeshTotals& totals, const Mesh& outline, const VtuArrays& arrays, Packing packing,
                    TemporaryFile& file) {
    const bool second_order = outline.is_second_order();
    const TypeRuns runs(totals, second_order);
    const std::uint64_t elements = runs.elements.back();
    VtkXmlWriter writer(file, "UnstructuredGrid", packing);
    writer.text("<UnstructuredGrid>");
    writer.text("<FieldData>");
    writer.names("region_names", outline.region_names);
    writer.names("surface_names", outline.surface_names);
    writer.field("UInt32", "facet_nodes", 4, outline.facets.nodes);
    writer.field("UInt32", "facet_surface", 1, outline.facets.surface);
    writer.field("UInt16", "facet_inside", 1, outline.facets.inside);
    writer.field("UInt16", "facet_outside", 1, outline.facets.outside);
    if (second_order) writer.field("UInt32", "facet_middles", 4, outline.facets.middles);
    if (outline.hanging.size() > 0) {
        writer.field("UInt32", "hanging_nodes", 1, outline.hanging.node);
        writer.field("UInt32", "hanging_masters", 4, outline.hanging.masters);
    }
    const PeriodicArrays& periodic = arrays.periodic;
    if (!periodic.counts.empty()) {
        writer.field("UInt32", "periodic_counts", 1, periodic.counts);
        writer.field("Float64", "periodic_shifts", 3, periodic.shifts);
        writer.field("UInt32", "periodic_nodes", 1, periodic.nodes);
        writer.field("UInt32", "periodic_originals", 1, periodic.originals);
    }
    writer.text("</FieldData>");
    writer.text("<Piece NumberOfPoints=\"" + std::to_string(totals.nodes) + "\" NumberOfCells=\"" +
                std::to_string(elements) + "\">");
    writer.text("<Points>");
    writer.array("Float64", "Points", " NumberOfComponents=\"3\"", arrays.points);
    writer.text("</Points>");
    if (arrays.model_dimension) {
        writer.text("<PointData>");
        writer.array("UInt8", "model_dimension", "", arrays.model_dimension);
        writer.text("</PointData>");
    }
    const std::size_t index = index_bytes(totals, second_order);
    const bool is_wide = index == sizeof(std::int64_t);
    const char* index_type = is_wide ? "Int64" : "Int32";
    writer.text("<Cells>");
    writer.array(index_type, "connectivity", "", arrays.connectivity);
    writer.array(index_type, "offsets", "", elements * index,
                 is_wide ? offsets_source<std::int64_t>(runs, second_order)
                         : offsets_source<std::int32_t>(runs, second_order));
    writer.array("UInt8", "types", "", elements,
                 value_source<std::uint8_t>([runs, second_order](std::size_t first, std::size_t last,
                                                                 std::uint8_t* out) {
                     split_by_type(runs.elements, first, last,
                                   [&](std::size_t t, std::size_t begin, std::size_t end) {
                                       const int type = kElementTable[t].vtk.type_of(second_order);
                                       out = std::fill_n(out, end - begin, static_cast<std::uint8_t>(type));
                                   });
                 }));
    writer.text("</Cells>");
    writer.text("<CellData Scalars=\"region\">");
    writer.array("Int32", "region", "", arrays.region);
    writer.array("UInt8", "kind", "", arrays.kind);
    writer.array("Float32", "scaled_jacobian", "", arrays.scaled_jacobian);
    writer.text("</CellData>");
    writer.text("</Piece>");
    writer.text("</UnstructuredGrid>");
    writer.finish();
}

void write_vtu(const Mesh& mesh, const std::vector<float>& jacobians, const MeshFileOptions& options,
               TemporaryFile& file) {
    const Packing packing = packing_of(options);
    MeshTotals totals;
    totals.nodes = mesh.node_count();
    for (std::size_t t = 0; t < kElementTypes; ++t) totals.elements[t] = mesh.elements[t].size();
    const TypeRuns runs(totals, mesh.is_second_order());
    const std::uint64_t elements = runs.elements.back();
    const std::size_t index = index_bytes(totals, mesh.is_second_order());
    const std::vector<float> computed =
        jacobians.empty() ? scaled_jacobians(mesh, packing.threads) : std::vector<float>{};
    const std::vector<float>& quality = jacobians.empty() ? computed : jacobians;
    const auto store = [packing](std::size_t size, const ByteSource& source) {
        return stored(size, source, packing);
    };
    VtuArrays arrays;
    arrays.points =
        store(mesh.points.size() * sizeof(double), Coordinates(mesh.points, options.scale).source());
    if (!mesh.model_dimension.empty()) {
        arrays.model_dimension =
            store(mesh.model_dimension.size(), memory_source(mesh.model_dimension.data()));
    }
    arrays.connectivity =
        store(runs.nodes.back() * index, index == sizeof(std::int64_t)
                                             ? connectivity_source<std::int64_t>(mesh, runs)
                                             : connectivity_source<std::int32_t>(mesh, runs));
    arrays.periodic = PeriodicArrays(mesh.periodic, options.scale);
    arrays.region = store(elements * sizeof(std::int32_t),
                          element_source<std::int32_t>(mesh, runs, &ElementBlock::region));
    arrays.kind = store(elements, element_source<std::uint8_t>(mesh, runs, &ElementBlock::kind));
    arrays.scaled_jacobian = store(quality.size() * sizeof(float), memory_source(quality.data()));
    write_vtu_file(totals, mesh, arrays, packing, file);
}

}  // namespace mortise::io
