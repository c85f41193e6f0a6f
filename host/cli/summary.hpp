// What a run tells on stdout when it is done.
#pragma once

#include <cstdint>
#include <string>

#include "host/cli/arguments.hpp"
#include "host/cli/figures.hpp"
#include "mortise/check.hpp"
#include "mortise/mesher.hpp"

namespace mortise::cli {

/// `check`: null if it was not asked for.
std::string summary(const Arguments& arguments, const MeshReport& report, const MeshFigures& figures,
                    const CheckReport* check);

/// The most memory that this process has had, bytes.
std::uint64_t peak_memory();

}  // namespace mortise::cli
