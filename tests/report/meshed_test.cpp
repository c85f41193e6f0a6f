// Features and distances of meshes that the mesher makes, against closed forms.
#include <doctest/doctest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "host/common/constants.hpp"
#include "mortise/io.hpp"
#include "tests/mesher/meshed.hpp"

using namespace mortise;
using namespace mortise::test;

namespace {

struct Assessed {
    Mesh mesh;
    MeshReport report;
    const QualityReport& quality() const { return *report.quality; }
    double crease_length() const {
        double sum = 0;
        for (const FeatureCurve& curve : report.features.curves) sum += curve.length;
        return sum;
    }
};

Assessed assess(const Model& model, int level, bool tetrahedra = false) {
    MeshOptions options;
    options.level = level;
    options.quality = true;
    options.tetrahedra = tetrahedra;
    Assessed result;
    result.mesh = generate(model, options, &result.report);
    REQUIRE(result.report.quality.has_value());
    return result;
}

}  // namespace

TEST_CASE("boxes keep 12 creases and 8 corners at any angle, as hexahedra and as tetrahedra") {
    for (const double angle : {0.0, 0.4}) {
        for (const bool tetrahedra : {false, true}) {
            CAPTURE(angle);
            CAPTURE(tetrahedra);
            const Model model = transformed(one_solid([](Model& m) {
                                                return add_box(m, {0, 0, 0}, {1, 0.8, 0.6});
                                            }),
                                            rotation({3, 1, 2}, angle));
            const Assessed box = assess(model, 4, tetrahedra);
            CHECK(box.report.features.curves.size() == 12);
            CHECK(box.report.features.corners.size() == 8);
            CHECK(box.crease_length() == doctest::Approx(4 * 2.4).epsilon(1e-7));
            for (const FeatureCurve& curve : box.report.features.curves) {
                CHECK(curve.model_angle == doctest::Approx(90));
                CHECK_FALSE(curve.closed);
            }
            CHECK(box.quality().corners_expected == 8);
            CHECK(box.quality().corners_found == 8);
            CHECK(box.quality().corners_extra == 0);
            CHECK(box.quality().surfaces.size() == 6);
            CHECK(box.quality().mesh_to_model.maximum < 1e-7);
            CHECK(box.quality().model_to_mesh.maximum < 1e-7);
            REQUIRE(box.mesh.model_dimension.size() == box.mesh.node_count());
        }
    }
}

TEST_CASE("two boxes that make an L: one crease is concave") {
    const Assessed l =
        assess(one_solid([](Model& m) {
                   return unite(m, {add_box(m, {0, 0, 0}, {2, 1, 1}), add_box(m, {0, 0, 0}, {1, 2, 1})});
               }),
               4);
    CHECK(l.report.features.corners.size() == 12);
    CHECK(l.report.features.curves.size() == 18);
    CHECK(l.quality().corners_expected == 12);
    CHECK(l.quality().corners_found == 12);
    int concave = 0;
    for (const FeatureCurve& curve : l.report.features.curves) {
        if (curve.model_angle > 180) {
            ++concave;
            CHECK(curve.model_angle == doctest::Approx(270));
            CHECK(curve.length == doctest::Approx(1).epsilon(1e-7));
        } else {
            CHECK(curve.model_angle == doctest::Approx(90));
        }
    }
    CHECK(concave == 1);
    CHECK(l.crease_length() == doctest::Approx(2 * 8 + 6).epsilon(1e-7));
}

TEST_CASE("a cylinder's two circles close, and their length converges with order 2") {
    // Over two levels: where the grid lies across the axis differs from level to level.
    std::vector<double> errors;
    for (const int level : {4, 5, 6}) {
        const Assessed cylinder =
            assess(one_solid([](Model& m) { return add_cylinder(m, 1, 0, 1.7); }), level);
        REQUIRE(cylinder.report.features.curves.size() == 2);
        CHECK(cylinder.report.features.corners.empty());
        for (const FeatureCurve& curve : cylinder.report.features.curves) {
            CHECK(curve.closed);
            CHECK(curve.model_angle == doctest::Approx(90));
        }
        const double error = 4 * kPi - cylinder.crease_length();
        MESSAGE("level ", level, ": circles too short by ", error);
        CHECK(error > 0);
        errors.push_back(error);
    }
    CHECK(errors[0] / errors[2] > 10);
    CHECK(errors[2] < 0.001 * 4 * kPi);
}

TEST_CASE("a ball has no features, and its distance to the mesh falls four times per level") {
    double forth = 0, back = 0, normals = 0;
    for (const int level : {4, 5, 6}) {
        const Assessed sphere = assess(one_solid([](Model& m) {
                                           return add_ball(m, {0.1, 0.2, 0.3}, 1);
                                       }),
                                       level);
        CHECK(sphere.report.features.curves.empty());
        CHECK(sphere.report.features.corners.empty());
        const QualityReport& q = sphere.quality();
        CHECK(q.corners_expected == 0);
        CHECK(q.surfaces.size() == 1);
        CHECK(q.surfaces[0].components == 1);
        MESSAGE("level ", level, ": mesh to model ", q.mesh_to_model.maximum, " mean ", q.mesh_to_model.mean,
                "; model to mesh ", q.model_to_mesh.maximum, " mean ", q.model_to_mesh.mean,
                "; mean angle of normals ", q.mean_normal_angle);
        if (forth > 0) {
            CHECK(forth / q.mesh_to_model.mean > 3.4);
            CHECK(forth / q.mesh_to_model.mean < 4.8);
            CHECK(back / q.model_to_mesh.mean > 3.4);
            CHECK(back / q.model_to_mesh.mean < 4.8);
        }
        forth = q.mesh_to_model.mean;
        back = q.model_to_mesh.mean;
        if (level == 4) normals = q.mean_normal_angle;
        // Order 1; single steps scatter, as smoothing has more or less room.
        if (level == 6) CHECK(normals / q.mean_normal_angle > 3);
        // A chord of two cells' diagonal is the longest edge there can be.
        const double chord = 2 * std::sqrt(3.0) * sphere.report.cell_size;
        CHECK(q.mesh_to_model.maximum < chord * chord / 8);
    }
}

TEST_CASE("distances of the ball's mesh are those of its radius") {
    // An oracle that knows that the surface is a sphere: every node and facet mean.
    const Assessed sphere = assess(one_solid([](Model& m) { return add_ball(m, {0, 0, 0}, 1); }), 5);
    double largest = 0;
    for (std::size_t f = 0; f < sphere.mesh.facets.size(); ++f) {
        const FacetNodes nodes = sphere.mesh.facets.facet(f);
        double mean[3] = {0, 0, 0};
        for (const NodeId node : nodes) {
            for (std::size_t j = 0; j < 3; ++j)
                mean[j] += sphere.mesh.points[3 * std::size_t{node} + j] / static_cast<double>(nodes.size());
        }
        largest = std::max(largest, std::fabs(1 - std::hypot(mean[0], mean[1], mean[2])));
    }
    CHECK(sphere.quality().mesh_to_model.maximum >= largest * (1 - 1e-6));
    CHECK(sphere.quality().mesh_to_model.maximum < 2 * largest);
}

TEST_CASE("a cone's apex is a corner, its rim one closed crease") {
    const Assessed cone = assess(one_solid([](Model& m) { return add_frustum(m, 1, 0, 0, 2); }), 5);
    CHECK(cone.quality().corners_expected == 1);
    REQUIRE(cone.report.features.curves.size() == 1);
    CHECK(cone.report.features.curves[0].closed);
    CHECK(cone.report.features.curves[0].model_angle ==
          doctest::Approx(180 / kPi * std::atan(2.0)).epsilon(0.001));
}

TEST_CASE("the sharp edge of a wedge gives its own angle as the cause") {
    // A right triangle of 2 × 0.5: angles 90, 75.96 and 14.04 degrees.
    const Assessed sharp =
        assess(one_solid([](Model& m) { return m.add_primitive(wedge(2, 0.5, 1), "blade"); }), 5);
    double smallest = 360;
    for (const FeatureCurve& curve : sharp.report.features.curves)
        smallest = std::min(smallest, curve.model_angle);
    CHECK(smallest == doctest::Approx(180 / kPi * std::atan(0.25)));
    CHECK(sharp.quality().corners_expected == 6);
    REQUIRE(!sharp.quality().worst.empty());
    CHECK(sharp.quality().worst[0].cause.find("14 degrees") != std::string::npos);
}

TEST_CASE("without --quality there is no report, but the nodes are classified") {
    MeshReport report;
    MeshOptions options;
    options.level = 4;
    const Mesh mesh = generate(one_solid([](Model& m) {
                                   return add_box(m, {0, 0, 0}, {1, 1, 1});
                               }),
                               options, &report);
    CHECK_FALSE(report.quality.has_value());
    CHECK(report.features.corners.size() == 8);
    CHECK(mesh.model_dimension == report.features.model_dimension);
}

TEST_CASE("files: model_dimension in .vtu, curves in .vtp") {
    namespace fs = std::filesystem;
    const fs::path folder = fs::temp_directory_path() / ("mortise_report_" + std::to_string(getpid()));
    fs::create_directories(folder);
    const Assessed box = assess(one_solid([](Model& m) { return add_box(m, {0, 0, 0}, {1, 1, 1}); }), 3);
    const std::string vtu = (folder / "a.vtu").string(), vtp = (folder / "a.vtp").string();
    write_mesh(box.mesh, vtu);
    CHECK(read_mesh(vtu).model_dimension == box.mesh.model_dimension);
    Mesh plain = box.mesh;
    plain.model_dimension.clear();
    write_mesh(plain, vtu);
    CHECK(read_mesh(vtu).model_dimension.empty());
    plain.model_dimension.assign(3, 0);
    CHECK_THROWS_AS(write_mesh(plain, vtu), Error);

    write_features(box.mesh, box.report.features, vtp);
    std::ifstream stream(vtp, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    CHECK(text.find("type=\"PolyData\"") != std::string::npos);
    CHECK(text.find("NumberOfVerts=\"8\" NumberOfLines=\"12\"") != std::string::npos);
    Features foreign = box.report.features;
    foreign.corners.at(0).node = static_cast<NodeId>(box.mesh.node_count());
    CHECK_THROWS_WITH_AS(write_features(box.mesh, foreign, "foreign.vtp"),
                         "cannot write 'foreign.vtp': features of another mesh: corner with a node index out "
                         "of range",
                         Error);
    foreign = box.report.features;
    foreign.curves.at(0).nodes.clear();
    CHECK_THROWS_AS(write_features(box.mesh, foreign, "foreign.vtp"), Error);
    write_features(box.mesh, Features{}, vtp);
    fs::remove_all(folder);
}
