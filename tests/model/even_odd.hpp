// Membership in polygons: an oracle for everything that is made of outlines.
#pragma once

#include "host/model/outlines/contours.hpp"

namespace mortise::test {

/// Even-odd rule over all loops: crossings of a ray to the right.
inline bool even_odd(const model_reader::Contours& loops, const model_reader::Vec2& p) {
    bool inside = false;
    for (const auto& loop : loops) {
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const auto& a = loop[i];
            const auto& b = loop[(i + 1) % loop.size()];
            if ((a[1] > p[1]) != (b[1] > p[1]) &&
                p[0] < a[0] + (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1])) {
                inside = !inside;
            }
        }
    }
    return inside;
}

}  // namespace mortise::test
