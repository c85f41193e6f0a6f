// Taking elements out of arrays, in place, on all threads.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/common/parallel.hpp"

namespace mortise {

/// What stays of some elements, whose values lie in any number of arrays; it keeps its order.
///
/// Each thread has a part of the elements, and moves them forward over those that are gone before them, and
/// so over the end of the part before it, which is copied first.
class Compaction {
  public:
    /// taken[i], not 0: element i goes. Must outlive this.
    Compaction(const std::vector<std::uint8_t>& taken, int threads) : taken_(taken), threads_(threads) {
        const std::size_t most = std::max<std::size_t>(1, taken.size() / kLeastPart);
        divide(std::min(static_cast<std::size_t>(thread_count(threads)), most));
        // No part may move farther than the one before it is long.
        for (std::size_t p = 1; p < parts_.size(); ++p) {
            if (parts_[p].gone > parts_[p - 1].end - parts_[p - 1].begin) divide(1);
        }
    }

    bool is_needed() const { return gone_ > 0; }

    /// Takes values out, `stride` for each element.
    template <class T>
    void keep(std::vector<T>& values, std::size_t stride) const {
        if (!is_needed()) return;
        keep_by(values, stride, [](const T* from, std::size_t count, T* to) {
            if (from != to) std::copy_n(from, count, to);
        });
    }

    /// The same; those that stay become change(value).
    template <class T, class Change>
    void keep(std::vector<T>& values, std::size_t stride, const Change& change) const {
        keep_by(values, stride, [&change](const T* from, std::size_t count, T* to) {
            std::transform(from, from + count, to, change);
        });
    }

  private:
    static constexpr std::size_t kLeastPart = 8192;

    struct Part {
        std::size_t begin = 0, end = 0;
        std::size_t gone = 0;  ///< elements taken before it
    };

    void divide(std::size_t parts) {
        parts_.assign(parts, {});
        std::vector<std::size_t> gone(parts);
        parallel_chunks(parts, 1, threads_, [&](std::size_t p, std::size_t, int) {
            Part& part = parts_[p];
            part.begin = taken_.size() * p / parts;
            part.end = taken_.size() * (p + 1) / parts;
            const std::uint8_t* const first = taken_.data();
            gone[p] = part.end - part.begin -
                      static_cast<std::size_t>(std::count(first + part.begin, first + part.end, 0));
        });
        gone_ = 0;
        for (std::size_t p = 0; p < parts; ++p) {
            parts_[p].gone = gone_;
            gone_ += gone[p];
        }
    }

    /// move(from, count, to) for runs of values.
    template <class T, class Move>
    void keep_by(std::vector<T>& values, std::size_t stride, const Move& move) const {
        T* const first = values.data();
        std::vector<std::vector<T>> ends(parts_.size());  // of parts, where the next one moves to
        parallel_chunks(parts_.size() - 1, 1, threads_, [&](std::size_t p, std::size_t, int) {
            const Part& next = parts_[p + 1];
            ends[p].assign(first + (next.begin - next.gone) * stride, first + next.begin * stride);
        });
        parallel_chunks(parts_.size(), 1, threads_, [&](std::size_t p, std::size_t, int) {
            const Part& part = parts_[p];
            const std::size_t copied = part.end - ends[p].size() / stride;
            std::size_t to = part.begin - part.gone;
            const auto move_run = [&](const T* from, std::size_t count) {
                move(from, count * stride, first + to * stride);
                to += count;
            };
            for (std::size_t i = part.begin; i < part.end;) {
                const std::size_t begin = next_where(i, part.end, true);
                const std::size_t end = next_where(begin, part.end, false);
                const std::size_t middle = std::clamp(copied, begin, end);
                move_run(first + begin * stride, middle - begin);
                if (middle < end) move_run(ends[p].data() + (middle - copied) * stride, end - middle);
                i = end;
            }
        });
        values.resize((taken_.size() - gone_) * stride);
    }

    std::size_t next_where(std::size_t from, std::size_t end, bool stays) const {
        const auto at = [this](std::size_t i) { return taken_.begin() + static_cast<std::ptrdiff_t>(i); };
        const auto is_it = [stays](std::uint8_t taken) { return (taken == 0) == stays; };
        return static_cast<std::size_t>(std::find_if(at(from), at(end), is_it) - taken_.begin());
    }

    const std::vector<std::uint8_t>& taken_;
    int threads_;
    std::vector<Part> parts_;
    std::size_t gone_ = 0;  ///< elements
};

}  // namespace mortise
