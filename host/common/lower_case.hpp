// Names of formats and extensions mean the same in any case of letters.
#pragma once

#include <string>

namespace mortise {

/// ASCII letters only, whatever the locale.
inline std::string lower_case(std::string text) {
    for (char& c : text) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    return text;
}

}  // namespace mortise
