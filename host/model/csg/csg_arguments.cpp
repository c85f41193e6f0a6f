// Reads the argument list of a .csg node: arg = [name "="] value, value = number | true | false | undef |
// nan | inf | string | "[" values "]". Lists nest to any depth without recursion.
#include "host/model/csg/csg_arguments.hpp"

#include <limits>
#include <string>

namespace mortise::model_reader {

void skip_csg_blanks(TextCursor& cursor) {
    while (true) {
        cursor.skip_blanks();
        if (cursor.peek() != '/') return;
        if (cursor.peek_next() == '/') {
            cursor.take_line();
        } else if (cursor.peek_next() == '*') {
            const SourceLocation opening = cursor.where();
            cursor.advance();
            cursor.advance();
            while (!(cursor.peek() == '*' && cursor.peek_next() == '/')) {
                if (cursor.at_end())
                    fail(cursor.source(), opening, "this comment is never closed; expected '*/'");
                cursor.advance();
            }
            cursor.advance();
            cursor.advance();
        } else {
            return;
        }
    }
}

void CsgArguments::read(TextCursor& cursor) {
    arguments_.clear();
    numbers_.clear();
    row_ends_.clear();
    cursor.advance();  // '('
    skip_csg_blanks(cursor);
    if (cursor.peek() == ')') {
        cursor.advance();
        return;
    }
    while (true) {
        CsgArgument argument;
        read_value(cursor, argument);
        if (!argument.name.empty() && find(argument.name) != nullptr) {
            fail(cursor.source(), argument.where,
                 "'" + std::string(argument.name) + "' is given twice; expected it once");
        }
        arguments_.push_back(argument);
        skip_csg_blanks(cursor);
        if (cursor.peek() == ',') {
            cursor.advance();
            skip_csg_blanks(cursor);
        } else if (cursor.peek() == ')') {
            cursor.advance();
            return;
        } else {
            cursor.fail_here("expected ',' or ')' after an argument, found " + cursor.found());
        }
    }
}

const CsgArgument* CsgArguments::find(std::string_view name, int position) const {
    int nameless = 0;
    for (const CsgArgument& argument : arguments_) {
        if (argument.name.empty()) {
            if (nameless == position) return &argument;
            ++nameless;
        } else if (argument.name == name) {
            return &argument;
        }
    }
    return nullptr;
}

void CsgArguments::read_value(TextCursor& cursor, CsgArgument& argument) {
    if (is_name_start(cursor.peek()) || cursor.peek() == '$') {
        // Either a name with '=', or a word that is the value itself.
        TextCursor ahead = cursor;
        if (ahead.peek() == '$') ahead.advance();
        ahead.take_name();
        const TextCursor after_name = ahead;
        skip_csg_blanks(ahead);
        if (ahead.peek() == '=') {
            argument.name = cursor.text_until(after_name);
            ahead.advance();
            skip_csg_blanks(ahead);
            cursor = ahead;
        }
    }
    argument.where = cursor.where();
    argument.first = numbers_.size();
    if (cursor.peek() == '[') {
        read_list(cursor, argument);
    } else {
        read_scalar(cursor, argument);
    }
    argument.count = numbers_.size() - argument.first;
}

void CsgArguments::read_list(TextCursor& cursor, CsgArgument& argument) {
    const SourceLocation opening = cursor.where();
    argument.first_row = row_ends_.size();
    std::size_t depth = 0;
    std::size_t in_row = 0;
    while (true) {
        if (cursor.peek() == '[') {
            cursor.advance();
            ++depth;
            if (depth == 2) in_row = 0;
            if (depth > 2) argument.numeric = argument.regular = false;
            skip_csg_blanks(cursor);
            if (cursor.peek() != ']') continue;
        } else {
            CsgArgument element;
            read_scalar(cursor, element);
            if (element.kind == CsgArgument::Kind::kBoolean) numbers_.push_back(element.boolean ? 1 : 0);
            if (element.kind != CsgArgument::Kind::kNumber) argument.numeric = argument.regular = false;
            if (element.not_finite.line != 0 && argument.not_finite.line == 0) {
                argument.not_finite = element.not_finite;
            }
            ++(depth == 1 ? argument.direct : in_row);
            skip_csg_blanks(cursor);
        }
        while (cursor.peek() == ']') {
            cursor.advance();
            if (depth == 2) {
                if (argument.rows != 0 && argument.row_length != in_row) argument.regular = false;
                argument.row_length = in_row;
                ++argument.rows;
                row_ends_.push_back(numbers_.size() - argument.first);
            }
            if (--depth == 0) {
                argument.kind = CsgArgument::Kind::kList;
                return;
            }
            skip_csg_blanks(cursor);
        }
        if (cursor.at_end()) fail(cursor.source(), opening, "this '[' is never closed; expected ']'");
        if (cursor.peek() != ',') {
            cursor.fail_here("expected ',' or ']' in a list, found " + cursor.found());
        }
        cursor.advance();
        skip_csg_blanks(cursor);
    }
}

void CsgArguments::read_scalar(TextCursor& cursor, CsgArgument& argument) {
    const SourceLocation start = cursor.where();
    if (cursor.peek() == '"') {
        cursor.advance();
        const TextCursor first = cursor;
        while (cursor.peek() != '"') {
            if (cursor.at_end()) fail(cursor.source(), start, "this string is never closed; expected '\"'");
            if (cursor.peek() == '\\' && cursor.peek_next() != '\0') cursor.advance();
            cursor.advance();
        }
        argument.text = first.text_until(cursor);
        cursor.advance();
        argument.kind = CsgArgument::Kind::kString;
        return;
    }
    const bool negative = cursor.peek() == '-';
    if (negative) cursor.advance();
    double value = 0;
    if (is_name_start(cursor.peek())) {
        const std::string found = cursor.found();
        const std::string_view word = cursor.take_name();
        if (word == "nan" || word == "inf") {
            value = word == "nan" ? std::numeric_limits<double>::quiet_NaN()
                                  : std::numeric_limits<double>::infinity();
            argument.not_finite = start;
        } else if (!negative && (word == "true" || word == "false")) {
            argument.kind = CsgArgument::Kind::kBoolean;
            argument.boolean = word == "true";
            return;
        } else if (!negative && word == "undef") {
            argument.kind = CsgArgument::Kind::kUndefined;
            return;
        } else {
            fail(cursor.source(), start,
                 "expected a value (a number, true, false, undef, a string or a list), found " + found);
        }
    } else if (is_digit(cursor.peek()) || cursor.peek() == '.') {
        value = cursor.take_number();
    } else {
        cursor.fail_here("expected a value (a number, true, false, undef, a string or a list), found " +
                         cursor.found());
    }
    argument.kind = CsgArgument::Kind::kNumber;
    numbers_.push_back(negative ? -value : value);
}

}  // namespace mortise::model_reader
