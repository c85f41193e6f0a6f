// Internal to host/device: what stands behind the public handles, in Boost.Compute types. Included by
// device.cpp, programs.cpp, memory.cpp and multiply.cpp only, which are thereby the only users of
// Boost.Compute; it takes the few headers it needs, as <boost/compute.hpp> takes 20 s to compile.
#pragma once

#include <algorithm>
#include <boost/compute/buffer.hpp>
#include <boost/compute/command_queue.hpp>
#include <boost/compute/context.hpp>
#include <boost/compute/device.hpp>
#include <boost/compute/event.hpp>
#include <boost/compute/exception/opencl_error.hpp>
#include <boost/compute/kernel.hpp>
#include <boost/compute/program.hpp>
#include <deque>
#include <future>
#include <map>
#include <optional>
#include <thread>

#include "host/device/device.hpp"
#include "host/device/disk_cache.hpp"
#include "host/device/opencl.hpp"
#include "mortise/error.hpp"

namespace mortise::device {

namespace compute = boost::compute;

/// Runs `action`; an OpenCL error becomes an Error that names the call.
template <class Action>
auto guarded(const char* call, const std::string& what, Action action) -> decltype(action()) {
    try {
        return action();
    } catch (const compute::opencl_error& error) {
        fail(error.error_code(), call, what);
    }
}

inline std::string amount(std::uint64_t bytes) {
    return std::to_string(bytes) + " bytes (" + std::to_string((bytes + (1u << 20) - 1) >> 20) + " MiB)";
}

[[noreturn]] inline void misuse(const std::string& message) { throw Error(ExitCode::kDevice, message); }

/// Bytes held by the buffers of one device; buffers may outlive it.
using MemoryCounter = std::shared_ptr<MemoryUse>;

struct Buffer::Implementation {
    Implementation(compute::buffer data, std::size_t size, MemoryCounter use)
        : memory(std::move(data)), bytes(size), counter(std::move(use)) {
        counter->bytes += bytes;
        counter->peak = std::max(counter->peak, counter->bytes);
    }
    ~Implementation() { counter->bytes -= bytes; }
    Implementation(const Implementation&) = delete;
    Implementation& operator=(const Implementation&) = delete;

    compute::buffer memory;
    std::size_t bytes;
    MemoryCounter counter;
    void* host = nullptr;  ///< Device::wrap on a device with memory of its own: what it is a copy of
    int mappings = 0;
};

struct Kernel::Implementation {
    compute::kernel handle;
    std::string file;
    std::string entry;
    std::size_t arguments = 0;
    std::size_t time_index = 0;
};

struct Event::Implementation {
    compute::event handle;
    std::string entry;
};

struct Mapping::Implementation {
    ~Implementation() {
        // An unmap that fails here cannot be reported; the next call on the queue reports it.
        clEnqueueUnmapMemObject(queue.get(), buffer->memory.get(), data, 0, nullptr, nullptr);
        --buffer->mappings;
    }
    compute::command_queue queue;
    std::shared_ptr<Buffer::Implementation> buffer;
    void* data = nullptr;
    std::size_t bytes = 0;
};

struct Device::Implementation {
    Implementation() = default;
    /// Waits for what was launched: a process that ends while PoCL's threads compile or run a kernel crashes.
    ~Implementation() {
        if (loader.joinable()) loader.join();
        if (queue.get() != nullptr) clFinish(queue.get());
    }
    Implementation(const Implementation&) = delete;
    Implementation& operator=(const Implementation&) = delete;

    FoundDevice found;
    DeviceOptions options;
    compute::context context;
    compute::command_queue queue;
    DiskCache cache{{}};
    std::string kernels_folder;
    bool float_is_exact = false;
    void (*look)() = nullptr;  ///< Device::set_look
    MemoryCounter memory = std::make_shared<MemoryUse>();
    std::map<std::string, compute::program> programs;  // by file and defines
    /// The same, of Device::load_ahead: what `loader` finds in the cache folder.
    std::map<std::string, std::future<std::optional<compute::program>>> ahead;
    std::thread loader;
    std::map<std::string, Kernel> kernels;  // by file, defines and entry
    std::vector<KernelTime> times;

    struct Pending {
        compute::event event;
        std::size_t time_index;
    };
    std::deque<Pending> pending;

    /// Whether kernels and host code reach the same bytes.
    bool shares_memory() const { return found.is_cpu && !options.copies; }
    /// Adds the times of finished launches, oldest first; `all` waits for the rest.
    void harvest(bool all);
    /// The program of kernels/`file`: from memory, the cache folder, or its text.
    const compute::program& program(const std::string& file, const std::string& defines);
    /// From the cache folder, or else nothing.
    std::optional<compute::program> load(const std::string& source, const std::string& build_flags) const;
    compute::program build(const std::string& file, const std::string& defines) const;
    std::string source_of(const std::string& file) const;
    std::string flags_of(const std::string& defines) const;
    int lanes() const;
    int work_group_size() const;
};

}  // namespace mortise::device
