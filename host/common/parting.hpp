// Where a strip of flat faces that meets itself at a corner is best parted into two smooth ones.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace mortise {

/// `turns`: angles by which the strip turns from each face to the next, the corner's not among them. Returns
/// the number of faces before the best place: the sharpest turn, the middle one of those that are as sharp
/// but for a twentieth; all faces if there is only one.
inline std::size_t best_parting(const std::vector<double>& turns) {
    constexpr double kAlike = 1.05;
    const std::size_t faces = turns.size() + 1;
    double most = 0;
    for (const double turn : turns) most = std::max(most, std::fabs(turn));
    const auto from_middle = [faces](std::size_t i) { return 2 * i > faces ? 2 * i - faces : faces - 2 * i; };
    std::size_t best = faces;
    for (std::size_t i = 1; i < faces; ++i) {
        if (std::fabs(turns[i - 1]) * kAlike >= most && from_middle(i) < from_middle(best)) best = i;
    }
    return best;
}

/// The same for a closed strip: by `turns`, the angle before each of its faces, and the face behind the
/// corner. Returns 0 or 1 for each face: its part.
inline std::vector<std::uint32_t> parts_of_ring(std::vector<double> turns, std::size_t corner) {
    const std::size_t faces = turns.size();
    std::rotate(turns.begin(), turns.begin() + static_cast<std::ptrdiff_t>(corner), turns.end());
    turns.erase(turns.begin());
    std::vector<std::uint32_t> part(faces, 0);
    for (std::size_t i = best_parting(turns); i < faces; ++i) part[(corner + i) % faces] = 1;
    return part;
}

}  // namespace mortise
