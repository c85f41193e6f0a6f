// Mesher::estimate beside the meshes that it tells of.
#include <doctest/doctest.h>

#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "host/pipeline/estimate.hpp"
#include "mortise/error.hpp"
#include "mortise/io.hpp"
#include "mortise/mesher.hpp"
#include "tests/mesher/meshed.hpp"

namespace mortise::test {
namespace {

Model parsed(const char* text) { return parse_model(text, "csg", "model.csg"); }

constexpr const char* kBall = "sphere(r = 1);";
constexpr const char* kTee =
    "union() { cylinder(h = 4, r1 = 1, r2 = 1, center = true); multmatrix([[0,0,1,0],[0,1,0,0],[-1,0,0,0],"
    "[0,0,0,1]]) cylinder(h = 3, r1 = 0.6, r2 = 0.6); }";

/// Of a .vtu with plain arrays.
double file_bytes(const Mesh& mesh) {
    const auto path =
        std::filesystem::temp_directory_path() / ("mortise-estimate-" + std::to_string(getpid()) + ".vtu");
    MeshFileOptions options;
    options.compress = false;
    write_mesh(mesh, path.string(), {}, options);
    const auto size = static_cast<double>(std::filesystem::file_size(path));
    std::filesystem::remove(path);
    return size;
}

/// What the estimate is to what was made.
struct Ratio {
    double elements, nodes, file;
};
Ratio compare(const char* text, const MeshOptions& options, bool is_exact) {
    Mesher mesher;
    const Model model = parsed(text);
    const MeshEstimate estimate = mesher.estimate(model, options);
    CHECK(estimate.is_exact == is_exact);
    MeshReport report;
    const Mesh mesh = mesher.generate(model, options, &report);
    CHECK(estimate.level == report.level);
    CHECK(estimate.cell_size == doctest::Approx(report.cell_size));
    CHECK(estimate.nio_cells == report.nio_cells);
    CHECK(estimate.in_cells == report.in_cells);
    CHECK(estimate.finest_level == report.finest_level);
    return {static_cast<double>(estimate.elements) / static_cast<double>(mesh.element_count()),
            static_cast<double>(estimate.nodes) / static_cast<double>(mesh.node_count()),
            static_cast<double>(estimate.file_bytes) / file_bytes(mesh)};
}

}  // namespace

TEST_CASE("an estimate of a model with few cells at its boundary is exact") {
    MeshOptions options;
    options.level = 5;
    const Ratio uniform = compare(kTee, options, true);
    CHECK(uniform.elements == 1);
    CHECK(uniform.nodes == 1);
    options.refine = 1;
    options.curvature_elements = 60;
    options.interior_coarsening = 2;
    const Ratio graded = compare(kTee, options, true);
    CHECK(graded.elements == 1);
    CHECK(graded.nodes == 1);
}

TEST_CASE("an estimate from coarser meshes: elements and nodes to some percent") {
    for (const bool tetrahedra : {false, true}) {
        for (const bool second_order : {false, true}) {
            CAPTURE(tetrahedra);
            CAPTURE(second_order);
            MeshOptions options;
            options.level = 7;
            options.tetrahedra = tetrahedra;
            options.second_order = second_order;
            const Ratio ball = compare(kBall, options, false);
            CHECK(ball.elements == doctest::Approx(1).epsilon(0.02));
            CHECK(ball.nodes == doctest::Approx(1).epsilon(0.02));
            const Ratio tee = compare(kTee, options, false);
            CHECK(tee.elements == doctest::Approx(1).epsilon(0.15));
            CHECK(tee.nodes == doctest::Approx(1).epsilon(0.05));
            CHECK(tee.file == doctest::Approx(1).epsilon(0.1));
        }
    }
}

TEST_CASE("an estimate of cells of several sizes") {
    MeshOptions options;
    options.level = 4;
    options.refine = 4;
    options.curvature_elements = 400;
    const Ratio ball = compare(kBall, options, false);
    CHECK(ball.elements == doctest::Approx(1).epsilon(0.2));
    CHECK(ball.nodes == doctest::Approx(1).epsilon(0.2));
    options.level = 7;
    options.refine = 0;
    options.curvature_elements = 0;
    options.interior_coarsening = 3;
    const Ratio tee = compare(kTee, options, false);
    CHECK(tee.elements == doctest::Approx(1).epsilon(0.2));
    CHECK(tee.nodes == doctest::Approx(1).epsilon(0.2));
}

TEST_CASE("an estimate of cells too many to count, from fewer of them") {
    Mesher mesher;
    const Model ball = parsed(kBall);
    MeshOptions options;
    options.level = 10;
    const MeshEstimate estimate = mesher.estimate(ball, options);
    const double cells = 4.18879 / (estimate.cell_size * estimate.cell_size * estimate.cell_size);
    CHECK(static_cast<double>(estimate.elements) == doctest::Approx(cells).epsilon(0.03));
    CHECK(static_cast<double>(estimate.memory_bytes) > 60 * cells);
    CHECK(static_cast<double>(estimate.memory_bytes) < 110 * cells);
    // Also where cells have several sizes, without building the whole tree.
    options.refine = 1;
    options.interior_coarsening = 1;
    const MeshEstimate graded = mesher.estimate(ball, options);
    CHECK(graded.level == 10);
    CHECK(static_cast<double>(graded.nio_cells) ==
          doctest::Approx(static_cast<double>(estimate.nio_cells)).epsilon(0.25));
}

TEST_CASE("where larger cells take longer than cells as asked, a part of the model tells") {
    std::string lattice;
    for (int i = 0; i < 216; ++i)
        lattice += "multmatrix([[1,0,0," + std::to_string(i % 6) + "],[0,1,0," + std::to_string(i / 6 % 6) +
                   "],[0,0,1," + std::to_string(i / 36) + "],[0,0,0,1]]) sphere(r = 0.4);";
    const Model model = parsed(lattice.c_str());
    MeshOptions options;
    options.level = 6;
    Mesher mesher;
    std::vector<double> sizes;
    device::Device device("", {});
    const double cell = 5.8 / 64;
    const MeshEstimate estimate =
        pipeline::estimate([&]() -> device::Device& { return device; }, model, options,
                           [&](const Model& tried, const MeshOptions& trial, MeshReport& report) {
                               if (tried.source == model.source) sizes.push_back(trial.size);
                               while (trial.size > 1.5 * cell && trial.progress("improve", 0.5))
                                   std::this_thread::sleep_for(std::chrono::milliseconds(20));
                               if (trial.size > 1.5 * cell) throw Interrupted();
                               return mesher.generate(tried, trial, &report);
                           });
    REQUIRE(sizes.size() >= 2);
    CHECK(sizes[0] > 1.5 * cell);  // given up
    CHECK(sizes[1] < 1.5 * cell);  // of a part
    const Mesh mesh = generate(model, options);
    CHECK(static_cast<double>(estimate.elements) ==
          doctest::Approx(static_cast<double>(mesh.element_count())).epsilon(0.2));
    CHECK(static_cast<double>(estimate.nodes) ==
          doctest::Approx(static_cast<double>(mesh.node_count())).epsilon(0.2));
    CHECK_FALSE(estimate.is_exact);
}

TEST_CASE("where a mesh of few cells takes long, a part of it tells") {
    const Model model = parsed(kTee);
    MeshOptions options;
    options.level = 6;
    Mesher mesher;
    device::Device device("", {});
    int whole = 0;
    int parts = 0;
    const MeshEstimate estimate =
        pipeline::estimate([&]() -> device::Device& { return device; }, model, options,
                           [&](const Model& tried, const MeshOptions& trial, MeshReport& report) {
                               const bool is_whole = tried.source == model.source && !trial.box;
                               (is_whole ? whole : parts) += tried.source == model.source ? 1 : 0;
                               while (is_whole && trial.progress("improve", 0.5))
                                   std::this_thread::sleep_for(std::chrono::milliseconds(20));
                               if (is_whole) throw Interrupted();
                               return mesher.generate(tried, trial, &report);
                           });
    CHECK(whole == 1);
    CHECK(parts >= 1);
    const Mesh mesh = generate(model, options);
    CHECK(static_cast<double>(estimate.elements) ==
          doctest::Approx(static_cast<double>(mesh.element_count())).epsilon(0.2));
    CHECK_FALSE(estimate.is_exact);
}

TEST_CASE("an estimate ends when its caller wants no more, and tells what generate tells") {
    Mesher mesher;
    MeshOptions options;
    options.level = 7;
    int calls = 0;
    options.progress = [&calls](const char*, double) { return ++calls < 12; };
    CHECK_THROWS_AS(mesher.estimate(parsed(kBall), options), Interrupted);
    options.progress = nullptr;
    CHECK_THROWS_AS(
        mesher.estimate(parsed("difference() { sphere(r = 1); cube(9, center = true); }"), options), Error);
    options.level = 0;
    options.size = 1000;
    CHECK_THROWS_AS(mesher.estimate(parsed(kBall), options), Error);
}

}  // namespace mortise::test
