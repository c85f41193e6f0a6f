// The text cursor of text.hpp.
#include "host/model/text.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>

namespace mortise::model_reader {

std::string number_text(double value) {
    std::array<char, 32> buffer{};
    const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
    return std::string(buffer.data(), result.ptr);
}

std::string place_text(const std::string& source, SourceLocation where) {
    return source + ":" + std::to_string(where.line) + ":" + std::to_string(where.column) + ": ";
}

void fail(const std::string& source, SourceLocation where, const std::string& message) {
    throw Error(ExitCode::kInput, place_text(source, where) + with_short_words(message));
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
    const char* last = at_;
    // With the sign of an exponent.
    long double ignored = 0;
    if (is_digit(*at_) || *at_ == '.') last = std::from_chars(at_, end_, ignored).ptr;
    while (last != end_ && (is_name_part(*last) || *last == '.')) ++last;
    if (last == at_) ++last;
    return "'" + excerpt({at_, static_cast<std::size_t>(last - at_)}) + "'";
}

}  // namespace mortise::model_reader
