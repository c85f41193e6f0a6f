// minkowski() of solids that are not convex, against sums cell by cell.
#include <doctest/doctest.h>

#include <array>
#include <random>

#include "tests/model/built_hull.hpp"
#include "tests/model/membership.hpp"

using namespace mortise;
using test::at;
using test::build;
using test::Built;

TEST_CASE("minkowski: differences of solids with flat faces") {
    const auto text = [](const std::array<double, 6>& b) {
        return at(b[0], b[1], b[2],
                  "cube([" + std::to_string(b[3] - b[0]) + ", " + std::to_string(b[4] - b[1]) + ", " +
                      std::to_string(b[5] - b[2]) + "]);");
    };
    std::mt19937 random(5);
    std::uniform_int_distribution<int> whole(0, 7);
    std::uniform_real_distribution<double> coordinate(-1, 10);
    for (int round = 0; round < 12; ++round) {
        std::vector<std::array<double, 6>> boxes = {{0, 0, 0, 7, 7, 7}};
        while (boxes.size() < 4) {
            std::array<double, 6> b{};
            for (std::size_t k = 0; k < 3; ++k) {
                b[k] = whole(random);
                b[k + 3] = whole(random);
                if (b[k] > b[k + 3]) std::swap(b[k], b[k + 3]);
            }
            if (b[0] < b[3] && b[1] < b[4] && b[2] < b[5]) boxes.push_back(b);
        }
        std::string solid = "difference() { ";
        for (const auto& b : boxes) solid += text(b);
        const Built sum = build(solid + " } cube([1, 2, 0.5]);", true);
        CAPTURE(solid);
        CHECK(sum.error.empty());
        int wrong = 0;
        int inside = 0;
        for (int i = 0; i < 300; ++i) {
            const Vec3 p = {coordinate(random), coordinate(random), coordinate(random)};
            // Whether p less the small cube meets a unit cell that is left.
            bool expected = false;
            for (int cell = 0; cell < 343; ++cell) {
                const Vec3 c = {static_cast<double>(cell % 7), static_cast<double>(cell / 7 % 7),
                                static_cast<double>(cell / 49)};
                const Vec3 size = {1, 2, 0.5};
                bool meets = true;
                for (std::size_t k = 0; k < 3; ++k) meets = meets && p[k] - size[k] < c[k] + 1 && p[k] > c[k];
                for (std::size_t b = 1; b < boxes.size() && meets; ++b) {
                    bool taken = true;
                    for (std::size_t k = 0; k < 3; ++k)
                        taken = taken && boxes[b][k] <= c[k] && c[k] + 1 <= boxes[b][k + 3];
                    meets = !taken;
                }
                expected = expected || meets;
            }
            wrong += test::holds(sum.model, sum.node, p) != expected ? 1 : 0;
            inside += expected ? 1 : 0;
        }
        CHECK(wrong == 0);
        CHECK(inside > 20);
    }
    // A frame with a round foot: rounded outside, sharp inside.
    const Built frame =
        build("difference() { cube([10, 10, 4]); " + at(2, 2, -1, "cube([6, 6, 9]);") + " } cylinder(r = 1);",
              true);
    const auto holds = [&](const Vec3& p) { return test::holds(frame.model, frame.node, p); };
    CHECK(holds({-0.69, -0.69, 2}));
    CHECK_FALSE(holds({-0.73, -0.73, 2}));
    CHECK(holds({2.99, 2.99, 2}));
    CHECK(holds({2.99, 5, 4.9}));
    CHECK_FALSE(holds({3.01, 3.01, 2}));
    CHECK_FALSE(holds({5, 5, 2}));
    CHECK_FALSE(holds({-0.5, 5, 5.1}));
}
