// Layers on meshes made by hand: cubes of a grid, of which parts touch, or regions.
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include <doctest/doctest.h>

#include "host/layers/layers.hpp"
#include "mortise/check.hpp"
#include "tests/quality/sample_meshes.hpp"

namespace mortise::layers {
namespace {

/// Unit cubes of a grid; `region` of each by its place, 0: none.
Mesh cubes(int nx, int ny, int nz, const std::function<int(int, int, int)>& region) {
    Mesh mesh;
    std::vector<NodeId> number(static_cast<std::size_t>((nx + 1) * (ny + 1) * (nz + 1)), 0xffffffffu);
    const auto node = [&](int i, int j, int k) {
        NodeId& n = number[static_cast<std::size_t>((k * (ny + 1) + j) * (nx + 1) + i)];
        if (n == 0xffffffffu) n = samples::add_node(mesh, i, j, k);
        return n;
    };
    int regions = 0;
    for (int k = 0; k < nz; ++k) {
        for (int j = 0; j < ny; ++j) {
            for (int i = 0; i < nx; ++i) {
                const int r = region(i, j, k);
                regions = std::max(regions, r);
                if (r == 0) continue;
                samples::add_element(mesh, ElementType::kHexahedron,
                                     {node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k),
                                      node(i, j + 1, k), node(i, j, k + 1), node(i + 1, j, k + 1),
                                      node(i + 1, j + 1, k + 1), node(i, j + 1, k + 1)},
                                     static_cast<std::uint16_t>(r));
            }
        }
    }
    samples::list_facets(mesh);
    for (int r = 1; r <= regions; ++r) mesh.region_names.push_back("region " + std::to_string(r));
    mesh.surface_names = {"outside", "to 1", "to 2", "to 3"};
    return mesh;
}

constexpr std::uint32_t kMostCubes = 8;  ///< along an axis

/// The planes x = 0, 1, …, then those across y and z.
tape::BoundModel planes() {
    tape::BoundModel model;
    model.expression_ops.resize(1);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::uint32_t at = 0; at <= kMostCubes; ++at) {
            Surface surface{};
            surface.kind = kSurfacePlane;
            surface.map[axis] = 1;
            surface.map[3] = -static_cast<double>(at);
            model.surfaces.push_back(surface);
        }
    }
    return model;
}

/// Of each facet its plane among these.
std::vector<std::uint32_t> planes_of(const Mesh& mesh) {
    std::vector<std::uint32_t> planes;
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const NodeId* const node = mesh.facets.nodes.data() + 4 * f;
        const auto at = [&](std::size_t k, std::size_t axis) {
            return mesh.points[3 * std::size_t{node[k]} + axis];
        };
        std::uint32_t axis = 0;
        while (at(0, axis) != at(1, axis) || at(0, axis) != at(2, axis)) ++axis;
        planes.push_back(axis * (kMostCubes + 1) + static_cast<std::uint32_t>(at(0, axis)));
    }
    return planes;
}

LayerFigures layer(Mesh& mesh, const LayerOptions& options) {
    const CheckReport before = check_mesh(mesh);
    REQUIRE(before.valid());
    std::vector<std::uint32_t> facet_surface = planes_of(mesh);
    const LayerFigures figures = add_layers(mesh, facet_surface, planes(), options, 2);
    CHECK(facet_surface.size() == mesh.facets.size());
    const CheckReport after = check_mesh(mesh);
    for (const Defect& defect : after.defects) FAIL_CHECK(defect.what << ": " << defect.first);
    CHECK(after.volume == doctest::Approx(before.volume).epsilon(1e-12));
    CHECK(after.boundary_area == doctest::Approx(before.boundary_area).epsilon(1e-12));
    CHECK(after.euler_characteristic == before.euler_characteristic);
    CHECK(after.components == before.components);
    REQUIRE(after.region_volume.size() == before.region_volume.size());
    for (std::size_t r = 0; r < before.region_volume.size(); ++r)
        CHECK(after.region_volume[r] == doctest::Approx(before.region_volume[r]).epsilon(1e-12));
    return figures;
}

LayerOptions layers_of(int count, double first, double growth = 1) {
    LayerOptions options;
    options.count = count;
    options.first = first;
    options.growth = growth;
    return options;
}

std::size_t layer_elements(const Mesh& mesh, ElementType type) {
    const ElementBlock& block = mesh.block(type);
    return static_cast<std::size_t>(
        std::count(block.kind.begin(), block.kind.end(), static_cast<std::uint8_t>(ElementKind::kLayer)));
}

}  // namespace

TEST_CASE("a block of cubes: layers of given heights on all sides") {
    Mesh mesh = cubes(5, 4, 6, [](int, int, int) { return 1; });
    const std::size_t facets = mesh.facets.size(), nodes = mesh.node_count();
    const LayerFigures figures = layer(mesh, layers_of(3, 0.05, 2));
    CHECK(figures.facets == facets);
    CHECK(figures.lower == 0);
    CHECK(figures.bare == 0);
    CHECK(figures.elements == 3 * facets);
    CHECK(layer_elements(mesh, ElementType::kHexahedron) == 3 * facets);
    CHECK(mesh.facets.size() == facets);
    // Three nodes behind each wall node, 0.05, 0.15 and 0.35 from the nearest wall.
    const std::size_t wall_nodes = 6 * 5 * 7 - 4 * 3 * 5;
    REQUIRE(mesh.node_count() == nodes + 3 * wall_nodes);
    for (std::size_t n = nodes; n < mesh.node_count(); ++n) {
        const double* const p = mesh.points.data() + 3 * n;
        const double depth = std::min({p[0], 5 - p[0], p[1], 4 - p[1], p[2], 6 - p[2]});
        const std::array<double, 3> expected = {0.05, 0.15, 0.35};
        CHECK(depth == doctest::Approx(expected[(n - nodes) % 3]).epsilon(1e-9));
    }
}

TEST_CASE("heights that nobody gives follow the walls' edges") {
    Mesh mesh = cubes(4, 4, 4, [](int, int, int) { return 1; });
    const LayerFigures figures = layer(mesh, layers_of(1, 0));
    CHECK(figures.lower == 0);
    CHECK(figures.thickness == doctest::Approx(0.4));
    CHECK(figures.edge == doctest::Approx(1));
}

TEST_CASE("parts that touch at an edge or a node: layers end there") {
    const auto at_edge = [](int i, int j, int) { return (i < 2 && j < 2) || (i >= 2 && j >= 2) ? 1 : 0; };
    const auto at_node = [](int i, int j, int k) {
        return (i < 2 && j < 2 && k < 2) || (i >= 2 && j >= 2 && k >= 2) ? 1 : 0;
    };
    for (int which = 0; which < 2; ++which) {
        Mesh mesh = which == 0 ? cubes(4, 4, 3, at_edge) : cubes(4, 4, 4, at_node);
        const LayerFigures figures = layer(mesh, layers_of(2, 0.1));
        // Quadrilaterals with one bare node are cut, and so are the cubes behind them.
        CHECK(figures.lower > 0);
        CHECK(figures.bare == 0);
        CHECK(layer_elements(mesh, ElementType::kPyramid) > 0);
        CHECK(layer_elements(mesh, ElementType::kHexahedron) > 0);
    }
}

TEST_CASE("layers in one region: the other stays as it is") {
    // Region 2 is a core in region 1.
    const auto core = [](int i, int j, int k) {
        const auto inner = [](int x) { return x >= 2 && x < 4; };
        return inner(i) && inner(j) && inner(k) ? 2 : 1;
    };
    for (const std::string name : {"region 1", "region 2"}) {
        CAPTURE(name);
        Mesh mesh = cubes(6, 6, 6, core);
        LayerOptions options = layers_of(2, 0.05);
        options.on = {name};
        const LayerFigures figures = layer(mesh, options);
        const std::size_t interface = 6 * 2 * 2, outer = 6 * 6 * 6;
        CHECK(figures.facets == (name == "region 1" ? interface + outer : interface));
        CHECK(figures.lower == 0);
        const std::uint16_t region = name == "region 1" ? 1 : 2;
        const ElementBlock& block = mesh.block(ElementType::kHexahedron);
        for (std::size_t e = 0; e < block.size(); ++e) {
            if (block.kind[e] == static_cast<std::uint8_t>(ElementKind::kLayer))
                CHECK(block.region[e] == region);
        }
    }
}

TEST_CASE("layers on the interface alone, on one side") {
    const auto core = [](int i, int j, int k) {
        const auto inner = [](int x) { return x >= 2 && x < 4; };
        return inner(i) && inner(j) && inner(k) ? 2 : 1;
    };
    Mesh mesh = cubes(6, 6, 6, core);
    LayerOptions options = layers_of(2, 0.05);
    options.on = {"region 1", "to 1", "to 2"};  // as the facets' order has it
    CHECK(layer(mesh, options).facets == 6 * 2 * 2);
}

TEST_CASE("an interface between two regions with layers goes on to the wall") {
    Mesh mesh = cubes(6, 3, 3, [](int i, int, int) { return i < 3 ? 1 : 2; });
    const std::size_t facets = mesh.facets.size();
    const LayerFigures figures = layer(mesh, layers_of(2, 0.05));
    CHECK(figures.lower + figures.bare == 0);
    CHECK(figures.facets == 2 * 9 + 4 * 18);
    // Four sides of three cubes, two layers each.
    REQUIRE(mesh.facets.size() == facets + 4 * 3 * 2);
    for (std::size_t f = facets; f < mesh.facets.size(); ++f) {
        CHECK(mesh.facets.inside[f] + mesh.facets.outside[f] == 3);
        for (std::size_t k = 0; k < 4; ++k)
            CHECK(mesh.points[3 * std::size_t{mesh.facets.nodes[4 * f + k]}] == 3);
    }
}

TEST_CASE("a wall that meets a region without layers ends bare there") {
    // Two regions side by side; layers in the first, on the outer boundary only.
    Mesh mesh = cubes(6, 3, 3, [](int i, int, int) { return i < 3 ? 1 : 2; });
    LayerOptions options = layers_of(2, 0.05);
    options.on = {"region 1", "outside"};
    const LayerFigures figures = layer(mesh, options);
    CHECK(figures.facets == 3 * 3 + 4 * 3 * 3);
    CHECK(figures.bare == 0);
    CHECK(figures.lower == 4 * 3);
}

TEST_CASE("no room: layers are lower, and the mesh stays valid") {
    for (const double first : {0.6, 1.0, 10.0}) {
        CAPTURE(first);
        Mesh mesh = cubes(3, 3, 2, [](int, int, int) { return 1; });
        const LayerFigures figures = layer(mesh, layers_of(2, first));
        CHECK(figures.lower + figures.bare > 0);
    }
}

TEST_CASE("names that no facet has: no layers") {
    Mesh mesh = cubes(2, 2, 2, [](int, int, int) { return 1; });
    const Mesh before = mesh;
    LayerOptions options = layers_of(2, 0.1);
    options.on = {"to 3"};
    CHECK(layer(mesh, options).facets == 0);
    CHECK(mesh.points == before.points);
}

}  // namespace mortise::layers
