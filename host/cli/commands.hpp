// The commands of `mortise`; each prints its result on stdout, throws what went wrong, and else returns the
// exit code.
#pragma once

#include "host/cli/arguments.hpp"

namespace mortise::cli {

ExitCode mesh_command(const Arguments& arguments);
ExitCode estimate_command(const Arguments& arguments);
ExitCode batch_command(const Arguments& arguments);
ExitCode check_command(const Arguments& arguments);
ExitCode devices_command(const Arguments& arguments);
ExitCode doctor_command(const Arguments& arguments);
ExitCode info_command(const Arguments& arguments);
ExitCode kernels_command(const Arguments& arguments);

}  // namespace mortise::cli
