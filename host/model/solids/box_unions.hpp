// Unions of many axis-parallel boxes, such as the pixels of a picture, as unions of few.
#pragma once

#include "mortise/model.hpp"

namespace mortise::model_reader {

/// In each union with its subunions: boxes that together make a larger one become that box, and those inside
/// another one vanish, where at least a quarter of 16 or more goes. The solid is the same; inner walls, which
/// every later stage would have to prove away, are gone. A merged box has the name of its first part. Shared
/// nodes, and those with sizes or bounds of their own, are left alone.
void merge_boxes(Model& model);

}  // namespace mortise::model_reader
