// Internal to host/device: plain OpenCL calls that need no queue, error names, and the device list.
#pragma once

#include <CL/cl.h>

#include <string>
#include <vector>

#include "host/device/device.hpp"

namespace mortise::device {

/// "CL_OUT_OF_RESOURCES" and so on; unknown codes as numbers.
std::string error_name(cl_int code);

/// Throws Error(kDevice): "<what>: <call> failed with <name> (<code>)", and what to do where that is known.
[[noreturn]] void fail(cl_int code, const std::string& call, const std::string& what);

inline void check(cl_int code, const char* call, const std::string& what) {
    if (code != CL_SUCCESS) fail(code, call, what);
}

struct FoundDevice {
    cl_platform_id platform = nullptr;
    cl_device_id id = nullptr;
    DeviceInfo info;
    std::string platform_version;
    bool is_cpu = false;
    bool is_pocl = false;
    bool has_exact_float = false;  ///< can round float division and square root correctly
};

/// What list_devices lists, with handles. Prepares the environment first.
std::vector<FoundDevice> find_devices();

/// What to do if there is none: a driver may be missing, or memory to load it.
std::string no_device_remedy();

/// Asks a device again; memory figures may have changed.
DeviceInfo describe(cl_platform_id platform, cl_device_id id);

}  // namespace mortise::device
