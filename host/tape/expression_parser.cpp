#include "host/tape/expression_parser.hpp"

#include <cctype>
#include <cmath>
#include <cstdlib>
#include <map>

#include "mortise/error.hpp"

namespace mortise::tape {
namespace {

constexpr int kMaxDepth = 1000;

class Parser {
  public:
    explicit Parser(const std::string& text) : text_(text) {}

    Formula run() {
        formula_.root = sum(0);
        skip_space();
        if (position_ != text_.size()) fail("an operator or the end of the formula");
        return std::move(formula_);
    }

  private:
    [[noreturn]] void fail(const std::string& expected) const {
        const std::string found =
            position_ < text_.size() ? std::string("'") + text_[position_] + "'" : std::string("the end");
        throw Error(ExitCode::kInput, "formula \"" + text_.substr(0, 60) + "\", column " +
                                          std::to_string(position_ + 1) + ": expected " + expected +
                                          ", found " + found);
    }

    void skip_space() {
        while (position_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[position_])))
            ++position_;
    }

    bool accept(char c) {
        skip_space();
        if (position_ >= text_.size() || text_[position_] != c) return false;
        ++position_;
        return true;
    }

    std::uint32_t add(std::int32_t operation, std::uint32_t a = 0, std::uint32_t b = 0, double constant = 0) {
        formula_.nodes.push_back({operation, a, b, constant});
        return static_cast<std::uint32_t>(formula_.nodes.size() - 1);
    }

    std::uint32_t sum(int depth) {
        if (depth > kMaxDepth) fail("at most 1000 nested parentheses");
        std::uint32_t left = product(depth);
        for (;;) {
            if (accept('+'))
                left = add(kExprAdd, left, product(depth));
            else if (accept('-'))
                left = add(kExprSubtract, left, product(depth));
            else
                return left;
        }
    }

    std::uint32_t product(int depth) {
        std::uint32_t left = unary(depth);
        for (;;) {
            if (accept('*'))
                left = add(kExprMultiply, left, unary(depth));
            else if (accept('/'))
                left = add(kExprDivide, left, unary(depth));
            else
                return left;
        }
    }

    std::uint32_t unary(int depth) {
        bool negative = false;
        for (;;) {
            if (accept('-'))
                negative = !negative;
            else if (!accept('+'))
                break;
        }
        const std::uint32_t value = power(depth);
        return negative ? add(kExprNegate, value) : value;
    }

    std::uint32_t power(int depth) {
        const std::uint32_t base = atom(depth);
        if (!accept('^')) return base;
        skip_space();
        const std::size_t start = position_;
        while (position_ < text_.size() && std::isdigit(static_cast<unsigned char>(text_[position_])))
            ++position_;
        const long exponent = start == position_ ? 0 : std::strtol(text_.c_str() + start, nullptr, 10);
        if (exponent < 1 || exponent > 64) fail("an integer exponent from 1 to 64");
        std::uint32_t result = base;
        for (int bit = 30 - __builtin_clz(static_cast<unsigned>(exponent)); bit >= 0; --bit) {
            result = add(kExprSquare, result);
            if ((exponent >> bit) & 1) result = add(kExprMultiply, result, base);
        }
        return result;
    }

    std::uint32_t atom(int depth) {
        skip_space();
        if (accept('(')) {
            const std::uint32_t value = sum(depth + 1);
            if (!accept(')')) fail("')'");
            return value;
        }
        if (position_ < text_.size() &&
            (std::isdigit(static_cast<unsigned char>(text_[position_])) || text_[position_] == '.')) {
            char* end = nullptr;
            const double value = std::strtod(text_.c_str() + position_, &end);
            if (end == text_.c_str() + position_ || !std::isfinite(value)) fail("a finite number");
            position_ = static_cast<std::size_t>(end - text_.c_str());
            return add(kExprConstant, 0, 0, value);
        }
        const std::size_t start = position_;
        while (position_ < text_.size() && std::isalpha(static_cast<unsigned char>(text_[position_])))
            ++position_;
        const std::string name = text_.substr(start, position_ - start);
        if (name == "x") return add(kExprX);
        if (name == "y") return add(kExprY);
        if (name == "z") return add(kExprZ);
        if (name == "pi") return add(kExprConstant, 0, 0, 3.14159265358979323846);
        static const std::map<std::string, std::int32_t> kUnary = {
            {"neg", kExprNegate}, {"abs", kExprAbs}, {"sqrt", kExprSqrt}, {"square", kExprSquare},
            {"sin", kExprSin},    {"cos", kExprCos}, {"exp", kExprExp},   {"log", kExprLog}};
        static const std::map<std::string, std::int32_t> kVariadic = {{"min", kExprMin}, {"max", kExprMax}};
        const auto one = kUnary.find(name);
        const auto many = kVariadic.find(name);
        if (one == kUnary.end() && many == kVariadic.end()) {
            position_ = start;
            fail(
                "a number, x, y, z, pi, '(' or one of the functions abs cos exp log max min neg sin sqrt "
                "square");
        }
        if (!accept('(')) fail("'(' after " + name);
        std::uint32_t value = sum(depth + 1);
        if (many != kVariadic.end()) {
            while (accept(',')) value = add(many->second, value, sum(depth + 1));
        } else {
            value = add(one->second, value);
        }
        if (!accept(')')) fail("')'");
        return value;
    }

    const std::string& text_;
    std::size_t position_ = 0;
    Formula formula_;
};

bool is_binary(std::int32_t operation) { return operation >= kExprAdd && operation <= kExprMax; }
bool is_leaf(std::int32_t operation) { return operation <= kExprZ; }

}  // namespace

Formula parse_formula(const std::string& text) { return Parser(text).run(); }

std::uint32_t emit_formula(const Formula& formula, std::uint32_t node, std::vector<ExpressionOp>& ops) {
    const auto& nodes = formula.nodes;
    // Uses of each node that `node` reaches; arguments come first, so one backward sweep counts them.
    std::vector<std::uint32_t> uses(nodes.size(), 0);
    uses[node] = 1;
    for (std::uint32_t i = node + 1; i-- > 0;) {
        if (uses[i] == 0 || is_leaf(nodes[i].operation)) continue;
        ++uses[nodes[i].a];
        if (is_binary(nodes[i].operation)) ++uses[nodes[i].b];
    }
    std::vector<std::uint32_t> place(nodes.size(), 0);
    std::vector<bool> taken(kExpressionRegisters, false);
    taken[0] = true;  // the result
    std::uint32_t count = 0;
    const auto release = [&](std::uint32_t argument) {
        if (--uses[argument] == 0) taken[place[argument]] = false;
    };
    for (std::uint32_t i = 0; i <= node; ++i) {
        if (uses[i] == 0) continue;
        const Formula::Node& n = nodes[i];
        ExpressionOp op{};
        op.operation = n.operation;
        op.literal = n.constant;
        if (!is_leaf(n.operation)) {
            op.a = op.b = place[n.a];
            if (is_binary(n.operation)) op.b = place[n.b];
            release(n.a);
            if (is_binary(n.operation)) release(n.b);
        }
        if (i != node) {
            std::uint32_t free = 1;
            while (free < taken.size() && taken[free]) ++free;
            if (free == taken.size()) {
                throw Error(ExitCode::kInput, "formula needs more than " +
                                                  std::to_string(kExpressionRegisters) +
                                                  " intermediate values at once; split it with min and max");
            }
            taken[free] = true;
            place[i] = free;
        }
        op.out = i == node ? 0 : place[i];
        ops.push_back(op);
        ++count;
    }
    return count;
}

}  // namespace mortise::tape
