// What a .vtu holds and in which order, whether the mesh lies in memory or comes in parts.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/io/element_table.hpp"
#include "host/io/vtk_xml.hpp"
#include "mortise/mesh_sink.hpp"

namespace mortise::io {

/// Source of an array of Value whose items [first, last) are made by fill(first, last, Value* out).
template <class Value, class Fill>
ByteSource value_source(const Fill& fill) {
    return [fill](std::size_t begin, std::size_t end, char* space) {
        fill(begin / sizeof(Value), end / sizeof(Value), reinterpret_cast<Value*>(space));
        return static_cast<const char*>(space);
    };
}

/// Where the values of each element type begin in an array, and the end: by element, and by node of elements.
struct TypeRuns {
    TypeRuns(const MeshTotals& totals, bool second_order) {
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            elements[t + 1] = elements[t] + totals.elements[t];
            nodes[t + 1] = nodes[t] + totals.elements[t] * all_nodes_per_element(t, second_order);
        }
    }
    std::array<std::uint64_t, kElementTypes + 1> elements{}, nodes{};
};

/// Writes entries [first, last) of the connectivity of a block of type t, from local node numbers to VTK's.
template <class Index>
void vtk_connectivity(const ElementBlock& block, std::size_t t, std::size_t first, std::size_t last,
                      Index* out) {
    const FormatElement& order = kElementTable[t].vtk;
    const std::size_t corners = nodes_per_element(t), middles = middles_per_element(t);
    const std::size_t per_element = all_nodes_per_element(t, !block.middles.empty());
    std::size_t local = first % per_element;
    for (std::size_t i = first / per_element; i * per_element < last; ++i, local = 0) {
        const std::size_t end = std::min(per_element, last - i * per_element);
        const NodeId* const corner = block.nodes.data() + corners * i;
        for (; local < std::min(corners, end); ++local)
            *out++ = static_cast<Index>(corner[order.nodes[local]]);
        const NodeId* const middle = block.middles.data() + middles * i;
        for (; local < end; ++local) *out++ = static_cast<Index>(middle[order.middles[local - corners]]);
    }
}

/// Mesh::periodic as arrays.
struct PeriodicArrays {
    PeriodicArrays() = default;
    PeriodicArrays(const std::vector<PeriodicNodes>& pairs, double scale);
    std::vector<std::uint32_t> counts;  ///< of nodes, by pair
    std::vector<double> shifts;         ///< three per pair
    std::vector<std::uint32_t> nodes, originals;
};

/// Arrays that come from the mesh; connectivity in indices of index_bytes() each, region in Int32.
struct VtuArrays {
    ArrayWriter points, connectivity, region, kind, scaled_jacobian;
    ArrayWriter model_dimension;  ///< empty: there is none
    PeriodicArrays periodic;
};

/// 4 or 8: of connectivity and offsets.
std::size_t index_bytes(const MeshTotals& totals, bool second_order);

/// Writes the file; `outline` has facets and names, and tells the order. `arrays` must be packed so, too.
void write_vtu_file(const MeshTotals& totals, const Mesh& outline, const VtuArrays& arrays, Packing packing,
                    TemporaryFile& file);

}  // namespace mortise::io
