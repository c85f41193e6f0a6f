// Facets of a block by the place of their bounds.
//
// Entries are only added. They may be stale: whoever asks looks at what an entry names now, and what has
// moved is entered again. So changes that are undone need no care: what they put back has its entries from
// before.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "host/improve/quality.hpp"

namespace mortise::improve {

struct Bounds {
    Point low;
    Point high;

    bool overlap(const Bounds& other) const {
        for (std::size_t j = 0; j < 3; ++j) {
            if (low[j] > other.high[j] || other.low[j] > high[j]) return false;
        }
        return true;
    }
};

class FacetGrid {
  public:
    /// `count`: how many facets there are about to be.
    void reset(const Bounds& all, std::size_t count) {
        places_ = kFewestPlaces;
        while (places_ < kMostPlaces && kFacetsPerPlace * places_ * places_ < count) ++places_;
        origin_ = all.low;
        double extent = 0;
        for (std::size_t j = 0; j < 3; ++j) extent = std::max(extent, all.high[j] - all.low[j]);
        per_place_ = extent > 0 ? static_cast<double>(places_) / extent : 0;
        last_.assign(places_ * places_ * places_, kEnd);
        chunks_.clear();
        size_ = 0;
    }

    std::size_t size() const { return size_; }

    void add(const Bounds& bounds, std::uint32_t element, std::uint32_t face) {
        const Box box = round_outward(bounds);
        for_places(box, [&](std::size_t place) {
            std::uint32_t& last = last_[place];
            if (last == kEnd || chunks_[last].count == kChunk) {
                chunks_.emplace_back();
                chunks_.back().previous = last;
                last = static_cast<std::uint32_t>(chunks_.size() - 1);
            }
            Chunk& chunk = chunks_[last];
            for (std::size_t j = 0; j < 3; ++j) {
                chunk.low[j][chunk.count] = box.low[j];
                chunk.high[j][chunk.count] = box.high[j];
            }
            chunk.name[chunk.count++] = 4 * element + face;
            ++size_;
            return false;
        });
    }

    /// Whether visit(element, face) holds for an entry whose bounds overlap these, or nearly so.
    template <class Visit>
    bool any(const Bounds& bounds, const Visit& visit) const {
        const Box box = round_outward(bounds);
        return for_places(box, [&](std::size_t place) {
            for (std::uint32_t c = last_[place]; c != kEnd; c = chunks_[c].previous) {
                const Chunk& chunk = chunks_[c];
                for (std::size_t e = 0; e < chunk.count; ++e) {
                    bool apart = false;
                    for (std::size_t j = 0; j < 3; ++j)
                        apart = apart || chunk.low[j][e] > box.high[j] || box.low[j] > chunk.high[j][e];
                    if (apart) continue;
                    // Of all places that both are in, the first one counts.
                    Corner low;
                    for (std::size_t j = 0; j < 3; ++j) low[j] = std::max(chunk.low[j][e], box.low[j]);
                    if (place_of(low) == place && visit(chunk.name[e] / 4, chunk.name[e] % 4)) return true;
                }
            }
            return false;
        });
    }

  private:
    static constexpr std::size_t kFewestPlaces = 8;  ///< along an axis
    static constexpr std::size_t kMostPlaces = 128;
    static constexpr std::size_t kFacetsPerPlace = 4;  ///< a skin passes through few of all places
    static constexpr std::uint32_t kEnd = 0xffffffffu;
    static constexpr std::uint32_t kChunk = 4;

    using Corner = std::array<float, 3>;
    struct Box {
        Corner low;
        Corner high;
    };

    /// Entries of one place, two cache lines of them: lists of single ones would wait for memory at each.
    struct alignas(64) Chunk {
        float low[3][kChunk];
        float high[3][kChunk];
        std::uint32_t name[kChunk];  ///< 4 * element + face
        std::uint32_t count = 0;
        std::uint32_t previous = kEnd;
    };

    static Box round_outward(const Bounds& bounds) {
        Box box{};
        for (std::size_t j = 0; j < 3; ++j) {
            box.low[j] = static_cast<float>(bounds.low[j]);
            box.high[j] = static_cast<float>(bounds.high[j]);
            if (static_cast<double>(box.low[j]) > bounds.low[j])
                box.low[j] = std::nextafter(box.low[j], -HUGE_VALF);
            if (static_cast<double>(box.high[j]) < bounds.high[j])
                box.high[j] = std::nextafter(box.high[j], HUGE_VALF);
        }
        return box;
    }

    std::size_t place_along(float x, std::size_t axis) const {
        const double at = (static_cast<double>(x) - origin_[axis]) * per_place_;
        return at > 0 ? static_cast<std::size_t>(std::min(at, static_cast<double>(places_ - 1))) : 0;
    }

    std::size_t place_of(const Corner& p) const {
        return (place_along(p[2], 2) * places_ + place_along(p[1], 1)) * places_ + place_along(p[0], 0);
    }

    template <class Visit>
    bool for_places(const Box& b, const Visit& visit) const {
        std::size_t first[3];
        std::size_t last[3];
        for (std::size_t j = 0; j < 3; ++j) {
            first[j] = place_along(b.low[j], j);
            last[j] = place_along(b.high[j], j);
        }
        for (std::size_t z = first[2]; z <= last[2]; ++z) {
            for (std::size_t y = first[1]; y <= last[1]; ++y) {
                for (std::size_t x = first[0]; x <= last[0]; ++x) {
                    if (visit((z * places_ + y) * places_ + x)) return true;
                }
            }
        }
        return false;
    }

    Point origin_ = {0, 0, 0};
    double per_place_ = 0;
    std::size_t places_ = 0;
    std::size_t size_ = 0;
    std::vector<std::uint32_t> last_;  ///< per place: its last chunk
    std::vector<Chunk> chunks_;
};

}  // namespace mortise::improve
