// Numbers and places in messages.
#pragma once

#include <cstdio>
#include <string>

#include "mortise/model.hpp"

namespace mortise::pipeline {

inline std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
}

inline std::string place(const Vec3& x) {
    return "(" + number(x[0]) + ", " + number(x[1]) + ", " + number(x[2]) + ")";
}

}  // namespace mortise::pipeline
