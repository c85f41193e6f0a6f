// Lexer of Netgen's .geo files: names are case-sensitive, '#' starts a comment, a sign is a token of its own.
#include "host/model/geo/geo_lexer.hpp"

namespace mortise::model_reader {
namespace {

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
    while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
    return text;
}

}  // namespace

GeoLexer::GeoLexer(std::string_view text, const std::string& source) : cursor_(text, source) { next(); }

void GeoLexer::next() {
    const std::uint32_t line = cursor_.where().line;
    trailing_comment_ = {};
    while (true) {
        cursor_.skip_blanks();
        if (cursor_.peek() != '#') break;
        const bool same_line = cursor_.where().line == line;
        cursor_.advance();
        const std::string_view comment = cursor_.take_line();
        if (same_line) trailing_comment_ = trimmed(comment);
    }
    token_ = GeoToken{};
    token_.where = cursor_.where();
    if (cursor_.at_end()) return;
    const char c = cursor_.peek();
    if (is_name_start(c)) {
        token_.kind = GeoToken::Kind::kName;
        token_.text = cursor_.take_name();
    } else if (is_digit(c) || c == '.') {
        const TextCursor start = cursor_;
        token_.kind = GeoToken::Kind::kNumber;
        token_.number = cursor_.take_number();
        token_.text = start.text_until(cursor_);
    } else if (std::string_view("()[]-+=,;").find(c) != std::string_view::npos) {
        const TextCursor start = cursor_;
        token_.kind = GeoToken::Kind::kSymbol;
        cursor_.advance();
        token_.text = start.text_until(cursor_);
    } else {
        cursor_.fail_here("unexpected " + cursor_.found() +
                          "; expected Netgen geometry (names, numbers and ()[]-=,;)");
    }
}

void GeoLexer::take_symbol(char c, std::string_view what) {
    if (!is_symbol(c)) fail_expected("'" + std::string(1, c) + "' " + std::string(what));
    next();
}

bool GeoLexer::take_word(std::string_view word) {
    if (!is_word(word)) return false;
    next();
    return true;
}

std::string_view GeoLexer::take_name(std::string_view what) {
    if (token_.kind != GeoToken::Kind::kName) fail_expected(what);
    const std::string_view name = token_.text;
    next();
    return name;
}

double GeoLexer::take_number(std::string_view what) {
    bool negative = false;
    while (is_symbol('-') || is_symbol('+')) {
        if (is_symbol('-')) negative = !negative;
        next();
    }
    if (token_.kind != GeoToken::Kind::kNumber) fail_expected(what);
    const double number = token_.number;
    next();
    return negative ? -number : number;
}

Vec3 GeoLexer::take_vector(std::string_view what) {
    Vec3 result{};
    for (std::size_t k = 0; k < 3; ++k) {
        // Messages are made where they are needed only: files hold millions of vectors.
        if (k > 0 && !is_symbol(',')) fail_expected("',' between the coordinates of " + std::string(what));
        if (k > 0) next();
        const bool is_number = token_.kind == GeoToken::Kind::kNumber || is_symbol('-') || is_symbol('+');
        if (!is_number) fail_expected("a coordinate of " + std::string(what));
        result[k] = take_number("a number");
    }
    return result;
}

std::vector<GeoFlag> GeoLexer::take_flags() {
    std::vector<GeoFlag> flags;
    while (is_symbol('-')) {
        GeoFlag flag;
        flag.where = token_.where;
        next();
        flag.name = take_name("the name of a flag after '-'");
        if (is_symbol('=')) {
            next();
            if (token_.kind == GeoToken::Kind::kName) {
                flag.kind = GeoFlag::Kind::kWord;
                flag.word = take_name("a word");
            } else if (is_symbol('[')) {
                flag.kind = GeoFlag::Kind::kList;
                do {
                    next();
                    if (token_.kind == GeoToken::Kind::kName) {
                        flag.list.emplace_back(take_name("a word"));
                    } else {
                        flag.list.push_back(number_text(
                            take_number("a number or word in the list of -" + std::string(flag.name))));
                    }
                } while (is_symbol(','));
                take_symbol(']', "after the list of -" + std::string(flag.name));
            } else {
                flag.kind = GeoFlag::Kind::kNumber;
                flag.number = take_number("a number, word or list for -" + std::string(flag.name));
            }
        }
        flags.push_back(flag);
    }
    return flags;
}

std::string GeoLexer::found() const {
    if (at_end()) return "end of file";
    return "'" + excerpt(token_.text) + "'";
}

void GeoLexer::fail_expected(std::string_view what) const {
    fail(source(), token_.where, "expected " + std::string(what) + ", found " + found());
}

}  // namespace mortise::model_reader
