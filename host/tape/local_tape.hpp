// A cell's pruned tape over its own list of surfaces: evaluated many times per cell, so without searching.
#pragma once

#include <cstdint>
#include <vector>

namespace mortise::tape {

/// The surfaces that a tape names, ascending.
void list_surfaces(const std::uint32_t* words, std::size_t length, std::vector<std::uint32_t>& surfaces);

/// Sign of a surface, for a tape, where it has this value: what is on it is inside.
inline std::int8_t sign_of(double value) { return value <= 0 ? std::int8_t{-1} : std::int8_t{1}; }

class LocalTape {
  public:
    /// `surfaces`: ascending, holds every surface of the tape.
    void load(const std::uint32_t* words, std::size_t length, const std::vector<std::uint32_t>& surfaces);

    /// A cell that lies in one region: no surfaces.
    void load_constant(std::int32_t region);

    /// Value for signs (-1, 0 unknown, +1) parallel to the surfaces, in three-valued logic, then by cases
    /// over up to kMaxCases unknown signs (p ∨ ¬p holds); kUnknown if neither tells.
    std::int32_t resolve(const std::int8_t* signs) const;

    /// Whether the tape names a surface.
    bool names(std::size_t surface) const { return constant_ == kNotConstant && occurs_[surface] != 0; }

    /// Whether the value depends on a surface's sign in some case of the signs that are unknown; that of the
    /// surface counts as unknown. True where that would take more than kMaxCases cases to tell.
    bool depends_on(std::size_t surface, const std::int8_t* signs) const;

    /// How many of the surfaces in `asked` the value no longer depends on once the sign of `surface` is
    /// known, added up for both signs; all others are unknown.
    std::size_t settled_by(std::size_t surface, const std::uint8_t* asked) const;

    static constexpr std::size_t kMaxCases = 6;

  private:
    struct Word {
        std::uint8_t operation;
        bool negated;
        std::uint16_t region;
        std::uint16_t otherwise;
        std::uint32_t surface;  ///< index into the list
    };
    std::int32_t evaluate(const std::int8_t* signs) const;
    std::uint64_t cases(const std::int8_t* signs, const std::size_t* open, std::size_t count) const;

    std::vector<Word> words_;
    std::size_t surface_count_ = 0;
    std::vector<std::uint8_t> occurs_;  ///< per surface: the tape names it
    std::int32_t constant_ = kNotConstant;
    static constexpr std::int32_t kNotConstant = -2;
    bool one_region_ = true;  ///< the tape ends with its only select
};

}  // namespace mortise::tape
