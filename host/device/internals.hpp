// Internal to host/device: OpenCL handles behind the public types, for files that do without Boost.Compute.
#pragma once

#include <string>

#include "host/device/device.hpp"
#include "host/device/disk_cache.hpp"
#include "host/device/opencl.hpp"

namespace mortise::device {

struct Internals {
    static cl_command_queue queue(const Device& device);
    static cl_mem memory(const Buffer& buffer);
    /// Identifies driver, device and build options: results that depend on them are remembered under it.
    static std::string build_key(const Device& device);
    static const DiskCache& cache(const Device& device);
    static bool is_cpu(const Device& device);
};

/// Outcome of the arithmetic probe (probe.cpp).
struct ProbeResult {
    bool float_is_exact = false;
};

/// Compares the device's arithmetic with the host's, or recalls the result from the cache folder. Throws
/// Error(kDevice), naming operation and operands, if double precision differs.
ProbeResult probe_arithmetic(Device& device);

}  // namespace mortise::device
