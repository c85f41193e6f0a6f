// Formulas in x, y, z that Python's operators and numpy's functions build.
#pragma once

#include <string>

#include <pybind11/pybind11.h>

namespace mortise::python {

/// The class Formula and coordinates().
void bind_formulas(pybind11::module_& module);

/// The text (docs/formulas.md) of a str, a Formula, or a function of three coordinates that returns one.
/// Raises TypeError for anything else, with `before` in front of its message.
std::string formula_text(const pybind11::object& formula, const std::string& before = {});

}  // namespace mortise::python
