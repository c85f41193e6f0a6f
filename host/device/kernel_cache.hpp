// Internal to host/device: where compiled kernels are kept.
#pragma once

#include <string>
#include <vector>

#include "host/device/device.hpp"
#include "host/device/disk_cache.hpp"

namespace mortise::device {

/// Folders of kernels that were compiled when the program or library was installed (`mortise kernels -o`), to
/// be read only: $MORTISE_COMPILED_KERNELS, else `compiled-kernels` beside the program (a build folder), in
/// `mortise` beside the library, and where the program's prefix has its libraries. They need not exist, and
/// may be of another machine: what does not fit this one is not found in them.
std::vector<std::string> installed_kernel_folders();

/// The cache folder of a device with these options, empty if it has none.
std::string chosen_cache_folder(const DeviceOptions& options);

/// That folder, and behind it, unless the options name one, those that are installed.
DiskCache kernel_cache(const DeviceOptions& options);

}  // namespace mortise::device
