#include "host/formula/expression_parser.hpp"

#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>
#include <vector>

#include "host/common/constants.hpp"
#include "host/common/lower_case.hpp"
#include "host/common/words.hpp"
#include "host/formula/functions.hpp"

namespace mortise::formula {
namespace {

constexpr int kMaxDepth = 1000;

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
        if (position_ != text_.size()) fail("an operator or the end of the formula", operator_hint());
        return std::move(formula_);
    }

  private:
    struct Definition {
        std::uint32_t value;
        std::size_t position;  ///< of the name
    };

    /// "source:line:column: formula: " of a position; without a line the formula's beginning and the column.
    std::string place(std::size_t position) const {
        if (where_.line == 0) {
            return (source_.empty() ? "" : source_ + ": ") + "formula \"" + excerpt(text_) + "\", column " +
                   std::to_string(position + 1) + ": ";
        }
        const SourceLocation at = location(position);
        return source_ + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) + ": formula: ";
    }

    SourceLocation location(std::size_t position) const {
        SourceLocation at = where_;
        for (std::size_t i = 0; i < position; ++i) {
            ++at.column;
            if (text_[i] == '\n') at = {at.line + 1, 1};
        }
        return at;
    }

    [[noreturn]] void refuse(std::size_t position, const std::string& message) const {
        throw Error(ExitCode::kInput, place(position) + message);
    }

    /// The name, number or character here.
    std::string_view token() const {
        const char* first = text_.data() + position_;
        const char* const end = text_.data() + text_.size();
        const char* last = first;
        long double ignored = 0;
        if (first != end && (is_digit(*first) || *first == '.'))
            last = std::from_chars(first, end, ignored).ptr;
        while (last != end && (is_name_start(*last) || is_digit(*last) || *last == '.')) ++last;
        if (last == first && first != end) ++last;
        return {first, static_cast<std::size_t>(last - first)};
    }

    std::string found() const {
        if (position_ == text_.size()) return "the end";
        const auto c = static_cast<unsigned char>(text_[position_]);
        const bool is_visible = c > ' ' && c < 127;
        return is_visible ? "'" + excerpt(token()) + "'" : "byte " + std::to_string(c);
    }

    /// `hint`: "; did you mean ...".
    [[noreturn]] void fail(const std::string& expected, const std::string& hint = {}) const {
        refuse(position_, "expected " + expected + ", found " + found() + hint);
    }

    /// Where a line "bounds ..." of a .formula file may be meant: formulas in others start later.
    std::string bounds_hint() const {
        if (where_.line != 1 || where_.column != 1) return {};
        const std::string_view word = token();
        if (word != "bounds" && nearest_hint(word, {"bounds"}).empty()) return {};
        return "; bounds need a line of their own: bounds x0 y0 z0 x1 y1 z1";
    }

    /// What to write instead of the operator of another language that is here.
    std::string operator_hint() const {
        switch (position_ < text_.size() ? text_[position_] : ' ') {
            case '<':
            case '>':
            case '=': return "; the solid is where the formula is at most 0: instead of a < b write a - b";
            case '&': return "; write max(a, b) for what is in both";
            case '|': return "; write min(a, b) for what is in either";
            case '%': return "; write mod(a, b)";
            case '?': return "; write min, max or mix for a choice";
            default: return bounds_hint();
        }
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

    bool is_next(char c) {
        skip_space();
        return position_ < text_.size() && text_[position_] == c;
    }

    bool accept(char c) {
        if (!is_next(c)) return false;
        ++position_;
        return true;
    }

    /// Python's ^.
    bool accept_power() {
        if (text_.compare(position_, 2, "**") != 0) return false;
        position_ += 2;
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
        const std::string quoted = "'" + excerpt(name) + "'";
        if (name == "x" || name == "y" || name == "z" || name == "pi")
            refuse(start, quoted + " has a meaning already; expected a new name before '='");
        const auto before = names_.find(name);
        if (before != names_.end()) {
            const std::size_t first = before->second.position;
            refuse(start, quoted + " is defined twice, first in " +
                              (where_.line == 0 ? "column " + std::to_string(first + 1)
                                                : "line " + std::to_string(location(first).line)) +
                              "; choose another name");
        }
        const std::uint32_t value = sum(0);
        if (!accept(';'))
            fail("an operator or ';' after the definition of " + excerpt(name), operator_hint());
        names_[name] = {value, start};
    }

    /// The node, unless it is a constant that is no finite number, from the text since `start`.
    std::uint32_t finite(std::uint32_t node, std::size_t start) const {
        const Formula::Node& made = formula_.nodes()[node];
        if (made.operation == kExprConstant && !std::isfinite(made.constant)) {
            std::string_view text = std::string_view(text_).substr(start, position_ - start);
            text = text.substr(0, text.find_last_not_of(" \t\r\n") + 1);
            refuse(start,
                   "'" + excerpt(text) + "' has no finite value; expected a constant that is a number");
        }
        return node;
    }

    std::uint32_t sum(int depth) {
        if (depth > kMaxDepth) fail("at most 1000 nested parentheses");
        skip_space();
        const std::size_t start = position_;
        std::uint32_t left = product(depth);
        for (;;) {
            if (accept('+'))
                left = formula_.add(kExprAdd, left, product(depth));
            else if (accept('-'))
                left = formula_.add(kExprSubtract, left, product(depth));
            else
                return left;
            finite(left, start);
        }
    }

    std::uint32_t product(int depth) {
        skip_space();
        const std::size_t start = position_;
        std::uint32_t left = unary(depth);
        for (;;) {
            if (accept('*'))
                left = formula_.add(kExprMultiply, left, unary(depth));
            else if (accept('/'))
                left = formula_.add(kExprDivide, left, unary(depth));
            else
                return left;
            finite(left, start);
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
        skip_space();
        const std::size_t start = position_;
        const std::uint32_t base = atom(depth);
        if (!accept('^') && !accept_power()) return base;
        // From the right, with its own sign.
        return finite(formula_.add_power(base, unary(depth + 1)), start);
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
        const auto function = functions().find(name);
        const auto defined = names_.find(name);
        if (defined != names_.end() && (function == functions().end() || !is_next('(')))
            return defined->second.value;
        if (function == functions().end()) {
            position_ = start;
            fail_at_operand(name);
        }
        return finite(call(name, function->second, depth), start);
    }

    /// `name`: what stands here and is unknown, or nothing.
    [[noreturn]] void fail_at_operand(const std::string& name) const {
        std::string list = name.empty() ? " (sin, max, ...)" : ":";
        std::vector<std::string_view> known = {"pi"};
        for (const auto& [function, unused] : functions()) {
            if (!name.empty()) list += " " + function;
            known.push_back(function);
        }
        for (const auto& [defined, unused] : names_) known.push_back(defined);
        // Other single letters are near to them all.
        for (const std::string_view coordinate : {"x", "y", "z"}) {
            if (lower_case(name) == coordinate) known.push_back(coordinate);
        }
        std::string hint = bounds_hint();
        if (hint.empty()) hint = nearest_hint(name, known);
        if (!hint.empty()) list.clear();
        fail("a number, x, y, z, pi, '(', a name defined before or a function" + list, hint);
    }

    [[noreturn]] void fail_in_call(const std::string& name, const Function& function,
                                   const char* expected) const {
        if (function.most < 0) fail(std::string(expected) + " in the arguments of " + name);
        const std::string most =
            function.most == 1 ? "one argument" : std::to_string(function.most) + " arguments";
        refuse(position_,
               name + " takes " +
                   (function.least == function.most ? "" : std::to_string(function.least) + " to ") + most +
                   "; expected " + expected + ", found " + found());
    }

    std::uint32_t call(const std::string& name, const Function& function, int depth) {
        if (!accept('(')) fail("'(' after " + name);
        std::vector<std::uint32_t> arguments = {sum(depth + 1)};
        const auto count = [&arguments] { return static_cast<int>(arguments.size()); };
        while (function.most < 0 || count() < function.most) {
            if (!accept(',')) break;
            arguments.push_back(sum(depth + 1));
        }
        if (count() < function.least) fail_in_call(name, function, "','");
        if (!accept(')')) fail_in_call(name, function, function.most < 0 ? "',' or ')'" : "')'");
        return function.build(formula_, arguments);
    }

    const std::string& text_;
    const std::string& source_;
    SourceLocation where_;
    std::size_t position_ = 0;
    std::map<std::string, Definition> names_;
    Formula formula_;
};

}  // namespace

Formula parse_formula(const std::string& text, const std::string& source, SourceLocation where) {
    return Parser(text, source, where).run();
}

}  // namespace mortise::formula
