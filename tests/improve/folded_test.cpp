// Faces with equal nodes that are not the same face, and models of the corpora that have them.
#include <doctest/doctest.h>

#include <filesystem>
#include <iostream>

#include "host/improve/improve.hpp"
#include "mortise/check.hpp"
#include "tests/corpora.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/tape/bound_models.hpp"

namespace mortise::test {
namespace {

/// Adds an element and all its facets, as the outer boundary.
void add_element(Mesh& mesh, ElementType type, const std::vector<NodeId>& nodes) {
    ElementBlock& block = mesh.block(type);
    block.nodes.insert(block.nodes.end(), nodes.begin(), nodes.end());
    block.region.push_back(1);
    block.kind.push_back(static_cast<std::uint8_t>(ElementKind::kCnio));
    const LocalFaces faces = local_faces(type);
    for (int f = 0; f < faces.count; ++f) {
        for (std::size_t k = 0; k < 4; ++k) {
            const int local = faces.faces[f][faces.faces[f][k] < 0 ? 2 : k];
            mesh.facets.nodes.push_back(nodes[static_cast<std::size_t>(local)]);
        }
        mesh.facets.surface.push_back(0);
        mesh.facets.inside.push_back(1);
        mesh.facets.outside.push_back(0);
    }
}

}  // namespace

/// Two warped bases have three nodes in common. Cut through the same two of them, they fold onto each other:
/// the half that both have is between their elements then, and no facet any more.
TEST_CASE("halves of two quadrilaterals that fold onto each other are no facets") {
    const tape::BoundModel model = bind_model(ball(), 5);
    Mesh mesh;
    const double cells[][3] = {{16, 13.911, 3},   {16.834, 14.206, 3}, {17.292, 14.93, 3}, {17, 14.365, 2},
                               {17, 14.365, 4},   {17, 14, 2},         {17, 14, 4},        {15, 14, 3.4},
                               {15.5, 14.4, 3.4}, {15, 14.4, 3.41},    {15.5, 14, 3.41}};
    const double cell = model.side / 32;
    for (const auto& p : cells) {
        for (std::size_t j = 0; j < 3; ++j) mesh.points.push_back(model.origin[j] + cell * p[j]);
    }
    add_element(mesh, ElementType::kPyramid, {3, 2, 1, 0, 5});
    add_element(mesh, ElementType::kPyramid, {1, 2, 4, 0, 6});
    // Flat: its cell and those around it are improved.
    add_element(mesh, ElementType::kTetrahedron, {7, 8, 9, 10});
    mesh.region_names = {"solid"};
    mesh.surface_names = {"surface"};
    REQUIRE(check_mesh(mesh).valid());
    improve::Counters counters;
    improve::Options options;
    options.level = 5;
    options.threads = 1;
    const Mesh improved = improve::improve(mesh, model, options, &counters);
    CHECK(counters.zone_elements == 5);
    CHECK(counters.block.given_up == 0);
    const CheckReport check = check_mesh(improved);
    CHECK(check.valid());
}

/// Meshes of these were invalid after improvement.
TEST_CASE("models of the corpora with folded facets stay valid") {
    const std::string corpora = corpora_folder().string();
    int skipped = 0;
    for (const char* const file :
         {"prusa-i3/csg/MK3/cable-holder.csg", "prusa-i3/csg/MMU2/s-buffer-spacer.csg"}) {
        const std::string path = corpora + "/" + file;
        if (!std::filesystem::exists(path)) {
            ++skipped;
            continue;
        }
        INFO(file);
        CHECK(mesh_and_check(read_model(path), 5).defects == "");
    }
    if (skipped > 0) std::cout << "folded facets: " << skipped << " files of the corpora are not there\n";
}

}  // namespace mortise::test
