// A solid with a low step.
#pragma once

#include <string>

#include "mortise/model.hpp"

namespace mortise::test {

/// Two boxes side by side, one higher by `step`, turned so that no face lies on the grid.
inline Model stepped(double step) {
    return parse_model(
        "multmatrix([[0.8, -0.6, 0, 0], [0.6, 0.8, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { union() {"
        " cube(size = [20, 20, 10]); multmatrix([[1, 0, 0, 19], [0, 1, 0, 3.3], [0, 0, 1, 0], [0, 0, 0, 1]])"
        " { cube(size = [20, 13, " +
            std::to_string(10 + step) + "]); } } }",
        "csg", "stepped.csg");
}

}  // namespace mortise::test
