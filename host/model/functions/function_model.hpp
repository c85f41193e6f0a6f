// Models that are one function, negative inside: text of its formula, and the model around it.
#pragma once

#include <string>
#include <string_view>

#include "mortise/model.hpp"

namespace mortise::model_reader {

/// A formula as a list of definitions (docs/formulas.md), so that shared operations stay shared.
class FunctionText {
  public:
    /// Appends a definition; its name is function_name(index), counted from 0.
    void define(std::string_view expression);
    /// The same for BEFORE first BETWEEN second AFTER, the two being definitions.
    void define(std::string_view before, std::size_t first, std::string_view after);
    void define(std::string_view before, std::size_t first, std::string_view between, std::size_t second,
                std::string_view after);
    std::size_t size() const { return count_; }
    /// The formula whose value is the definition `index`.
    std::string formula(std::size_t index) const;

  private:
    void append_name(std::size_t index);
    void begin();
    void end() { text_ += ";\n"; }

    std::string text_;
    std::size_t count_ = 0;
};

std::string function_name(std::size_t index);
/// The shortest text of a number, in parentheses if it is negative.
std::string function_number(double value);

/// Appends the solid of a formula that starts at `where`, and its region. A function of x and y alone is cut
/// to 0 <= z <= options.extrude, and refused where that is 0.
void add_function(Model& model, const std::string& formula, bool has_z, const std::string& region,
                  SourceLocation where, const ReadOptions& options);

}  // namespace mortise::model_reader
