// Random CSG trees: valid meshes that fill the model's space, with and without templates.
//
// MORTISE_RANDOM_MODELS=N tries N models (default 48), MORTISE_RANDOM_SEED=S starts at seed S (default 1).
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "tests/mesher/against_model.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_models.hpp"

namespace mortise::test {
namespace {

constexpr int kRandomLevel = 5;

constexpr double kNextToVertex = 2.5e-4;  ///< cells

/// Boundary nodes on the planes of the cell grid: what a template and the certificate must agree on. Those
/// next to a vertex are left out: there the certificate may count an end of an edge as the root
/// (docs/design/certificate.md).
std::set<Vec3> nodes_on_cell_faces(const Meshed& meshed) {
    std::set<Vec3> result;
    const MeshReport& report = meshed.report;
    for (const NodeId node : meshed.mesh.facets.nodes) {
        Vec3 p{};
        bool on_plane = false, at_vertex = true;
        for (std::size_t j = 0; j < 3; ++j) {
            p[j] = meshed.mesh.points[3 * node + j];
            const double t = (p[j] - report.root.min[j]) / report.cell_size;
            on_plane = on_plane || std::fabs(t - std::round(t)) < 1e-7;
            at_vertex = at_vertex && std::fabs(t - std::round(t)) < kNextToVertex;
        }
        if (on_plane && !at_vertex) result.insert(p);
    }
    return result;
}

/// Meshes `count` models; returns how many were not empty.
std::uint64_t mesh_all(RandomModel (*make)(std::uint64_t), std::uint64_t count) {
    const std::uint64_t first = environment_number("MORTISE_RANDOM_SEED", 1);
    std::uint64_t meshed_models = 0;
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
        const RandomModel random = make(seed);
        CAPTURE(seed);
        CAPTURE(random.style);
        MeshOptions options;
        options.level = kRandomLevel;
        const std::optional<Meshed> with = mesh_unless_empty(random.model, options);
        if (!with) continue;
        ++meshed_models;
        CHECK(with->defects == "");
        compare_with_model(random.model, *with);
        if (!with->check.valid()) MESSAGE("nodes of the model:\n" << describe(random.model));

        if (seed % 3 != 0) continue;
        // Undisplaced and unimproved, templates and certificate cut cell faces alike.
        options.snap = false;
        options.improve = false;
        const std::optional<Meshed> plain = mesh_unless_empty(random.model, options);
        options.templates = false;
        const std::optional<Meshed> without = mesh_unless_empty(random.model, options);
        REQUIRE(plain);
        REQUIRE(without);
        CHECK(plain->defects == "");
        CHECK(without->defects == "");
        CHECK(without->report.snio_cells == 0);
        const double cell = with->report.cell_size, area = with->check.boundary_area;
        CHECK(std::fabs(with->check.volume - without->check.volume) <= 0.05 * area * cell);
        CHECK(std::fabs(plain->check.boundary_area - without->check.boundary_area) <= 0.03 * area);
        CHECK(std::fabs(area - without->check.boundary_area) <= 0.03 * area);
        CHECK(nodes_on_cell_faces(*plain) == nodes_on_cell_faces(*without));
    }
    return meshed_models;
}

}  // namespace

TEST_CASE("random models give valid meshes that fill them") {
    const std::uint64_t count = environment_number("MORTISE_RANDOM_MODELS", 36);
    const std::uint64_t meshed_models = mesh_all(make_random_model, count);
    if (count >= 10) CHECK(meshed_models >= count / 2);
}

TEST_CASE("random models of rounded solids give valid meshes that fill them") {
    const std::uint64_t count = environment_number("MORTISE_RANDOM_MODELS", 36) / 3;
    const std::uint64_t meshed_models = mesh_all(make_random_hulls, count);
    if (count >= 10) CHECK(meshed_models >= count / 2);
}

/// Films of a thousandth of a cell between nearly coincident surfaces: once made up to 30 times as thick.
TEST_CASE("random models that were not filled stay mended") {
    for (const std::uint64_t seed : {1207, 2137, 4860, 8100, 10218}) {
        const RandomModel random = make_random_model(seed);
        CAPTURE(seed);
        MeshOptions options;
        options.level = kRandomLevel;
        const std::optional<Meshed> meshed = mesh_unless_empty(random.model, options);
        REQUIRE(meshed);
        CHECK(meshed->defects == "");
        compare_with_model(random.model, *meshed);
    }
}

TEST_CASE("the mesh does not depend on threads or work-group size") {
    const std::uint64_t first = environment_number("MORTISE_RANDOM_SEED", 1);
    for (std::uint64_t seed = first; seed < first + 3; ++seed) {
        CAPTURE(seed);
        const Model model = make_random_model(seed).model;
        MeshOptions options;
        options.level = kRandomLevel;
        const std::optional<Meshed> reference = mesh_unless_empty(model, options);
        if (!reference) continue;
        struct Way {
            int threads, work_group_size;
        };
        for (const Way& way : {Way{1, 16}, Way{2, 64}, Way{4, 0}}) {
            options.threads = way.threads;
            options.work_group_size = way.work_group_size;
            CHECK(is_same_mesh(generate(model, options), reference->mesh));
        }
    }
}

}  // namespace mortise::test
