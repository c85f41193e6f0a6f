// Words of model files in error messages.
#pragma once

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/common/lower_case.hpp"

namespace mortise {

/// The start of a text from a file, for messages: without control characters, "..." where it was cut.
inline std::string excerpt(std::string_view text) {
    constexpr std::size_t kLongest = 40;
    std::string result(text.substr(0, kLongest));
    for (char& c : result) {
        if ((c >= 0 && c < ' ') || c == 0x7f) c = ' ';
    }
    return text.size() > kLongest ? result + "..." : result;
}

/// A message with what is no word any more (10 MB without a blank) cut.
inline std::string with_short_words(const std::string& message) {
    constexpr std::size_t kLongest = 400;  // paths stay whole
    std::string result;
    for (std::size_t first = 0; first < message.size();) {
        const std::size_t last = std::min(message.find(' ', first), message.size() - 1) + 1;
        const std::string_view word = std::string_view(message).substr(first, last - first);
        if (word.size() > kLongest) {
            // With what ends it: a quote, a comma, the blank.
            std::size_t end = word.size();
            while (end > word.size() - 4 && std::isalnum(static_cast<unsigned char>(word[end - 1])) == 0)
                --end;
            result += excerpt(word) + std::string(word.substr(end));
        } else {
            result += word;
        }
        first = last;
    }
    return result;
}

/// "; did you mean 'sphere'?" for the known word that is nearest to this one; empty if none is near.
inline std::string nearest_hint(std::string_view word, const std::vector<std::string_view>& known) {
    constexpr std::size_t kLongest = 40;
    if (word.empty() || word.size() > kLongest) return {};
    std::string_view best;
    std::size_t fewest = std::max<std::size_t>(1, std::min<std::size_t>(3, word.size() / 3)) + 1;
    for (const std::string_view other : known) {
        // Changes between their starts, row by row: insertions, deletions, replacements, swaps of neighbours.
        std::vector<std::size_t> row(other.size() + 1);
        std::iota(row.begin(), row.end(), std::size_t{0});
        std::vector<std::size_t> above, second;
        for (std::size_t i = 1; i <= word.size(); ++i) {
            second = std::move(above);
            above = row;
            row[0] = i;
            for (std::size_t j = 1; j <= other.size(); ++j) {
                const bool equal = lower_case(word[i - 1]) == lower_case(other[j - 1]);
                row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (equal ? 0 : 1)});
                const bool swapped =
                    i > 1 && j > 1 && word[i - 1] == other[j - 2] && word[i - 2] == other[j - 1];
                if (swapped) row[j] = std::min(row[j], second[j - 2] + 1);
            }
        }
        if (row.back() >= fewest) continue;
        fewest = row.back();
        best = other;
    }
    return best.empty() ? std::string() : "; did you mean '" + std::string(best) + "'?";
}

}  // namespace mortise
