// Which cells the elements of a mesh belong to: told by their centroids.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/common/lattice_rounding.hpp"
#include "host/improve/cell_set.hpp"
#include "host/improve/zone.hpp"

namespace mortise::improve {

/// One element of a mesh.
struct Element {
    ElementType type;
    const NodeId* node;
    std::size_t count;
};

Element element(const Mesh& mesh, int type, std::size_t i);

/// Position of a node, in finest cells. Nodes lie on the lattice of 2^-26 of a finest cell, until they are
/// improved: rounding takes away what the map to model coordinates added.
inline Point in_cells(const Mesh& mesh, const CellFrame& frame, NodeId node) {
    const double* const point = mesh.points.data() + 3 * std::size_t{node};
    Point p;
    for (std::size_t j = 0; j < 3; ++j) {
        const double x = (point[j] - frame.origin[j]) * frame.per_cell;
        p[j] = frame.on_lattice ? round_to_lattice(x) : x;
    }
    return p;
}

Point centroid(const Mesh& mesh, const CellFrame& frame, const Element& element);

/// Whether an element is a cube inside the solid.
bool is_cube(const ElementBlock& block, int type, std::size_t i);

/// A point in the cell that an element belongs to: its centroid, for cubes without looking at all nodes.
Point place_of(const Mesh& mesh, const CellFrame& frame, int type, std::size_t i);

/// Where the elements of a mesh lie: of a graded tree all of them, of a uniform one those near the zone.
struct Places {
    static constexpr std::uint32_t kLookAnew = 0xffffffffu;
    /// Per type: elements, ascending.
    std::array<std::vector<std::uint32_t>, kElementTypes> element;
    /// Parallel to `element`: its cell, or kLookAnew: one without a leaf, or whose number does not fit (level
    /// 11).
    std::array<std::vector<std::uint32_t>, kElementTypes> cell_of;
    /// Per node the size class of the smallest cell around it; uniform trees: empty.
    std::vector<std::uint8_t> node_class;

    int size_class(NodeId node) const { return node_class.empty() ? 0 : node_class[node]; }
    /// The cell of the i-th element of the list.
    CellId cell(const Mesh& mesh, const CellFrame& frame, const CellSet& cells, int type,
                std::size_t i) const;
};

/// Fills `element` and `cell_of`; of a uniform tree with the elements near the set, where hexahedra of IN
/// cells must be in the order of the cells' Morton codes, and others are told to be far by the chunks of
/// `known`, which are filled in; what is gone is told of graded trees only. `threads` host threads, here and
/// below; results do not depend on them.
void find_cells(const Mesh& mesh, const CellFrame& frame, const CellSet& cells, Known& known, int threads,
                Places& places);

/// Fills Places::node_class, from cell_of.
void find_size_classes(const Mesh& mesh, const CellFrame& frame, const CellSet& cells, const Gone& gone,
                       int threads, Places& places);

}  // namespace mortise::improve
