// Numbers and places in messages.
#pragma once

#include <cstdio>
#include <string>

#include "mortise/model.hpp"

namespace mortise::pipeline {

inline std::string number_text(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
}

inline std::string place_text(const Vec3& x) {
    return "(" + number_text(x[0]) + ", " + number_text(x[1]) + ", " + number_text(x[2]) + ")";
}

}  // namespace mortise::pipeline
