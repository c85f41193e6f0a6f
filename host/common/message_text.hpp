// Numbers, places and counts in messages: with decimal points, whatever the locale.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <string>

#include "mortise/model.hpp"

namespace mortise {

/// To so many digits, 17 at most, without zeros at the end.
inline std::string rounded_text(double value, int digits = 6) {
    char text[64];
    const auto result =
        std::to_chars(text, text + sizeof text, value, std::chars_format::general, std::min(digits, 17));
    return {text, result.ptr};
}

inline std::string place_text(const Vec3& x) {
    return "(" + rounded_text(x[0]) + ", " + rounded_text(x[1]) + ", " + rounded_text(x[2]) + ")";
}

/// "1 node was", "2 nodes were".
inline std::string counted(std::size_t count, const std::string& one, const std::string& many) {
    return std::to_string(count) + " " + (count == 1 ? one : many);
}
inline std::string counted(std::size_t count, const std::string& one) {
    return counted(count, one, one + "s");
}

}  // namespace mortise
