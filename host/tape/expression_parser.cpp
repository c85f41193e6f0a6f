#include "host/tape/expression_parser.hpp"

#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>
#include <vector>

#include "host/common/constants.hpp"
#include "host/common/words.hpp"

namespace mortise::tape {
namespace {

constexpr int kMaxDepth = 1000;
constexpr std::uint32_t kNoOperand = 0xffffffffu;

struct Function {
    std::int32_t operation;
    int least;  ///< number of arguments
    int most;   ///< -1: any
};

constexpr std::int32_t kMix = -1;
constexpr std::int32_t kReciprocal = -2;
constexpr std::int32_t kClamp = -3;
constexpr std::int32_t kPow = -4;

const std::map<std::string, Function>& functions() {
    static const std::map<std::string, Function> kFunctions = {
        {"neg", {kExprNegate, 1, 1}},    {"abs", {kExprAbs, 1, 1}},     {"sqrt", {kExprSqrt, 1, 1}},
        {"square", {kExprSquare, 1, 1}}, {"min", {kExprMin, 1, -1}},    {"max", {kExprMax, 1, -1}},
        {"sin", {kExprSin, 1, 1}},       {"cos", {kExprCos, 1, 1}},     {"exp", {kExprExp, 1, 1}},
        {"log", {kExprLog, 1, 1}},       {"ln", {kExprLog, 1, 1}},      {"tan", {kExprTan, 1, 1}},
        {"asin", {kExprAsin, 1, 1}},     {"acos", {kExprAcos, 1, 1}},   {"atan", {kExprAtan, 1, 1}},
        {"floor", {kExprFloor, 1, 1}},   {"ceil", {kExprCeil, 1, 1}},   {"round", {kExprRound, 1, 1}},
        {"sign", {kExprSign, 1, 1}},     {"not", {kExprNot, 1, 1}},     {"atan2", {kExprAtan2, 2, 2}},
        {"mod", {kExprMod, 2, 2}},       {"hypot", {kExprHypot, 2, 2}}, {"compare", {kExprCompare, 2, 2}},
        {"and", {kExprAnd, 2, 2}},       {"or", {kExprOr, 2, 2}},       {"mix", {kMix, 3, 3}},
        {"recip", {kReciprocal, 1, 1}},  {"clamp", {kClamp, 3, 3}},     {"pow", {kPow, 2, 2}}};
    return kFunctions;
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_name_start(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

class Parser {
  public:
    Parser(const std::string& text, const std::string& source, SourceLocation where)
        : text_(text), source_(source), where_(where) {}

    Formula run() {
        for (;;) {
            skip_space();
            const std::size_t start = position_;
            const std::string name = take_name();
            if (name.empty() || !accept('=')) {
                position_ = start;
                break;
            }
            define(name, start);
        }
        formula_.root = sum(0);
        accept(';');
        skip_space();
        if (position_ != text_.size()) fail("an operator or the end of the formula");
        return std::move(formula_);
    }

  private:
    /// `found` and `hint` (`; did you mean ...`): default to the character here and nothing.
    [[noreturn]] void fail(const std::string& expected, std::string found = {},
                           const std::string& hint = {}) const {
        if (found.empty() && position_ == text_.size()) found = "the end";
        if (found.empty()) {
            const auto c = static_cast<unsigned char>(text_[position_]);
            found =
                c >= ' ' && c < 127 ? std::string("'") + text_[position_] + "'" : "byte " + std::to_string(c);
        }
        std::string place;
        if (where_.line == 0) {
            place = "formula \"" + text_.substr(0, 60) + "\", column " + std::to_string(position_ + 1) + ": ";
        } else {
            SourceLocation at = where_;
            for (std::size_t i = 0; i < position_; ++i) {
                ++at.column;
                if (text_[i] == '\n') at = {at.line + 1, 1};
            }
            place = source_ + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) + ": formula: ";
        }
        throw Error(ExitCode::kInput, place + "expected " + expected + ", found " + found + hint);
    }

    void skip_space() {
        for (; position_ < text_.size(); ++position_) {
            if (text_[position_] == '#') {
                while (position_ < text_.size() && text_[position_] != '\n') ++position_;
                if (position_ == text_.size()) return;
            }
            if (!std::isspace(static_cast<unsigned char>(text_[position_]))) return;
        }
    }

    bool accept(char c) {
        skip_space();
        if (position_ >= text_.size() || text_[position_] != c) return false;
        ++position_;
        return true;
    }

    std::string take_name() {
        const std::size_t start = position_;
        if (position_ < text_.size() && is_name_start(text_[position_])) {
            while (position_ < text_.size() &&
                   (is_name_start(text_[position_]) || is_digit(text_[position_])))
                ++position_;
        }
        return text_.substr(start, position_ - start);
    }

    void define(const std::string& name, std::size_t start) {
        if (name == "x" || name == "y" || name == "z" || name == "pi" || functions().count(name) > 0) {
            position_ = start;
            fail("a new name before '='; " + name + " has a meaning already");
        }
        const std::uint32_t value = sum(0);
        if (!accept(';')) fail("an operator or ';' after the definition of " + name);
        names_[name] = value;
    }

    std::uint32_t sum(int depth) {
        if (depth > kMaxDepth) fail("at most 1000 nested parentheses");
        std::uint32_t left = product(depth);
        for (;;) {
            if (accept('+'))
                left = formula_.add(kExprAdd, left, product(depth));
            else if (accept('-'))
                left = formula_.add(kExprSubtract, left, product(depth));
            else
                return left;
        }
    }

    std::uint32_t product(int depth) {
        std::uint32_t left = unary(depth);
        for (;;) {
            if (accept('*'))
                left = formula_.add(kExprMultiply, left, unary(depth));
            else if (accept('/'))
                left = formula_.add(kExprDivide, left, unary(depth));
            else
                return left;
        }
    }

    std::uint32_t unary(int depth) {
        if (depth > kMaxDepth) fail("at most 1000 nested powers");
        bool negative = false;
        for (;;) {
            if (accept('-'))
                negative = !negative;
            else if (!accept('+'))
                break;
        }
        const std::uint32_t value = power(depth);
        return negative ? formula_.add(kExprNegate, value) : value;
    }

    std::uint32_t power(int depth) {
        const std::uint32_t base = atom(depth);
        if (!accept('^')) return base;
        return formula_.add_power(base, unary(depth + 1));  // from the right, with its own sign
    }

    std::uint32_t atom(int depth) {
        skip_space();
        if (accept('(')) {
            const std::uint32_t value = sum(depth + 1);
            if (!accept(')')) fail("')'");
            return value;
        }
        if (position_ < text_.size() && (is_digit(text_[position_]) || text_[position_] == '.')) {
            // Of the wider type: one too small for a double is 0.
            const char* begin = text_.data() + position_;
            long double wide = 0;
            const auto result = std::from_chars(begin, text_.data() + text_.size(), wide);
            const bool is_number = result.ec == std::errc();
            double value = 0;
            if (is_number && std::from_chars(begin, result.ptr, value).ec != std::errc()) {
                value = static_cast<double>(wide);
            }
            if (!is_number || !std::isfinite(value)) fail("a finite number");
            position_ += static_cast<std::size_t>(result.ptr - begin);
            return formula_.add_constant(value);
        }
        const std::size_t start = position_;
        const std::string name = take_name();
        if (name == "x") return formula_.add(kExprX);
        if (name == "y") return formula_.add(kExprY);
        if (name == "z") return formula_.add(kExprZ);
        if (name == "pi") return formula_.add_constant(kPi);
        const auto defined = names_.find(name);
        if (defined != names_.end()) return defined->second;
        const auto function = functions().find(name);
        if (function == functions().end()) {
            position_ = start;
            std::string list;
            std::vector<std::string_view> known = {"pi"};
            for (const auto& [known_name, unused] : functions()) {
                list += " " + known_name;
                known.push_back(known_name);
            }
            for (const auto& [known_name, unused] : names_) known.push_back(known_name);
            fail("a number, x, y, z, pi, '(', a name defined before or one of the functions" + list,
                 name.empty() ? name : "'" + excerpt(name) + "'", nearest_hint(name, known));
        }
        return call(name, function->second, depth);
    }

    std::uint32_t call(const std::string& name, const Function& function, int depth) {
        if (!accept('(')) fail("'(' after " + name);
        std::vector<std::uint32_t> arguments = {sum(depth + 1)};
        const auto count = [&arguments] { return static_cast<int>(arguments.size()); };
        while (function.most < 0 || count() < function.most) {
            if (!accept(',')) break;
            arguments.push_back(sum(depth + 1));
        }
        if (count() < function.least)
            fail("',' and " + std::to_string(function.least) + " arguments of " + name);
        if (!accept(')')) fail("')'");
        const std::uint32_t a = arguments[0];
        const std::uint32_t b = arguments.size() > 1 ? arguments[1] : kNoOperand;
        const std::uint32_t c = arguments.size() > 2 ? arguments[2] : kNoOperand;
        switch (function.operation) {
            case kMix:
                return formula_.add(kExprAdd, a,
                                    formula_.add(kExprMultiply, c, formula_.add(kExprSubtract, b, a)));
            case kReciprocal: return formula_.add(kExprDivide, formula_.add_constant(1), a);
            case kClamp: return formula_.add(kExprMin, formula_.add(kExprMax, a, b), c);
            case kPow: return formula_.add_power(a, b);
            default: break;
        }
        if (function.most == 1) return formula_.add(function.operation, a);
        std::uint32_t value = a;
        for (std::size_t i = 1; i < arguments.size(); ++i)
            value = formula_.add(function.operation, value, arguments[i]);
        return value;
    }

    const std::string& text_;
    const std::string& source_;
    SourceLocation where_;
    std::size_t position_ = 0;
    std::map<std::string, std::uint32_t> names_;
    Formula formula_;
};

}  // namespace

Formula parse_formula(const std::string& text, const std::string& source, SourceLocation where) {
    return Parser(text, source, where).run();
}

}  // namespace mortise::tape
