// Which cells are near a set, against distances.
#include "host/improve/cell_set.hpp"

#include <doctest/doctest.h>

#include <set>

#include "host/common/parallel_sort.hpp"
#include "host/improve/places.hpp"
#include "tests/mesher/random_source.hpp"

using namespace mortise;
using mortise::test::RandomSource;

TEST_CASE("bricks near a set of cells hold all points within reach of it") {
    RandomSource random(5);
    const std::pair<int, std::int64_t> cases[] = {{2, improve::CellSet::kReach},
                                                  {4, improve::CellSet::kReach},
                                                  {4, improve::CellSet::kShortReach},
                                                  {5, improve::CellSet::kReach},
                                                  {5, improve::CellSet::kShortReach}};
    for (const auto& [level, reach] : cases) {
        improve::CellSet cells(level, nullptr, reach);
        const double side = std::ldexp(1.0, level);
        std::vector<improve::Point> centres;
        for (int k = 0; k < 3; ++k) {
            // Also in the ring around the root box.
            const improve::Point p = {random.uniform(-1, side + 1), random.uniform(-1, side + 1),
                                      random.uniform(-1, side + 1)};
            centres.push_back(p);
            cells.set_ring(cells.index(p));
        }
        const std::vector<std::uint64_t> bricks = cells.near_bricks();
        CHECK(std::is_sorted(bricks.begin(), bricks.end()));
        for (int i = 0; i < 4000; ++i) {
            const improve::Point p = {random.uniform(0, side), random.uniform(0, side),
                                      random.uniform(0, side)};
            const std::uint64_t code =
                morton_encode(static_cast<u32>(p[0]), static_cast<u32>(p[1]), static_cast<u32>(p[2])) >>
                (3 * improve::CellSet::kBrickLevels);
            const bool listed = std::binary_search(bricks.begin(), bricks.end(), code);
            CHECK(listed == cells.is_near(p));
            for (const improve::Point& centre : centres) {
                double distance = 0;
                for (std::size_t j = 0; j < 3; ++j)
                    distance = std::max(distance, std::fabs(p[j] - centre[j]));
                if (distance < static_cast<double>(reach)) CHECK(listed);
            }
        }
    }
}

namespace {

constexpr int kSetLevel = 5;  ///< of the next two cases

improve::Point corner_of(std::uint64_t code) {
    return {static_cast<double>(gather_bits(code)), static_cast<double>(gather_bits(code >> 1)),
            static_cast<double>(gather_bits(code >> 2))};
}

/// The elements of one type near two cells, and their cells, against a look at each; from the second set on
/// some elements are gone, and their nodes, which no others have, are anywhere.
void check_places(Mesh mesh, int type, std::int64_t reach, RandomSource& random) {
    improve::CellFrame frame{};
    frame.cell = frame.per_cell = 1;
    frame.level = kSetLevel;
    frame.on_lattice = false;
    // Later sets skip the chunks that the first has seen far from them.
    improve::Known known;
    for (const improve::Point& other : {improve::Point{20.5, 31.9, 7.5}, {9.5, 9.5, 9.5}, {3.5, 4.5, 30.5}}) {
        improve::CellSet cells(kSetLevel, nullptr, reach);
        cells.set_ring(cells.index({3.5, 4.5, 30.5}));
        cells.set_ring(cells.index(other));
        improve::Places places;
        improve::find_cells(mesh, frame, cells, known, 2, places);
        std::vector<std::uint32_t> expected, cell_of;
        const auto t = static_cast<std::size_t>(type);
        const std::size_t count = mesh.elements[t].size();
        for (std::size_t i = 0; i < count; ++i) {
            const improve::Point place = improve::place_of(mesh, frame, type, i);
            if (known.gone.element[t][i] != 0 || !cells.is_near(place)) continue;
            expected.push_back(static_cast<std::uint32_t>(i));
            cell_of.push_back(static_cast<std::uint32_t>(cells.index(place)));
        }
        CHECK(expected.size() > 500);
        CHECK(expected.size() < count / 2);
        CHECK(places.element[t] == expected);
        CHECK(places.cell_of[t] == cell_of);
        for (std::size_t i = 0; i < count; ++i) {
            if (!random.chance(0.1)) continue;
            known.gone.element[t][i] = 1;
            const improve::Element gone = improve::element(mesh, type, i);
            for (std::size_t k = 0; k < gone.count; ++k)
                for (std::size_t j = 0; j < 3; ++j)
                    mesh.points[3 * gone.node[k] + j] = random.uniform(0, std::ldexp(1.0, kSetLevel));
        }
    }
}

}  // namespace

TEST_CASE("elements near the zone are found whether rows of cubes are skipped or not") {
    RandomSource random(6);
    // Cubes in Morton order, with gaps, and displaced hexahedra among them.
    Mesh mesh;
    ElementBlock& block = mesh.block(ElementType::kHexahedron);
    for (std::uint64_t code = 0; code < std::uint64_t{1} << (3 * kSetLevel); ++code) {
        if (random.chance(0.2)) continue;
        const bool is_cube = random.chance(0.9);
        const improve::Point low = corner_of(code);
        const int corner[8] = {0, 1, 3, 2, 4, 5, 7, 6};
        for (const int c : corner) {
            block.nodes.push_back(static_cast<NodeId>(mesh.node_count()));
            for (std::size_t j = 0; j < 3; ++j)
                mesh.points.push_back(low[j] + ((c >> j) & 1) + (is_cube ? 0 : random.uniform(-0.3, 0.3)));
        }
        block.region.push_back(1);
        block.kind.push_back(static_cast<std::uint8_t>(is_cube ? ElementKind::kIn : ElementKind::kSnio));
    }
    check_places(mesh, 0, improve::CellSet::kReach, random);
}

TEST_CASE("tetrahedra near the zone are found, whatever their number") {
    RandomSource random(8);
    Mesh mesh;
    ElementBlock& block = mesh.block(ElementType::kTetrahedron);
    for (std::uint64_t code = 0; code < std::uint64_t{1} << (3 * kSetLevel); ++code) {
        const improve::Point low = corner_of(code);
        for (int left = random.chance(0.2) ? 0 : 3; left > 0; --left) {
            for (int k = 0; k < 4; ++k) {
                block.nodes.push_back(static_cast<NodeId>(mesh.node_count()));
                for (std::size_t j = 0; j < 3; ++j) mesh.points.push_back(low[j] + random.uniform(-0.3, 1.3));
            }
            block.region.push_back(1);
            block.kind.push_back(static_cast<std::uint8_t>(ElementKind::kSnio));
        }
    }
    check_places(mesh, 3, improve::CellSet::kShortReach, random);
}

TEST_CASE("a set that looks farther is one that has done so from the start") {
    RandomSource random(9);
    for (const int level : {2, 4, 6}) {
        improve::CellSet grown(level, nullptr, improve::CellSet::kShortReach);
        improve::CellSet far(level, nullptr, improve::CellSet::kReach);
        const double side = std::ldexp(1.0, level);
        for (int k = 0; k < 4; ++k) {
            const improve::CellId cell = far.index(
                {random.uniform(-1, side + 1), random.uniform(-1, side + 1), random.uniform(-1, side + 1)});
            grown.set_ring(cell);
            far.set_ring(cell);
        }
        grown.extend_reach(improve::CellSet::kReach);
        CHECK(grown.near_bricks() == far.near_bricks());
    }
}

TEST_CASE("nodes of a zone are numbered in their order") {
    RandomSource random(10);
    for (const std::size_t count : {1u, 64u, 65u, 5000u}) {
        std::vector<std::uint32_t> expected(count, improve::kNone);
        improve::ZoneNodes nodes;
        nodes.clear(count);
        for (std::size_t i = 0; i < count; ++i) {
            if (!random.chance(0.3)) continue;
            expected[i] = 0;
            nodes.add(static_cast<NodeId>(i));
            nodes.add(static_cast<NodeId>(i));
        }
        std::uint32_t next = 0;
        nodes.number([&](NodeId node) { expected[node] = next++; });
        for (std::size_t i = 0; i < count; ++i) {
            CHECK(nodes[static_cast<NodeId>(i)] == expected[i]);
            CHECK(nodes.has(static_cast<NodeId>(i)) == (expected[i] != improve::kNone));
        }
        nodes.clear(count);
        CHECK_FALSE(nodes.has(0));
    }
}

TEST_CASE("sorting on threads sorts, whatever their number") {
    RandomSource random(7);
    for (const std::size_t count : {0u, 1u, 5000u, 100000u, 262145u}) {
        std::vector<std::uint64_t> values(count);
        for (auto& value : values) value = random.next() >> 50;
        std::vector<std::uint64_t> expected = values;
        std::sort(expected.begin(), expected.end());
        for (const int threads : {1, 2, 3, 8}) {
            std::vector<std::uint64_t> sorted = values;
            parallel_sort(sorted, threads);
            CHECK(sorted == expected);
        }
    }
}
