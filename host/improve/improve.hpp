// Improves a mesh's poor elements: collapses, swaps and repositioning in fixed blocks of the lattice
// (docs/design/improvement.md).
#pragma once

#include "host/common/index_run.hpp"
#include "host/common/leaf_grid.hpp"
#include "host/improve/block.hpp"
#include "host/improve/crumbs.hpp"
#include "host/tape/compile.hpp"
#include "mortise/mesh.hpp"

namespace mortise::improve {

/// Nodes that nothing else helps may lie beside the model by this, in merge distances.
inline constexpr double kMostLoose = 3;

struct Options {
    int level = 0;                     ///< of the finest cells
    int smooth = 4;                    ///< rounds of repositioning; 0: nodes move only onto the model
    double merge_distance = 0;         ///< features closer than this, in cells, may be merged; 0: none
    double goal = kGoodQuality;        ///< of raise(), which follows if this is more (quality_of_angle)
    int threads = 0;                   ///< host threads; 0: all cores
    const LeafGrid* leaves = nullptr;  ///< null or empty: a uniform tree
    const std::vector<tape::Pole>* poles = nullptr;  ///< of the model; null: none
    /// Per surface, not 0: its facets and their nodes stay as they are. May be null.
    const std::vector<std::uint8_t>* held = nullptr;
    /// Of a part of a mesh (scope.hpp): per node, not 0 if elements around it are missing. May be null.
    const std::vector<std::uint8_t>* is_open = nullptr;
    /// Poor elements that are not in all of these are left alone; uniform trees only. May be null.
    const std::vector<Slab>* slabs = nullptr;
    bool keeps_loose = false;  ///< nodes that do not lie on their surfaces are not put there first
    /// Hexahedra; brought up to date: where those are that stay. May be null.
    IndexRuns* followed = nullptr;
};

struct Counters {
    std::uint64_t zone_elements = 0;
    bool reached_open = false;  ///< a zone would have held an open node: the result means nothing
    BlockCounters block;
    std::uint64_t loosened = 0;    ///< nodes that have left their surfaces (loosen.cpp)
    std::uint64_t below_goal = 0;  ///< elements, if the goal is above kGoodQuality
    Crumbs crumbs;                 ///< its place in model coordinates
};

/// Quality of elements whose worst dihedral angle is this; the same on all platforms.
double quality_of_angle(double degrees);

/// Precondition: the mesh's facets carry surfaces of `model` (indices into BoundModel::surfaces), in model
/// coordinates; region and surface names are not looked at. Cubes inside are in Morton order. The result does
/// not depend on the threads. `trace`, if wanted, receives where its parts come from. If raise() follows, no
/// nodes are loosened yet.
Mesh improve(Mesh mesh, const tape::BoundModel& model, const Options& options, Counters* counters,
             Trace* trace = nullptr);

/// Improves what improve()'s elements have been split into, whose quality may be less than theirs: all are
/// tetrahedra, but for cubes inside, which are to be split from their lowest nodes as their neighbours see
/// them now. Without merging or smaller elements; nodes that are loose move only where that mends elements,
/// no others become loose.
Mesh mend_parts(Mesh mesh, const tape::BoundModel& model, const Options& options, Counters& counters);

/// Raises the quality of all elements to a goal above kGoodQuality. The mesh is what improve() has made with
/// these options, or what it has been split into; `counters` and `trace` are those of improve(), and are
/// brought up to date.
Mesh raise(Mesh mesh, const tape::BoundModel& model, const Options& options, Counters& counters,
           Trace* trace = nullptr);

}  // namespace mortise::improve
