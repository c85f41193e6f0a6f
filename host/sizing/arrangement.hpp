// The value of a tape for many signs of a few surfaces, 64 choices at a time.
//
// Tells which surfaces bound the solid in a node, and on which side of them it lies. Only choices of signs
// count that occur (signs.hpp), so that x < 1 ∨ x > 0 has no boundary.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace mortise::sizing {

class Arrangement {
  public:
    static constexpr std::size_t kMost = 20;  ///< free surfaces

    /// `signs` is parallel to `surfaces` (ascending, all of the tape): -1, +1, or 0 for the free ones, which
    /// are numbered in order. `choices`, ascending, have a bit for each free surface that is negative.
    void load(const std::uint32_t* words, std::size_t length, const std::vector<std::uint32_t>& surfaces,
              const std::vector<std::int8_t>& signs, const std::vector<std::uint32_t>& choices);

    /// Whether the region changes at the surface for some choice of the other signs.
    bool bounds(std::size_t free) const { return side(free).first; }

    /// +1: solid where f < 0 and void where f > 0, -1: the reverse, 0: both occur, or two regions meet.
    int orientation(std::size_t free) const { return side(free).second; }

    /// Whether no two regions occur.
    bool is_one_region() const;

  private:
    std::pair<bool, int> side(std::size_t free) const;

    std::vector<std::uint32_t> choices_;
    std::vector<std::uint16_t> region_;  ///< per choice
    std::vector<std::int8_t> rank_;      ///< per surface: its number, if it is free
};

}  // namespace mortise::sizing
