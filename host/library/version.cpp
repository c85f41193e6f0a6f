#include "mortise/version.hpp"

namespace mortise {

const char* version() noexcept { return MORTISE_VERSION; }

}  // namespace mortise
