// Names of formats and extensions mean the same in any case of letters.
#pragma once

#include <string>

namespace mortise {

/// ASCII letters only, whatever the locale.
inline char lower_case(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }
inline std::string lower_case(std::string text) {
    for (char& c : text) c = lower_case(c);
    return text;
}

}  // namespace mortise
