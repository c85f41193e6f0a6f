// Many elements around a node at once against one after the other: the same bits.
#include "host/improve/star_views.hpp"

#include <doctest/doctest.h>

#include <algorithm>

#include "tests/mesher/random_source.hpp"

namespace mortise::improve {
namespace {

struct Face {
    std::array<std::uint32_t, 3> nodes;
    std::array<Point, 3> corners;
};

Point random_point(test::RandomSource& random, double reach) {
    return {random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)};
}

/// Faces around the origin, most seen from the side on which their element is positive.
std::vector<Face> random_faces(test::RandomSource& random, std::size_t count) {
    std::vector<Face> faces;
    for (std::size_t i = 0; i < count; ++i) {
        Face f;
        for (std::size_t k = 0; k < 3; ++k) {
            f.nodes[k] = static_cast<std::uint32_t>(random.integer(0, 30));
            f.corners[k] = random_point(random, 1);
        }
        const double volume = dot(cross(f.corners[0], f.corners[1]), f.corners[2]);
        if ((volume < 0) != random.chance(0.05)) std::swap(f.corners[0], f.corners[1]);
        faces.push_back(f);
    }
    return faces;
}

double quality_of(const Face& f, const Point& p) {
    return tetrahedron_quality(p, f.corners[0], f.corners[1], f.corners[2]);
}

bool has(const Face& f, std::uint32_t node) {
    return std::find(f.nodes.begin(), f.nodes.end(), node) != f.nodes.end();
}

TEST_CASE("the worst element around a node is that of the single elements") {
    test::RandomSource random(3);
    StarViews views;
    int positive = 0;
    for (int star = 0; star < 300; ++star) {
        const std::vector<Face> faces = random_faces(random, static_cast<std::size_t>(random.integer(1, 40)));
        views.clear();
        for (const Face& f : faces) views.add(f.nodes, f.corners[0], f.corners[1], f.corners[2]);
        views.finish();
        REQUIRE(views.size() == faces.size());
        for (int place = 0; place < 20; ++place) {
            const Point p = random_point(random, 0.05);
            const auto except =
                random.chance(0.5) ? static_cast<std::uint32_t>(random.integer(0, 30)) : StarViews::kNobody;
            double worst = StarViews::kNoElement;
            for (const Face& f : faces) {
                if (!has(f, except)) worst = std::min(worst, quality_of(f, p));
            }
            positive += worst > 0 ? 1 : 0;
            // Below what was asked any value below will do.
            CHECK(views.worst_at(p, -2, kVolumeRounding, except) == worst);
            const double enough = random.uniform(0, 0.3);
            const double found = views.worst_at(p, enough, kVolumeRounding, except);
            CHECK((found > enough) == (worst > enough));
            if (!(found > enough)) continue;
            CHECK(found == worst);
            for (std::size_t i = 0; i < faces.size(); ++i) {
                if (!has(faces[i], except)) CHECK(views.quality(i) == quality_of(faces[i], p));
            }
        }
    }
    CHECK(positive > 500);
}

TEST_CASE("flat and coinciding elements are inverted, never not-a-number") {
    StarViews views;
    const Point a = {0, 0, 0}, b = {1, 0, 0}, c = {0, 1, 0};
    views.add({0, 1, 2}, a, b, c);
    views.add({0, 0, 0}, a, a, a);
    views.finish();
    CHECK(views.worst_at({0.3, 0.3, 0}, -2, kVolumeRounding) == kInvertedQuality);
    CHECK(views.worst_at({0, 0, 0}, -2, kVolumeRounding) == kInvertedQuality);
    CHECK(views.quality(0) == kInvertedQuality);
    CHECK(views.quality(1) == kInvertedQuality);
}

TEST_CASE("a star without elements refuses no place") {
    StarViews views;
    views.finish();
    CHECK(views.worst_at({0, 0, 0}, 0.5, kVolumeRounding) == StarViews::kNoElement);
}

}  // namespace
}  // namespace mortise::improve
