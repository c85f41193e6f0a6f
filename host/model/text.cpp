// The text cursor of text.hpp.
#include "host/model/text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

namespace mortise::model_reader {

std::string number_text(double value) {
    std::array<char, 32> buffer{};
    const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
    return std::string(buffer.data(), result.ptr);
}

std::string excerpt(std::string_view text) {
    constexpr std::size_t kLongest = 40;
    std::string result(text.substr(0, kLongest));
    for (char& c : result) {
        if ((c >= 0 && c < ' ') || c == 0x7f) c = ' ';
    }
    return text.size() > kLongest ? result + "..." : result;
}

std::string nearest_hint(std::string_view word, const std::vector<std::string_view>& known) {
    constexpr std::size_t kLongest = 40;
    if (word.empty() || word.size() > kLongest) return {};
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; };
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
                const bool equal = lower(word[i - 1]) == lower(other[j - 1]);
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

std::string place_text(const std::string& source, SourceLocation where) {
    return source + ":" + std::to_string(where.line) + ":" + std::to_string(where.column) + ": ";
}

void fail(const std::string& source, SourceLocation where, const std::string& message) {
    throw Error(ExitCode::kInput, place_text(source, where) + message);
}

TextCursor::TextCursor(std::string_view text, const std::string& source)
    : source_(&source), begin_(text.data()), at_(begin_), end_(begin_ + text.size()), line_begin_(begin_) {
    if (text.substr(0, 3) == "\xEF\xBB\xBF") {
        at_ += 3;
        line_begin_ = at_;
    }
}

std::string_view TextCursor::take_line() {
    const char* first = at_;
    while (at_ != end_ && *at_ != '\n' && *at_ != '\r') ++at_;
    return {first, static_cast<std::size_t>(at_ - first)};
}

std::string_view TextCursor::take_name() {
    const char* first = at_;
    while (at_ != end_ && is_name_part(*at_)) ++at_;
    return {first, static_cast<std::size_t>(at_ - first)};
}

std::string_view TextCursor::take_word() {
    const char* first = at_;
    while (at_ != end_ && *at_ > ' ' && *at_ < 0x7f) ++at_;
    return {first, static_cast<std::size_t>(at_ - first)};
}

double TextCursor::take_number() {
    if (!is_digit(peek()) && peek() != '.') fail_here("expected a number, found " + found());
    double value = 0;
    auto result = std::from_chars(at_, end_, value);
    if (result.ec == std::errc::result_out_of_range) {
        // Too large or too small: the wider type tells which.
        long double wide = 0;
        result = std::from_chars(at_, end_, wide);
        const bool too_large =
            result.ec != std::errc() || wide > static_cast<long double>(std::numeric_limits<double>::max());
        if (too_large) {
            fail_here("the number " + found() + " is too large; expected a finite double-precision number");
        }
        value = static_cast<double>(wide);
    } else if (result.ec != std::errc()) {
        fail_here("expected a number, found " + found());
    }
    if (result.ptr != end_ && (is_name_part(*result.ptr) || *result.ptr == '.')) {
        fail_here("malformed number " + found());
    }
    at_ = result.ptr;
    return value;
}

std::string TextCursor::found() const {
    if (at_end()) return "end of file";
    if (*at_ == '\n' || *at_ == '\r') return "the end of the line";
    const auto byte = static_cast<unsigned char>(*at_);
    if (byte < 0x20 || byte >= 0x7f) {
        std::array<char, 48> buffer{};
        std::snprintf(buffer.data(), buffer.size(), "byte 0x%02x (is this a text file?)", byte);
        return buffer.data();
    }
    constexpr std::ptrdiff_t kLongest = 30;
    const char* last = at_;
    while (last != end_ && last - at_ < kLongest && (is_name_part(*last) || *last == '.')) ++last;
    if (last == at_) ++last;
    return "'" + std::string(at_, last) + "'";
}

}  // namespace mortise::model_reader
