// Solids built in Python, and models of them.
#pragma once

#include <pybind11/pybind11.h>

#include "mortise/model.hpp"

namespace mortise::python {

/// The class Solid and what makes solids; after the class Model, which learns to come from them.
void bind_solids(pybind11::module_& module, pybind11::class_<Model>& model);

/// A Model, that of a Solid, or that of a dict of regions' names and solids. Raises TypeError for anything
/// else.
Model model_of(const pybind11::object& given);

}  // namespace mortise::python
