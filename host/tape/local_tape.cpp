#include "host/tape/local_tape.hpp"

#include <algorithm>

#include "host/common/sort_unique.hpp"
#include "kernels/shared/tape.h"

namespace mortise::tape {
namespace {

/// Bit i of entry k: whether the k-th open surface is inside in case i.
constexpr std::uint64_t kCases[LocalTape::kMaxCases] = {0xaaaaaaaaaaaaaaaaULL, 0xccccccccccccccccULL,
                                                        0xf0f0f0f0f0f0f0f0ULL, 0xff00ff00ff00ff00ULL,
                                                        0xffff0000ffff0000ULL, 0xffffffff00000000ULL};

}  // namespace

void list_surfaces(const std::uint32_t* words, std::size_t length, std::vector<std::uint32_t>& surfaces) {
    surfaces.clear();
    for (std::size_t i = 0; i < length; ++i) {
        if (tape_operation(words[i]) == kTapeLiteral) surfaces.push_back(tape_surface(words[i]));
    }
    sort_unique(surfaces);
}

void LocalTape::load(const std::uint32_t* words, std::size_t length,
                     const std::vector<std::uint32_t>& surfaces) {
    words_.clear();
    constant_ = kNotConstant;
    surface_count_ = surfaces.size();
    occurs_.assign(surface_count_, 0);
    std::size_t selects = 0;
    for (std::size_t i = 0; i < length; ++i) {
        Word word{};
        word.operation = static_cast<std::uint8_t>(tape_operation(words[i]));
        if (word.operation == kTapeLiteral) {
            word.negated = tape_negated(words[i]) != 0;
            word.surface = static_cast<std::uint32_t>(
                std::lower_bound(surfaces.begin(), surfaces.end(), tape_surface(words[i])) -
                surfaces.begin());
            occurs_[word.surface] = 1;
        } else {
            word.region = static_cast<std::uint16_t>(tape_region(words[i]));
            word.otherwise = static_cast<std::uint16_t>(tape_otherwise(words[i]));
            if (word.operation == kTapeSelect || word.operation == kTapeSelectConst) ++selects;
        }
        words_.push_back(word);
    }
    one_region_ = selects == 1 && words_.back().operation == kTapeSelectConst;
}

void LocalTape::load_constant(std::int32_t region) {
    words_.clear();
    surface_count_ = 0;
    constant_ = region;
}

std::int32_t LocalTape::evaluate(const std::int8_t* signs) const {
    std::int32_t stack[kTapeStack];
    int top = -1;
    for (const Word& word : words_) {
        if (word.operation == kTapeLiteral) {
            const std::int8_t sign = signs[word.surface];
            stack[++top] = sign == 0 ? kUnknown : ((sign < 0) != word.negated ? 1 : 0);
        } else if (word.operation == kTapeSelectConst) {
            stack[top] = combine_select(word.otherwise, stack[top], word.region);
        } else {
            const std::int32_t b = stack[top--];
            const std::int32_t a = stack[top];
            stack[top] = word.operation == kTapeAnd  ? combine_and(a, b)
                         : word.operation == kTapeOr ? combine_or(a, b)
                                                     : combine_select(a, b, word.region);
        }
    }
    return stack[top];
}

/// The truth value that the only select of the tape takes, in all 2^count cases at once, one bit each.
std::uint64_t LocalTape::cases(const std::int8_t* signs, const std::size_t* open, std::size_t count) const {
    std::uint64_t stack[kTapeStack];
    int top = -1;
    for (const Word& word : words_) {
        if (word.operation == kTapeLiteral) {
            std::uint64_t inside = signs[word.surface] < 0 ? ~std::uint64_t{0} : 0;
            for (std::size_t k = 0; k < count; ++k) {
                if (open[k] == word.surface) inside = kCases[k];
            }
            stack[++top] = word.negated ? ~inside : inside;
        } else if (word.operation != kTapeSelectConst) {
            const std::uint64_t b = stack[top--];
            stack[top] = word.operation == kTapeAnd ? stack[top] & b : stack[top] | b;
        }
    }
    return stack[top];
}

std::int32_t LocalTape::resolve(const std::int8_t* signs) const {
    if (constant_ != kNotConstant) return constant_;
    const std::int32_t direct = evaluate(signs);
    if (direct != kUnknown) return direct;
    std::size_t open[kMaxCases];
    std::size_t count = 0;
    for (std::size_t s = 0; s < surface_count_; ++s) {
        if (signs[s] != 0 || occurs_[s] == 0) continue;
        if (count == kMaxCases) return kUnknown;
        open[count++] = s;
    }
    if (one_region_) {
        const std::uint64_t inside = cases(signs, open, count);
        if (inside == ~std::uint64_t{0}) return words_.back().region;
        return inside == 0 ? words_.back().otherwise : kUnknown;
    }
    std::vector<std::int8_t> trial(signs, signs + surface_count_);
    std::int32_t common = kUnknown;
    for (std::size_t choice = 0; choice < (std::size_t{1} << count); ++choice) {
        for (std::size_t k = 0; k < count; ++k) trial[open[k]] = ((choice >> k) & 1) != 0 ? 1 : -1;
        const std::int32_t value = evaluate(trial.data());
        if (choice == 0)
            common = value;
        else if (value != common)
            return kUnknown;
    }
    return common;
}

bool LocalTape::depends_on(std::size_t surface, const std::int8_t* signs) const {
    if (constant_ != kNotConstant || occurs_[surface] == 0) return false;
    std::size_t open[kMaxCases];
    std::size_t count = 0;
    open[count++] = surface;
    for (std::size_t s = 0; s < surface_count_; ++s) {
        if (signs[s] != 0 || occurs_[s] == 0 || s == surface) continue;
        if (count == kMaxCases) return true;
        open[count++] = s;
    }
    if (one_region_) {
        if (words_.back().region == words_.back().otherwise) return false;
        const std::uint64_t inside = cases(signs, open, count);
        return ((inside ^ (inside >> 1)) & ~kCases[0]) != 0;
    }
    std::vector<std::int8_t> trial(signs, signs + surface_count_);
    for (std::size_t choice = 0; choice < (std::size_t{1} << count); choice += 2) {
        for (std::size_t k = 1; k < count; ++k) trial[open[k]] = ((choice >> k) & 1) != 0 ? 1 : -1;
        trial[surface] = -1;
        const std::int32_t inside = evaluate(trial.data());
        trial[surface] = 1;
        if (evaluate(trial.data()) != inside) return true;
    }
    return false;
}

std::size_t LocalTape::settled_by(std::size_t surface, const std::uint8_t* asked) const {
    std::vector<std::int8_t> signs(surface_count_, 0);
    std::size_t settled = 0;
    for (const std::int8_t sign : {std::int8_t{-1}, std::int8_t{1}}) {
        signs[surface] = sign;
        for (std::size_t s = 0; s < surface_count_; ++s) {
            if (s == surface || asked[s] == 0 || occurs_[s] == 0) continue;
            settled += depends_on(s, signs.data()) ? 0 : 1;
        }
    }
    return settled;
}

}  // namespace mortise::tape
