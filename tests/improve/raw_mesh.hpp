// A mesh before improvement, as the stages behind assembly get it.
#pragma once

#include "host/tape/compile.hpp"
#include "mortise/mesh.hpp"
#include "mortise/model.hpp"

namespace mortise::test {

/// Facets carry surfaces of `model`, named by their numbers.
struct RawMesh {
    Mesh mesh;
    tape::BoundModel model;
    int level = 0;
};

RawMesh raw_mesh(const Model& model, int level);

}  // namespace mortise::test
