// Numbers as text.
#pragma once

#include <charconv>
#include <string>

namespace mortise::python {

/// The shortest text that reads back as the same number.
inline std::string number_text(double value) {
    char digits[32];
    return {digits, std::to_chars(digits, digits + sizeof digits, value).ptr};
}

}  // namespace mortise::python
