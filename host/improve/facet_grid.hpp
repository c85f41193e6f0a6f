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

    void include(const Bounds& other) {
        for (std::size_t j = 0; j < 3; ++j) {
            low[j] = std::min(low[j], other.low[j]);
            high[j] = std::max(high[j], other.high[j]);
        }
    }
};

inline constexpr Bounds kNoBounds = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};

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
        first_.assign(places_ * places_ * places_, kEnd);
        entries_.clear();
    }

    std::size_t size() const { return entries_.size(); }

    void add(const Bounds& bounds, std::uint32_t element, std::uint32_t face) {
        for_places(bounds, [&](std::size_t place) {
            entries_.push_back({bounds, element, face, first_[place]});
            first_[place] = static_cast<std::uint32_t>(entries_.size() - 1);
            return false;
        });
    }

    /// Whether visit(element, face) holds for an entry whose bounds overlap these.
    template <class Visit>
    bool any(const Bounds& bounds, const Visit& visit) const {
        return for_places(bounds, [&](std::size_t place) {
            for (std::uint32_t e = first_[place]; e != kEnd; e = entries_[e].next) {
                const Entry& entry = entries_[e];
                if (!entry.bounds.overlap(bounds)) continue;
                // Of all places that both are in, the first one counts.
                Point low;
                for (std::size_t j = 0; j < 3; ++j) low[j] = std::max(entry.bounds.low[j], bounds.low[j]);
                if (place_of(low) == place && visit(entry.element, entry.face)) return true;
            }
            return false;
        });
    }

  private:
    static constexpr std::size_t kFewestPlaces = 8;  ///< along an axis
    static constexpr std::size_t kMostPlaces = 128;
    static constexpr std::size_t kFacetsPerPlace = 4;  ///< a skin passes through few of all places
    static constexpr std::uint32_t kEnd = 0xffffffffu;

    struct Entry {
        Bounds bounds;
        std::uint32_t element;
        std::uint32_t face;
        std::uint32_t next;
    };

    std::size_t place_along(double x, std::size_t axis) const {
        const double at = (x - origin_[axis]) * per_place_;
        return at > 0 ? static_cast<std::size_t>(std::min(at, static_cast<double>(places_ - 1))) : 0;
    }

    std::size_t place_of(const Point& p) const {
        return (place_along(p[2], 2) * places_ + place_along(p[1], 1)) * places_ + place_along(p[0], 0);
    }

    template <class Visit>
    bool for_places(const Bounds& b, const Visit& visit) const {
        for (std::size_t z = place_along(b.low[2], 2); z <= place_along(b.high[2], 2); ++z) {
            for (std::size_t y = place_along(b.low[1], 1); y <= place_along(b.high[1], 1); ++y) {
                for (std::size_t x = place_along(b.low[0], 0); x <= place_along(b.high[0], 0); ++x) {
                    if (visit((z * places_ + y) * places_ + x)) return true;
                }
            }
        }
        return false;
    }

    Point origin_ = {0, 0, 0};
    double per_place_ = 0;
    std::size_t places_ = 0;
    std::vector<std::uint32_t> first_;
    std::vector<Entry> entries_;
};

}  // namespace mortise::improve
