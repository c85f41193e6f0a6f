// What writer and reader of .msh share. See msh_write.cpp for the layout.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace mortise::io {

/// First line of the $Comments section of our files; the number counts versions of that section.
inline constexpr const char* kMshSignature = "mortise mesh 1";

/// First word of the comments' line with the numbers of facets and elements, which tells their order, too.
inline constexpr const char* kMshCounts = "counts";
inline constexpr const char* kMshSecondCounts = "counts_of_second_order";

/// First word of the comments' line with the numbers of periodic pairs and of links in $Periodic, if there
/// are any; the pair of each link follows, a line each.
inline constexpr const char* kMshPeriodic = "periodic";

/// Names may hold any byte, lines of text may not: what is not printable ASCII becomes %XX.
inline std::string encode_name(const std::string& name) {
    constexpr char digits[] = "0123456789ABCDEF";
    std::string text;
    for (const char c : name) {
        const unsigned char code = static_cast<unsigned char>(c);
        if (code > 0x20 && code < 0x7f && c != '%') {
            text += c;
        } else {
            text += {'%', digits[code / 16], digits[code % 16]};
        }
    }
    return text;
}

/// The inverse; false if the text is no encoded name.
inline bool decode_name(const std::string& text, std::string& name) {
    const auto digit = [](char c) {
        return c >= '0' && c <= '9' ? c - '0' : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
    };
    name.clear();
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            name += text[i];
            continue;
        }
        if (i + 2 >= text.size() || digit(text[i + 1]) < 0 || digit(text[i + 2]) < 0) return false;
        name += static_cast<char>(16 * digit(text[i + 1]) + digit(text[i + 2]));
        i += 2;
    }
    return true;
}

}  // namespace mortise::io
