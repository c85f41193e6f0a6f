// Which cells hold poor elements.
//
// Which cell an element belongs to is told by its centroid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/improve/cell_set.hpp"
#include "host/improve/zone.hpp"
#include "kernels/shared/lattice.h"

namespace mortise::improve {

/// One element of a mesh.
struct Element {
    ElementType type;
    const NodeId* node;
    std::size_t count;
};

Element element(const Mesh& mesh, int type, std::size_t i);

/// Position of a node, in finest cells. Nodes lie on the lattice of 2^-26 of a finest cell, until they are
/// improved: rounding takes away what the map to model coordinates added. Adding and subtracting 1.5 × 2^52
/// rounds as std::rint does, without a call.
inline Point in_cells(const Mesh& mesh, const CellFrame& frame, NodeId node) {
    constexpr double kRounder = 6755399441055744.0;
    const double* const point = mesh.points.data() + 3 * std::size_t{node};
    Point p;
    for (std::size_t j = 0; j < 3; ++j) {
        const double x = (point[j] - frame.origin[j]) * frame.per_cell;
        p[j] = frame.on_lattice ? ((x * kCellUnits + kRounder) - kRounder) * (1.0 / kCellUnits) : x;
    }
    return p;
}

Point centroid(const Mesh& mesh, const CellFrame& frame, const Element& element);

/// Whether an element is a cube inside the solid.
bool is_cube(const ElementBlock& block, int type, std::size_t i);

/// A point in the cell that an element belongs to: its centroid, for cubes without looking at all nodes.
Point place_of(const Mesh& mesh, const CellFrame& frame, int type, std::size_t i);

/// Rounding of volumes (tetrahedron_quality) in a tree whose finest leaves have this size class.
double volume_rounding(const CellFrame& frame, int finest_class);

/// Where the elements of a mesh lie: of a graded tree all of them, of a uniform one those near the zone.
struct Places {
    static constexpr std::uint32_t kLookAnew = 0xffffffffu;
    /// Per type: elements, ascending.
    std::array<std::vector<std::uint32_t>, kElementTypes> element;
    /// Parallel to `element`: its cell (fits: a uniform tree has at most level 10); kLookAnew: one without a
    /// leaf.
    std::array<std::vector<std::uint32_t>, kElementTypes> cell_of;
    /// Per node the size class of the smallest cell around it; uniform trees: empty.
    std::vector<std::uint8_t> node_class;

    int size_class(NodeId node) const { return node_class.empty() ? 0 : node_class[node]; }
    /// The cell of the i-th element of the list.
    CellId cell(const Mesh& mesh, const CellFrame& frame, const CellSet& cells, int type,
                std::size_t i) const;
};

/// Fills `element` and `cell_of`; of a uniform tree with the elements near the set, where hexahedra of IN
/// cells must be in the order of the cells' Morton codes. Of `known` only cube_pieces is used. `threads` host
/// threads, here and below; results do not depend on them.
void find_cells(const Mesh& mesh, const CellFrame& frame, const CellSet& cells, const Known& known,
                int threads, Places& places);

/// Fills Places::node_class, from cell_of.
void find_size_classes(const Mesh& mesh, const CellFrame& frame, const CellSet& cells, int threads,
                       Places& places);

/// Cells of the elements of less quality than `least`, and of those with an edge too short for them,
/// ascending; only new elements are looked at. Of `places` only node_class is used.
std::vector<CellId> poor_cells(const Mesh& mesh, const CellFrame& frame, const CellSet& cells,
                               const Places& places, double rounding, double least, int threads,
                               const Known& known = {});

/// Elements of less quality than `least`.
std::uint64_t count_below(const Mesh& mesh, const CellFrame& frame, double least, int threads);

}  // namespace mortise::improve
