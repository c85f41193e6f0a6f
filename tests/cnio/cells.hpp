// All NIO leaves of a model meshed by the certificate, decoded to lattice positions, for tests/cnio.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/cnio/certificate.hpp"
#include "host/octree/octree.hpp"
#include "mortise/model.hpp"

namespace mortise::test {

__extension__ using Exact = __int128;

using Point = std::array<std::int64_t, 3>;  ///< on the lattice of the root box

struct CellMesh {
    std::uint64_t morton = 0;
    Point corner{};
    std::array<std::int32_t, 12> edge_roots{};  ///< -1 where the cell uses none
    cnio::CellRecord record;
    cnio::CellCounters counters;  ///< of this cell alone
};

/// A model's tree and the certificate's mesh of every NIO leaf.
struct MeshedTree {
    tape::BoundModel model;
    octree::DeviceTree on_device;
    octree::Octree tree;  ///< after on_device, which building it fills
    cnio::CellArena arena;
    std::vector<CellMesh> cells;  ///< by NIO index
    cnio::CellCounters counters;  ///< of all

    MeshedTree(device::Device& device, const Model& source, int level);

    /// Position of a node code of a cell; false if the cell does not use it and so does not know it.
    bool locate(const CellMesh& cell, std::uint16_t code, Point& at) const;
    /// The same for a node that must be known.
    Point position(const CellMesh& cell, std::uint16_t code) const;
};

/// Six times the signed volume of a tetrahedron.
Exact six_volume(const Point& a, const Point& b, const Point& c, const Point& d);

/// Volume of each region (index 0: outside) in a cube of model space, exact up to rounding: the cube is cut
/// by all planes of the model, and each piece asked at its centroid. Polyhedral models only.
std::vector<double> region_volumes(const Model& source, const tape::BoundModel& model,
                                   const std::vector<std::uint32_t>& planes, const Vec3& corner, double size);

}  // namespace mortise::test
