// Trees whose parts are used again and again: how large they are without sharing.
#pragma once

#include <cstddef>

#include "mortise/model.hpp"

namespace mortise::tape {

/// Throws Error(kInput), with the place of the first node that is too large, if the tree of a region has more
/// than `most` surfaces where each use of a node counts.
void refuse_large_trees(const Model& model, std::size_t most);

/// "source:line:column: " of a node, or "source: " if its place is not known.
std::string start_of(const Model& model, std::uint32_t node);

}  // namespace mortise::tape
