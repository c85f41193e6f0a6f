// Functions of formulas by their words (docs/formulas.md).
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "host/formula/formula.hpp"

namespace mortise::formula {

struct Function {
    /// Appends the function of `arguments` to a formula, as an operation or made of several.
    using Build = std::uint32_t (*)(Formula& formula, const std::vector<std::uint32_t>& arguments);
    Build build;
    int least;  ///< number of arguments
    int most;   ///< -1: any
};

const std::map<std::string, Function>& functions();

}  // namespace mortise::formula
