// The stages of a mesh in memory after its assembly: better elements, tetrahedra, hanging nodes, checks,
// names, second order.
#pragma once

#include <optional>
#include <vector>

#include "host/device/device.hpp"
#include "host/improve/improve.hpp"
#include "host/jacobian/jacobian.hpp"
#include "host/pipeline/prepare.hpp"
#include "host/pipeline/stages.hpp"
#include "mortise/mesher.hpp"

namespace mortise::pipeline {

/// One run's stages after assembly; Mesher::generate knows their order. All that they find out goes to the
/// report.
class Finish {
  public:
    Finish(device::Device& device, const Model& model, const MeshOptions& options, const Prepared& prepared,
           Stages& stages, MeshReport& report);
    Finish(const Finish&) = delete;
    Finish& operator=(const Finish&) = delete;

    void improve(Mesh& mesh);

    /// Periodic planes get the same facets.
    void match_planes(Mesh& mesh);

    /// Into tetrahedra. `old`: as for tetrahedra::split_cubes.
    void split(Mesh& mesh, Mesh* old);

    /// Whether more is asked of elements than improve() gives.
    bool raises() const { return improve_options_.goal > improve::kGoodQuality; }

    /// Better elements than improve() makes if raises(), else those that split() has made poor once more.
    void raise(Mesh& mesh);

    /// Hexahedra with hanging nodes.
    void restore_cells(Mesh& mesh);

    /// Names of surfaces.
    void name(Mesh& mesh);

    /// Which nodes of periodic planes are copies of others; after name().
    void pair_planes(Mesh& mesh);

    /// Layers at walls; after name().
    void add_layers(Mesh& mesh);

    /// Throws Error if faces do not fit together.
    void verify(const Mesh& mesh);

    /// What improvement did; dimensions of nodes; what the mesh has lost; the quality report if it is wanted.
    void describe(Mesh& mesh);

    /// Nodes in the middles of edges; after describe().
    void raise_order(Mesh& mesh);

    /// Scaled Jacobians. `memory`: of a vector that is not needed any more.
    void measure(const Mesh& mesh, std::optional<jacobian::Method> method, std::vector<float> memory);

  private:
    void assess(const Mesh& mesh);

    device::Device& device_;
    const Model& model_;
    const MeshOptions& options_;
    const Prepared& prepared_;
    Stages& stages_;
    MeshReport& out_;
    const std::vector<std::uint8_t> held_;  ///< surfaces that stay as they are
    improve::Options improve_options_;
    improve::Counters counters_;
    bool knows_shapes_ = true;     ///< false: hexahedra have other numbers than those that follow
    IndexRuns moved_cubes_;        ///< hexahedra of kind kIn, but for these, are boxes along the axes; before
                                   ///< add_layers(), which moves others
    IndexRuns sixths_;             ///< tetrahedra that are sixths of such boxes
    std::vector<NodeId> copy_of_;  ///< of periodic planes
    std::vector<std::uint32_t> facet_surface_;  ///< by facet, the bound model's: known from name() on
};

}  // namespace mortise::pipeline
