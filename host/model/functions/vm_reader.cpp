// Reader of Fidget's .vm files: a line per operation, "NAME OPERATION ARGUMENTS", arguments defined before
// them; the last line is the function. Lines that start with # are comments. Written from Fidget's text
// parser (fidget-core/src/context/mod.rs). Its rand and mix are hashes of bits: they describe no solid.
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include "host/formula/expression_parser.hpp"
#include "host/model/functions/function_model.hpp"
#include "host/model/name_table.hpp"
#include "host/model/readers.hpp"
#include "host/model/text.hpp"

namespace mortise::model_reader {
namespace {

struct Operation {
    std::string_view name;
    int arguments;
    std::string_view before;  ///< what a formula has before, between and behind the arguments
    std::string_view between;
    std::string_view after;
};

constexpr std::array<Operation, 27> kOperations = {{{"add", 2, "", " + ", ""},
                                                    {"sub", 2, "", " - ", ""},
                                                    {"mul", 2, "", " * ", ""},
                                                    {"div", 2, "", " / ", ""},
                                                    {"min", 2, "min(", ", ", ")"},
                                                    {"max", 2, "max(", ", ", ")"},
                                                    {"neg", 1, "neg(", "", ")"},
                                                    {"abs", 1, "abs(", "", ")"},
                                                    {"sqrt", 1, "sqrt(", "", ")"},
                                                    {"square", 1, "square(", "", ")"},
                                                    {"sin", 1, "sin(", "", ")"},
                                                    {"cos", 1, "cos(", "", ")"},
                                                    {"tan", 1, "tan(", "", ")"},
                                                    {"asin", 1, "asin(", "", ")"},
                                                    {"acos", 1, "acos(", "", ")"},
                                                    {"atan", 1, "atan(", "", ")"},
                                                    {"exp", 1, "exp(", "", ")"},
                                                    {"ln", 1, "log(", "", ")"},
                                                    {"floor", 1, "floor(", "", ")"},
                                                    {"ceil", 1, "ceil(", "", ")"},
                                                    {"round", 1, "round(", "", ")"},
                                                    {"not", 1, "not(", "", ")"},
                                                    {"atan2", 2, "atan2(", ", ", ")"},
                                                    {"mod", 2, "mod(", ", ", ")"},
                                                    {"compare", 2, "compare(", ", ", ")"},
                                                    {"and", 2, "and(", ", ", ")"},
                                                    {"or", 2, "or(", ", ", ")"}}};

class VmReader {
  public:
    VmReader(const std::string& text, const std::string& source) : cursor_(text, source), source_(source) {}

    void read() {
        for (; !cursor_.at_end(); end_line()) {
            if (cursor_.peek() == '#') {
                cursor_.take_line();
                continue;
            }
            skip_spaces();
            if (at_line_end()) continue;
            const std::string_view name = take_word("a name");
            skip_spaces();
            const SourceLocation where = cursor_.where();
            const std::string_view operation = take_word("an operation after", name);
            read_operation(operation, where);
            places_.set(name, static_cast<std::uint32_t>(function.size() - 1));
        }
        if (function.size() == 0) cursor_.fail_here("the file holds no operation; expected: x var-x");
    }

    FunctionText function;
    bool has_z = false;

  private:
    bool at_line_end() const { return cursor_.at_end() || cursor_.peek() == '\n'; }

    void skip_spaces() {
        while (!at_line_end() && (cursor_.peek() == ' ' || cursor_.peek() == '\t' || cursor_.peek() == '\r'))
            cursor_.advance();
    }

    /// Messages say that `what` 'of' is expected; `of` may be empty.
    std::string_view take_word(const char* what, std::string_view of = {}) {
        skip_spaces();
        const std::string_view word = cursor_.take_word();
        if (!word.empty() && (at_line_end() || (cursor_.peek() >= 0 && cursor_.peek() <= ' '))) return word;
        cursor_.fail_here("expected " + std::string(what) + (of.empty() ? "" : " '" + std::string(of) + "'") +
                          ", found " + (at_line_end() ? "the end of the line" : cursor_.found()));
    }

    void end_line() {
        skip_spaces();
        if (!at_line_end()) {
            // Comments leave the cursor at the end of theirs.
            cursor_.fail_here("expected the end of the line, found " + cursor_.found());
        }
        if (!cursor_.at_end()) cursor_.advance();
    }

    std::size_t argument(std::string_view operation) {
        skip_spaces();
        const SourceLocation where = cursor_.where();
        const std::string_view name = take_word("an argument of", operation);
        const NameTable::Entry* found = places_.find(name);
        if (found == nullptr) fail(source_, where, "'" + excerpt(name) + "' is not defined before this line");
        return found->value;
    }

    void read_operation(std::string_view name, SourceLocation where) {
        if (name == "const") return function.define(number());
        if (name == "var-x") return function.define("x");
        if (name == "var-y") return function.define("y");
        if (name == "var-z") {
            has_z = true;
            return function.define("z");
        }
        for (const Operation& known : kOperations) {
            if (known.name != name) continue;
            const std::size_t first = argument(name);
            const bool is_binary = known.arguments == 2;
            const std::size_t second = is_binary ? argument(name) : first;
            note_constant(known, first, second, where);
            if (!is_binary) return function.define(known.before, first, known.after);
            return function.define(known.before, first, known.between, second, known.after);
        }
        const std::string quoted = "'" + std::string(name) + "'";
        if (name == "rand" || name == "mix") {
            fail(source_, where,
                 quoted +
                     " makes random numbers from the bits of its arguments, which no mesh can follow; "
                     "replace it by constants");
        }
        std::vector<std::string_view> known = {"const", "var-x", "var-y", "var-z"};
        for (const Operation& operation : kOperations) known.push_back(operation.name);
        std::string list;
        for (const std::string_view operation : known) list += " " + std::string(operation);
        fail(source_, where,
             "unknown operation '" + excerpt(name) + "'; expected one of" + list + nearest_hint(name, known));
    }

    /// Keeps the value of an operation on constants, which must be finite.
    void note_constant(const Operation& known, std::size_t first, std::size_t second, SourceLocation where) {
        const double a = constant(first), b = constant(second);
        if (std::isnan(a) || std::isnan(b)) return;
        std::string text = std::string(known.before) + function_number(a);
        if (known.arguments == 2) text += std::string(known.between) + function_number(b);
        text += known.after;
        try {
            const formula::Formula formula = formula::parse_formula(text);
            set_constant(formula.nodes()[formula.root].constant);
        } catch (const Error&) {
            fail(source_, where,
                 "'" + std::string(known.name) + "' of these constants, " + text +
                     ", has no finite value; expected a constant that is a number");
        }
    }

    /// NaN: it depends on x, y or z.
    double constant(std::size_t definition) const {
        return definition < constants_.size() ? constants_[definition] : NAN;
    }

    /// Of the operation that is read.
    void set_constant(double value) {
        constants_.resize(function.size(), NAN);
        constants_.push_back(value);
    }

    std::string number() {
        skip_spaces();
        bool negative = false;
        if (cursor_.peek() == '-' || cursor_.peek() == '+') {
            negative = cursor_.peek() == '-';
            cursor_.advance();
        }
        const double value = cursor_.take_number();
        set_constant(negative ? -value : value);
        return function_number(negative ? -value : value);
    }

    TextCursor cursor_;
    const std::string& source_;
    NameTable places_;
    std::vector<double> constants_;  ///< per definition, up to the last constant; NaN: not constant
};

}  // namespace

Model read_vm(const std::string& text, const std::string& source, const std::string& region,
              const ReadOptions& options) {
    VmReader reader(text, source);
    reader.read();
    Model model;
    model.source = source;
    add_function(model, reader.function.formula(reader.function.size() - 1), reader.has_z, region, {},
                 options);
    return model;
}

}  // namespace mortise::model_reader
