// See trees.hpp.
#include "tests/octree/trees.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <map>

#include "host/tape/reference.hpp"
#include "kernels/shared/lattice.h"
#include "tests/model/membership.hpp"
#include "tests/tape/bound_models.hpp"

namespace mortise::test {
namespace {

Vec3 corner_of(std::uint64_t morton, int level) {
    const double size = 1.0 / static_cast<double>(1 << level);
    return {gather_bits(morton) * size, gather_bits(morton >> 1) * size, gather_bits(morton >> 2) * size};
}

Vec3 point_in(RandomSource& random, const Vec3& corner, double size) {
    return {corner[0] + size * random.uniform(0, 1), corner[1] + size * random.uniform(0, 1),
            corner[2] + size * random.uniform(0, 1)};
}

void descend(const tape::BoundModel& model, const std::vector<std::uint32_t>& words, std::uint64_t morton,
             int depth, int level, std::vector<std::int32_t>& out) {
    const double half = 0.5 / static_cast<double>(1 << depth);
    const Vec3 corner = corner_of(morton, depth);
    const tape::Cell cell = {{corner[0] + half, corner[1] + half, corner[2] + half}, half};
    std::vector<std::uint32_t> pruned;
    const std::int32_t region = tape::classify_cell(model, words, cell, &pruned);
    if (region != kUnknown) {
        const std::size_t count = std::size_t{1} << (3 * (level - depth));
        std::fill_n(out.begin() + static_cast<std::ptrdiff_t>(morton * count), count, region);
        return;
    }
    if (depth == level) return;
    for (std::uint64_t c = 0; c < 8; ++c) descend(model, pruned, 8 * morton + c, depth + 1, level, out);
}

}  // namespace

device::Device& device_with(int lanes, int work_group_size) {
    static std::map<std::pair<int, int>, device::Device> devices;
    const auto key = std::make_pair(lanes, work_group_size);
    const auto found = devices.find(key);
    if (found != devices.end()) return found->second;
    device::DeviceOptions options;
    options.lanes = lanes;
    options.work_group_size = work_group_size;
    return devices.emplace(key, device::Device("cpu", options)).first->second;
}

Comparison compare_with_reference(const octree::Octree& tree, const tape::BoundModel& model) {
    const auto mine = leaf_regions(tree);
    const auto expected = reference_regions(model, tree.level);
    Comparison result;
    for (std::size_t cell = 0; cell < mine.size(); ++cell) {
        if (mine[cell] != kUnknown) {
            const bool agrees = expected[cell] == mine[cell] || expected[cell] == kUnknown;
            REQUIRE(agrees);
            continue;
        }
        ++result.nio;
        result.extra += expected[cell] != kUnknown ? 1 : 0;
    }
    return result;
}

std::vector<std::int32_t> leaf_regions(const octree::Octree& tree) {
    std::vector<std::int32_t> regions(std::size_t{1} << (3 * tree.level), 0);
    const octree::InRegions in(tree);
    for (std::size_t cell = 0; cell < regions.size(); ++cell) {
        if (tree.is_nio(cell)) regions[cell] = kUnknown;
        if (tree.is_in(cell)) regions[cell] = in.of(tree.in_index(cell));
    }
    return regions;
}

std::vector<std::int32_t> reference_regions(const tape::BoundModel& model, int level) {
    std::vector<std::int32_t> regions(std::size_t{1} << (3 * level), kUnknown);
    descend(model, model.tape, 0, 0, level, regions);
    return regions;
}

void check_bitmaps(const octree::Octree& tree) {
    const std::size_t cells = std::size_t{1} << (3 * tree.level);
    REQUIRE(tree.words() <= std::max<std::size_t>(1, cells / 32));
    REQUIRE(tree.words() == tree.page_codes.size() << tree.page_shift);
    REQUIRE(tree.nio_bits.size() == tree.words());
    REQUIRE(tree.in_rank.size() == tree.words() + 1);
    REQUIRE(tree.nio_rank.size() == tree.words() + 1);
    std::vector<std::uint8_t> in(cells, 0);
    for (std::size_t i = 0; i < tree.in_nodes.size(); ++i) {
        const InNode& node = tree.in_nodes[i];
        REQUIRE(node.level <= static_cast<std::uint32_t>(tree.level));
        REQUIRE(node.region > 0);
        if (i > 0) {
            const InNode& before = tree.in_nodes[i - 1];
            const bool ordered =
                before.level < node.level || (before.level == node.level && before.morton < node.morton);
            REQUIRE(ordered);
        }
        const std::size_t count = std::size_t{1}
                                  << (3 * (static_cast<std::uint32_t>(tree.level) - node.level));
        for (std::size_t k = 0; k < count; ++k) ++in.at(node.morton * count + k);
    }
    std::size_t in_count = 0;
    std::size_t nio_count = 0;
    for (std::size_t cell = 0; cell < cells; ++cell) {
        REQUIRE(static_cast<int>(tree.is_in(cell)) == in[cell]);
        if (tree.is_in(cell)) {
            REQUIRE(tree.in_index(cell) == in_count);
            ++in_count;
        }
        if (tree.is_nio(cell)) {
            REQUIRE(in[cell] == 0);
            REQUIRE(tree.nio_index(cell) == nio_count);
            REQUIRE(nio_count < tree.nio.size());
            REQUIRE(tree.nio[nio_count].morton == cell);  // ascending
            ++nio_count;
        }
    }
    CHECK(tree.in_count == in_count);
    CHECK(tree.nio.size() == nio_count);
    CHECK(tree.in_rank.back() == in_count);
    CHECK(tree.nio_rank.back() == nio_count);
}

void check_decided(const octree::Octree& tree, const Model& source, const tape::BoundModel& model,
                   RandomSource& random, int points) {
    const auto regions = leaf_regions(tree);
    const double size = tree.finest_edge();
    for (std::size_t cell = 0; cell < regions.size(); ++cell) {
        if (regions[cell] == kUnknown) continue;
        const Vec3 corner = corner_of(cell, tree.level);
        for (int k = 0; k < points; ++k) {
            const Vec3 at = to_model(model, point_in(random, corner, size));
            REQUIRE(region_at(source, at) == static_cast<std::size_t>(regions[cell]));
        }
        const auto c = static_cast<unsigned>(random.integer(0, 7));
        const Vec3 at = {corner[0] + (c & 1) * size, corner[1] + ((c >> 1) & 1) * size,
                         corner[2] + (c >> 2) * size};
        const auto inside = halves_at(model, at);
        REQUIRE(run_tape(model.tape.data(), model.tape.size(), inside) == regions[cell]);
    }
}

void check_tapes(const octree::Octree& tree, const tape::BoundModel& model, RandomSource& random,
                 int points) {
    for (const TreeNode& leaf : tree.nio) {
        REQUIRE(leaf.tape_length > 0);
        REQUIRE(std::size_t{leaf.tape_offset} + leaf.tape_length <= tree.tapes.size());
        const std::uint32_t* words = tree.tapes.data() + leaf.tape_offset;
        const Vec3 corner = corner_of(leaf.morton, tree.level);
        for (int k = 0; k < points; ++k) {
            const auto inside = halves_at(model, point_in(random, corner, tree.finest_edge()));
            REQUIRE(run_tape(words, leaf.tape_length, inside) ==
                    run_tape(model.tape.data(), model.tape.size(), inside));
        }
        std::vector<std::uint32_t> surfaces;
        for (std::uint32_t i = 0; i < leaf.tape_length; ++i) {
            if (tape_operation(words[i]) == kTapeLiteral) surfaces.push_back(tape_surface(words[i]));
        }
        std::sort(surfaces.begin(), surfaces.end());
        surfaces.erase(std::unique(surfaces.begin(), surfaces.end()), surfaces.end());
        REQUIRE(!surfaces.empty());
        if (surfaces.size() > 5 || leaf.tape_length > 48) continue;
        std::vector<bool> inside(model.surfaces.size(), false);
        for (const std::uint32_t tested : surfaces) {
            bool depends = false;
            for (std::uint32_t choice = 0; choice < (1u << surfaces.size()) && !depends; ++choice) {
                for (std::size_t s = 0; s < surfaces.size(); ++s) inside[surfaces[s]] = (choice >> s) & 1;
                const std::int32_t one = run_tape(words, leaf.tape_length, inside);
                inside[tested] = !inside[tested];
                depends = run_tape(words, leaf.tape_length, inside) != one;
            }
            REQUIRE(depends);
        }
    }
}

std::vector<std::vector<std::uint64_t>> contents(const octree::Octree& tree) {
    std::vector<std::vector<std::uint64_t>> result;
    for (const TreeNode& leaf : tree.nio) {
        std::vector<std::uint64_t> row = {leaf.morton};
        row.insert(row.end(), tree.tapes.begin() + leaf.tape_offset,
                   tree.tapes.begin() + leaf.tape_offset + leaf.tape_length);
        result.push_back(std::move(row));
    }
    for (const InNode& node : tree.in_nodes) result.push_back({node.morton, node.level, node.region});
    return result;
}

}  // namespace mortise::test
