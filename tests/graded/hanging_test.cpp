// Hanging nodes: cells between others of different sizes as hexahedra again.
//
// The oracle looks at positions only: a hexahedron that has a node in the middle of an edge or face has a
// hanging node there.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "tests/graded/parse_text.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_models.hpp"

namespace mortise::test {
namespace {

using Place = std::array<std::int64_t, 3>;

/// Nodes by position, in steps of a thousandth of the smallest cell from a corner of the root box: grid
/// points lie in the middle of steps.
class Places {
  public:
    Places(const Mesh& mesh, const MeshReport& report)
        : mesh_(mesh),
          origin_(report.root.min),
          step_(std::ldexp(report.cell_size, report.level - report.finest_level) / 1000) {
        for (NodeId i = 0; i < mesh.node_count(); ++i) nodes_[place({i})] = i;
    }
    /// The node in the middle of others, or none. Some edges are shorter than a step, before improvement: a
    /// node is in the middle if it is closer to it than a hundredth of the distance to the others.
    std::optional<NodeId> middle(const std::vector<NodeId>& of) const {
        const auto found = nodes_.find(place(of));
        if (found == nodes_.end()) return std::nullopt;
        const Vec3 at = mean(of);
        const double off = distance(at, mean({found->second}));
        const bool is_middle =
            std::all_of(of.begin(), of.end(), [&](NodeId n) { return off < 0.01 * distance(at, mean({n})); });
        return is_middle ? std::optional<NodeId>(found->second) : std::nullopt;
    }

  private:
    Vec3 mean(const std::vector<NodeId>& of) const {
        Vec3 sum{};
        for (const NodeId node : of) {
            for (std::size_t j = 0; j < 3; ++j) sum[j] += mesh_.points[3 * std::size_t{node} + j];
        }
        for (double& x : sum) x /= static_cast<double>(of.size());
        return sum;
    }
    static double distance(const Vec3& a, const Vec3& b) {
        return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    }
    Place place(const std::vector<NodeId>& of) const {
        const Vec3 at = mean(of);
        Place result{};
        for (std::size_t j = 0; j < 3; ++j) result[j] = std::llround((at[j] - origin_[j]) / step_);
        return result;
    }
    const Mesh& mesh_;
    Vec3 origin_;
    double step_;
    std::map<Place, NodeId> nodes_;
};

/// Hanging nodes as the hexahedra's edges and faces show them, with sorted masters, each once.
std::map<NodeId, std::vector<NodeId>> hanging_by_position(const Mesh& mesh, const MeshReport& report) {
    const Places places(mesh, report);
    std::map<NodeId, std::vector<NodeId>> result;
    const auto& nodes = mesh.block(ElementType::kHexahedron).nodes;
    for (std::size_t i = 0; i < nodes.size(); i += 8) {
        for (const LocalFace& face : kHexahedronFaces) {
            std::vector<NodeId> corners;
            for (const int k : face) corners.push_back(nodes[i + static_cast<std::size_t>(k)]);
            for (std::size_t k = 0; k < 4; ++k) {
                std::vector<NodeId> ends = {corners[k], corners[(k + 1) % 4]};
                std::sort(ends.begin(), ends.end());
                if (const auto node = places.middle(ends)) result[*node] = ends;
            }
            std::sort(corners.begin(), corners.end());
            if (const auto node = places.middle(corners)) result[*node] = corners;
        }
    }
    return result;
}

std::map<NodeId, std::vector<NodeId>> hanging_as_listed(const Mesh& mesh) {
    std::map<NodeId, std::vector<NodeId>> result;
    for (std::size_t i = 0; i < mesh.hanging.size(); ++i) {
        const auto begin = mesh.hanging.masters.begin() + 4 * static_cast<std::ptrdiff_t>(i);
        std::vector<NodeId> masters(begin, begin + (mesh.hanging.in_edge(i) ? 2 : 4));
        std::sort(masters.begin(), masters.end());
        result[mesh.hanging.node[i]] = masters;
    }
    return result;
}

std::uint64_t of_kind(const Mesh& mesh, ElementType type, ElementKind kind) {
    const auto& kinds = mesh.block(type).kind;
    return static_cast<std::uint64_t>(
        std::count(kinds.begin(), kinds.end(), static_cast<std::uint8_t>(kind)));
}

}  // namespace

TEST_CASE("a coarse interior with hanging nodes is hexahedra but for the boundary") {
    const Model model = parse_text("sphere(r = 10);", "csg");
    MeshOptions options;
    options.level = 6;
    options.interior_coarsening = 4;
    const Meshed conforming = mesh_and_check(model, options);
    CHECK(conforming.mesh.hanging.size() == 0);
    options.hanging = true;
    const Meshed hanging = mesh_and_check(model, options);
    CHECK(hanging.defects == "");
    // Every cell beside smaller ones: the boundary's are all of one size.
    CHECK(hanging.report.transition_cells > 1000);
    CHECK(hanging.report.hanging_cells == hanging.report.transition_cells);
    CHECK(of_kind(hanging.mesh, ElementType::kHexahedron, ElementKind::kTransition) ==
          hanging.report.hanging_cells);
    for (const ElementType type : {ElementType::kWedge, ElementType::kPyramid, ElementType::kTetrahedron})
        CHECK(of_kind(hanging.mesh, type, ElementKind::kTransition) == 0);
    CHECK(hanging_as_listed(hanging.mesh) == hanging_by_position(hanging.mesh, hanging.report));
    // All else stays.
    CHECK(hanging.mesh.facets.surface == conforming.mesh.facets.surface);
    CHECK(hanging.check.boundary_area == doctest::Approx(conforming.check.boundary_area).epsilon(1e-12));
    CHECK(hanging.check.volume == doctest::Approx(conforming.check.volume).epsilon(1e-12));
    CHECK(hanging.check.components == 1);
    CHECK(hanging.check.min_scaled_jacobian[0] == doctest::Approx(conforming.check.min_scaled_jacobian[0]));
    for (const ElementKind kind : {ElementKind::kIn, ElementKind::kSnio, ElementKind::kCnio}) {
        for (int t = 0; t < kElementTypes; ++t) {
            const auto type = static_cast<ElementType>(t);
            CHECK(of_kind(hanging.mesh, type, kind) == of_kind(conforming.mesh, type, kind));
        }
    }
}

TEST_CASE("cells whose faces others divide at the boundary keep their templates") {
    // Half of the ball is fine, so the front between the sizes ends at the surface.
    const Model model = parse_text("sphere(r = 10);", "csg");
    MeshOptions options;
    options.level = 5;
    options.interior_coarsening = 3;
    options.size_formula = "0.35 + max(x, 0)";
    options.hanging = true;
    const Meshed meshed = mesh_and_check(model, options);
    CHECK(meshed.defects == "");
    CHECK(meshed.report.hanging_cells > 0);
    CHECK(meshed.report.hanging_cells < meshed.report.transition_cells);
    CHECK(of_kind(meshed.mesh, ElementType::kTetrahedron, ElementKind::kTransition) > 0);
}

TEST_CASE("random graded models with hanging nodes are valid, and all that hang are listed") {
    const std::uint64_t first = environment_number("MORTISE_RANDOM_SEED", 1);
    const std::uint64_t count = environment_number("MORTISE_RANDOM_MODELS", 18);
    std::uint64_t cells = 0;
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
        CAPTURE(seed);
        const Model model = make_random_model(seed).model;
        MeshOptions options;
        options.level = 5;
        options.interior_coarsening = 1 + static_cast<int>(seed % 3);
        options.refine = static_cast<int>(seed % 2);
        options.improve = seed % 4 != 0;
        options.min_angle = seed % 4 == 1 ? 25 : 18;
        options.hanging = true;
        std::optional<Meshed> meshed;
        try {
            meshed = mesh_and_check(model, options);
        } catch (const Error& error) {
            if (error.code() != ExitCode::kInput) throw;  // an empty solid
            continue;
        }
        CHECK(meshed->defects == "");
        cells += meshed->report.hanging_cells;
        const auto listed = hanging_as_listed(meshed->mesh);
        const auto seen = hanging_by_position(meshed->mesh, meshed->report);
        for (const auto& [node, masters] : listed) {
            CAPTURE(node);
            REQUIRE(seen.count(node) == 1);
            CHECK(seen.at(node) == masters);
        }
        for (const auto& [node, masters] : seen) {
            CAPTURE(node);
            CHECK(listed.count(node) == 1);
        }
        if (seed > first + 5) continue;
        options.threads = 1;
        CHECK(is_same_mesh(generate(model, options), meshed->mesh));
        options.pieces = 7;
        CHECK(is_same_mesh(generate(model, options), meshed->mesh));
    }
    if (count >= 10) CHECK(cells > 100);
}

TEST_CASE("hanging nodes lie inside regions, never between two") {
    const Model model = parse_text(R"(algebraic3d
solid box = orthobrick(-1,-1,-1;1,1,1);
solid ball = sphere(0,0,0;0.6);
solid rest = box and not ball;
tlo ball;
tlo rest;
)",
                                   "geo");
    MeshOptions options;
    options.level = 6;
    options.interior_coarsening = 3;
    options.hanging = true;
    const Meshed meshed = mesh_and_check(model, options);
    CHECK(meshed.defects == "");
    CHECK(meshed.report.hanging_cells > 100);
    CHECK(meshed.check.region_volume[0] + meshed.check.region_volume[1] == doctest::Approx(8).epsilon(1e-9));
}

TEST_CASE("scaled Jacobians are the elements' own where cells with hanging nodes take the place of others") {
    // Cubes at the notches move, and hexahedra of templates that are listed before them go.
    const Model model = parse_text(
        "rotate([154, 308, 300]) linear_extrude(height = 6) polygon([[7, 0], [7.07, 7.07], [0, 8], "
        "[-7.07, 7.07], [-6, 0], [-7.07, -7.07], [0, -8], [7.07, -7.07]]);",
        "csg");
    MeshOptions options;
    options.level = 5;
    options.interior_coarsening = 1;
    options.refine = 1;
    options.hanging = true;
    const Meshed meshed = mesh_and_check(model, options);
    CHECK(meshed.defects == "");
    CHECK(meshed.report.hanging_cells > 0);
    CHECK(worst(meshed) == doctest::Approx(worst_jacobian(meshed.check)));
}

TEST_CASE("trees of one size have no hanging nodes, and tetrahedra none") {
    const Model model = parse_text("sphere(r = 10);", "csg");
    MeshOptions options;
    options.level = 4;
    const Mesh plain = generate(model, options);
    options.hanging = true;
    CHECK(is_same_mesh(generate(model, options), plain));
    options.tetrahedra = true;
    CHECK_THROWS_AS(generate(model, options), Error);
}

}  // namespace mortise::test
