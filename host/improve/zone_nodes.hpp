// The nodes of a mesh that a zone has. A number for each node of the mesh would be 70 MB for a zone of a few
// thousand in a large mesh, to be cleared, and fetched from memory at every look.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "mortise/mesh.hpp"

namespace mortise::improve {

inline constexpr std::uint32_t kNone = 0xffffffffu;

/// A set of nodes, numbered in ascending order: a bit for each, and how many are before every 64.
class ZoneNodes {
  public:
    /// None of so many.
    void clear(std::size_t nodes) { words_.assign((nodes + 63) / 64, {}); }

    void add(NodeId node) { words_[node / 64].bits |= bit_of(node); }

    /// After all have been added: numbers them, and calls visit(node) for each, in order.
    template <class Visit>
    void number(const Visit& visit) {
        std::uint32_t count = 0;
        for (std::size_t w = 0; w < words_.size(); ++w) {
            words_[w].before = count;
            for (std::uint64_t bits = words_[w].bits; bits != 0; bits &= bits - 1, ++count)
                visit(static_cast<NodeId>(64 * w + static_cast<std::size_t>(__builtin_ctzll(bits))));
        }
    }

    bool has(NodeId node) const { return (words_[node / 64].bits & bit_of(node)) != 0; }

    /// The number of a node; kNone if it is not in the set.
    std::uint32_t operator[](NodeId node) const {
        const Word& word = words_[node / 64];
        if ((word.bits & bit_of(node)) == 0) return kNone;
        return word.before + count(word.bits & (bit_of(node) - 1));
    }

  private:
    struct Word {
        std::uint64_t bits = 0;
        std::uint32_t before = 0;
    };
    /// Plain x86-64 has no instruction for it, and compilers call a library.
    static std::uint32_t count(std::uint64_t bits) {
        bits -= (bits >> 1) & 0x5555555555555555u;
        bits = (bits & 0x3333333333333333u) + ((bits >> 2) & 0x3333333333333333u);
        bits = (bits + (bits >> 4)) & 0x0f0f0f0f0f0f0f0fu;
        return static_cast<std::uint32_t>((bits * 0x0101010101010101u) >> 56);
    }
    static std::uint64_t bit_of(NodeId node) { return std::uint64_t{1} << (node % 64); }

    std::vector<Word> words_;
};

}  // namespace mortise::improve
