// Unions of many boxes become unions of few: the same solid.
#include <doctest/doctest.h>

#include <set>

#include "host/common/random.hpp"
#include "host/model/solids/box_unions.hpp"
#include "tests/model/membership.hpp"
#include "tests/model/read_csg.hpp"

using namespace mortise;
using mortise::test::read_csg;

namespace {

std::string moved_group(double x, double y, double z, const std::string& child) {
    const auto text = [](double value) { return std::to_string(value); };
    return "multmatrix([[1, 0, 0, " + text(x) + "], [0, 1, 0, " + text(y) + "], [0, 0, 1, " + text(z) +
           "], [0, 0, 0, 1]]) { group() { " + child + " } }";
}

std::size_t boxes(const Model& model) {
    std::size_t count = 0;
    for (const CsgNode& node : model.nodes) count += node.op == CsgNode::Op::kPrimitive ? 1 : 0;
    return count;
}

using Cells = std::set<std::array<int, 3>>;

/// Unit cubes at whole places, nested in twos.
std::string text_of(const Cells& cells) {
    std::string text;
    for (const auto& cell : cells) {
        text =
            "union() { group() { " + text + " } " +
            moved_group(cell[0], cell[1], cell[2] + 0.5, moved_group(0, 0, -0.5, "cube(size = [1, 1, 1]);")) +
            " }";
    }
    return text;
}

void check(const Cells& cells, const Model& model) {
    Random random(3);
    for (int i = 0; i < 2000; ++i) {
        Vec3 p{};
        std::array<int, 3> cell{};
        for (std::size_t k = 0; k < 3; ++k) {
            p[k] = 8 * random.uniform() - 1;
            cell[k] = static_cast<int>(p[k] + 1) - 1;
        }
        REQUIRE(test::region_at(model, p) == cells.count(cell));
    }
}

}  // namespace

TEST_CASE("boxes that make a larger one become that box") {
    Cells block;
    for (int x = 0; x < 5; ++x) {
        for (int y = 0; y < 4; ++y) {
            for (int z = 0; z < 3; ++z) block.insert({x, y, z});
        }
    }
    const Model whole = read_csg(text_of(block));
    CHECK(boxes(whole) == 1);
    check(block, whole);
    const CsgNode& node = whole.nodes[0];
    CHECK(node.name == "cube1");
    CHECK(node.where.line == 1);
    // A hole through it: four beams.
    for (int z = 0; z < 3; ++z) block.erase({2, 2, z});
    const Model pierced = read_csg(text_of(block));
    CHECK(boxes(pierced) == 4);
    check(block, pierced);
}

TEST_CASE("random pixels: the same solid, of fewer boxes") {
    for (int seed = 0; seed < 20; ++seed) {
        Random random(static_cast<std::uint64_t>(seed) + 1);
        Cells cells;
        for (int i = 0; i < 150; ++i) {
            cells.insert({static_cast<int>(6 * random.uniform()), static_cast<int>(6 * random.uniform()),
                          static_cast<int>(6 * random.uniform())});
        }
        const Model model = read_csg(text_of(cells));
        CAPTURE(seed);
        CHECK(boxes(model) < cells.size() * 3 / 4 + 1);
        check(cells, model);
    }
}

TEST_CASE("boxes are merged below scales and in operands, with what is no box beside them") {
    std::string row;
    for (int i = 0; i < 20; ++i) row += moved_group(0.1 * i, 0, 0, "cube(size = [0.1, 1, 1]);");
    const std::string scaled =
        "multmatrix([[2, 0, 0, 1], [0, 3, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { " + row + " }";
    const Model model = read_csg("difference() { union() { " + scaled + " sphere(r = 0.5); } cube(0.2); }");
    CHECK(boxes(model) == 3);
    CHECK(test::region_at(model, {4.99, 2.99, 0.5}) == 1);
    CHECK(test::region_at(model, {5.01, 2.99, 0.5}) == 0);
    CHECK(test::region_at(model, {-0.3, -0.1, 0.1}) == 1);
    CHECK(test::region_at(model, {0.1, 0.1, 0.1}) == 0);
    // Turned boxes, mirrored ones and those in operands of an intersection stay.
    std::string turned;
    for (int i = 0; i < 20; ++i) {
        turned += "multmatrix([[0, -1, 0, " + std::to_string(i) +
                  "], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { cube(1); }";
    }
    CHECK(boxes(read_csg(turned)) == 20);
    CHECK(boxes(read_csg("intersection() { " + row + " }")) == 20);
    // Few boxes keep their names, apart ones have nothing to join.
    CHECK(boxes(read_csg("cube(1);" + moved_group(1, 0, 0, "cube(1);"))) == 2);
    std::string apart;
    for (int i = 0; i < 20; ++i) apart += moved_group(2 * i, 0, 0, "cube(1);");
    CHECK(boxes(read_csg(apart)) == 20);
    CHECK(boxes(read_csg(apart + moved_group(-9, 0, 0, "cube([99, 9, 9]);"))) == 1);
}

TEST_CASE("shared nodes and sizes keep their boxes") {
    Model model;
    std::vector<std::uint32_t> children;
    for (int i = 0; i < 20; ++i) {
        const double x = i;
        children.push_back(model.add_primitive(box({x, 0, 0}, {x + 1, 1, 1}), "b" + std::to_string(i)));
    }
    const std::uint32_t row = model.add_operation(CsgNode::Op::kUnion, children);
    model.nodes[3].max_size = 0.1;
    const std::uint32_t shifted = model.add_transform({1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1, 0}, children[9]);
    const std::uint32_t all = model.add_operation(CsgNode::Op::kUnion, {row, shifted});
    model.regions.push_back({"r", all, 0, ""});
    model_reader::merge_boxes(model);
    // 0-2, 3, 4-8, 9, 10-19.
    CHECK(boxes(model) == 5);
    for (const double x : {0.5, 3.5, 9.5, 15.5}) CHECK(test::region_at(model, {x, 0.5, 0.5}) == 1);
    CHECK(test::region_at(model, {9.5, 5.5, 0.5}) == 1);
    CHECK(test::region_at(model, {8.5, 5.5, 0.5}) == 0);
}
