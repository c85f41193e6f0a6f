// Compares the space that a mesh fills with the model's definition, point by point, along vertical lines.
//
// The mesh answers by its facets alone: the region above a facet that a vertical line crosses. The model
// answers by tests/model/membership. Neither shares code with the mesher.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mortise/mesh.hpp"
#include "mortise/model.hpp"

namespace mortise::test {

struct ScanResult {
    std::uint64_t samples = 0;
    std::uint64_t wrong = 0;           ///< samples where mesh and model name different regions
    std::uint64_t wrong_far = 0;       ///< of these, those with no model boundary within half a cell
    double sample_volume = 0;          ///< volume of space that one sample stands for
    double wrong_volume = 0;           ///< wrong × sample_volume
    std::vector<double> model_volume;  ///< by region, index 0 is region 1: Monte-Carlo estimates
    /// By region: standard deviation of model_volume, or more, as neighbouring columns tell it.
    std::vector<double> volume_spread;
    std::string first_far;  ///< the first far sample, for messages
};

/// Scans `box` on lines × lines columns of `lines` samples each, jittered by a fixed seed.
ScanResult scan_membership(const Model& model, const Mesh& mesh, const Box3& box, double cell, int lines);

}  // namespace mortise::test
