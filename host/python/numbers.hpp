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

/// For people: nine digits.
inline std::string rounded_text(double value) {
    char digits[32];
    return {digits, std::to_chars(digits, digits + sizeof digits, value, std::chars_format::general, 9).ptr};
}

}  // namespace mortise::python
