// Binning of NIO leaves by topology, and snapping of vertices (kernels/snio).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/device/device.hpp"
#include "host/octree/octree.hpp"
#include "kernels/shared/snio.h"
#include "mortise/mesh.hpp"

namespace mortise::snio {

/// What the bins say of each NIO leaf. Counts are zero for CNIO leaves.
struct Classification {
    std::vector<SnioLeaf> leaves;
    std::vector<std::uint32_t> used;  ///< node masks of kernels/shared/tree.h
    std::array<std::vector<std::uint32_t>, kElementTypes> elements;
    std::vector<std::uint32_t> facets;
    std::vector<std::uint32_t> cnio;  ///< indices of the leaves left to the certificate, ascending
};

/// An IN leaf with corners that are snapped beside complex leaves; `is_complex`: left to the certificate.
struct SnappedInLeaf {
    std::uint64_t code;
    SnappedLeaf corners;  ///< `leaf` does not count
    bool is_complex;
};

/// Bins the NIO leaves of one tree, in steps between which the host may snap vertices of complex leaves.
///
/// With `snap`, vertices near a smooth surface are moved onto it. Then the IN leaves around them are
/// promoted: `tree` and `on_device` change, and hold these leaves as NIO leaves with an empty tape.
class Classifier {
  public:
    /// All arguments outlive the classifier. With templates off every leaf is left to the certificate. So are
    /// the leaves `complex`, indices into Octree::nio.
    Classifier(device::Device& device, octree::Octree& tree, octree::DeviceTree& on_device, bool templates,
               bool snap, const std::vector<std::uint32_t>& complex);

    /// What is known of each leaf while no vertex has moved.
    const std::vector<SnioCandidate>& candidates();

    /// The same of leaves that were simple, with corners snapped; parallel to `leaves`.
    std::vector<SnioCandidate> with_corners(const std::vector<SnappedLeaf>& leaves);

    /// Snaps all other vertices, and chooses templates. `simple` and `in_leaves`, by code, are all leaves
    /// that are not complex and have corners snapped before; `complex` those that are because of these
    /// corners.
    Classification finish(const std::vector<SnappedLeaf>& simple, const std::vector<SnappedInLeaf>& in_leaves,
                          const std::vector<std::uint32_t>& complex);

  private:
    std::size_t count() const { return tree_.nio.size(); }
    std::size_t rows(std::size_t leaves) const;
    device::Buffer no_vetoes();
    template <class... Arguments>
    void launch(const char* file, const char* entry, std::size_t items, const Arguments&... arguments);
    void leave_to_certificate(const std::vector<std::uint32_t>& leaves);
    void find_points();
    void drop_misfits();
    void promote(const std::vector<SnappedInLeaf>& in_leaves);
    void snap_corners(const std::vector<SnappedLeaf>& leaves);
    Classification all_complex() const;
    Classification fill();

    device::Device& device_;
    octree::Octree& tree_;
    octree::DeviceTree& on_device_;
    bool templates_;
    std::int32_t snap_;
    std::vector<SnioCandidate> first_;  ///< of all leaves, once they have been asked for
    device::Buffer candidates_;
    device::Buffer points_;           ///< of the leaves that were found first
    device::Buffer promoted_points_;  ///< of the others
    device::Buffer point_of_;         ///< of each leaf: where its points are
    device::Buffer plans_;
    device::Buffer vetoes_;
};

/// What a simple leaf some of whose corners are snapped has while no others move. kPerhaps: that depends on
/// these.
enum class Keeps : std::uint8_t { kTemplate, kPerhaps, kNothing };
Keeps keeps_template(const tape::BoundModel& model, const octree::Octree& tree,
                     const SnioCandidate& candidate, const SnappedLeaf& leaf);

/// Whether an IN leaf with snapped corners is a valid hexahedron.
bool stays_hexahedron(const SnappedLeaf& leaf);

/// All steps at once: no vertex of a complex leaf is snapped.
Classification classify(device::Device& device, octree::Octree& tree, octree::DeviceTree& on_device,
                        bool templates, bool snap, const std::vector<std::uint32_t>& complex = {});

}  // namespace mortise::snio
