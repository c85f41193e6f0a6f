// Tokens and flags of Netgen's .geo files, one token ahead.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host/model/text.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

struct GeoToken {
    enum class Kind : std::uint8_t { kEnd, kName, kNumber, kSymbol };
    Kind kind = Kind::kEnd;
    std::string_view text;  ///< kName: the name; kSymbol: one character
    double number = 0;      ///< kNumber
    SourceLocation where;
};

/// "-name", "-name=word", "-name=1.5" or "-name=[...]".
struct GeoFlag {
    enum class Kind : std::uint8_t { kNone, kWord, kNumber, kList };
    std::string_view name;
    Kind kind = Kind::kNone;
    std::string_view word;
    double number = 0;
    std::vector<std::string> list;  ///< kList: words and numbers as text
    SourceLocation where;
};

class GeoLexer {
  public:
    GeoLexer(std::string_view text, const std::string& source);

    const GeoToken& token() const { return token_; }
    void next();
    bool is_symbol(char c) const { return token_.kind == GeoToken::Kind::kSymbol && token_.text[0] == c; }
    bool is_word(std::string_view word) const {
        return token_.kind == GeoToken::Kind::kName && token_.text == word;
    }
    bool at_end() const { return token_.kind == GeoToken::Kind::kEnd; }

    /// Each of these takes what it names and steps on, or fails; `what` completes "expected ...".
    void take_symbol(char c, std::string_view what);
    bool take_word(std::string_view word);  ///< false: another token; nothing taken
    std::string_view take_name(std::string_view what);
    double take_number(std::string_view what);  ///< an optional sign, then a number
    Vec3 take_vector(std::string_view what);    ///< three numbers with commas
    std::vector<GeoFlag> take_flags();

    /// The comment that followed the last token taken on its line, without '#' and outer blanks.
    std::string_view trailing_comment() const { return trailing_comment_; }

    std::string found() const;
    [[noreturn]] void fail_expected(std::string_view what) const;
    const std::string& source() const { return cursor_.source(); }

  private:
    TextCursor cursor_;
    GeoToken token_;
    std::string_view trailing_comment_;
};

}  // namespace mortise::model_reader
