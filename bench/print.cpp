// Tables and numbers of the report; see print.hpp.
#include "bench/print.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>

namespace mortise::bench {
namespace {

/// Characters that a terminal shows for UTF-8 text.
std::size_t shown_width(const std::string& text) {
    return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char byte) {
        return (static_cast<unsigned char>(byte) & 0xc0u) != 0x80u;
    }));
}

}  // namespace

std::string fixed(double value, int digits) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", digits, value);
    return text;
}

std::string short_number(double value) {
    const double magnitude = std::fabs(value);
    if (magnitude == 0 || !std::isfinite(value)) return fixed(value, 0);
    const int digits = 2 - static_cast<int>(std::floor(std::log10(magnitude)));
    return fixed(value, std::clamp(digits, 0, 6));
}

std::string grouped(std::uint64_t count) {
    std::string text = std::to_string(count);
    for (std::size_t at = text.size(); at > 3;) text.insert(at -= 3, ",");
    return text;
}

std::string percent(double share) { return short_number(100 * share) + " %"; }

Table::Table(std::vector<Heading> headings) : rows_(2) {
    for (const Heading& heading : headings) {
        rows_[0].push_back(heading.name);
        rows_[1].push_back(heading.unit);
    }
}

void Table::add(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }

void Table::print() const {
    std::vector<std::size_t> widths(rows_[0].size(), 0);
    for (const std::vector<std::string>& row : rows_) {
        for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], shown_width(row[i]));
    }
    for (const std::vector<std::string>& row : rows_) {
        std::string line = "  ";
        for (std::size_t i = 0; i < row.size(); ++i) {
            const std::string padding(widths[i] - shown_width(row[i]), ' ');
            line += i == 0 ? row[i] + padding : "  " + padding + row[i];
        }
        line.erase(line.find_last_not_of(' ') + 1);
        if (!line.empty()) std::printf("%s\n", line.c_str());
    }
}

}  // namespace mortise::bench
