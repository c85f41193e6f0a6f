// Meshes that are handed on part by part equal those that are made whole, number for number.
#include <doctest/doctest.h>
#include <malloc.h>

#include <string>

#include "host/pipeline/memory_limit.hpp"
#include "mortise/mesher.hpp"
#include "tests/assembly/regions_on_grid.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_models.hpp"

using namespace mortise;

namespace {

/// Puts the parts together again.
class Collector : public MeshSink {
  public:
    void begin(const MeshTotals& wanted, const Mesh& outline) override {
        CHECK(++begins == 1);
        totals = wanted;
        mesh = outline;
        CHECK(outline.points.empty());
        CHECK(outline.element_count() == 0);
    }

    void add(const Mesh& part, const std::vector<float>& scaled_jacobians) override {
        CHECK(begins == 1);
        ++parts;
        CHECK(part.facets.size() == 0);
        CHECK(part.model_dimension.size() == part.node_count());
        REQUIRE(scaled_jacobians.size() == part.element_count());
        append(mesh.points, part.points);
        append(mesh.model_dimension, part.model_dimension);
        auto next = scaled_jacobians.begin();
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            append(mesh.elements[t].nodes, part.elements[t].nodes);
            append(mesh.elements[t].region, part.elements[t].region);
            append(mesh.elements[t].kind, part.elements[t].kind);
            const auto end = next + static_cast<std::ptrdiff_t>(part.elements[t].size());
            jacobians[t].insert(jacobians[t].end(), next, end);
            next = end;
        }
    }

    int begins = 0;
    int parts = 0;
    MeshTotals totals;
    Mesh mesh;
    std::array<std::vector<float>, kElementTypes> jacobians;

  private:
    template <class T>
    static void append(std::vector<T>& to, const std::vector<T>& from) {
        to.insert(to.end(), from.begin(), from.end());
    }
};

void check_same_features(const Features& a, const Features& b) {
    REQUIRE(a.curves.size() == b.curves.size());
    for (std::size_t i = 0; i < a.curves.size(); ++i) {
        CHECK(a.curves[i].name == b.curves[i].name);
        CHECK(a.curves[i].nodes == b.curves[i].nodes);
        CHECK(a.curves[i].length == b.curves[i].length);
    }
    REQUIRE(a.corners.size() == b.corners.size());
    for (std::size_t i = 0; i < a.corners.size(); ++i) {
        CHECK(a.corners[i].node == b.corners[i].node);
        CHECK(a.corners[i].surfaces == b.corners[i].surfaces);
    }
}

/// What tells the runs apart besides how they are made.
void check_same_report(const MeshReport& whole, const MeshReport& parts) {
    REQUIRE(whole.warnings.size() == parts.warnings.size());
    for (std::size_t i = 0; i < whole.warnings.size(); ++i) CHECK(whole.warnings[i] == parts.warnings[i]);
    CHECK(whole.refused_splits == parts.refused_splits);
    CHECK(whole.dropped_features == parts.dropped_features);
    CHECK(whole.first_dropped == parts.first_dropped);
    CHECK(whole.cnio_cells == parts.cnio_cells);
    CHECK(whole.snio_cells == parts.snio_cells);
    check_same_features(whole.features, parts.features);
    CHECK(parts.scaled_jacobians.empty());
    CHECK(parts.features.model_dimension.empty());
}

/// `pieces` 1: as many as the memory asks for.
void check_stream(Mesher& mesher, const Model& model, MeshOptions options, int pieces) {
    MeshReport whole_report, report;
    const Mesh whole = mesher.generate(model, options, &whole_report);
    Collector collector;
    options.pieces = pieces;
    mesher.stream(model, options, collector, &report);
    CHECK(collector.parts >= pieces);
    const Mesh& mesh = collector.mesh;
    CHECK(collector.totals.nodes == whole.node_count());
    CHECK(mesh.points == whole.points);
    CHECK(mesh.model_dimension == whole.model_dimension);
    std::vector<float> jacobians;
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        CAPTURE(t);
        CHECK(collector.totals.elements[t] == whole.elements[t].size());
        CHECK(mesh.elements[t].nodes == whole.elements[t].nodes);
        CHECK(mesh.elements[t].region == whole.elements[t].region);
        CHECK(mesh.elements[t].kind == whole.elements[t].kind);
        jacobians.insert(jacobians.end(), collector.jacobians[t].begin(), collector.jacobians[t].end());
    }
    CHECK(jacobians == whole_report.scaled_jacobians);
    CHECK(mesh.facets.nodes == whole.facets.nodes);
    CHECK(mesh.facets.surface == whole.facets.surface);
    CHECK(mesh.facets.inside == whole.facets.inside);
    CHECK(mesh.facets.outside == whole.facets.outside);
    CHECK(mesh.region_names == whole.region_names);
    CHECK(mesh.surface_names == whole.surface_names);
    check_same_report(whole_report, report);
}

Model asset(const char* name) {
    return read_model(std::string(MORTISE_SOURCE_DIR "/assets/models/") + name + ".csg");
}

Model ball() {
    Model model;
    model.add_primitive(sphere(1));
    model.regions.push_back({"ball", 0, 0, {}});
    return model;
}

/// What this process holds and so many MiB more. What the heap has free goes back first: a run that gave it
/// back later would find more than these.
std::uint64_t memory_with(std::uint64_t mebibytes) {
    malloc_trim(0);
    return pipeline::memory_now() + (mebibytes << 20);
}

}  // namespace

TEST_CASE("models in parts, improved") {
    Mesher mesher;
    for (const char* name : {"bracket", "star", "housing", "object_x"}) {
        for (const int pieces : {1, 2, 7, 64}) {
            CAPTURE(name);
            CAPTURE(pieces);
            MeshOptions options;
            options.level = 5;
            check_stream(mesher, asset(name), options, pieces);
        }
    }
}

TEST_CASE("unimproved, without templates, without snapping, on one thread") {
    Mesher mesher;
    const Model model = asset("housing");
    for (int k = 0; k < 4; ++k) {
        CAPTURE(k);
        MeshOptions options;
        options.level = 5;
        options.improve = k != 0;
        options.templates = k != 1;
        options.snap = k != 2;
        options.threads = k == 3 ? 1 : 0;
        check_stream(mesher, model, options, 9);
    }
}

TEST_CASE("a smooth surface: poor elements are few, and most parts hold none") {
    Mesher mesher;
    MeshOptions options;
    options.level = 6;
    check_stream(mesher, ball(), options, 100);
}

// Three boxes with corners within some hundredths of a cell: nodes leave the model.
TEST_CASE("loose nodes, in parts") {
    Mesher mesher;
    const Model model = parse_model(
        "difference() { cube(size = [18, 18, 18], center = true);"
        " multmatrix([[0.897027, -0.249156, -0.365053, 0.003064], [-0.036625, 0.781213, -0.623189, "
        "-0.013886],"
        " [0.440455, 0.572388, 0.691644, -0.003716], [0, 0, 0, 1]]) { cube(size = [7.5, 8.6, 8.5]); }"
        " multmatrix([[0.979317, -0.088552, 0.181926, -0.00769], [-0.10236, 0.55876, 0.822988, 0.017163],"
        " [-0.17453, -0.824588, 0.538139, -0.006906], [0, 0, 0, 1]]) { cube(size = [8.8, 6.8, 5.8]); }"
        " multmatrix([[0.991724, -0.080943, 0.099658, -0.013006], [0.057089, 0.973282, 0.222401, 0.008124],"
        " [-0.114997, -0.214871, 0.969849, -0.009094], [0, 0, 0, 1]]) { cube(size = [7.3, 5.1, 5.4]); } }",
        "csg", "clump.csg");
    MeshOptions options;
    options.level = 5;
    MeshReport report;
    mesher.generate(model, options, &report);
    CHECK(report.loosened_nodes > 0);
    check_stream(mesher, model, options, 20);
}

// Improvement adds nodes around a step of a fifteenth of a cell.
TEST_CASE("a step with smaller elements beside it, in parts") {
    Mesher mesher;
    const Model model = parse_model(
        "multmatrix([[0.8, -0.6, 0, 0], [0.6, 0.8, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) {"
        " cube(size = [20, 20, 10]); cube(size = [40, 13, 10.1]); }",
        "csg", "step.csg");
    MeshOptions options;
    options.level = 5;
    for (const int pieces : {3, 40}) {
        CAPTURE(pieces);
        check_stream(mesher, model, options, pieces);
    }
}

TEST_CASE("larger angles, in parts: most of the boundary is improved") {
    Mesher mesher;
    MeshOptions options;
    options.level = 5;
    options.min_angle = 25;
    for (const int pieces : {4, 30}) {
        CAPTURE(pieces);
        check_stream(mesher, asset("bracket"), options, pieces);
    }
}

TEST_CASE("two pipes of one radius, whose creases cross") {
    Mesher mesher;
    MeshOptions options;
    options.level = 5;
    const std::string pipe = "cylinder(h = 40, r1 = 10, r2 = 10, center = true);";
    const Model model = parse_model(
        "multmatrix([[0.36, 0.48, -0.8, 1], [-0.8, 0.6, 0, 2], [0.48, 0.64, 0.6, 3], [0, 0, 0, 1]]) {"
        "intersection() { " +
            pipe + " multmatrix([[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]) {" + pipe +
            "} } }",
        "csg", "pipes.csg");
    check_stream(mesher, model, options, 5);
}

TEST_CASE("several regions, with interfaces on cell faces") {
    Mesher mesher;
    MeshOptions options;
    options.level = 5;
    for (const int pieces : {3, 50})
        check_stream(mesher, parse_model(test::kRegionsOnGrid, "geo", "regions"), options, pieces);
}

TEST_CASE("random models in parts") {
    Mesher mesher;
    for (std::uint64_t seed = 4000; seed < 4025; ++seed) {
        CAPTURE(seed);
        const Model model = test::make_random_model(seed).model;
        MeshOptions options;
        options.level = 4;
        try {
            check_stream(mesher, model, options, 2 + static_cast<int>(seed % 30));
        } catch (const Error& error) {
            const std::string what = error.what();
            CAPTURE(what);
            CHECK(error.code() == ExitCode::kInput);  // empty
        }
    }
}

TEST_CASE("parts follow from the memory") {
    Mesher mesher;
    MeshOptions options;
    options.level = 7;
    options.memory = memory_with(3072);
    Collector few;
    mesher.stream(ball(), options, few);
    options.memory = memory_with(250);
    Collector many;
    mesher.stream(ball(), options, many);
    CHECK(many.parts > few.parts);
    CHECK(many.mesh.points == few.mesh.points);
    CHECK(many.mesh.elements[0].nodes == few.mesh.elements[0].nodes);
}

TEST_CASE("a boundary that does not fit into the memory is refused before it is classified") {
    Mesher mesher;
    test::DiscardingSink sink;
    MeshOptions options;
    options.level = 7;
    options.memory = memory_with(1);
    MeshReport report;
    ExitCode code = ExitCode::kOk;
    try {
        mesher.stream(ball(), options, sink, &report);
    } catch (const Error& error) {
        code = error.code();
        CHECK(std::string(error.what()).find("the cells at the boundary need about") == 0);
    }
    CHECK(code == ExitCode::kDevice);
    CHECK(report.nio_cells > 50000);
    const auto is_classification = [](const StageTime& stage) { return stage.stage == "classify"; };
    CHECK(std::none_of(report.stages.begin(), report.stages.end(), is_classification));
}

TEST_CASE("what cannot be made in parts is refused") {
    Mesher mesher;
    test::DiscardingSink sink;
    const auto code_of = [&](const Model& model, const MeshOptions& options) {
        try {
            mesher.stream(model, options, sink);
        } catch (const Error& error) {
            CAPTURE(error.what());
            CHECK(std::string(error.what()).find("memory") != std::string::npos);
            return error.code();
        }
        return ExitCode::kOk;
    };
    MeshOptions options;
    options.level = 4;
    CHECK(code_of(ball(), options) == ExitCode::kOk);
    options.memory = 1 << 20;
    CHECK(code_of(ball(), options) == ExitCode::kDevice);
    options.memory = 0;
    options.tetrahedra = true;
    CHECK(code_of(ball(), options) == ExitCode::kUsage);
    options.tetrahedra = false;
    options.quality = true;
    CHECK(code_of(ball(), options) == ExitCode::kUsage);
    options.quality = false;
    options.interior_coarsening = 1;
    CHECK(code_of(ball(), options) == ExitCode::kUsage);
}

TEST_CASE("an empty model and an interrupted run end as usual") {
    Mesher mesher;
    test::DiscardingSink sink;
    Model empty =
        parse_model("algebraic3d\nsolid a = sphere (0,0,0;1) and sphere (5,0,0;1);\ntlo a;\n", "geo", "e");
    MeshOptions options;
    options.level = 4;
    try {
        mesher.stream(empty, options, sink);
        FAIL("an empty model was meshed");
    } catch (const Error& error) {
        CHECK(error.code() == ExitCode::kInput);
    }
    options.progress = [](const char* stage, double) { return std::string(stage) != "judge"; };
    CHECK_THROWS_WITH(mesher.stream(ball(), options, sink), "interrupted");
}
