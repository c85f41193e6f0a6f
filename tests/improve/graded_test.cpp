// Improvement on graded trees: the same as on uniform ones where a tree is uniform, whatever its level is
// said to be; and good elements at every size.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "host/improve/improve.hpp"
#include "mortise/check.hpp"
#include "tests/improve/graded_mesh.hpp"
#include "tests/improve/raw_mesh.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_models.hpp"
#include "tests/mesher/random_source.hpp"
#include "tests/tape/bound_models.hpp"

namespace mortise::test {
namespace {

Mesh improved(const RawMesh& raw, int level, const LeafGrid* leaves, improve::Counters* counters = nullptr) {
    improve::Options options;
    options.level = level;
    options.leaves = leaves;
    return improve::improve(raw.mesh, raw.model, options, counters);
}

/// The cells that hold elements, as leaves of a tree that is said to be `deeper` levels deeper; of every
/// hundred `missing` are left out.
LeafGrid cells_of(const RawMesh& raw, int deeper, int missing) {
    LeafGrid grid;
    grid.level = raw.level + deeper;
    const double cell = std::ldexp(raw.model.side, -raw.level);
    for (int t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = raw.mesh.elements[static_cast<std::size_t>(t)];
        const auto count = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(t)]);
        for (std::size_t i = 0; i < block.size(); ++i) {
            std::uint32_t at[3];
            for (std::size_t j = 0; j < 3; ++j) {
                double sum = 0;
                for (std::size_t k = 0; k < count; ++k)
                    sum += raw.mesh.points[3 * block.nodes[i * count + k] + j];
                at[j] = static_cast<std::uint32_t>((sum / static_cast<double>(count) - raw.model.origin[j]) /
                                                   cell);
            }
            grid.code.push_back(morton_encode(at[0], at[1], at[2]) << (3 * deeper));
        }
    }
    std::sort(grid.code.begin(), grid.code.end());
    grid.code.erase(std::unique(grid.code.begin(), grid.code.end()), grid.code.end());
    RandomSource random(7);
    std::vector<std::uint64_t> kept;
    for (const std::uint64_t code : grid.code) {
        if (random.integer(0, 99) >= missing) kept.push_back(code);
    }
    grid.code = kept;
    grid.leaf_level.assign(kept.size(), static_cast<std::uint8_t>(raw.level));
    return grid;
}

Model drilled() {
    const Model block = one_solid([](Model& m) {
        return subtract(m, {add_box(m, {-1, -1, -1}, {1, 1, 1}), add_cylinder(m, 0.5, -2, 2)});
    });
    return transformed(block, rotation({1, 2, 3}, 0.7));
}

Model cone() {
    return transformed(one_solid([](Model& m) { return add_frustum(m, 0.8, 0, 0, 1.5); }),
                       rotation({1, 2, 3}, 0.7));
}

std::string defects_of(const CheckReport& check) {
    return check.defects.empty() ? "" : check.defects[0].what + ", " + check.defects[0].first;
}

/// Some groups of eight cells, and of 64, as one leaf.
LeafGrid merged(const LeafGrid& grid) {
    LeafGrid result;
    result.level = grid.level;
    for (std::size_t i = 0; i < grid.size(); ++i) {
        const std::uint64_t far = grid.code[i] >> 6, near = grid.code[i] >> 3;
        const int size_class = RandomSource(far).chance(0.3) ? 2 : RandomSource(near).chance(0.4) ? 1 : 0;
        const GridCube leaf = cube_of(grid.code[i], size_class);
        if (!result.code.empty() && result.code.back() == leaf.code) continue;
        result.code.push_back(leaf.code);
        result.leaf_level.push_back(static_cast<std::uint8_t>(grid.level - size_class));
    }
    return result;
}

}  // namespace

TEST_CASE("whatever the leaves are said to be: valid, not worse, the same for any threads") {
    for (const std::uint64_t seed : {3, 11, 45, 60, 105}) {
        CAPTURE(seed);
        const RawMesh raw = raw_mesh(make_random_model(seed).model, 5);
        const CheckReport before = check_mesh(raw.mesh);
        const LeafGrid grid = merged(cells_of(raw, 0, 10));
        improve::Options options;
        options.level = 5;
        options.leaves = &grid;
        options.threads = 1;
        improve::Counters counters;
        const Mesh mesh = improve::improve(raw.mesh, raw.model, options, &counters);
        const CheckReport after = check_mesh(mesh);
        CHECK(defects_of(after) == "");
        CHECK(worst_jacobian(after) >= 0.999 * std::min(0.2, worst_jacobian(before)));
        CHECK(counters.block.moved > 0);
        options.threads = 4;
        CHECK(is_same_mesh(improve::improve(raw.mesh, raw.model, options, nullptr), mesh));
    }
}

TEST_CASE("a uniform tree given leaf by leaf: the same mesh; the same if it is said to be deeper") {
    // The zone of the last one grows, so that a uniform tree is searched once more, farther.
    std::vector<Model> models = {drilled(), cone()};
    for (const std::uint64_t seed : {3, 11, 45}) models.push_back(make_random_model(seed).model);
    models.push_back(read_model(MORTISE_SOURCE_DIR "/assets/models/bracket.csg"));
    for (std::size_t i = 0; i < models.size(); ++i) {
        CAPTURE(i);
        const RawMesh raw = raw_mesh(models[i], 5);
        improve::Counters counters;
        const Mesh expected = improved(raw, 5, nullptr, &counters);
        CHECK(counters.block.moved > 0);
        for (const int deeper : {0, 1, 12}) {
            for (const int missing : {0, 25}) {
                CAPTURE(deeper);
                CAPTURE(missing);
                const LeafGrid grid = cells_of(raw, deeper, missing);
                improve::Counters same;
                CHECK(is_same_mesh(improved(raw, 5 + deeper, &grid, &same), expected));
                CHECK(same.zone_elements == counters.zone_elements);
                CHECK(same.block.moved == counters.block.moved);
            }
        }
    }
}

namespace {

/// Sizes 1, 2 and 4, the finest in the middle of an edge of the box.
GradedMesh edge_mesh() {
    return graded_mesh(6, [](const Vec3& low, double edge) {
        const double reach = edge > 2 ? 16 : 8;
        return low[0] < reach && low[1] < reach && std::fabs(low[2] - 28) < 1.5 * reach;
    });
}

/// Moves inner nodes, chosen at random, by a part of the smallest leaf around them; or only nodes between
/// leaves of two sizes.
void disturb(GradedMesh& graded, double by, double chance, bool between) {
    const double side = std::ldexp(1.0, graded.leaves.level);
    RandomSource random(5);
    for (std::size_t i = 0; i < graded.mesh.node_count(); ++i) {
        double* p = graded.mesh.points.data() + 3 * i;
        if (std::min({p[0], p[1], p[2]}) <= 4 || std::max({p[0], p[1], p[2]}) >= side - 4) continue;
        double size = 4, largest = 0;
        for_touching_leaves(graded.leaves, cube_of(finest_cell(graded.leaves, {p[0], p[1], p[2]}), 0),
                            [&](std::size_t leaf) {
                                const double edge = std::ldexp(1.0, graded.leaves.size_class(leaf));
                                size = std::min(size, edge);
                                largest = std::max(largest, edge);
                            });
        if (!random.chance(chance) || (between && size == largest)) continue;
        for (std::size_t j = 0; j < 3; ++j) {
            p[j] += std::rint(size * by * random.uniform(-1, 1) * 0x1p20) * 0x1p-20;
        }
    }
}

Mesh improved(const GradedMesh& graded, int threads, improve::Counters* counters = nullptr) {
    improve::Options options;
    options.level = graded.leaves.level;
    options.threads = threads;
    options.leaves = &graded.leaves;
    return improve::improve(graded.mesh, graded.model, options, counters);
}

}  // namespace

TEST_CASE("a mesh of three sizes is left alone where it is good") {
    const GradedMesh graded = edge_mesh();
    CHECK(defects_of(check_mesh(graded.mesh)) == "");
    CHECK(graded.mesh.block(ElementType::kTetrahedron).size() > 0);
    improve::Counters counters;
    CHECK(is_same_mesh(improved(graded, 2, &counters), graded.mesh));
    CHECK(counters.zone_elements == 0);
}

TEST_CASE("a disturbed mesh of three sizes becomes good at all of them") {
    GradedMesh graded = edge_mesh();
    SUBCASE("anywhere") { disturb(graded, 0.3, 0.1, false); }
    SUBCASE("where sizes meet") { disturb(graded, 0.3, 0.4, true); }
    const CheckReport before = check_mesh(graded.mesh);
    REQUIRE(defects_of(before) == "");
    CHECK(before.min_dihedral < 15);
    improve::Counters counters;
    const Mesh mesh = improved(graded, 1, &counters);
    const CheckReport after = check_mesh(mesh);
    CHECK(defects_of(after) == "");
    CHECK(after.volume == doctest::Approx(before.volume));
    CHECK(after.min_dihedral >= 18);
    CHECK(after.max_dihedral <= 155);
    CHECK(worst_jacobian(after) >= 0.19);
    CHECK(counters.block.given_up == 0);
    CHECK(is_same_mesh(improved(graded, 4), mesh));

    // The same tree, said to be deeper.
    GradedMesh deeper = graded;
    deeper.leaves.level += 2;
    for (std::uint64_t& code : deeper.leaves.code) code <<= 6;
    CHECK(is_same_mesh(improved(deeper, 2), mesh));
}

}  // namespace mortise::test
