// Internal to host/device: the text and options with which every program is built, and the key of its binary.
#pragma once

#include <string>

#include "host/device/opencl.hpp"

namespace mortise::device {

/// Options of clBuildProgram for this device; `defines` come from the caller of Device::kernel.
std::string build_options(const FoundDevice& device, int lanes, int work_group_size,
                          const std::string& defines);

/// Kernel text with the prelude that device.hpp promises.
std::string with_prelude(const std::string& source);

/// Key of a built program: platform, driver, device and options; the caller appends the source.
std::string binary_key(const FoundDevice& device, const std::string& options);

/// What went wrong in a build of `source`; `log` is the compiler's.
std::string build_failure(const FoundDevice& device, const std::string& file, const std::string& options,
                          const std::string& source, const std::string& log);

/// A compiler's log with places as file and line, where it counts the lines of the whole text ("<kernel>:7:")
/// and does not heed #line, as NVIDIA's does.
std::string with_places(const std::string& log, const std::string& source);

/// Throws Error(kDevice) if PoCL would abort for lack of a linker.
void require_linker(const FoundDevice& device);

}  // namespace mortise::device
