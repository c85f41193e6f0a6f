// A set of indices, of which few are members: the nodes on the boundary of a large mesh.
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace mortise {

/// Members have places in ascending order, so that what is known of them takes memory for them alone; the set
/// takes a fifth of a byte for each possible index.
class IndexSet {
  public:
    /// Empty, for indices below `bound`.
    explicit IndexSet(std::size_t bound) : bits_(bound / kWord + 1, 0) {}

    void insert(std::size_t index) { bits_[index / kWord] |= bit(index); }

    /// Gives all members their places: after the last insert().
    void number() {
        before_.resize(bits_.size());
        for (std::size_t w = 0; w < bits_.size(); ++w) {
            before_[w] = static_cast<std::uint32_t>(size_);
            size_ += count(bits_[w]);
        }
    }

    bool holds(std::size_t index) const { return (bits_[index / kWord] & bit(index)) != 0; }

    /// How many members; numbered.
    std::size_t size() const { return size_; }

    /// Of a member; numbered.
    std::size_t place(std::size_t index) const {
        return before_[index / kWord] + count(bits_[index / kWord] & (bit(index) - 1));
    }

    /// All members, ascending; numbered.
    std::vector<std::uint32_t> members() const {
        std::vector<std::uint32_t> list;
        list.reserve(size_);
        for (std::size_t w = 0; w < bits_.size(); ++w) {
            for (std::uint64_t rest = bits_[w]; rest != 0; rest &= rest - 1)
                list.push_back(static_cast<std::uint32_t>(w * kWord + count((rest & (~rest + 1)) - 1)));
        }
        return list;
    }

  private:
    static constexpr std::size_t kWord = 64;
    static std::uint64_t bit(std::size_t index) { return std::uint64_t{1} << (index % kWord); }
    static std::size_t count(std::uint64_t word) { return std::bitset<kWord>(word).count(); }

    std::vector<std::uint64_t> bits_;
    std::vector<std::uint32_t> before_;  ///< per word: members below it
    std::size_t size_ = 0;
};

}  // namespace mortise
