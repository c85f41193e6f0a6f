// A model meshed and checked in one call, and small measures of the result.
#pragma once

#include <string>
#include <vector>

#include "mortise/check.hpp"
#include "mortise/mesher.hpp"
#include "tests/mesher/solids.hpp"

namespace mortise::test {

/// Cells of one size: the root box split so many times.
MeshOptions at_level(int level);

/// Takes a mesh in parts, and forgets them.
struct DiscardingSink : MeshSink {
    void begin(const MeshTotals&, const Mesh&) override {}
    void add(const Mesh&, const std::vector<float>&) override {}
};

struct Meshed {
    Mesh mesh;
    MeshReport report;
    CheckReport check;
    std::string defects;  ///< all in one line; empty: valid
};

/// As generate_mesh; on the default device by one mesher for the whole process, which loads its kernels once.
Mesh generate(const Model& model, const MeshOptions& options = {}, MeshReport* report = nullptr);

Meshed mesh_and_check(const Model& model, const MeshOptions& options);
Meshed mesh_and_check(const Model& model, int level, bool templates = true);

/// Missed features that the mesh does not show.
std::int64_t lost_features(const MeshReport& report);

/// The lowest scaled Jacobian: as the mesher tells it, and as the check finds it.
float worst(const Meshed& meshed);
double worst_jacobian(const CheckReport& check);

/// A model of one region.
template <typename Build>
Model one_solid(Build build) {
    Model model;
    model.source = "test model";
    const NodeIndex root = build(model);
    add_region(model, root, "solid");
    return model;
}

/// The volume that the facets around a region enclose, by the divergence theorem: no element is looked at.
double enclosed_volume(const Mesh& mesh, std::size_t region);

/// Area of the facets between two regions (0: outside), whichever lies in front.
double facet_area(const Mesh& mesh, std::size_t first, std::size_t second);

/// Distance from a point to the nearest node.
double nearest_node(const Mesh& mesh, const Vec3& point);

/// Whether two meshes are equal byte by byte.
bool is_same_mesh(const Mesh& a, const Mesh& b);

/// A positive whole number from the environment, or the fallback.
std::uint64_t environment_number(const char* name, std::uint64_t fallback);

}  // namespace mortise::test
