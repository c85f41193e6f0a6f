// A cursor over the text of a model file, shared by all readers: places, numbers and error messages.
//
// Columns count bytes. A cursor is small: copy it to look ahead.
#pragma once

#include <string>
#include <string_view>

#include "host/common/words.hpp"
#include "mortise/error.hpp"

namespace mortise::model_reader {

/// The shortest text that reads back as the same number.
std::string number_text(double value);

/// "source:line:column: "
std::string place_text(const std::string& source, SourceLocation where);

/// Throws Error(kInput) with the place in front of the message.
[[noreturn]] void fail(const std::string& source, SourceLocation where, const std::string& message);

inline bool is_digit(char c) { return c >= '0' && c <= '9'; }
inline bool is_name_start(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
inline bool is_name_part(char c) { return is_name_start(c) || is_digit(c); }

class TextCursor {
  public:
    /// Both texts outlive the cursor. A byte order mark at the start is skipped.
    TextCursor(std::string_view text, const std::string& source);

    bool at_end() const { return at_ == end_; }
    char peek() const { return at_ == end_ ? '\0' : *at_; }
    char peek_next() const { return end_ - at_ < 2 ? '\0' : at_[1]; }
    /// Steps over one byte, counting lines.
    void advance() {
        if (*at_ == '\n') {
            ++line_;
            line_begin_ = at_ + 1;
        }
        ++at_;
    }
    SourceLocation where() const { return {line_, static_cast<std::uint32_t>(at_ - line_begin_) + 1}; }
    std::size_t offset() const { return static_cast<std::size_t>(at_ - begin_); }
    /// The text from here to a later cursor over the same text.
    std::string_view text_until(const TextCursor& later) const {
        return {at_, static_cast<std::size_t>(later.at_ - at_)};
    }

    void skip_blanks() {
        while (at_ != end_ && (*at_ == ' ' || (*at_ >= '\t' && *at_ <= '\r'))) advance();
    }

    /// The rest of the current line, without its end; leaves the cursor at the line's end.
    std::string_view take_line();
    /// The longest run of name characters from here; may be empty.
    std::string_view take_name();
    /// The longest run of visible ASCII characters from here; may be empty.
    std::string_view take_word();
    /// Reads an unsigned decimal number; fails unless one starts here. A number too large for a double
    /// fails, one too small is 0.
    double take_number();

    /// What stands at the cursor, for messages: "'foo'", "end of file", "byte 0x89 (is this a text file?)".
    std::string found() const;
    [[noreturn]] void fail_here(const std::string& message) const { fail(*source_, where(), message); }
    const std::string& source() const { return *source_; }

  private:
    const std::string* source_;
    const char* begin_;
    const char* at_;
    const char* end_;
    const char* line_begin_;
    std::uint32_t line_ = 1;
};

}  // namespace mortise::model_reader
