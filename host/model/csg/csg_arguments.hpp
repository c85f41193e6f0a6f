// Arguments of one .csg node: their text read into flat arrays that are reused from node to node.
#pragma once

#include <string_view>
#include <vector>

#include "host/model/text.hpp"

namespace mortise::model_reader {

struct CsgArgument {
    enum class Kind : std::uint8_t { kNumber, kBoolean, kUndefined, kString, kList };
    Kind kind = Kind::kUndefined;
    std::string_view name;  ///< empty: given by position
    SourceLocation where;   ///< of the value
    bool boolean = false;   ///< kBoolean
    std::size_t first = 0;  ///< kNumber, kList: first number in CsgArguments::numbers
    std::size_t count = 0;  ///< how many numbers, over all nested lists
    // The shape of a list.
    std::size_t direct = 0;      ///< numbers that stand in the outermost list itself
    std::size_t rows = 0;        ///< lists that stand in the outermost list
    std::size_t row_length = 0;  ///< numbers in each of them, if `regular`
    bool numeric = true;         ///< only numbers, nested at most twice; true and false are listed as 1 and 0
    bool regular = true;         ///< `numeric`, and rows equally long
    std::size_t first_row = 0;   ///< the rows' ends start here in CsgArguments::row_ends
    std::string_view text;       ///< kString: between the quotes, with its backslashes
    SourceLocation not_finite;   ///< first nan or inf; line 0: none
};

class CsgArguments {
  public:
    /// Reads "(...)" at the cursor; fails with a place and what was expected.
    void read(TextCursor& cursor);

    const std::vector<CsgArgument>& all() const { return arguments_; }
    /// The argument of that name, or the nameless one at `position` (-1: names only); null if there is none.
    const CsgArgument* find(std::string_view name, int position = -1) const;
    const double* numbers(const CsgArgument& argument) const { return numbers_.data() + argument.first; }
    /// Where each row of a list ends, counted in numbers from the list's first one.
    const std::size_t* row_ends(const CsgArgument& argument) const {
        return row_ends_.data() + argument.first_row;
    }

  private:
    void read_value(TextCursor& cursor, CsgArgument& argument);
    void read_list(TextCursor& cursor, CsgArgument& argument);
    void read_scalar(TextCursor& cursor, CsgArgument& argument);

    std::vector<CsgArgument> arguments_;
    std::vector<double> numbers_;
    std::vector<std::size_t> row_ends_;
};

/// Skips blanks and // and /* */ comments.
void skip_csg_blanks(TextCursor& cursor);

}  // namespace mortise::model_reader
