// Features smaller than a cell: what passes between all samples of the grid (docs/design/probe.md).
//
// A small ball inside a cell, a rod or a thin torus between vertices, a small void: templates and certificate
// see a surface only where its sign changes between samples. This stage looks between them, tells what the
// mesh would miss, and where a cell can keep it all the same.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "host/octree/octree.hpp"
#include "host/tape/compile.hpp"
#include "mortise/mesher.hpp"

namespace mortise::probe {

/// A leaf whose cone has its apex in a feature, where the hidden surface has another sign than at all
/// samples.
struct Apex {
    std::uint64_t morton;
    std::array<std::int32_t, 3> at;  ///< lattice units from the leaf's minimum corner
};

struct Probe {
    std::vector<MissedFeature> features;  ///< the largest first
    std::vector<Apex> apexes;             ///< of the features that are kept, by Morton code
    std::vector<std::uint32_t> leaves;    ///< theirs, indices into Octree::nio; must go to the certificate
    /// Codes of leaves in which a curved surface turns by 90 degrees or more, ascending: see
    /// false_facets.hpp.
    std::vector<std::uint64_t> folded;
    /// The first leaf, by its code, in which a formula is 0 around the centre: neither inside nor outside.
    std::optional<std::uint64_t> flat;
    std::uint64_t probed = 0;  ///< leaves with a hidden surface that may be more than a cap
};

/// Probes all NIO leaves, before any is promoted. The same result for any number of threads.
///
/// Found for certain are features that hold a ball of 1/18 of a cell (leaf.hpp), thinner balls and tubes of
/// primitives as a rule. Not looked at are further sheets of a surface that the leaf's samples do see.
Probe find_features(const tape::BoundModel& model, const octree::Octree& tree, int threads);

}  // namespace mortise::probe
