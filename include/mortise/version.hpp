// Which Mortise this is.
#pragma once

namespace mortise {

/// "major.minor.patch", of the library that runs.
const char* version() noexcept;

}  // namespace mortise
