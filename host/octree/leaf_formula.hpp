// The formula of a leaf, a short tape over a few surfaces, to be rewritten.
#pragma once

#include <cstdint>
#include <vector>

namespace mortise::octree {

/// Surfaces are named by their place in `surfaces()`. A choice of sides is a word: bit s is set inside
/// surface s.
class LeafFormula {
  public:
    static constexpr std::size_t kMostSurfaces = 6;

    /// False if the tape holds more surfaces than that, or words of the spatial table.
    bool load(std::vector<std::uint32_t> tape);

    const std::vector<std::uint32_t>& tape() const { return tape_; }
    const std::vector<std::uint32_t>& surfaces() const { return surfaces_; }  ///< ascending
    std::size_t count() const { return surfaces_.size(); }

    /// Another surface's literals, or their complements, in the place of one surface's.
    struct Substitution {
        std::size_t gone;
        std::size_t by;
        bool negated;
    };

    /// Whether the region stays the same for all choices for which occurs(choice) holds.
    template <class Occurs>
    bool allows(const Substitution& s, const Occurs& occurs) const {
        for (std::uint32_t choice = 0; choice < (1u << count()); ++choice) {
            if (!occurs(choice)) continue;
            const std::uint32_t side = ((choice >> s.by) & 1u) ^ (s.negated ? 1u : 0u);
            if (value(choice) != value((choice & ~(1u << s.gone)) | (side << s.gone))) return false;
        }
        return true;
    }

    void substitute(const Substitution& s);

    /// Becomes: inside `chooser`, the formula after one substitution, outside it after another. False, and
    /// nothing changed, if the formula tells several regions apart, or is like that already.
    bool choose(std::size_t chooser, const Substitution& inside, const Substitution& outside);

    /// The formula after a substitution, if it then no longer depends on `free`, with another surface's
    /// literals in the place of those of `s.by`: empty if it does, or as for choose().
    std::vector<std::uint32_t> joined(const Substitution& s, std::size_t free, std::uint32_t renamed) const;

  private:
    std::int32_t value(std::uint32_t choice) const;
    bool has_one_select() const;
    /// Part of a formula: a truth value, or the words that give it.
    struct Part {
        bool is_constant = false;
        bool value = false;
        std::vector<std::uint32_t> words;
    };
    static Part combined(std::uint32_t operation, Part a, Part b);
    Part restricted(std::size_t surface, bool inside, const Substitution& s) const;
    std::uint32_t replaced(std::uint32_t literal, const Substitution& s) const;
    void list_surfaces();

    std::vector<std::uint32_t> tape_;
    std::vector<std::uint32_t> surfaces_;
};

}  // namespace mortise::octree
