// Options of a run from Python's keyword arguments.
#pragma once

#include <pybind11/pybind11.h>

#include "mortise/mesher.hpp"

namespace mortise::python {

/// Keywords are the names of MeshOptions' members. Raises TypeError for others, and for values of another
/// kind. A run listens to Ctrl-C; `progress`, if given, is called with (stage, share) and stops the run by
/// returning False.
MeshOptions options_of(const pybind11::kwargs& arguments);

}  // namespace mortise::python
