// Repositioning of nodes at poor elements, before anything is taken apart (docs/design/improvement.md): what
// moving nodes mends keeps its hexahedra, wedges and pyramids, and need not be searched by host/improve.
//
// Only elements of templates are mended, away from those of complex cells, whose tetrahedra have too little
// room for moves: that is for host/improve. Nodes move inside a region, or slide on the one surface that they
// lie on. A node moves only if the worst element around it gets better and none that is not good gets worse.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "host/common/index_run.hpp"
#include "host/common/leaf_grid.hpp"
#include "host/device/device.hpp"
#include "host/tape/compile.hpp"
#include "mortise/mesh.hpp"

namespace mortise::reposition {

/// Kernels, or host threads on CPU devices and where there are few nodes: the same bits.
enum class Method { kDevice, kHost };

struct Options {
    int level = 0;                     ///< of the finest cells
    int rounds = 8;                    ///< in each of which a node moves once at most
    int threads = 0;                   ///< host threads; 0: all cores; the result does not depend on them
    const LeafGrid* leaves = nullptr;  ///< null or empty: a uniform tree
    /// Per surface, not 0: the nodes of its facets stay where they are. May be null.
    const std::vector<std::uint8_t>* held = nullptr;
    std::optional<Method> method;  ///< none: by device and number of nodes

    bool is_uniform() const { return leaves == nullptr || leaves->is_uniform(); }
};

struct Counters {
    std::uint64_t poor = 0;   ///< elements that were looked at, before
    std::uint64_t left = 0;   ///< and after
    std::uint64_t moved = 0;  ///< nodes
    IndexRuns moved_cubes;    ///< hexahedra of kind kIn with such nodes
};

/// Moves nodes of `mesh`. Precondition: its nodes lie on the lattice of positions (kernels/shared/lattice.h)
/// and its facets carry surfaces of `model`, in model coordinates. The result is the same on any device and,
/// for the elements around poor ones, whatever else is in the mesh.
Counters reposition(device::Device& device, const tape::BoundModel& model, const Options& options,
                    Mesh& mesh);

}  // namespace mortise::reposition
