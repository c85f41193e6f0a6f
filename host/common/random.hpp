// Random numbers that are the same on every platform and library: SplitMix64 (Steele, Lea, Flood 2014).
#pragma once

#include <cstdint>

namespace mortise {

class Random {
  public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    double uniform() {  ///< in [0, 1)
        std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ULL);
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
        return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
    }

  private:
    std::uint64_t state_;
};

}  // namespace mortise
