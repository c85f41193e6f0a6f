// See opencl.hpp.
#include "host/device/opencl.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <cstdlib>

#include "host/common/lower_case.hpp"
#include "host/device/environment.hpp"
#include "mortise/error.hpp"

namespace mortise::device {
namespace {

constexpr rlim_t kEnoughForDrivers = rlim_t{1} << 30;  // bytes; PoCL with LLVM takes 300 to 500 MB
constexpr cl_int kNoPlatform = -1001;                  // CL_PLATFORM_NOT_FOUND_KHR, from the ICD loader

const char* remedy(cl_int code) {
    switch (code) {
        case CL_MEM_OBJECT_ALLOCATION_FAILURE:
        case CL_OUT_OF_RESOURCES:
            return "; the device is out of memory: choose a lower level, or another device";
        case CL_OUT_OF_HOST_MEMORY:
            return "; memory is out: choose a lower level, or raise the process's limit (ulimit -v)";
        case CL_INVALID_BUFFER_SIZE: return "; choose a lower level, or another device";
        case CL_INVALID_WORK_GROUP_SIZE: return "; choose a smaller work-group size";
        case CL_DEVICE_NOT_AVAILABLE:
        case CL_COMPILER_NOT_AVAILABLE: return "; choose another device (`mortise devices` lists them)";
        default: return "";
    }
}

std::string text(cl_device_id id, cl_device_info what) {
    std::size_t size = 0;
    check(clGetDeviceInfo(id, what, 0, nullptr, &size), "clGetDeviceInfo", "reading a device's description");
    std::string value(size, '\0');
    check(clGetDeviceInfo(id, what, size, value.data(), nullptr), "clGetDeviceInfo",
          "reading a device's description");
    while (!value.empty() && (value.back() == '\0' || value.back() == ' ')) value.pop_back();
    return value;
}

std::string text(cl_platform_id id, cl_platform_info what) {
    std::size_t size = 0;
    check(clGetPlatformInfo(id, what, 0, nullptr, &size), "clGetPlatformInfo",
          "reading a platform's description");
    std::string value(size, '\0');
    check(clGetPlatformInfo(id, what, size, value.data(), nullptr), "clGetPlatformInfo",
          "reading a platform's description");
    while (!value.empty() && (value.back() == '\0' || value.back() == ' ')) value.pop_back();
    return value;
}

template <class T>
T number(cl_device_id id, cl_device_info what) {
    T value{};
    check(clGetDeviceInfo(id, what, sizeof value, &value, nullptr), "clGetDeviceInfo",
          "reading a device's description");
    return value;
}

std::string listing(const std::vector<DeviceInfo>& devices) {
    std::string lines;
    for (std::size_t i = 0; i < devices.size(); ++i) {
        lines += (i == 0 ? "" : ", ") + std::to_string(i) + ": " + devices[i].name + " (" +
                 devices[i].platform + ")";
    }
    return lines;
}

bool is_all_digits(const std::string& value) {
    return !value.empty() && value.find_first_not_of("0123456789") == std::string::npos;
}

bool matches(const std::string& choice, const DeviceInfo& device) {
    const std::string wanted = lower_case(choice);
    if (wanted == "gpu") return device.is_gpu;
    // A CPU's name may hold "GPU" or "CPU" or neither; what counts is its type.
    if (wanted == "cpu") return !device.is_gpu;
    return lower_case(device.name).find(wanted) != std::string::npos ||
           lower_case(device.platform).find(wanted) != std::string::npos;
}

std::size_t default_device(const std::vector<DeviceInfo>& devices) {
    for (std::size_t i = 0; i < devices.size(); ++i) {
        if (devices[i].is_gpu && devices[i].has_double) return i;
    }
    for (std::size_t i = 0; i < devices.size(); ++i) {
        if (devices[i].platform == "Portable Computing Language" && devices[i].has_double) return i;
    }
    for (std::size_t i = 0; i < devices.size(); ++i) {
        if (devices[i].has_double) return i;
    }
    return 0;
}

}  // namespace

std::string error_name(cl_int code) {
    switch (code) {
#define MORTISE_NAME(name) \
    case name: return #name
        MORTISE_NAME(CL_SUCCESS);
        MORTISE_NAME(CL_DEVICE_NOT_FOUND);
        MORTISE_NAME(CL_DEVICE_NOT_AVAILABLE);
        MORTISE_NAME(CL_COMPILER_NOT_AVAILABLE);
        MORTISE_NAME(CL_MEM_OBJECT_ALLOCATION_FAILURE);
        MORTISE_NAME(CL_OUT_OF_RESOURCES);
        MORTISE_NAME(CL_OUT_OF_HOST_MEMORY);
        MORTISE_NAME(CL_PROFILING_INFO_NOT_AVAILABLE);
        MORTISE_NAME(CL_MEM_COPY_OVERLAP);
        MORTISE_NAME(CL_BUILD_PROGRAM_FAILURE);
        MORTISE_NAME(CL_MAP_FAILURE);
        MORTISE_NAME(CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST);
        MORTISE_NAME(CL_LINKER_NOT_AVAILABLE);
        MORTISE_NAME(CL_INVALID_VALUE);
        MORTISE_NAME(CL_INVALID_PLATFORM);
        MORTISE_NAME(CL_INVALID_DEVICE);
        MORTISE_NAME(CL_INVALID_CONTEXT);
        MORTISE_NAME(CL_INVALID_COMMAND_QUEUE);
        MORTISE_NAME(CL_INVALID_HOST_PTR);
        MORTISE_NAME(CL_INVALID_MEM_OBJECT);
        MORTISE_NAME(CL_INVALID_BINARY);
        MORTISE_NAME(CL_INVALID_BUILD_OPTIONS);
        MORTISE_NAME(CL_INVALID_PROGRAM);
        MORTISE_NAME(CL_INVALID_PROGRAM_EXECUTABLE);
        MORTISE_NAME(CL_INVALID_KERNEL_NAME);
        MORTISE_NAME(CL_INVALID_KERNEL);
        MORTISE_NAME(CL_INVALID_ARG_INDEX);
        MORTISE_NAME(CL_INVALID_ARG_VALUE);
        MORTISE_NAME(CL_INVALID_ARG_SIZE);
        MORTISE_NAME(CL_INVALID_KERNEL_ARGS);
        MORTISE_NAME(CL_INVALID_WORK_GROUP_SIZE);
        MORTISE_NAME(CL_INVALID_WORK_ITEM_SIZE);
        MORTISE_NAME(CL_INVALID_EVENT);
        MORTISE_NAME(CL_INVALID_OPERATION);
        MORTISE_NAME(CL_INVALID_BUFFER_SIZE);
        MORTISE_NAME(CL_INVALID_GLOBAL_WORK_SIZE);
#undef MORTISE_NAME
        case kNoPlatform: return "CL_PLATFORM_NOT_FOUND_KHR";
        default: return "OpenCL error";
    }
}

void fail(cl_int code, const std::string& call, const std::string& what) {
    throw Error(ExitCode::kDevice, what + ": " + call + " failed with " + error_name(code) + " (" +
                                       std::to_string(code) + ")" + remedy(code));
}

DeviceInfo describe(cl_platform_id platform, cl_device_id id) {
    DeviceInfo info;
    info.name = text(id, CL_DEVICE_NAME);
    info.platform = text(platform, CL_PLATFORM_NAME);
    info.version = text(id, CL_DEVICE_VERSION);
    info.driver = text(id, CL_DRIVER_VERSION);
    info.is_gpu = (number<cl_device_type>(id, CL_DEVICE_TYPE) & CL_DEVICE_TYPE_GPU) != 0;
    info.has_double = number<cl_device_fp_config>(id, CL_DEVICE_DOUBLE_FP_CONFIG) != 0;
    info.compute_units = number<cl_uint>(id, CL_DEVICE_MAX_COMPUTE_UNITS);
    info.global_bytes = number<cl_ulong>(id, CL_DEVICE_GLOBAL_MEM_SIZE);
    info.max_allocation_bytes = number<cl_ulong>(id, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
    info.local_bytes = number<cl_ulong>(id, CL_DEVICE_LOCAL_MEM_SIZE);
    info.max_work_group = static_cast<unsigned>(number<std::size_t>(id, CL_DEVICE_MAX_WORK_GROUP_SIZE));
    return info;
}

std::vector<FoundDevice> find_devices() {
    prepare_environment();
    std::vector<FoundDevice> found;
    cl_uint platform_count = 0;
    cl_int code = clGetPlatformIDs(0, nullptr, &platform_count);
    if (code == kNoPlatform || (code == CL_SUCCESS && platform_count == 0)) return found;
    check(code, "clGetPlatformIDs", "looking for OpenCL platforms");
    std::vector<cl_platform_id> platforms(platform_count);
    check(clGetPlatformIDs(platform_count, platforms.data(), nullptr), "clGetPlatformIDs",
          "looking for OpenCL platforms");
    for (const cl_platform_id platform : platforms) {
        const std::string name = text(platform, CL_PLATFORM_NAME);
        cl_uint count = 0;
        code = clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &count);
        if (code == CL_DEVICE_NOT_FOUND || (code == CL_SUCCESS && count == 0)) continue;
        check(code, "clGetDeviceIDs", "looking for devices of OpenCL platform " + name);
        std::vector<cl_device_id> ids(count);
        check(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, count, ids.data(), nullptr), "clGetDeviceIDs",
              "looking for devices of OpenCL platform " + name);
        for (const cl_device_id id : ids) {
            FoundDevice device;
            device.platform = platform;
            device.id = id;
            device.info = describe(platform, id);
            device.platform_version = text(platform, CL_PLATFORM_VERSION);
            device.is_cpu = (number<cl_device_type>(id, CL_DEVICE_TYPE) & CL_DEVICE_TYPE_CPU) != 0;
            device.is_pocl = name == "Portable Computing Language";
            device.has_exact_float = (number<cl_device_fp_config>(id, CL_DEVICE_SINGLE_FP_CONFIG) &
                                      CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
            found.push_back(std::move(device));
        }
    }
    return found;
}

std::string no_device_remedy() {
    const std::string install =
        "install a driver, e.g. `apt-get install pocl-opencl-icd` for the CPU, or your GPU's";
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur > kEnoughForDrivers) return install;
    return "the process may have " + std::to_string(limit.rlim_cur >> 20) +
           " MiB of memory (ulimit -v), in which a driver may not fit: raise that limit; else " + install;
}

std::vector<DeviceInfo> list_devices() {
    std::vector<DeviceInfo> devices;
    for (FoundDevice& found : find_devices()) devices.push_back(std::move(found.info));
    return devices;
}

std::size_t choose_device(const std::string& choice, const std::vector<DeviceInfo>& devices) {
    if (devices.empty()) throw Error(ExitCode::kDevice, "no OpenCL device found: " + no_device_remedy());
    std::string wanted = choice;
    std::string origin = "device";
    const char* const variable = std::getenv("MORTISE_DEVICE");
    if (wanted.empty() && variable != nullptr && *variable != '\0') {
        wanted = variable;
        origin = "MORTISE_DEVICE";
    }
    if (wanted.empty()) return default_device(devices);
    if (is_all_digits(wanted)) {
        if (wanted.size() < 6 && std::stoul(wanted) < devices.size()) return std::stoul(wanted);
    } else {
        for (std::size_t i = 0; i < devices.size(); ++i) {
            if (matches(wanted, devices[i])) return i;
        }
    }
    throw Error(
        ExitCode::kDevice,
        origin + " \"" + wanted +
            "\" not found; expected an index, \"cpu\", \"gpu\" or part of a name of: " + listing(devices));
}

}  // namespace mortise::device
