// How far vertices move onto surfaces.
#include <doctest/doctest.h>

#include <array>
#include <cmath>

#include "kernels/shared/lattice.h"
#include "kernels/shared/snap.h"

namespace {

/// A plane with this unit normal, `distance` cells from the origin.
Surface plane(const std::array<double, 3>& normal, double distance, double cell) {
    Surface s{};
    s.kind = kSurfacePlane;
    for (std::size_t j = 0; j < 3; ++j) s.map[j] = normal[j];
    s.map[3] = -distance * cell;
    return s;
}

}  // namespace

TEST_CASE(
    "vertices move onto planes along the grid as far as edges would be short, and less far onto others") {
    const double cell = 1.0 / 64;
    const double origin[3] = {0, 0, 0};
    const std::array<double, 3> along_grid[] = {{1, 0, 0}, {0, -1, 0}, {6e-17, 0, 1}};
    const std::array<double, 3> tilted[] = {{0.6, 0.8, 0}, {1, 1e-6, 0}, {1.0 / 3, 2.0 / 3, -2.0 / 3}};
    for (const double distance : {-0.36, -0.351, -0.35, -0.336, -0.334, 0.1, 0.334, 0.34, 0.35, 0.351}) {
        CAPTURE(distance);
        i32 moved[3];
        for (const auto& normal : along_grid) {
            const Surface s = plane(normal, distance, cell);
            const bool moves = snap_displacement(&s, nullptr, origin, cell, moved) != 0;
            CHECK(moves == (std::fabs(distance) < 0.3505));
            for (std::size_t j = 0; j < 3 && moves; ++j)
                CHECK(std::fabs(moved[j] - distance * normal[j] * kCellUnits) <= 0.5);
        }
        for (const auto& normal : tilted) {
            const Surface s = plane(normal, distance, cell);
            const bool moves = snap_displacement(&s, nullptr, origin, cell, moved) != 0;
            CHECK(moves == (std::fabs(distance) < 0.335));
        }
    }
}
