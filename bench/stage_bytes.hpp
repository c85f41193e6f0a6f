// How many bytes each stage moves, by a model that does not depend on caches.
//
// Each array that a stage reads or writes counts once for each pass over it, with the part of it that holds
// values. Not counted: surfaces, tables and tapes' formulas (they stay in cache), and whatever a leaf looks
// up in its neighbours (bits, masks and numbers that the pass over the array has counted already). So the
// figures are what a machine with a perfect cache would move, and a stage's share of the copy bandwidth says
// how far it is from being limited by memory alone.
#pragma once

#include <cstdint>

#include "host/cnio/extract.hpp"
#include "host/octree/octree.hpp"
#include "mortise/mesh.hpp"

namespace mortise::bench {

/// Bytes that a stage reads and writes.
struct StageBytes {
    double descent = 0;
    double entities = 0;
    double compaction = 0;
    double numbering = 0;
    double templates = 0;
    double extraction = 0;
    double assembly = 0;
    double repositioning = 0;
};

/// `before`: the mesh before improvement, `after` it; `zone_elements` as improve::Counters. Uniform trees.
StageBytes stage_bytes(const octree::Octree& tree, const cnio::Extraction& extraction, const Mesh& before,
                       const Mesh& after, std::uint64_t zone_elements);

/// Bytes of coordinates and connectivity.
double geometry_bytes(const Mesh& mesh);

/// Bytes of all arrays of the mesh, without names.
double mesh_bytes(const Mesh& mesh);

}  // namespace mortise::bench
