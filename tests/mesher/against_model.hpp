// A mesh against the definition of its model: the space that its regions fill.
#pragma once

#include <optional>

#include "tests/mesher/meshed.hpp"

namespace mortise::test {

/// Nothing if the solid is empty, or too small for its distance from the origin; any other error is a failure
/// of the test.
std::optional<Meshed> mesh_unless_empty(const Model& model, const MeshOptions& options);

/// Samples, volumes of the regions and the space that facets enclose, in cells of the boundary's level.
void compare_with_model(const Model& model, const Meshed& meshed);

}  // namespace mortise::test
