#include "host/model/functions/function_model.hpp"

#include <array>
#include <charconv>
#include <cmath>

#include "host/formula/expression_parser.hpp"
#include "host/model/text.hpp"

namespace mortise::model_reader {

std::string function_name(std::size_t index) { return "_" + std::to_string(index); }

std::string function_number(double value) {
    return std::signbit(value) ? "(" + number_text(value) + ")" : number_text(value);
}

void FunctionText::append_name(std::size_t index) {
    std::array<char, 24> buffer{'_'};
    const auto result = std::to_chars(buffer.data() + 1, buffer.data() + buffer.size(), index);
    text_.append(buffer.data(), result.ptr);
}

void FunctionText::begin() {
    append_name(count_++);
    text_ += " = ";
}

void FunctionText::define(std::string_view expression) {
    begin();
    text_ += expression;
    end();
}

void FunctionText::define(std::string_view before, std::size_t first, std::string_view after) {
    begin();
    text_ += before;
    append_name(first);
    text_ += after;
    end();
}

void FunctionText::define(std::string_view before, std::size_t first, std::string_view between,
                          std::size_t second, std::string_view after) {
    begin();
    text_ += before;
    append_name(first);
    text_ += between;
    append_name(second);
    text_ += after;
    end();
}

std::string FunctionText::formula(std::size_t index) const { return text_ + function_name(index); }

void add_function(Model& model, const std::string& formula, bool has_z, const std::string& region,
                  SourceLocation where, const ReadOptions& options) {
    const bool flat = options.extrude != 0;
    if (flat && !(std::isfinite(options.extrude) && options.extrude > 0)) {
        throw Error(ExitCode::kUsage,
                    "--extrude " + number_text(options.extrude) + " is out of range; use a positive length");
    }
    if (!has_z && !flat && !options.is_cut) {
        // What is wrong with the formula itself comes first.
        formula::parse_formula(formula, model.source, where);
        throw Error(ExitCode::kInput,
                    model.source +
                        ": the formula names no z: a flat figure; use --extrude H for the solid above it, "
                        "0 <= z <= H, or --box for what lies in a box");
    }
    if (has_z && flat)
        throw Error(ExitCode::kUsage, model.source + ": the function depends on z; leave --extrude out");
    Primitive primitive;
    primitive.kind = Primitive::Kind::kExpression;
    primitive.expression = formula;
    std::uint32_t root = model.add_primitive(std::move(primitive), {}, where);
    if (flat) {
        Primitive slab;
        slab.planes = {{{0, 0, -1}, 0, "zmin"}, {{0, 0, 1}, options.extrude, "zmax"}};
        const std::uint32_t cut = model.add_primitive(std::move(slab), "extrude", where);
        root = model.add_operation(CsgNode::Op::kIntersection, {root, cut});
    }
    Region result;
    result.name = region;
    result.root = root;
    model.regions.push_back(std::move(result));
}

}  // namespace mortise::model_reader
