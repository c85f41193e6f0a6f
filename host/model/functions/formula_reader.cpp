// Reader of .formula files: one formula (docs/formulas.md), # comments, and optionally a line
// "bounds x0 y0 z0 x1 y1 z1", where the solid is cut. The formula itself is parsed when it is compiled.
#include <cstdint>

#include "host/model/functions/function_model.hpp"
#include "host/model/readers.hpp"
#include "host/model/text.hpp"

namespace mortise::model_reader {
namespace {

/// Whether the line at the cursor is a "bounds" line: not a definition of that name. No formula has a name
/// after a name, so a word there (nan) is a wrong number.
bool is_bounds_line(TextCursor cursor) {
    if (cursor.take_name() != "bounds") return false;
    const bool blank = cursor.peek() == ' ' || cursor.peek() == '\t';
    while (cursor.peek() == ' ' || cursor.peek() == '\t') cursor.advance();
    return blank && (is_name_part(cursor.peek()) || cursor.peek() == '-' || cursor.peek() == '+' ||
                     cursor.peek() == '.');
}

Box3 read_bounds(TextCursor& cursor) {
    const SourceLocation where = cursor.where();
    cursor.take_name();
    double numbers[6] = {};
    for (double& number : numbers) {
        while (cursor.peek() == ' ' || cursor.peek() == '\t') cursor.advance();
        bool negative = false;
        if (cursor.peek() == '-' || cursor.peek() == '+') {
            negative = cursor.peek() == '-';
            cursor.advance();
        }
        if (is_name_part(cursor.peek()) && !is_digit(cursor.peek()))
            cursor.fail_here("bounds: expected six finite numbers, found " + cursor.found());
        number = cursor.take_number();
        if (negative) number = -number;
    }
    while (cursor.peek() == ' ' || cursor.peek() == '\t' || cursor.peek() == '\r') cursor.advance();
    if (!cursor.at_end() && cursor.peek() != '\n' && cursor.peek() != '#')
        cursor.fail_here("expected the end of the line after six numbers, found " + cursor.found());
    const Box3 box{{numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]}};
    for (std::size_t j = 0; j < 3; ++j) {
        if (!(box.min[j] < box.max[j])) {
            fail(cursor.source(), where,
                 std::string("the bounds are empty along ") + "xyz"[j] +
                     "; expected bounds x0 y0 z0 x1 y1 z1 with x0 < x1, y0 < y1, z0 < z1");
        }
    }
    return box;
}

/// Refuses what cannot stand in a formula: the formula itself is parsed late, and the file may be none.
void refuse_foreign_text(const std::string& text, const std::string& source) {
    TextCursor cursor(text, source);
    // Of operators of other languages the formula's parser tells more, but no formula begins with one.
    std::string_view symbols = "+-*/^().,=;";
    for (cursor.skip_blanks(); !cursor.at_end(); cursor.skip_blanks()) {
        const char c = cursor.peek();
        if (c == '#') {
            cursor.take_line();
        } else if (is_name_part(c) || symbols.find(c) != std::string_view::npos) {
            cursor.advance();
            symbols = "+-*/^().,=;<>&|%?";
        } else {
            cursor.fail_here("expected a formula (names, numbers and + - * / ^ ( ) , = ;), found " +
                             cursor.found());
        }
    }
}

/// Whether the name z occurs outside of comments.
bool names_z(const std::string& text) {
    for (std::size_t i = 0; i < text.size();) {
        if (text[i] == '#') {
            while (i < text.size() && text[i] != '\n') ++i;
        } else if (is_name_start(text[i])) {
            const std::size_t start = i;
            while (i < text.size() && is_name_part(text[i])) ++i;
            if (text.compare(start, i - start, "z") == 0) return true;
        } else {
            ++i;
        }
    }
    return false;
}

}  // namespace

Model read_formula(const std::string& text, const std::string& source, const std::string& region,
                   const ReadOptions& options) {
    Model model;
    model.source = source;
    std::string formula = text;  // the bounds line becomes blank, so that places stay
    bool empty = true;
    TextCursor cursor(text, source);
    for (std::size_t i = 0; i < cursor.offset(); ++i) formula[i] = ' ';
    const std::size_t mark = cursor.offset();  // of a byte order mark: no columns
    while (!cursor.at_end()) {
        while (cursor.peek() == ' ' || cursor.peek() == '\t' || cursor.peek() == '\r') cursor.advance();
        if (is_bounds_line(cursor)) {
            if (model.clip) cursor.fail_here("a second line of bounds; expected one");
            const std::size_t start = cursor.offset();
            model.clip = read_bounds(cursor);
            for (std::size_t i = start; i < cursor.offset(); ++i) formula[i] = ' ';
        } else if (!cursor.at_end() && cursor.peek() != '#' && cursor.peek() != '\n') {
            empty = false;
        }
        cursor.take_line();
        while (!cursor.at_end() && cursor.peek() != '\n') cursor.advance();
        if (!cursor.at_end()) cursor.advance();
    }
    if (empty) cursor.fail_here("the file holds no formula; expected, say: x^2 + y^2 + z^2 - 1");
    formula.erase(0, mark);
    refuse_foreign_text(text, source);
    // Bounds make a solid of a function of x and y, too.
    const bool has_z = names_z(formula) || (model.clip.has_value() && options.extrude == 0);
    add_function(model, formula, has_z, region, {1, 1}, options);
    return model;
}

}  // namespace mortise::model_reader
