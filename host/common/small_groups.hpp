// Lists of numbers, one per group, in one array.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace mortise {

class SmallGroups {
  public:
    struct Group {
        const std::uint32_t* first;
        const std::uint32_t* last;
        const std::uint32_t* begin() const { return first; }
        const std::uint32_t* end() const { return last; }
        std::size_t size() const { return static_cast<std::size_t>(last - first); }
    };

    SmallGroups() = default;

    /// `visit(found)` calls found(group, number) for all that there is, twice in the same order.
    template <class Visit>
    SmallGroups(std::size_t groups, const Visit& visit) : begin_(groups + 1, 0) {
        visit([&](std::size_t group, std::size_t) { ++begin_[group + 1]; });
        for (std::size_t g = 0; g < groups; ++g) begin_[g + 1] += begin_[g];
        numbers_.resize(begin_.back());
        std::vector<std::size_t> at(begin_.begin(), begin_.end() - 1);
        visit([&](std::size_t group, std::size_t number) {
            numbers_[at[group]++] = static_cast<std::uint32_t>(number);
        });
    }

    std::size_t size() const { return begin_.empty() ? 0 : begin_.size() - 1; }
    /// Where a group begins among the numbers of all.
    std::size_t first(std::size_t group) const { return begin_[group]; }
    Group operator[](std::size_t group) const {
        return {numbers_.data() + begin_[group], numbers_.data() + begin_[group + 1]};
    }

  private:
    std::vector<std::size_t> begin_;
    std::vector<std::uint32_t> numbers_;
};

}  // namespace mortise
