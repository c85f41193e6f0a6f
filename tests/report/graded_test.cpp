// The report's own leaves follow those of a graded tree: small features are seen, and the rest costs little.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>

#include "host/report/corners.hpp"
#include "host/report/distance.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/tape/bound_models.hpp"

using namespace mortise;
using namespace mortise::test;

namespace {

constexpr int kLevel = 13;
constexpr double kSmall = 0.004;

/// A box of edge 1 with a small box cut out.
Model box_with_a_pore() {
    return transformed(one_solid([](Model& m) {
                           return subtract(
                               m, {add_box(m, {0, 0, 0}, {1, 1, 1}),
                                   add_box(m, {0.6, 0.5, 0.4}, {0.6 + kSmall, 0.5 + kSmall, 0.4 + kSmall})});
                       }),
                       rotation({1, 2, 3}, 0.3));
}

/// Leaves of level 5 at the solid's boundary, of kLevel where no more than small(centre) tells; coarse
/// inside.
LeafGrid leaves_of(const tape::BoundModel& model, const std::function<bool(const double*)>& is_small) {
    LeafGrid grid;
    grid.level = kLevel;
    const std::function<void(const tape::Cell&, std::uint64_t, int)> descend =
        [&](const tape::Cell& cell, std::uint64_t number, int depth) {
            const std::int32_t region = tape::classify_cell(model, model.tape, cell, nullptr);
            if (region == 0) return;
            const bool split = depth < 3 || (region == kUnknown && depth < 5) ||
                               (region == kUnknown && depth < kLevel && is_small(cell.centre));
            if (!split) {
                grid.code.push_back(number << (3 * (kLevel - depth)));
                grid.leaf_level.push_back(static_cast<std::uint8_t>(depth));
                return;
            }
            for (unsigned child = 0; child < 8; ++child) {
                tape::Cell part{{0, 0, 0}, 0.5 * cell.half};
                for (unsigned j = 0; j < 3; ++j) {
                    part.centre[j] = cell.centre[j] + ((child >> j & 1u) != 0 ? part.half : -part.half);
                }
                descend(part, number << 3 | child, depth + 1);
            }
        };
    descend({{0.5, 0.5, 0.5}, 0.5}, 0, 0);
    return grid;
}

}  // namespace

TEST_CASE("a small pore in a large box: leaves of both sizes, few of them, the area from both") {
    const tape::BoundModel model = bind_model(box_with_a_pore(), 5);
    Vec3 pore{};
    const Vec3 place =
        apply(rotation({1, 2, 3}, 0.3), {0.6 + kSmall / 2, 0.5 + kSmall / 2, 0.4 + kSmall / 2});
    for (std::size_t j = 0; j < 3; ++j) pore[j] = (place[j] - model.origin[j]) / model.side;
    const LeafGrid grid = leaves_of(model, [&](const double* x) {
        return std::hypot(x[0] - pore[0], x[1] - pore[1], x[2] - pore[2]) < 0.05;
    });
    const report::Depth depth = report::Depth::of(kLevel, &grid);
    CHECK(depth.deepest == kLevel);
    struct Found {
        std::size_t leaves = 0, strangers = 0;
        std::vector<report::BoundaryPoint> points;
        std::vector<report::Corner> corners;
    };
    Found all;
    for (Found& part :
         report::visit_leaves<Found>(model, depth, 2, [&](const report::Leaf&leaf, Found&found) {
             ++found.leaves;
             const double edge = std::ldexp(2 * leaf.cell.half, kLevel);
             const std::array<double, 3> centre = {std::ldexp(leaf.cell.centre[0], kLevel),
                                                   std::ldexp(leaf.cell.centre[1], kLevel),
                                                   std::ldexp(leaf.cell.centre[2], kLevel)};
             const std::size_t own = find_leaf(grid, finest_cell(grid, centre));
             if (own == kNoLeaf || edge_of(grid.size_class(own)) != edge) ++found.strangers;
             report::sample_boundary(model, leaf, depth, found.points);
             report::find_corners(model, leaf, found.corners);
         })) {
        all.leaves += part.leaves;
        all.strangers += part.strangers;
        all.points.insert(all.points.end(), part.points.begin(), part.points.end());
        all.corners.insert(all.corners.end(), part.corners.begin(), part.corners.end());
    }
    CHECK(all.strangers == 0);
    CHECK(all.leaves < 40000);
    report::merge_corners(all.corners);
    CHECK(all.corners.size() == 16);
    // A line along an axis meets a face of unit normal n once in 1 / |n| leaves' cross sections: three axes
    // count |n_x| + |n_y| + |n_z| times the area.
    const Affine turn = rotation({1, 2, 3}, 0.3);
    double seen = 0;
    for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}}) {
        const Vec3 n = apply(turn, axis);
        seen += 2 * (std::fabs(n[0]) + std::fabs(n[1]) + std::fabs(n[2]));
    }
    double outer = 0, inner = 0;
    for (const report::BoundaryPoint& p : all.points) {
        const double area = p.weight * std::pow(std::ldexp(model.side, -kLevel), 2);
        const report::Vector d = p.local - report::Vector{pore[0], pore[1], pore[2]};
        (length(d) < 0.03 ? inner : outer) += area;
    }
    CHECK(outer == doctest::Approx(seen).epsilon(0.05));
    CHECK(inner == doctest::Approx(seen * kSmall * kSmall).epsilon(0.05));
}

TEST_CASE("trees with too many leaves are cut off") {
    LeafGrid grid;
    grid.level = 9;
    for (std::uint64_t i = 0; i < (std::uint64_t{1} << 22); ++i) {
        grid.code.push_back(i);
        grid.leaf_level.push_back(9);
    }
    CHECK(report::Depth::of(9, &grid).deepest == 8);
    grid.code.resize(std::size_t{1} << 21);
    grid.leaf_level.resize(grid.code.size());
    CHECK(report::Depth::of(9, &grid).deepest == 9);
    CHECK(report::Depth::of(12, nullptr).deepest == 8);
    CHECK(report::Depth::of(6, nullptr).deepest == 6);
}
