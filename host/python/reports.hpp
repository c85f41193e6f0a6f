// What is known of a mesh beside its arrays: reports of runs, checks, quality, features.
#pragma once

#include <pybind11/pybind11.h>

namespace mortise::python {

void bind_reports(pybind11::module_& module);

}  // namespace mortise::python
