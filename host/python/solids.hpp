// Solids built in Python, and models of them.
#pragma once

#include <pybind11/pybind11.h>

#include "mortise/model.hpp"

namespace mortise::python {

/// The class Solid and what makes solids; after the class Model, which learns to come from them.
void bind_solids(pybind11::module_& module, pybind11::class_<Model>& model);

}  // namespace mortise::python
