// Formulas in x, y, z as text (docs/formulas.md).
#pragma once

#include <string>

#include "host/formula/formula.hpp"
#include "mortise/error.hpp"

namespace mortise::formula {

/// Parses `text`, which starts at `where` of the file `source`. Throws Error(kInput) with the place (without
/// one: the formula's beginning and the column) and what was expected.
Formula parse_formula(const std::string& text, const std::string& source = {}, SourceLocation where = {});

}  // namespace mortise::formula
