// Expressions of Netgen's .geo files: see geo_expression.hpp.
#include "host/model/geo/geo_expression.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "host/model/affine.hpp"

namespace mortise::model_reader {
namespace {

constexpr std::array<std::string_view, 11> kStatements = {"solid",
                                                          "tlo",
                                                          "boundingbox",
                                                          "boundarycondition",
                                                          "boundaryconditionname",
                                                          "identify",
                                                          "singular",
                                                          "point",
                                                          "define",
                                                          "curve2d",
                                                          "curve3d"};

constexpr std::array<std::string_view, 4> kCopies = {"translate", "rotate", "multitranslate", "multirotate"};

/// Words that Netgen's lexer knows but its parser rejects.
constexpr std::array<std::string_view, 2> kNotYetFunctions = {"tube", "gencyl"};

template <std::size_t N>
bool contains(const std::array<std::string_view, N>& words, std::string_view word) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

constexpr double kMostCopies = 1e6;

}  // namespace

bool is_geo_statement(const GeoToken& token) {
    return token.kind == GeoToken::Kind::kName && contains(kStatements, token.text);
}

std::vector<std::string_view> geo_statement_names() { return {kStatements.begin(), kStatements.end()}; }

bool is_geo_reserved(std::string_view name) {
    return name == "or" || name == "and" || name == "not" || name == "algebraic3d" ||
           contains(kStatements, name) || contains(kCopies, name) || contains(kNotYetFunctions, name) ||
           is_geo_primitive(name);
}

std::string undefined_solid(const std::string& name) {
    return "the solid '" + name + "' is not defined; expected 'solid " + name + " = ...' above this line";
}

std::uint32_t GeoExpression::read() {
    frames_.assign(1, Frame{});
    frames_[0].where = lexer_.token().where;
    while (true) {
        std::uint32_t node = read_operand();
        // Close what ends after this operand; stop at the next `and` or `or`.
        while (true) {
            Frame& frame = frames_.back();
            if (frame.negated) {
                node = model_.add_operation(CsgNode::Op::kComplement, {node});
                frame.negated = false;
            }
            factors_.push_back(node);
            if (lexer_.take_word("and")) break;
            terms_.push_back(close_term(frame));
            if (lexer_.take_word("or")) break;
            if (!frame.in_parentheses) return close_frame();
            if (!lexer_.is_symbol(')')) {
                lexer_.fail_expected("'and', 'or' or ')' for the '(' at line " +
                                     std::to_string(frame.where.line) + ", column " +
                                     std::to_string(frame.where.column));
            }
            lexer_.next();
            node = close_frame();
        }
    }
}

std::uint32_t GeoExpression::read_operand() {
    while (true) {
        const GeoToken token = lexer_.token();
        if (lexer_.is_symbol('(')) {
            lexer_.next();
            Frame frame;
            frame.where = token.where;
            frame.in_parentheses = true;
            frame.first_term = terms_.size();
            frame.first_factor = factors_.size();
            frames_.push_back(std::move(frame));
            continue;
        }
        if (token.kind != GeoToken::Kind::kName) {
            lexer_.fail_expected("a primitive, the name of a solid, 'not' or '('");
        }
        if (lexer_.take_word("not")) {
            frames_.back().negated = !frames_.back().negated;
        } else if (is_geo_primitive(token.text)) {
            return add_geo_primitive(model_, lexer_, shapes_);
        } else if (contains(kCopies, token.text)) {
            open_copy(token.text);
        } else if (contains(kNotYetFunctions, token.text)) {
            fail(lexer_.source(), token.where,
                 lexer_.found() + " is not supported yet; supported are " + geo_primitive_list());
        } else if (is_geo_reserved(token.text)) {
            lexer_.fail_expected("a primitive, the name of a solid, 'not' or '('");
        } else {
            const NameTable::Entry* found = solids_.find(token.text);
            lexer_.next();
            if (found == nullptr) {
                const std::string name(token.text);
                if (!lexer_.is_symbol('(')) fail(lexer_.source(), token.where, undefined_solid(name));
                // A primitive that is misspelt, by the looks of it.
                std::vector<std::string_view> known = geo_primitive_names();
                known.insert(known.end(), kCopies.begin(), kCopies.end());
                fail(lexer_.source(), token.where,
                     "unknown primitive '" + name + "'; supported are " + geo_primitive_list() +
                         nearest_hint(name, known));
            }
            frames_.back().refers = true;
            return found->value;
        }
    }
}

void GeoExpression::open_copy(std::string_view name) {
    Frame frame;
    frame.where = lexer_.token().where;
    frame.in_parentheses = true;
    frame.is_copy = true;
    frame.first_term = terms_.size();
    frame.first_factor = factors_.size();
    lexer_.next();
    lexer_.take_symbol('(', "after '" + std::string(name) + "'");
    if (name == "translate" || name == "multitranslate") {
        const Vec3 step = lexer_.take_vector("the translation");
        lexer_.take_symbol(';', "after the translation");
        frame.keeps_original = name == "multitranslate";
        const int count = frame.keeps_original ? take_count(name) : 1;
        for (int k = 1; k <= count; ++k)
            frame.maps.push_back(translation({k * step[0], k * step[1], k * step[2]}));
    } else {
        const Vec3 center = lexer_.take_vector("the center");
        lexer_.take_symbol(';', "after the center");
        const Vec3 angles = lexer_.take_vector("the angles");
        lexer_.take_symbol(';', "after the angles");
        const Affine turn = geo_rotation(center, angles);
        frame.keeps_original = name == "multirotate";
        // Netgen's first copy is not rotated: n copies are n solids in all.
        const int count = frame.keeps_original ? take_count(name) - 1 : 1;
        Affine map = turn;
        for (int k = 1; k <= count; ++k) {
            frame.maps.push_back(map);
            map = compose(turn, map);
        }
    }
    frames_.push_back(std::move(frame));
}

int GeoExpression::take_count(std::string_view name) {
    const SourceLocation where = lexer_.token().where;
    const double count = lexer_.take_number("the number of copies");
    if (!(count >= 0 && count <= kMostCopies) || count != std::floor(count)) {
        fail(lexer_.source(), where,
             "'" + std::string(name) + "': the number of copies is " + number_text(count) +
                 "; expected a whole number from 0 to 1000000");
    }
    lexer_.take_symbol(';', "after the number of copies");
    return static_cast<int>(count);
}

std::uint32_t GeoExpression::combine(CsgNode::Op op, std::vector<std::uint32_t>& operands,
                                     std::size_t first) {
    std::uint32_t result = operands[first];
    if (operands.size() - first > 1) {
        const auto begin = operands.begin() + static_cast<std::ptrdiff_t>(first);
        result = model_.add_operation(op, {begin, operands.end()});
    }
    operands.resize(first);
    return result;
}

std::uint32_t GeoExpression::close_term(const Frame& frame) {
    return combine(CsgNode::Op::kIntersection, factors_, frame.first_factor);
}

std::uint32_t GeoExpression::close_frame() {
    const Frame frame = std::move(frames_.back());
    frames_.pop_back();
    const std::uint32_t node = combine(CsgNode::Op::kUnion, terms_, frame.first_term);
    // Copies have surfaces of their own and refer to nothing.
    const bool still_refers = frame.refers && (!frame.is_copy || frame.keeps_original);
    if (!frames_.empty() && still_refers) frames_.back().refers = true;
    return frame.is_copy ? make_copies(frame, node) : node;
}

std::uint32_t GeoExpression::make_copies(const Frame& frame, std::uint32_t node) {
    std::vector<std::uint32_t> copies;
    if (frame.keeps_original) copies.push_back(node);
    const bool must_copy = frame.refers && !frame.maps.empty();
    // A copy of what was moved is moved at once, so that chains of copies do not grow with each link.
    Affine moved = kIdentity;
    while (must_copy && model_.nodes[node].op == CsgNode::Op::kTransform &&
           model_.nodes[node].max_size == 0) {
        moved = compose(moved, model_.nodes[node].map);
        node = model_.nodes[node].children[0];
    }
    const std::uint32_t original = must_copy ? surfaces_.copy(node, first_) : node;
    for (const Affine& step : frame.maps) {
        const Affine map = compose(step, moved);
        if (map == kIdentity) {
            copies.push_back(original);
        } else {
            copies.push_back(model_.add_transform(map, original));
            model_.nodes[copies.back()].where = frame.where;
        }
    }
    return combine(CsgNode::Op::kUnion, copies, 0);
}

}  // namespace mortise::model_reader
