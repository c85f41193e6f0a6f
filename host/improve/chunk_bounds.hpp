// Where the items of a list lie, chunk by chunk: most chunks are far from a small zone, and need no look at
// their items.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "host/improve/quality.hpp"

namespace mortise::improve {

/// Consecutive items, and the finest cells that hold the points by which they are judged. Of a new chunk no
/// such point is known yet.
struct Chunk {
    std::size_t begin = 0;
    std::size_t end = 0;
    bool is_known = false;
    std::array<std::int32_t, 3> low;
    std::array<std::int32_t, 3> high;

    void start() {
        low.fill(std::numeric_limits<std::int32_t>::max());
        high.fill(std::numeric_limits<std::int32_t>::min());
        is_known = true;
    }
    void include(const Point& p) {
        for (std::size_t j = 0; j < 3; ++j) {
            const auto cell = static_cast<std::int32_t>(p[j]) - (p[j] < 0 ? 1 : 0);
            low[j] = std::min(low[j], cell);
            high[j] = std::max(high[j], cell);
        }
    }
};

/// The chunks of a list to whose end items are added.
class ChunkBounds {
  public:
    /// Chunks of a list that has so many items now.
    std::vector<Chunk>& of(std::size_t count) {
        for (std::size_t at = chunks_.empty() ? 0 : chunks_.back().end; at < count;) {
            Chunk chunk{};
            chunk.begin = at;
            chunk.end = at = std::min(count, at + kItems);
            chunks_.push_back(chunk);
        }
        return chunks_;
    }

  private:
    static constexpr std::size_t kItems = 1024;
    std::vector<Chunk> chunks_;
};

}  // namespace mortise::improve
