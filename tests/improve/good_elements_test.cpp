// The quick look at eight elements against the formulas that decide.
#include "host/common/good_elements.hpp"

#include <doctest/doctest.h>

#include "host/improve/poor_cells.hpp"
#include "host/reposition/stars.hpp"
#include "tests/mesher/random_source.hpp"

using namespace mortise;
using mortise::test::RandomSource;

namespace {

const std::vector<std::array<double, 3>> kShapes[kElementTypes] = {
    {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}},
    {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}},
    {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 0.7}},
    {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

/// Elements of one type, from fine ones to inverted ones, stretched and small ones among them; nodes on the
/// lattice of positions of cells with an edge of `cell`.
Mesh random_elements(ElementType type, std::size_t count, double cell, RandomSource& random) {
    Mesh mesh;
    ElementBlock& block = mesh.block(type);
    for (std::size_t i = 0; i < count; ++i) {
        const double reach = random.uniform(0, 0.6), low = random.uniform(0, 40);
        const double stretch[3] = {random.uniform(0.2, 1.2), random.uniform(0.2, 1.2),
                                   random.uniform(0.2, 1.2)};
        for (const auto& corner : kShapes[static_cast<std::size_t>(type)]) {
            block.nodes.push_back(static_cast<NodeId>(mesh.node_count()));
            for (std::size_t j = 0; j < 3; ++j) {
                const double at = low + stretch[j] * (corner[j] + random.uniform(-reach, reach));
                mesh.points.push_back(cell * (std::rint(at * kCellUnits) / kCellUnits));
            }
        }
        block.region.push_back(1);
        block.kind.push_back(static_cast<std::uint8_t>(ElementKind::kSnio));
    }
    return mesh;
}

}  // namespace

TEST_CASE("elements that are certainly good are good, and most good ones are") {
    RandomSource random(31);
    const double cell = 0.37;
    improve::CellFrame frame{};
    frame.cell = cell;
    frame.per_cell = 1 / cell;
    frame.level = 6;
    reposition::Options options;
    options.level = 6;
    tape::BoundModel model;
    model.side = cell * 64;
    const reposition::Frame lattice = reposition::make_frame(model, options);
    GoodElementsFrame quick;
    quick.per_cell = 1 / cell;
    quick.on_lattice = true;
    quick.shortest = 0.35;
    for (int t = 0; t < kElementTypes; ++t) {
        const auto type = static_cast<ElementType>(t);
        const std::size_t count = 20000;
        const Mesh mesh = random_elements(type, count, cell, random);
        std::vector<std::uint8_t> is_left(count, 0);
        std::vector<std::size_t> order;
        const auto visit = [&](std::size_t i) {
            is_left[i] = 1;
            order.push_back(i);
        };
        GoodElementsFilter filter(mesh, type, quick, visit);
        for (std::size_t i = 0; i < count - 3; ++i) filter.look_at(i);
        filter.finish();
        for (std::size_t i = count - 3; i < count; ++i) filter.look_at(i);  // fewer than eight
        filter.finish();
        CHECK(std::is_sorted(order.begin(), order.end()));
        std::size_t good = 0, found = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const bool is_poor = reposition::is_poor(
                mesh, lattice, {static_cast<std::uint32_t>(t), static_cast<std::uint32_t>(i)});
            good += is_poor ? 0 : 1;
            found += is_left[i] == 0 ? 1 : 0;
            if (is_left[i] == 0) CHECK_FALSE(is_poor);
        }
        CHECK(good > 500);
        CHECK(good < count - 500);
#if defined(__GNUC__) && !defined(__clang__)
        CHECK(found > good - good / 1000);
#endif
        // What improvement calls poor: each alone, as a mesh of one element.
        Mesh one;
        one.points = mesh.points;
        for (std::size_t i = 0; i < count; i += 10) {
            if (is_left[i] != 0) continue;
            ElementBlock& block = one.block(type);
            const auto size = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(t)]);
            const auto begin = mesh.block(type).nodes.begin() + static_cast<std::ptrdiff_t>(i * size);
            block.nodes.assign(begin, begin + static_cast<std::ptrdiff_t>(size));
            block.region = {1};
            block.kind = {static_cast<std::uint8_t>(ElementKind::kSnio)};
            CHECK(improve::count_below(one, frame, improve::kGoodQuality, 1) == 0);
        }
    }
}
