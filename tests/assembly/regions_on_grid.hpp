// Three regions whose interfaces and skins lie on faces between cells, and a ball.
#pragma once

namespace mortise::test {

inline constexpr const char* kRegionsOnGrid =
    "algebraic3d\n"
    "solid cube = orthobrick (0, 0, 0; 1, 1, 1);\n"
    "solid cut = plane (0.5, 0, 0; 1, 0, 0);\n"
    "solid ball = sphere (0.5, 0.5, 0.5; 0.3);\n"
    "solid left = cube and cut and not ball;\n"
    "solid right = cube and not cut and not ball;\n"
    "tlo left;\ntlo right;\ntlo ball;\n";

}  // namespace mortise::test
