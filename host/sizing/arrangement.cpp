#include "host/sizing/arrangement.hpp"

#include <algorithm>
#include <array>

#include "kernels/shared/tape.h"

namespace mortise::sizing {
namespace {

using Bits = std::uint64_t;
constexpr std::size_t kLanes = 64;
constexpr std::size_t kPlanes = 12;  ///< bits of a region's number

}  // namespace

void Arrangement::load(const std::uint32_t* words, std::size_t length,
                       const std::vector<std::uint32_t>& surfaces, const std::vector<std::int8_t>& signs,
                       const std::vector<std::uint32_t>& choices) {
    choices_ = choices;
    region_.assign(choices.size(), 0);
    rank_.assign(surfaces.size(), 0);
    std::int8_t free = 0;
    for (std::size_t i = 0; i < surfaces.size(); ++i) rank_[i] = signs[i] == 0 ? free++ : std::int8_t{0};
    for (std::size_t first = 0; first < choices.size(); first += kLanes) {
        const std::size_t lanes = std::min(kLanes, choices.size() - first);
        std::array<Bits, kMost> negative{};
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            for (std::size_t k = 0; k < static_cast<std::size_t>(free); ++k)
                negative[k] |= Bits{(choices[first + lane] >> k) & 1} << lane;
        }
        // A value of the stack is a truth; the region, if there is one yet, lies below them all.
        std::array<Bits, kTapeStack> stack;
        std::size_t top = 0;
        std::array<Bits, kPlanes> region{};
        for (std::size_t i = 0; i < length; ++i) {
            const std::uint32_t word = words[i];
            const std::uint32_t operation = tape_operation(word);
            if (operation == kTapeLiteral) {
                const auto at = static_cast<std::size_t>(
                    std::lower_bound(surfaces.begin(), surfaces.end(), tape_surface(word)) -
                    surfaces.begin());
                const Bits inside = signs[at] == 0  ? negative[static_cast<std::size_t>(rank_[at])]
                                    : signs[at] < 0 ? ~Bits{0}
                                                    : Bits{0};
                stack[top++] = tape_negated(word) != 0 ? ~inside : inside;
                continue;
            }
            const Bits a = stack[--top];
            if (operation == kTapeAnd || operation == kTapeOr) {
                Bits& b = stack[top - 1];
                b = operation == kTapeAnd ? a & b : a | b;
                continue;
            }
            const auto chosen = static_cast<std::uint32_t>(tape_region(word));
            const auto otherwise = static_cast<std::uint32_t>(tape_otherwise(word));
            for (std::size_t plane = 0; plane < kPlanes; ++plane) {
                Bits rest = region[plane];
                if (operation == kTapeSelectConst)
                    rest = ((otherwise >> plane) & 1) != 0 ? ~Bits{0} : Bits{0};
                region[plane] = (((chosen >> plane) & 1) != 0 ? a : Bits{0}) | (rest & ~a);
            }
        }
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            std::uint32_t number = 0;
            for (std::size_t plane = 0; plane < kPlanes; ++plane)
                number |= static_cast<std::uint32_t>((region[plane] >> lane) & 1) << plane;
            region_[first + lane] = static_cast<std::uint16_t>(number);
        }
    }
}

std::pair<bool, int> Arrangement::side(std::size_t free) const {
    const std::uint32_t bit = std::uint32_t{1} << free;
    bool below = false;
    bool above = false;
    bool between = false;
    for (std::size_t i = 0; i < choices_.size(); ++i) {
        if ((choices_[i] & bit) == 0) continue;
        const auto other = std::lower_bound(choices_.begin(), choices_.end(), choices_[i] ^ bit);
        if (other == choices_.end() || *other != (choices_[i] ^ bit)) continue;
        const std::uint16_t inside = region_[i];
        const std::uint16_t outside = region_[static_cast<std::size_t>(other - choices_.begin())];
        if (inside == outside) continue;
        below = below || outside == 0;
        above = above || inside == 0;
        between = between || (inside != 0 && outside != 0);
    }
    return {below || above || between, between || below == above ? 0 : below ? 1 : -1};
}

bool Arrangement::is_one_region() const {
    std::uint16_t only = 0;
    for (const std::uint16_t region : region_) {
        if (region == 0) continue;
        if (only != 0 && region != only) return false;
        only = region;
    }
    return true;
}

}  // namespace mortise::sizing
