// Mesher::recycle: meshes made in the memory of others are the same, and memory is neither wasted nor kept.
#include <doctest/doctest.h>

#include <algorithm>
#include <limits>

#include "mortise/check.hpp"
#include "mortise/mesher.hpp"
#include "tests/mesher/meshed.hpp"

namespace mortise::test {
namespace {

struct Job {
    const char* text;  ///< .csg
    int level;
    bool tetrahedra = false;
};

Model model_of(const Job& job) { return parse_model(job.text, "csg", "job.csg"); }

MeshOptions options_of(const Job& job) {
    MeshOptions options;
    options.level = job.level;
    options.tetrahedra = job.tetrahedra;
    options.threads = 2;
    return options;
}

constexpr const char* kBall = "sphere(r = 1);";
constexpr const char* kDrilled =
    "difference() { cube(size = [3, 2, 1]); multmatrix([[1,0,0,1.1],[0,1,0,0.9],[0,0,1,-1],[0,0,0,1]]) "
    "cylinder(h = 3, r1 = 0.4, r2 = 0.4); }";

/// What a mesh that uses old values would show.
void spoil(Mesh& mesh) {
    std::fill(mesh.points.begin(), mesh.points.end(), std::numeric_limits<double>::quiet_NaN());
    for (ElementBlock& block : mesh.elements) {
        std::fill(block.nodes.begin(), block.nodes.end(), 0xfffffff0u);
        std::fill(block.region.begin(), block.region.end(), std::uint16_t{0xfff0});
        std::fill(block.kind.begin(), block.kind.end(), std::uint8_t{0xf0});
    }
}

}  // namespace

TEST_CASE("meshes in recycled memory are the same, whatever was there before") {
    const Job jobs[] = {{kBall, 5},          {kBall, 5},       {kDrilled, 5},       {kBall, 4},
                        {kBall, 6},          {kBall, 6, true}, {kBall, 6, true},    {kDrilled, 5, true},
                        {kDrilled, 5, true}, {kDrilled, 6},    {kDrilled, 6, true}, {kBall, 3}};
    Mesher mesher;
    MeshReport report;
    for (const Job& job : jobs) {
        CAPTURE(job.text);
        CAPTURE(job.level);
        CAPTURE(job.tetrahedra);
        Mesh mesh = mesher.generate(model_of(job), options_of(job), &report);
        MeshReport expected;
        CHECK(is_same_mesh(mesh, generate_mesh(model_of(job), options_of(job), &expected)));
        CHECK(report.scaled_jacobians == expected.scaled_jacobians);
        CHECK(report.scaled_jacobians == scaled_jacobians(mesh));
        std::fill(report.scaled_jacobians.begin(), report.scaled_jacobians.end(), -7.0f);
        spoil(mesh);
        mesher.recycle(std::move(mesh));
        CHECK(mesh.node_count() == 0);
        CHECK(mesh.element_count() == 0);
    }
}

TEST_CASE("recycled memory serves the next mesh of its size, and no small one") {
    const Job large{kBall, 6}, small{kBall, 4};
    Mesher mesher;
    Mesh first = mesher.generate(model_of(large), options_of(large));
    const double* const points = first.points.data();
    const NodeId* const nodes = first.elements[0].nodes.data();
    mesher.recycle(std::move(first));
    Mesh second = mesher.generate(model_of(large), options_of(large));
    CHECK(second.points.data() == points);
    CHECK(second.elements[0].nodes.data() == nodes);
    mesher.recycle(std::move(second));
    const Mesh third = mesher.generate(model_of(small), options_of(small));
    CHECK(third.points.capacity() < 3 * third.points.size());
    CHECK(third.elements[0].nodes.capacity() < 3 * third.elements[0].nodes.size());
}

TEST_CASE("a mesh is recycled after a run that failed, and by any mesher") {
    const Job job{kDrilled, 4};
    Mesher first, second;
    const Mesh expected = first.generate(model_of(job), options_of(job));
    second.recycle(first.generate(model_of(job), options_of(job)));
    CHECK_THROWS_AS(second.generate(parse_model("", "csg", "empty.csg"), options_of(job)), Error);
    CHECK(is_same_mesh(second.generate(model_of(job), options_of(job)), expected));
    second.recycle(Mesh{});
    CHECK(is_same_mesh(second.generate(model_of(job), options_of(job)), expected));
}

}  // namespace mortise::test
