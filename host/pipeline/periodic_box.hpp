// A solid that repeats in a box (MeshOptions::periodic) as a model with periodic planes.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "mortise/mesher.hpp"
#include "mortise/model.hpp"

namespace mortise::pipeline {

/// The axes that MeshOptions::periodic names, ascending. Throws Error(kUsage) for other letters than x, y and
/// z, or one that comes twice.
std::vector<std::size_t> axes_of(const std::string& periodic);

/// The same task without MeshOptions::periodic: the box that cuts the model (MeshOptions::box, else the
/// model's own) as planes of the model, named as the faces of a box are, with pairs across the periodic axes.
/// Throws Error(kUsage) for options that check_options refuses, or if no box cuts the model; what check_model
/// throws.
struct PeriodicTask {
    Model model;
    MeshOptions options;
};
PeriodicTask repeat_in_box(const Model& model, const MeshOptions& options);

}  // namespace mortise::pipeline
