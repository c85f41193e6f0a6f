// Periodic faces, of Netgen's "identify periodic" and of MeshOptions::periodic: the facets of one, moved, are
// those of the other.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <set>

#include "tests/corpora.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_source.hpp"

namespace mortise::test {
namespace {

/// Sections of the mesh's elements with a plane: the faces that lie in it, as sorted positions in the plane,
/// with the region of their element.
using Section = std::multiset<std::pair<std::vector<std::array<double, 2>>, int>>;

/// Element faces in the plane x[axis] == at, taken from the elements: facets are not looked at.
Section section(const Mesh& mesh, std::size_t axis, double at) {
    Section result;
    for (int t = 0; t < kElementTypes; ++t) {
        const auto type = static_cast<ElementType>(t);
        const ElementBlock& block = mesh.block(type);
        const auto size = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(t)]);
        const LocalFaces faces = local_faces(type);
        for (std::size_t i = 0; i < block.size(); ++i) {
            for (int f = 0; f < faces.count; ++f) {
                std::vector<std::array<double, 2>> key;
                bool in_plane = true;
                for (const int k : faces.faces[f]) {
                    if (k < 0) continue;
                    const NodeId node = block.nodes[i * size + static_cast<std::size_t>(k)];
                    const double* p = mesh.points.data() + 3 * std::size_t{node};
                    in_plane = in_plane && p[axis] == at;
                    key.push_back({p[(axis + 1) % 3], p[(axis + 2) % 3]});
                }
                if (!in_plane) continue;
                std::sort(key.begin(), key.end());
                result.insert({key, block.region[i]});
            }
        }
    }
    return result;
}

/// Equal up to 1e-12 of the unit box.
bool is_same(const Section& a, const Section& b) {
    if (a.size() != b.size()) return false;
    const auto rounded = [](const Section& s) {
        std::multiset<std::pair<std::vector<std::array<long long, 2>>, int>> result;
        for (const auto& [key, region] : s) {
            std::vector<std::array<long long, 2>> k;
            for (const auto& p : key) k.push_back({std::llround(p[0] * 1e12), std::llround(p[1] * 1e12)});
            std::sort(k.begin(), k.end());
            result.insert({k, region});
        }
        return result;
    };
    return a == b || rounded(a) == rounded(b);
}

bool warns_of_period(const MeshReport& report) {
    return std::any_of(report.warnings.begin(), report.warnings.end(),
                       [](const std::string& w) { return w.find("periodic") != std::string::npos; });
}

const std::string kCube =
    "algebraic3d\n"
    "solid px = plane (0,0,0;-1,0,0); solid qx = plane (1,0,0;1,0,0);\n"
    "solid py = plane (0,0,0;0,-1,0); solid qy = plane (0,1,0;0,1,0);\n"
    "solid pz = plane (0,0,0;0,0,-1); solid qz = plane (0,0,1;0,0,1);\n"
    "solid cube = px and qx and py and qy and pz and qz;\n";
const std::string kPairs = "identify periodic px qx; identify periodic py qy; identify periodic pz qz;\n";

/// Balls at the corners, in the middle of two faces and in the middle, so that all planes cut some.
std::string balls() {
    std::string text = "solid balls = sphere(0.5,0.52,0.47;0.2)";
    for (int c = 0; c < 8; ++c) {
        text += " or sphere(" + std::to_string(c & 1) + "," + std::to_string((c >> 1) & 1) + "," +
                std::to_string(c >> 2) + ";0.31)";
    }
    text += " or sphere(0,0.47,0.55;0.17) or sphere(1,0.47,0.55;0.17)";
    return text + ";\n";
}

/// One to four balls anywhere, with all images that meet the cube.
std::string random_balls(std::uint64_t seed) {
    RandomSource random(seed);
    std::string text;
    for (int n = random.integer(1, 4); n > 0; --n) {
        const Vec3 at = {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
        const double radius = random.uniform(0.12, 0.3);
        for (int image = 0; image < 27; ++image) {
            const Vec3 x = {at[0] + image % 3 - 1, at[1] + image / 3 % 3 - 1, at[2] + image / 9 - 1};
            if (std::any_of(x.begin(), x.end(), [&](double c) { return c < -radius || c > 1 + radius; }))
                continue;
            text += (text.empty() ? "solid balls = sphere(" : " or sphere(") + std::to_string(x[0]) + "," +
                    std::to_string(x[1]) + "," + std::to_string(x[2]) + ";" + std::to_string(radius) + ")";
        }
    }
    return text + ";\n";
}

void check_periodic(const std::string& text, const MeshOptions& options, const Vec3& period = {1, 1, 1}) {
    const Meshed m = mesh_and_check(parse_model(text, "geo", "periodic.geo"), options);
    CHECK(m.defects == "");
    CHECK_FALSE(warns_of_period(m.report));
    for (std::size_t axis = 0; axis < 3; ++axis) {
        CAPTURE(axis);
        const Section low = section(m.mesh, axis, 0);
        CHECK(low.size() > 50);
        CHECK(is_same(low, section(m.mesh, axis, period[axis])));
    }
}

/// Places of a facet's nodes and middles, moved.
std::vector<Vec3> places_of(const Mesh& mesh, std::size_t facet, const Vec3& shift) {
    std::vector<Vec3> places;
    const auto add = [&](NodeId node) {
        Vec3 place{};
        for (std::size_t j = 0; j < 3; ++j)
            place[j] = std::round((mesh.points[3 * std::size_t{node} + j] + shift[j]) * 1e9);
        places.push_back(place);
    };
    const FacetNodes corners = mesh.facets.facet(facet);
    for (const NodeId node : corners) add(node);
    for (std::size_t k = 0; k < corners.size() && mesh.is_second_order(); ++k)
        add(mesh.facets.middles[4 * facet + k]);
    std::sort(places.begin(), places.end());
    return places;
}

/// Meshes a model with MeshOptions::periodic, and checks Mesh::periodic: each node is where it should be, and
/// the facets of one plane are those of the other, moved.
void check_repeats(const Model& model, const MeshOptions& options, std::size_t pairs) {
    const Meshed m = mesh_and_check(model, options);
    CHECK(m.defects == "");
    CHECK_FALSE(warns_of_period(m.report));
    const Mesh& mesh = m.mesh;
    REQUIRE(mesh.periodic.size() == pairs);
    for (const PeriodicNodes& pair : mesh.periodic) {
        CHECK(std::is_sorted(pair.node.begin(), pair.node.end()));
        double farthest = 0;
        for (std::size_t i = 0; i < pair.size(); ++i) {
            for (std::size_t j = 0; j < 3; ++j) {
                const double to = mesh.points[3 * std::size_t{pair.node[i]} + j];
                const double from = mesh.points[3 * std::size_t{pair.original[i]} + j];
                farthest = std::max(farthest, std::fabs(to - from - pair.shift[j]));
            }
        }
        CHECK(farthest < 1e-12);
        std::size_t axis = 0;
        while (pair.shift[axis] == 0) ++axis;
        const std::string name = std::string("box_") + "xyz"[axis];
        std::multiset<std::vector<Vec3>> copies, originals;
        std::set<NodeId> nodes;
        for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
            const std::string& surface = mesh.surface_names[mesh.facets.surface[f]];
            if (surface == name + "min") originals.insert(places_of(mesh, f, pair.shift));
            if (surface != name + "max") continue;
            copies.insert(places_of(mesh, f, {}));
            const FacetNodes corners = mesh.facets.facet(f);
            nodes.insert(corners.begin(), corners.end());
            for (std::size_t k = 4 * f; k < 4 * f + 4 && mesh.is_second_order(); ++k)
                nodes.insert(mesh.facets.middles[k]);
        }
        CHECK(copies.size() > 20);
        CHECK(copies == originals);
        CHECK(nodes == std::set<NodeId>(pair.node.begin(), pair.node.end()));
    }
}

}  // namespace

TEST_CASE("three pairs of planes, balls at corners and faces, as holes and as a region") {
    const std::string regions =
        kCube + balls() + "solid inner = cube and balls; solid outer = cube and not balls;\n";
    for (const char* tlos : {"tlo outer;\n", "tlo outer; tlo inner;\n", "tlo inner;\n"}) {
        CAPTURE(tlos);
        for (const int level : {4, 5}) {
            MeshOptions options;
            options.level = level;
            check_periodic(regions + tlos + kPairs, options);
            options.improve = false;
            check_periodic(regions + tlos + kPairs, options);
        }
    }
}

TEST_CASE("elements at the planes, where two meet and where three meet are good") {
    const std::string cylinder = "solid balls = cylinder(0.5,0.52,0;0.5,0.52,1;0.23) or ";
    std::string both = balls();
    both.replace(0, std::string("solid balls = ").size(), cylinder);
    for (const std::string& holes : {balls(), both}) {
        for (const char* tlos : {"tlo outer;\n", "tlo outer; tlo inner;\n"}) {
            CAPTURE(std::string(tlos));
            MeshOptions options;
            options.level = 5;
            const Meshed m = mesh_and_check(
                parse_model(kCube + holes +
                                "solid inner = cube and balls; solid outer = cube and not balls;\n" + tlos +
                                kPairs,
                            "geo", "periodic.geo"),
                options);
            CHECK(m.defects == "");
            CHECK(m.check.min_dihedral >= 15);
            CHECK(m.check.max_dihedral <= 160);
            for (const double least : m.check.min_scaled_jacobian) CHECK(least >= 0.12);
        }
    }
}

TEST_CASE("random balls that repeat: the same faces") {
    const std::uint64_t first = environment_number("MORTISE_RANDOM_SEED", 1);
    const std::uint64_t count = environment_number("MORTISE_RANDOM_MODELS", 6);
    for (std::uint64_t seed = first; seed < first + count; ++seed) {
        CAPTURE(seed);
        MeshOptions options;
        options.level = 4;
        check_periodic(kCube + random_balls(seed) +
                           "solid inner = cube and balls; solid outer = cube and not balls;\n"
                           "tlo outer; tlo inner;\n" +
                           kPairs,
                       options);
    }
}

TEST_CASE("a ball's facets close to a plane do not become the plane's") {
    MeshOptions options;
    options.level = 4;
    check_periodic(
        kCube + random_balls(137) +
            "solid inner = cube and balls; solid outer = cube and not balls; tlo outer; tlo inner;\n" +
            kPairs,
        options);
}

TEST_CASE("tetrahedra, sizes by length, pieces: the same faces") {
    const std::string text = kCube + balls() + "solid outer = cube and not balls; tlo outer;\n" + kPairs;
    MeshOptions options;
    options.level = 5;
    options.tetrahedra = true;
    check_periodic(text, options);
    options = {};
    options.size = 0.043;
    check_periodic(text, options);
    options = {};
    options.level = 5;
    options.pieces = 5;
    check_periodic(text, options);
    options.pieces = 1;
    options.interior_coarsening = 2;
    check_periodic(text, options);
}

TEST_CASE("larger angles leave the planes as they are") {
    MeshOptions options;
    options.level = 4;
    options.min_angle = 25;
    check_periodic(kCube + balls() + "solid part = cube and not balls;\ntlo part;\n" + kPairs, options);
    options.tetrahedra = true;
    check_periodic(kCube + balls() + "solid part = cube and not balls;\ntlo part;\n" + kPairs, options);
}

TEST_CASE("sizes at one plane hold at the other, too") {
    const std::string text = kCube + balls() + "solid outer = cube and not balls; tlo outer;\n" + kPairs;
    for (const char* hint : {"singular edge px py;", "point (0, 0, 0.5);", "tlo outer px -maxh=0.02;"}) {
        CAPTURE(std::string(hint));
        MeshOptions options;
        options.level = 4;
        check_periodic(text + hint, options);
    }
}

TEST_CASE("periods that differ share a cell") {
    const std::string text =
        "algebraic3d\n"
        "solid px = plane (0,0,0;-1,0,0); solid qx = plane (1,0,0;1,0,0);\n"
        "solid py = plane (0,0,0;0,-1,0); solid qy = plane (0,0.6,0;0,1,0);\n"
        "solid pz = plane (0,0,0;0,0,-1); solid qz = plane (0,0,0.35;0,0,1);\n"
        "solid a = px and qx and py and qy and pz and qz and not (sphere(0,0.3,0.2;0.13) or "
        "sphere(1,0.3,0.2;0.13)); tlo a;\n" +
        kPairs;
    MeshOptions options;
    options.level = 6;
    check_periodic(text, options, {1, 0.6, 0.35});
    // No cell fits an irrational ratio: a warning.
    const std::string odd = kCube.substr(0, kCube.find("solid pz")) +
                            "solid pz = plane (0,0,0;0,0,-1); solid qz = plane (0,0,0.70710678;0,0,1);\n"
                            "solid a = px and qx and py and qy and pz and qz; tlo a;\n" +
                            kPairs;
    options.level = 4;
    const Meshed m = mesh_and_check(parse_model(odd, "geo", "odd.geo"), options);
    CHECK(m.defects == "");
    CHECK(warns_of_period(m.report));
}

TEST_CASE("a model that does not repeat: one warning with the place") {
    const std::string text = kCube +
                             "solid a = cube and not sphere(0,0.5,0.5;0.2); tlo a;\n"
                             "identify periodic px qx; identify periodic py qy;";
    MeshOptions options;
    options.level = 5;
    const Meshed m = mesh_and_check(parse_model(text, "geo", "half.geo"), options);
    CHECK(m.defects == "");
    std::vector<std::string> warnings;
    for (const std::string& warning : m.report.warnings) {
        if (warning.rfind("half.geo:", 0) == 0) warnings.push_back(warning);
    }
    REQUIRE(warnings.size() == 1);
    CAPTURE(warnings[0]);
    CHECK(warnings[0].rfind("half.geo:7:1: identify periodic px qx: ", 0) == 0);
    CHECK(warnings[0].find("the model differs") != std::string::npos);
    CHECK(warnings[0].find("'a'") != std::string::npos);
    const Section low = section(m.mesh, 1, 0);
    CHECK(is_same(low, section(m.mesh, 1, 1)));
}

TEST_CASE("what no grid can repeat is told") {
    const auto warning = [](const std::string& statement) {
        MeshOptions options;
        options.level = 4;
        const Meshed m = mesh_and_check(
            parse_model(
                "algebraic3d\nsolid p = plane(0,0,0;-1,-1,0); solid q = plane(1,1,0;1,1,0);\n"
                "solid s = sphere(0,0,0;9); solid b = orthobrick(-1,-1,-1;2,2,2); solid a = p and q and b;\n"
                "solid far = plane(0,0,0;0,1,0); tlo a;\n" +
                    statement,
                "geo", "odd.geo"),
            options);
        CHECK(m.defects == "");
        REQUIRE(m.report.warnings.size() == 1);
        return m.report.warnings[0];
    };
    CHECK(warning("identify periodic p q;").find("across the same axis") != std::string::npos);
    CHECK(warning("identify periodic p far;").find("bounds no region") != std::string::npos);
}

TEST_CASE("a box that repeats: sheets between minimal surfaces, of all kinds of elements") {
    const Model gyroid = parse_model(
        "gyroid(size = [40, 40, 40], period = 10, thickness = 2, center = true);", "csg", "g.csg");
    MeshOptions options;
    options.level = 4;
    options.box = Box3{{0, 0, 0}, {10, 10, 10}};
    options.periodic = "zxy";
    check_repeats(gyroid, options, 3);
    options.second_order = true;
    check_repeats(gyroid, options, 3);
    options.tetrahedra = true;
    check_repeats(gyroid, options, 3);
    options = {};
    options.size = 0.4;
    options.box = Box3{{2, -5, 1}, {12, 5, 11}};
    options.periodic = "xyz";
    check_repeats(gyroid, options, 3);
    // Beyond the period only across y.
    options.box = Box3{{0, 0, 0}, {7, 10, 4}};
    options.periodic = "y";
    check_repeats(gyroid, options, 1);
}

TEST_CASE("a box that repeats: a body-centred lattice, whose corners the box cuts") {
    std::string text = "algebraic3d\nsolid rods = ";
    const std::array<const char*, 4> along = {"1,1,1", "-1,1,1", "1,-1,1", "1,1,-1"};
    for (int image = 0; image < 27; ++image) {
        const std::array<int, 3> cell = {image % 3, image / 3 % 3, image / 9};
        for (const char* direction : along) {
            const double x[3] = {cell[0] - 0.5, cell[1] - 0.5, cell[2] - 0.5};
            double d[3];
            REQUIRE(std::sscanf(direction, "%lf,%lf,%lf", &d[0], &d[1], &d[2]) == 3);
            text += text.back() == ' ' ? "cylinder(" : " or cylinder(";
            for (int j = 0; j < 3; ++j) text += std::to_string(x[j]) + (j < 2 ? "," : ";");
            for (int j = 0; j < 3; ++j) text += std::to_string(x[j] + d[j]) + (j < 2 ? "," : ";0.13)");
        }
    }
    const Model lattice = parse_model(text + "; tlo rods;", "geo", "lattice.geo");
    MeshOptions options;
    options.level = 5;
    options.box = Box3{{0, 0, 0}, {1, 1, 1}};
    options.periodic = "xyz";
    check_repeats(lattice, options, 3);
    options.second_order = true;
    check_repeats(lattice, options, 3);
}

TEST_CASE("a box that repeats: several regions, sizes, the file's own box") {
    std::string text = kCube + balls() + "solid inner = balls; solid outer = not balls;\n";
    text.replace(0, text.find("solid balls"), "algebraic3d\nboundingbox(0,0,0;1,1,1);\n");
    const Model packing = parse_model(text + "tlo inner; tlo outer;", "geo", "packing.geo");
    MeshOptions options;
    options.level = 4;
    options.periodic = "xyz";
    check_repeats(packing, options, 3);
    options.interior_coarsening = 2;
    options.refine = 1;
    check_repeats(packing, options, 3);
    const MeshEstimate estimate = Mesher().estimate(packing, options);
    CHECK(estimate.is_exact);
    CHECK(estimate.nodes == generate_mesh(packing, options).node_count());
}

TEST_CASE("a box that cuts a surface through its saddles") {
    const double quarter = std::acos(0.0), period = 4 * quarter;
    const Model surface = parse_model("cos(x) + cos(y) + cos(z)", "formula", "p.formula");
    MeshOptions options;
    options.level = 4;
    options.box = Box3{{quarter, 4.747, 0.688}, {quarter + period, 4.747 + period, 0.688 + period}};
    options.periodic = "xyz";
    check_repeats(surface, options, 3);
}

TEST_CASE("a box that does not repeat: a warning, and no pairs") {
    const Model ball = parse_model("translate([0, 5, 5]) sphere(3);", "csg", "ball.csg");
    MeshOptions options;
    options.level = 4;
    options.box = Box3{{0, 0, 0}, {10, 10, 10}};
    options.periodic = "x";
    const Meshed m = mesh_and_check(ball, options);
    CHECK(m.defects == "");
    CHECK(m.mesh.periodic.empty());
    REQUIRE(m.report.warnings.size() == 1);
    CAPTURE(m.report.warnings[0]);
    CHECK(m.report.warnings[0].rfind("ball.csg: periodic faces across x: ", 0) == 0);
    CHECK(m.report.warnings[0].find("the model differs, at ") != std::string::npos);
}

TEST_CASE("a solid that does not reach the faces of the box: a warning, and no pair") {
    const Model ball = parse_model("sphere(3);", "csg", "ball.csg");
    MeshOptions options;
    options.level = 4;
    options.box = Box3{{-5, -5, -5}, {5, 5, 5}};
    options.periodic = "y";
    const Meshed m = mesh_and_check(ball, options);
    CHECK(m.mesh.periodic.empty());
    REQUIRE(m.report.warnings.size() == 1);
    CHECK(m.report.warnings[0] == "ball.csg: periodic faces across y: the solid does not reach these faces");
}

TEST_CASE("the corpora's periodic model") {
    const std::filesystem::path file = corpora_folder() / "netgen-tutorials" / "period.geo";
    if (!std::filesystem::exists(file)) {
        MESSAGE("skipped: 1 model of the corpora is not there");
        return;
    }
    MeshOptions options;
    options.level = 5;
    const Meshed m = mesh_and_check(read_model(file.string()), options);
    CHECK(m.defects == "");
    CHECK_FALSE(warns_of_period(m.report));
    for (std::size_t axis = 0; axis < 3; ++axis)
        CHECK(is_same(section(m.mesh, axis, 0), section(m.mesh, axis, 1)));
}

}  // namespace mortise::test
