// What unions are made of, for passes that write them with other parts.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "mortise/model.hpp"

namespace mortise::model_reader {

/// A primitive or an intersection below a union, its subunions and transforms only.
struct UnionPart {
    std::uint32_t node;
    Affine map;  ///< into the frame of the topmost union
};

/// By the topmost union: its parts, the last node first. Shared nodes, and those with sizes or bounds of
/// their own, are left out.
std::map<std::uint32_t, std::vector<UnionPart>> union_parts(const Model& model);

/// Adds a solid to a model, in the frame of the union it is for.
using PartMaker = std::function<std::uint32_t(Model& model)>;

/// Takes out nodes (`gone`: per node, not 0) with whatever held nothing else, and adds parts to unions.
void replace_parts(Model& model, const std::vector<char>& gone,
                   const std::map<std::uint32_t, std::vector<PartMaker>>& added);

}  // namespace mortise::model_reader
