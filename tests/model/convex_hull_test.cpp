// Vertices of half-spaces and hulls of points.
#include "host/model/solids/convex_hull.hpp"

#include <doctest/doctest.h>

#include "mortise/model.hpp"

using namespace mortise;

TEST_CASE("vertices of half-spaces, far from the origin and of very different sizes") {
    using model_reader::Boundedness;
    for (const double scale : {1e-3, 1.0, 1e4}) {
        for (const double shift : {0.0, 100.0}) {
            const Vec3 low = {shift * scale, -shift * scale, 0};
            const Vec3 high = {(shift + 2) * scale, (-shift + 1) * scale, 0.01 * scale};
            std::vector<Vec3> vertices;
            REQUIRE(model_reader::vertices_of(box(low, high).planes, vertices) == Boundedness::kBounded);
            CHECK(vertices.size() == 8);
            const auto hull = model_reader::convex_hull(vertices);
            REQUIRE(hull);
            CHECK(hull->faces.size() == 6);
            CHECK(model_reader::volume_of(*hull) ==
                  doctest::Approx(0.02 * scale * scale * scale).epsilon(1e-6));
        }
    }
    std::vector<Vec3> vertices;
    std::vector<Plane> planes = box({0, 0, 0}, {1, 1, 1}).planes;
    planes.push_back({{1, 1, 1}, -0.1, {}});
    CHECK(model_reader::vertices_of(planes, vertices) == Boundedness::kEmpty);
    planes.pop_back();
    planes.pop_back();
    CHECK(model_reader::vertices_of(planes, vertices) == Boundedness::kUnbounded);
    CHECK(model_reader::vertices_of({{{1, 0, 0}, 1, {}}}, vertices) == Boundedness::kUnbounded);
    CHECK_FALSE(model_reader::convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0.5, 0.2, 1e-9}}));
}
