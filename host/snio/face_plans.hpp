// The plans of all faces in all states of their corners (kernels/shared/face_plan.h).
#pragma once

#include "kernels/shared/face_plan.h"

namespace mortise::snio {

/// Made at the first call; the same for every model.
const FacePlans& face_plans();

}  // namespace mortise::snio
