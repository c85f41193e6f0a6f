// Loose pieces of the certificate, on a zone made by hand: a unit tetrahedron and small ones around it.
#include <doctest/doctest.h>

#include <algorithm>

#include "host/improve/crumbs.hpp"

using namespace mortise::improve;

namespace {

constexpr FaceTag kOuter = (0 + 1) << 3 | kTagInside;

/// A zone of uniform cells whose tetrahedra are given by their nodes; faces of one of them are outer facets.
Zone make_zone(std::vector<Point> points, const std::vector<std::array<std::uint32_t, 4>>& tetrahedra) {
    Zone zone;
    for (const Point& p : points) zone.add_node(p, 0, {0});
    for (const auto& node : tetrahedra) {
        Tetrahedron t;
        t.node = node;
        t.region = 1;
        for (std::size_t f = 0; f < 4; ++f) {
            bool shared = false;
            for (const auto& other : tetrahedra) {
                int common = 0;
                for (const std::uint8_t k : kOpposite[f]) {
                    common += std::count(other.begin(), other.end(), node[k]) > 0 ? 1 : 0;
                }
                shared = shared || (other != node && common == 3);
            }
            t.tag[f] = shared ? 0 : kOuter;
        }
        zone.tetrahedra.push_back(t);
    }
    return zone;
}

constexpr double kSmall = 0.05;  // volume 2e-5

std::vector<Point> large_and_small(const Point& at, double size = kSmall) {
    std::vector<Point> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (const Point& corner : {Point{0, 0, 0}, Point{1, 0, 0}, Point{0, 1, 0}, Point{0, 0, 1}}) {
        points.push_back(at + size * corner);
    }
    return points;
}

}  // namespace

TEST_CASE("crumbs: loose pieces go, whatever hangs on a face stays") {
    SUBCASE("loose") {
        Zone zone = make_zone(large_and_small({2, 2, 2}), {{0, 1, 2, 3}, {4, 5, 6, 7}});
        const Crumbs crumbs = remove_crumbs(zone, kScrapVolume, 2);
        CHECK(crumbs.count == 1);
        REQUIRE(crumbs.first);
        CHECK(*crumbs.first == Point{2, 2, 2});
        REQUIRE(zone.tetrahedra.size() == 1);
        CHECK(zone.tetrahedra[0].node[3] == 3);
    }
    SUBCASE("on a hinge") {
        Zone zone = make_zone(large_and_small({1, 0, 0}), {{0, 1, 2, 3}, {1, 5, 6, 7}});
        CHECK(remove_crumbs(zone, kScrapVolume, 1).count == 1);
        CHECK(zone.tetrahedra.size() == 1);
    }
    SUBCASE("two that share a face are one") {
        std::vector<Point> points = large_and_small({2, 2, 2});
        points.push_back({2.03, 2.03, 2.03});
        Zone zone = make_zone(points, {{4, 5, 6, 7}, {0, 1, 2, 3}, {5, 6, 7, 8}});
        CHECK(remove_crumbs(zone, kScrapVolume, 1).count == 1);
        CHECK(zone.tetrahedra.size() == 1);
    }
    SUBCASE("on a face of the large one") {
        std::vector<Point> points = large_and_small({2, 2, 2});
        points.push_back({0.3, 0.3, -1e-5});
        Zone zone = make_zone(points, {{0, 1, 2, 3}, {0, 2, 1, 8}});
        CHECK(remove_crumbs(zone, kScrapVolume, 1).count == 0);
        CHECK(zone.tetrahedra.size() == 2);
    }
    SUBCASE("on something outside the zone: its face is no facet") {
        Zone zone = make_zone(large_and_small({2, 2, 2}), {{0, 1, 2, 3}, {4, 5, 6, 7}});
        zone.tetrahedra[1].tag[2] = 0;
        CHECK(remove_crumbs(zone, kScrapVolume, 1).count == 0);
    }
    SUBCASE("inside another region") {
        Zone zone = make_zone(large_and_small({2, 2, 2}), {{0, 1, 2, 3}, {4, 5, 6, 7}});
        for (FaceTag& tag : zone.tetrahedra[1].tag) tag |= kTagInterface;
        CHECK(remove_crumbs(zone, kScrapVolume, 1).count == 0);
    }
    SUBCASE("held, or with a tip") {
        Zone zone = make_zone(large_and_small({2, 2, 2}), {{0, 1, 2, 3}, {4, 5, 6, 7}});
        SUBCASE("held") { zone.tetrahedra[1].tag[0] |= kTagBorder; }
        SUBCASE("tip") { zone.tips.push_back({5, {2, 2, 2}}); }
        CHECK(remove_crumbs(zone, kScrapVolume, 1).count == 0);
    }
    SUBCASE("as large as what the probe finds") {
        std::vector<Point> points = large_and_small({2, 2, 2});
        points[5][0] += 3 * kSmall;
        Zone zone = make_zone(points, {{0, 1, 2, 3}, {4, 5, 6, 7}});
        CHECK(remove_crumbs(zone, kScrapVolume, 1).count == 0);
    }
}

TEST_CASE("scraps: what hangs by an edge or a node goes, bodies stay") {
    const double size = 0.9;  // volume 0.12, or 0.135 on an edge
    SUBCASE("on a node") {
        Zone zone = make_zone(large_and_small({1, 0, 0}, size), {{0, 1, 2, 3}, {1, 5, 6, 7}});
        const Crumbs crumbs = remove_crumbs(zone, kScrapVolume, 1);
        CHECK(crumbs.count == 1);
        CHECK(crumbs.largest == doctest::Approx(size * size * size / 6));
        CHECK(zone.tetrahedra.size() == 1);
    }
    const auto on_edge = [](double height) {
        return make_zone({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -height, 0}, {0, 0, -height}},
                         {{0, 1, 2, 3}, {0, 1, 4, 5}});
    };
    SUBCASE("on an edge") {
        Zone zone = on_edge(size);
        CHECK(remove_crumbs(zone, kScrapVolume, 1).count == 1);
        CHECK(zone.tetrahedra.size() == 1);
    }
    SUBCASE("on an edge of what is outside the zone") {
        Zone zone = on_edge(size);
        zone.tetrahedra.erase(zone.tetrahedra.begin());
        zone.frozen[1] = 1;
        CHECK(remove_crumbs(zone, kScrapVolume, 1).count == 1);
    }
    SUBCASE("as large as a body") {
        Zone zone = on_edge(1);
        CHECK(remove_crumbs(zone, kScrapVolume, 1).count == 0);
    }
    SUBCASE("apart") {
        Zone zone = make_zone(large_and_small({2, 2, 2}, size), {{0, 1, 2, 3}, {4, 5, 6, 7}});
        CHECK(remove_crumbs(zone, kScrapVolume, 1).count == 0);
    }
    SUBCASE("one that hangs on one that hangs on a body") {
        std::vector<Point> points = large_and_small({1, 0, 0}, size);
        for (const Point& corner : {Point{1, 0, 0}, Point{0, 1, 0}, Point{0, 0, 1}})
            points.push_back(points[5] + size * corner);
        Zone zone = make_zone(points, {{0, 1, 2, 3}, {5, 8, 9, 10}, {1, 5, 6, 7}});
        CHECK(remove_crumbs(zone, kScrapVolume, 1).count == 2);
        CHECK(zone.tetrahedra.size() == 1);
    }
    SUBCASE("scraps that are not asked for") {
        Zone zone = on_edge(size);
        CHECK(remove_crumbs(zone, kCrumbVolume, 1).count == 0);
    }
    SUBCASE("two that hang on each other only") {
        Zone zone =
            make_zone({{0, 0, 0}, {1, 0, 0}, {0, size, 0}, {0, 0, size}, {0, -size, 0}, {0, 0, -size}},
                      {{0, 1, 2, 3}, {0, 1, 4, 5}});
        CHECK(remove_crumbs(zone, kScrapVolume, 1).count == 0);
    }
}
