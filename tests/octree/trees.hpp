// Checks of a device tree against definitions, for tests/octree: see trees.cpp.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/octree/octree.hpp"
#include "host/tape/compile.hpp"
#include "mortise/model.hpp"
#include "tests/mesher/random_source.hpp"

namespace mortise::test {

/// One device per setting for all tests: kernels are built once. 0: the default.
device::Device& device_with(int lanes, int work_group_size);

/// NIO leaves, and those that the device did not decide though the reference did.
struct Comparison {
    std::size_t nio = 0;
    std::size_t extra = 0;
};

/// Requires that no decided leaf contradicts the reference.
Comparison compare_with_reference(const octree::Octree& tree, const tape::BoundModel& model);

/// Region of a finest cell: kUnknown for an NIO leaf.
std::vector<std::int32_t> leaf_regions(const octree::Octree& tree);

/// The same from a recursion in double precision on the host (host/tape/reference.hpp).
std::vector<std::int32_t> reference_regions(const tape::BoundModel& model, int level);

/// Bitmaps, ranks, counts and order of the lists agree with each other.
void check_bitmaps(const octree::Octree& tree);

/// Regions of decided leaves against the model's definition at random points, and at their corners.
void check_decided(const octree::Octree& tree, const Model& source, const tape::BoundModel& model,
                   RandomSource& random, int points);

/// Pruned tapes give the full tape's value in their cell, and depend on all their surfaces if they have few.
void check_tapes(const octree::Octree& tree, const tape::BoundModel& model, RandomSource& random, int points);

/// Words of each leaf's tape with the leaf's code in front: what may not depend on the launch.
std::vector<std::vector<std::uint64_t>> contents(const octree::Octree& tree);

}  // namespace mortise::test
