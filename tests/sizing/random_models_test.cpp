// Random models: what the sizer takes for the surfaces of a node tells the region everywhere in it.
#include <doctest/doctest.h>

#include <cmath>
#include <map>

#include "host/sizing/topology.hpp"
#include "tests/mesher/random_models.hpp"
#include "tests/mesher/random_source.hpp"
#include "tests/sizing/descent.hpp"
#include "tests/tape/bound_models.hpp"

using namespace mortise;
using namespace mortise::test;

TEST_CASE("the sheets that count tell the region at random points of their node") {
    constexpr int kSamplePoints = 60;
    constexpr double kInside = 0.97;  // what touches the node's boundary belongs to its neighbour
    std::size_t points = 0;
    std::size_t contradictions = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        tape::BoundModel bound;
        try {
            bound = bind_model(make_random_model(seed).model, 4);
        } catch (const Error&) {
            continue;  // the solid is empty
        }
        const Nodes nodes = nodes_at(bound, 4);
        sizing::Topology topology(bound, 0);
        RandomSource random(seed);
        for (const TreeNode& node : nodes.nodes) {
            const tape::Cell cell = sizing::cell_of(node.morton, 4);
            topology.load(nodes.tapes.data() + node.tape_offset, node.tape_length, cell);
            std::map<std::vector<bool>, std::map<std::int32_t, std::size_t>> regions;
            for (int i = 0; i < kSamplePoints; ++i) {
                Vec3 x{};
                for (std::size_t j = 0; j < 3; ++j)
                    x[j] = cell.centre[j] + kInside * cell.half * random.uniform(-1, 1);
                std::vector<bool> signs;
                for (const sizing::Sheet& sheet : topology.sheets())
                    signs.push_back(surface_value(&bound.surfaces[sheet.surface], bound.expression_ops.data(),
                                                  x[0], x[1], x[2]) <= 0);
                ++regions[signs][tape::region_at(bound, x[0], x[1], x[2])];
                ++points;
            }
            for (const auto& [signs, counts] : regions) {
                std::size_t all = 0;
                std::size_t most = 0;
                for (const auto& [region, count] : counts) {
                    all += count;
                    most = std::max(most, count);
                }
                contradictions += all - most;
            }
        }
    }
    MESSAGE(points, " points, ", contradictions, " contradict their node's sheets");
    CHECK(points > 100000);
    CHECK(contradictions * 100000 < points);
}
