// Which nodes stand for the model's tips (stratum.hpp).
#pragma once

#include <vector>

#include "host/improve/stratum.hpp"
#include "host/improve/zone.hpp"

namespace mortise::improve {

/// Gives each tip within reach a node of the zone that lies on its surfaces, and appends them to zone.tips.
///
/// Near a pole whose surfaces take turns these lie closer together than the mesh tells, and their facets may
/// meet in other ways than the model's. They get the surface that is theirs, so that the creases cross at the
/// pole's node: zone.stratum must be found anew if this returns true.
bool assign_tips(const std::vector<Tip>& tips, const Surfaces& surfaces, Zone& zone);

}  // namespace mortise::improve
