// Thousands of primitives in one model.
#include <doctest/doctest.h>

#include <cmath>

#include "host/common/constants.hpp"
#include "tests/mesher/meshed.hpp"

namespace mortise::test {
TEST_CASE("a lattice of 3,000 flush pieces of struts is valid and has every opening") {
    constexpr double kRadius = 0.3;
    constexpr int kNodes = 10;  // along each axis
    const Affine turns[3] = {kIdentity, rotation({0, 1, 0}, kPi / 2), rotation({1, 0, 0}, kPi / 2)};
    const Model model = one_solid([&](Model& m) {
        const NodeIndex piece = add_cylinder(m, kRadius, -0.5, 0.5);
        std::vector<NodeIndex> pieces;
        for (const Affine& turn : turns) {
            for (int i = 0; i < kNodes * kNodes * kNodes; ++i) {
                const Affine place = translation(
                    {1.0 * (i % kNodes), 1.0 * (i / kNodes % kNodes), 1.0 * (i / kNodes / kNodes)});
                pieces.push_back(m.add_transform(compose(place, turn), piece));
            }
        }
        return unite(m, pieces);
    });
    MeshOptions options;
    options.level = 5;
    options.improve = false;
    const Meshed result = mesh_and_check(model, options);
    CHECK(result.defects == "");
    // Three cylinders cross at each node: less what two of them share, plus what all three do.
    const double cube = kRadius * kRadius * kRadius;
    const double node = 3 * kPi * kRadius * kRadius - 3 * 16.0 / 3 * cube + 8 * (2 - std::sqrt(2.0)) * cube;
    // A cell is wider than a strut's radius.
    CHECK(result.check.volume == doctest::Approx(kNodes * kNodes * kNodes * node).epsilon(0.08));
    CHECK(result.check.components == 1);
    constexpr int kGraph = kNodes * kNodes * kNodes - 3 * (kNodes - 1) * kNodes * kNodes;
    CHECK(result.check.euler_characteristic == 2 * kGraph);
    CHECK(result.report.missed.empty());
}

/// From apexes in the middles of cells and faces they had 25 and 31.
TEST_CASE("complex cells at creases have few elements before improvement") {
    const auto per_cell = [](const Model& model) {
        MeshOptions options;
        options.level = 5;
        options.improve = false;
        const Meshed result = mesh_and_check(model, options);
        CHECK(result.defects == "");
        std::size_t count = 0;
        for (const auto& block : result.mesh.elements) {
            for (const std::uint8_t kind : block.kind)
                count += kind == static_cast<std::uint8_t>(ElementKind::kCnio) ? 1 : 0;
        }
        return static_cast<double>(count) / static_cast<double>(result.report.cnio_cells);
    };

    CHECK(per_cell(one_solid([&](Model& m) {
              const NodeIndex strut = add_cylinder(m, 0.3, -1, 1);
              return unite(m, {strut, m.add_transform(rotation({0, 1, 0}, kPi / 2), strut),
                               m.add_transform(rotation({1, 0, 0}, kPi / 2), strut)});
          })) < 12);
    CHECK(per_cell(one_solid([&](Model& m) {
              return m.add_transform(rotation({1, 2, 3}, 0.7), add_box(m, {-1, -1, -1}, {1, 1, 1}));
          })) < 15);
}

}  // namespace mortise::test
