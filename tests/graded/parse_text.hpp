// A model from a text in a given format.
#pragma once

#include <string>

#include "mortise/model.hpp"

namespace mortise::test {

inline Model parse_text(const std::string& text, const std::string& format) {
    return parse_model(text, format, "test." + format);
}

}  // namespace mortise::test
