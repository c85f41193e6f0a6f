// Where the models of others are: MORTISE_CORPORA, or shared/corpora beside the checkout. A clone may have
// neither; tests skip what is not there, and say so.
#pragma once

#include <cstdlib>
#include <filesystem>

namespace mortise::test {

inline std::filesystem::path corpora_folder() {
    const char* const named = std::getenv("MORTISE_CORPORA");
    return named != nullptr ? std::filesystem::path(named)
                            : std::filesystem::path(MORTISE_SOURCE_DIR) / "../shared/corpora";
}

}  // namespace mortise::test
