// Random CSG trees on graded trees: surfaces whose cell size changes along them, coarse interiors.
//
// MORTISE_RANDOM_MODELS=N tries N models (default 28), MORTISE_RANDOM_SEED=S starts at seed S (default 1).
#include <doctest/doctest.h>

#include <cmath>

#include "tests/mesher/against_model.hpp"
#include "tests/mesher/random_models.hpp"
#include "tests/mesher/random_source.hpp"

namespace mortise::test {
namespace {

constexpr int kLevel = 4;

/// Sizes around points near the solid, and how coarse the interior is: options of every kind over the seeds.
MeshOptions random_sizes(std::uint64_t seed, const Box3& root, double cell) {
    RandomSource random(seed);
    MeshOptions options;
    options.level = kLevel;
    options.interior_coarsening = random.integer(0, 2);
    options.refine = random.integer(0, 2);
    const int count = random.integer(1, 3);
    for (int i = 0; i < count; ++i) {
        SizeSource source;
        for (std::size_t j = 0; j < 3; ++j) source.at[j] = random.uniform(root.min[j], root.max[j]);
        source.size = cell * std::pow(0.5, random.uniform(0.5, 2.5));
        source.grading = random.uniform(0.1, 0.6);
        options.sizes.push_back(source);
    }
    return options;
}

/// The root box and cell size that a model gets at kLevel; nothing if it is empty.
std::optional<MeshReport> plain_run(const Model& model) {
    MeshOptions options;
    options.level = kLevel;
    const std::optional<Meshed> meshed = mesh_unless_empty(model, options);
    if (!meshed) return std::nullopt;
    return meshed->report;
}

/// Checks the meshes of a random model with sizes of its own; returns how many have cells of several sizes.
std::uint64_t check_graded(std::uint64_t seed) {
    const RandomModel random = make_random_model(seed);
    CAPTURE(seed);
    CAPTURE(random.style);
    const std::optional<MeshReport> plain = plain_run(random.model);
    if (!plain) return 0;
    std::uint64_t graded = 0;
    MeshOptions options = random_sizes(seed, plain->root, plain->cell_size);
    for (const bool improve : {false, true}) {
        options.improve = improve;
        const std::optional<Meshed> meshed = mesh_unless_empty(random.model, options);
        REQUIRE(meshed);
        CAPTURE(improve);
        CHECK(meshed->defects == "");
        compare_with_model(random.model, *meshed);
        if (meshed->report.finest_level > kLevel) ++graded;
    }
    if (seed % 4 != 0) return graded;
    options.improve = false;
    options.templates = false;
    const std::optional<Meshed> certified = mesh_unless_empty(random.model, options);
    REQUIRE(certified);
    CHECK(certified->defects == "");
    compare_with_model(random.model, *certified);
    return graded;
}

}  // namespace

TEST_CASE("random models on graded trees give valid meshes that fill them") {
    const std::uint64_t first = environment_number("MORTISE_RANDOM_SEED", 1);
    const std::uint64_t count = environment_number("MORTISE_RANDOM_MODELS", 20);
    std::uint64_t graded = 0;
    for (std::uint64_t seed = first; seed < first + count; ++seed) graded += check_graded(seed);
    if (count >= 10) CHECK(graded >= count / 2);
}

/// A leaf inside a plate of 1.5 cells, with corners that move onto one side of it and a face on the other.
TEST_CASE("random models on graded trees that were not valid stay mended") { check_graded(99131); }

TEST_CASE("a graded mesh does not depend on threads, work-group size or pieces") {
    const std::uint64_t first = environment_number("MORTISE_RANDOM_SEED", 1);
    for (std::uint64_t seed = first; seed < first + 2; ++seed) {
        CAPTURE(seed);
        const Model model = make_random_model(seed).model;
        const std::optional<MeshReport> plain = plain_run(model);
        if (!plain) continue;
        MeshOptions options = random_sizes(seed, plain->root, plain->cell_size);
        const Mesh reference = generate(model, options);
        struct Way {
            int threads, work_group_size, pieces;
        };
        for (const Way& way : {Way{1, 0, 2}, Way{4, 16, 7}, Way{0, 0, 40}}) {
            options.threads = way.threads;
            options.work_group_size = way.work_group_size;
            options.pieces = way.pieces;
            CHECK(is_same_mesh(generate(model, options), reference));
        }
    }
}

}  // namespace mortise::test
