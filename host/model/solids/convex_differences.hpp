// Convex polytopes less convex polytopes, as convex polytopes.
#pragma once

#include <vector>

#include "host/model/solids/convex_pieces.hpp"

namespace mortise::model_reader {

/// Takes the solids of `cuts` away from those of `pieces`: a part for each plane of a cut, all that lies
/// beyond it. Parts overlap and are as large as they can be, so that their outlines are those of the whole.
/// Both must be points, not facetted. Throws Error(kInput) if there are too many parts.
void take_away(std::vector<ConvexPiece>& pieces, const std::vector<ConvexPiece>& cuts, const Wanted& wanted);

}  // namespace mortise::model_reader
