// Reader of Fidget's .vm files: a line per operation, "NAME OPERATION ARGUMENTS", arguments defined before
// them; the last line is the function. Lines that start with # are comments. Written from Fidget's text
// parser (fidget-core/src/context/mod.rs). Its rand and mix are hashes of bits: they describe no solid.
#include <array>
#include <string_view>
#include <unordered_map>

#include "host/model/functions/function_model.hpp"
#include "host/model/readers.hpp"
#include "host/model/text.hpp"

namespace mortise::model_reader {
namespace {

struct Operation {
    std::string_view name;
    int arguments;
    const char* text;  ///< an infix sign, or the name of the function
};

constexpr std::array<Operation, 26> kOperations = {
    {{"add", 2, "+"},           {"sub", 2, "-"},         {"mul", 2, "*"},       {"div", 2, "/"},
     {"min", 2, "min"},         {"max", 2, "max"},       {"neg", 1, "neg"},     {"abs", 1, "abs"},
     {"sqrt", 1, "sqrt"},       {"square", 1, "square"}, {"sin", 1, "sin"},     {"cos", 1, "cos"},
     {"tan", 1, "tan"},         {"asin", 1, "asin"},     {"acos", 1, "acos"},   {"atan", 1, "atan"},
     {"exp", 1, "exp"},         {"ln", 1, "log"},        {"floor", 1, "floor"}, {"ceil", 1, "ceil"},
     {"round", 1, "round"},     {"not", 1, "not"},       {"atan2", 2, "atan2"}, {"mod", 2, "mod"},
     {"compare", 2, "compare"}, {"and", 2, "and"}}};

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
            const std::string_view operation = take_word("an operation after '" + std::string(name) + "'");
            read_operation(operation, where);
            places_[name] = function.size() - 1;
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

    std::string_view take_word(const std::string& what) {
        skip_spaces();
        if (at_line_end()) cursor_.fail_here("expected " + what + ", found the end of the line");
        const TextCursor begin = cursor_;
        while (!at_line_end() && static_cast<unsigned char>(cursor_.peek()) > ' ') {
            if (static_cast<unsigned char>(cursor_.peek()) >= 0x7f)
                cursor_.fail_here("expected " + what + ", found " + cursor_.found());
            cursor_.advance();
        }
        if (begin.offset() == cursor_.offset())
            cursor_.fail_here("expected " + what + ", found " + cursor_.found());
        return begin.text_until(cursor_);
    }

    void end_line() {
        skip_spaces();
        if (!at_line_end()) {
            // Comments leave the cursor at the end of theirs.
            cursor_.fail_here("expected the end of the line, found " + cursor_.found());
        }
        if (!cursor_.at_end()) cursor_.advance();
    }

    std::string argument(std::string_view operation) {
        skip_spaces();
        const SourceLocation where = cursor_.where();
        const std::string_view name = take_word("an argument of " + std::string(operation));
        const auto found = places_.find(name);
        if (found == places_.end())
            fail(source_, where, "'" + std::string(name) + "' is not defined before this line");
        return function_name(found->second);
    }

    void read_operation(std::string_view name, SourceLocation where) {
        if (name == "const") return function.define(number());
        if (name == "var-x") return function.define("x");
        if (name == "var-y") return function.define("y");
        if (name == "var-z") {
            has_z = true;
            return function.define("z");
        }
        if (name == "or") {
            const std::string first = argument(name);
            return function.define("or(" + first + ", " + argument(name) + ")");
        }
        for (const Operation& known : kOperations) {
            if (known.name != name) continue;
            const std::string first = argument(name);
            const std::string text = known.text;
            if (known.arguments == 1) return function.define(text + "(" + first + ")");
            const std::string second = argument(name);
            const bool infix = !is_name_start(known.text[0]);
            return function.define(infix ? first + " " + text + " " + second
                                         : text + "(" + first + ", " + second + ")");
        }
        const std::string quoted = "'" + std::string(name) + "'";
        if (name == "rand" || name == "mix") {
            fail(source_, where,
                 quoted +
                     " makes random numbers from the bits of its arguments, which no mesh can follow; "
                     "replace it by constants");
        }
        std::string known = "const var-x var-y var-z or";
        for (const Operation& operation : kOperations) known += " " + std::string(operation.name);
        fail(source_, where, "unknown operation " + quoted + "; expected one of " + known);
    }

    std::string number() {
        skip_spaces();
        bool negative = false;
        if (cursor_.peek() == '-' || cursor_.peek() == '+') {
            negative = cursor_.peek() == '-';
            cursor_.advance();
        }
        const double value = cursor_.take_number();
        return function_number(negative ? -value : value);
    }

    TextCursor cursor_;
    const std::string& source_;
    std::unordered_map<std::string_view, std::size_t> places_;
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
