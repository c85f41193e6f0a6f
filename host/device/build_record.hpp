// A note in the cache folder that some programs have been built: to be read before a driver is opened, when
// it is not known yet under which names their binaries are.
#pragma once

#include <string>
#include <vector>

#include "host/device/device.hpp"

namespace mortise::device {

/// Whether the programs need not be built ahead: remember_built was called with the same arguments, and the
/// same kernel text, MORTISE_DEVICE and processor; or there is no folder to keep them in. A driver that has
/// changed since is not noticed; its programs are built when they are used. Opens no driver.
bool are_built(const std::vector<ProgramName>& programs, const std::string& choice,
               const DeviceOptions& options);
void remember_built(const std::vector<ProgramName>& programs, const std::string& choice,
                    const DeviceOptions& options);

}  // namespace mortise::device
