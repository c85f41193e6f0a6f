// Text of the report: numbers with few digits, and tables.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace mortise::bench {

/// Fixed-point text.
std::string fixed(double value, int digits);

/// Three significant digits in fixed point: 0.0123, 1.23, 12.3, 1234.
std::string short_number(double value);

/// 1234567 as 1,234,567.
std::string grouped(std::uint64_t count);

/// 0.123 as 12 %.
std::string percent(double share);

/// A table whose columns are as wide as their widest cell: the first one aligned left, the others right.
class Table {
  public:
    /// Each heading is a name and, on a second line, a unit; both may be empty.
    struct Heading {
        std::string name;
        std::string unit;
    };
    explicit Table(std::vector<Heading> headings);
    void add(std::vector<std::string> cells);  ///< as many as there are headings
    void print() const;                        ///< to stdout

  private:
    std::vector<std::vector<std::string>> rows_;
};

}  // namespace mortise::bench
