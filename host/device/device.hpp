// The device layer: the only code that includes OpenCL, Boost.Compute or CLBlast headers.
//
// A Device is one OpenCL device with one in-order, profiled queue. One host thread owns it: it allocates,
// launches and maps; other threads may only call Event::wait() and Event::done(). Handles (Buffer, Kernel,
// Event, MappedSpan) keep what they need alive, so the order of destruction does not matter.
//
// What a kernel file can rely on (kernels/*.cl, OpenCL C 1.2; the prelude is in build_options.cpp):
// - `#pragma OPENCL FP_CONTRACT OFF`, no fast-math: + - * / sqrt fma in double equal the host's, bit for bit
//   (kernels/probe.cl checks that at first use of a device);
// - LANES (8 on CPU, 1 on GPU) and MORTISE_WORK_GROUP (the local size, always one-dimensional) are defined,
//   and MORTISE_KERNEL stands for `__kernel` with that work-group size required;
// - its last parameter is `uint items`, filled in by launch(); the global size is padded to whole groups, so
//   it starts with `if (get_global_id(0) >= items) return;` (or guards around its barriers);
// - `#include "shared/name.h"` finds kernels/shared/name.h, once per program (a .def file: each time).
//
//     Device device;                                           // choice: environment, GPU, else CPU
//     Buffer values = device.allocate(count * sizeof(double));
//     device.upload(values, host.data(), count);
//     Kernel scale = device.kernel("example.cl", "scale");     // MORTISE_KERNEL void scale(
//     device.launch(scale, count, values, 2.0);                //     global double* v, double s, uint items)
//     auto mapped = device.map<double>(values, Access::kRead); // waits for the kernel
//
// Every failure is an Error(ExitCode::kDevice) that names the call, the value and what to do.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace mortise::device {

/// What a device says about itself. Memory figures are those of the moment: some drivers let them grow.
struct DeviceInfo {
    std::string name;
    std::string platform;
    std::string version;  ///< OpenCL version of the device
    std::string driver;
    bool is_gpu = false;
    bool has_double = false;
    unsigned compute_units = 0;
    std::uint64_t global_bytes = 0;
    std::uint64_t max_allocation_bytes = 0;
    std::uint64_t local_bytes = 0;
    unsigned max_work_group = 0;
};

/// All devices of all platforms; the position is the index that a choice may name. Empty if there is no
/// OpenCL driver. Throws Error(kDevice) only for a driver that fails.
std::vector<DeviceInfo> list_devices();

/// Position in `devices` of what `choice` means: an index, "cpu", "gpu", or part of a device's name or
/// platform (upper and lower case alike; the first that matches). Empty: the environment variable
/// MORTISE_DEVICE, else the first GPU with double precision, else PoCL, else the first with double precision.
/// Throws Error(kDevice) listing the devices if nothing matches, or saying what to install if there is none.
std::size_t choose_device(const std::string& choice, const std::vector<DeviceInfo>& devices);

/// Settings of a Device; the defaults are right except for tests and experiments.
struct DeviceOptions {
    int work_group_size = 0;     ///< local size of every launch; 0: 32 on CPU, 128 on GPU
    int lanes = 0;               ///< LANES of kernels, 1, 2, 4, 8 or 16; 0: 8 on CPU, 1 on GPU
    bool disk_cache = true;      ///< keep built programs in the cache folder
    std::string cache_folder;    ///< this one, and no other is looked into; empty: that of the environment
    std::string kernels_folder;  ///< load kernels from here; empty: $MORTISE_KERNELS, else the embedded ones
    bool probe = true;           ///< compare the device's arithmetic with the host's at first use
    bool copies = false;         ///< move memory as for devices with memory of their own: tests on a CPU
};

/// A program: kernels/`file`, built with `defines`.
struct ProgramName {
    std::string file;     ///< e.g. "octree/descend.cl"
    std::string defines;  ///< e.g. "-DTOPOLOGY=3"
};

enum class Access { kRead, kWrite, kReadWrite };  ///< kWrite: the old content is lost

/// Device memory. Movable; an empty one (default-constructed) can only be assigned to or destroyed.
class Buffer {
  public:
    Buffer() = default;
    Buffer(Buffer&& other) noexcept
        : implementation_(std::move(other.implementation_)), bytes_(std::exchange(other.bytes_, 0)) {}
    Buffer& operator=(Buffer&& other) noexcept {
        implementation_ = std::move(other.implementation_);
        bytes_ = std::exchange(other.bytes_, 0);
        return *this;
    }
    Buffer(const Buffer&) = delete;
    Buffer& operator=(const Buffer&) = delete;

    std::size_t bytes() const { return bytes_; }
    template <class T>
    std::size_t count() const {
        return bytes_ / sizeof(T);
    }
    explicit operator bool() const { return implementation_ != nullptr; }

    struct Implementation;

  private:
    friend class Device;
    friend struct Internals;
    std::shared_ptr<Implementation> implementation_;
    std::size_t bytes_ = 0;
};

/// One entry point of a built program. Cheap to copy.
class Kernel {
  public:
    Kernel() = default;
    const std::string& entry() const;

  private:
    friend class Device;
    friend struct Internals;
    struct Implementation;
    std::shared_ptr<Implementation> implementation_;
};

/// End of a launch. Cheap to copy; safe to use from any thread. A default-constructed one is done.
class Event {
  public:
    void wait() const;  ///< Throws Error(kDevice) if the launch failed.
    bool done() const;

  private:
    friend class Device;
    friend struct Internals;
    struct Implementation;
    std::shared_ptr<Implementation> implementation_;
};

/// Untyped mapping of a buffer into host memory; unmapped on destruction. See MappedSpan.
class Mapping {
  public:
    Mapping() = default;
    Mapping(Mapping&&) noexcept = default;
    Mapping& operator=(Mapping&&) noexcept = default;
    void* data() const;
    std::size_t bytes() const;

  private:
    friend class Device;
    struct Implementation;
    std::shared_ptr<Implementation> implementation_;
};

/// A buffer's content as an array of T while this object lives. No launch may use the buffer meanwhile.
template <class T>
class MappedSpan {
  public:
    MappedSpan() = default;
    explicit MappedSpan(Mapping mapping)
        : mapping_(std::move(mapping)),
          data_(static_cast<T*>(mapping_.data())),
          size_(mapping_.bytes() / sizeof(T)) {}
    T* data() const { return data_; }
    std::size_t size() const { return size_; }
    T* begin() const { return data_; }
    T* end() const { return data_ + size_; }
    T& operator[](std::size_t index) const { return data_[index]; }

  private:
    Mapping mapping_;
    T* data_ = nullptr;
    std::size_t size_ = 0;
};

/// A kernel argument `local T*` of that many bytes per work-group.
struct LocalMemory {
    std::size_t bytes;
};

/// One argument of a launch: a Buffer, LocalMemory, or a plain value (int32, uint32, uint64, float, double,
/// or a struct of kernels/shared). Refers to its source, so it lives no longer than the launch expression.
class Argument {
  public:
    Argument(const Buffer& buffer) : buffer_(&buffer) {}
    Argument(const LocalMemory& local) : bytes_(local.bytes) {}
    template <class T>
    Argument(const T& value) : value_(&value), bytes_(sizeof(T)) {
        static_assert(std::is_trivially_copyable_v<T> && !std::is_pointer_v<T> && !std::is_same_v<T, bool>,
                      "kernel arguments are buffers, numbers or plain structs");
    }

  private:
    friend class Device;
    const Buffer* buffer_ = nullptr;
    const void* value_ = nullptr;
    std::size_t bytes_ = 0;
};

/// Sum over the launches of one kernel entry.
struct KernelTime {
    std::string entry;
    std::uint64_t launches = 0;
    std::uint64_t items = 0;
    double seconds = 0;  ///< wall time on the device, from profiling events
};

/// Device memory held by Buffers of one Device.
struct MemoryUse {
    std::uint64_t bytes = 0;
    std::uint64_t peak = 0;
};

class Device {
  public:
    /// Opens a device; `choice` as for choose_device.
    explicit Device(const std::string& choice = {}, const DeviceOptions& options = {});
    Device(Device&&) noexcept = default;
    Device& operator=(Device&&) noexcept = default;
    ~Device() = default;  ///< Waits for everything launched.

    const DeviceInfo& info() const;
    int lanes() const;
    int work_group_size() const;
    bool float_is_exact() const;  ///< the probe found float + - * / sqrt fma equal to the host's too

    /// New memory, content undefined. Zero bytes give a buffer that can be passed to kernels but not touched.
    Buffer allocate(std::size_t bytes);

    /// Host memory as a buffer: on CPU devices kernels work in it directly, without a copy. Other devices
    /// have a copy, whose content is undefined until sync_to_device.
    ///
    /// `host` must outlive the buffer and not move. Call sync_to_device after host writes and before a
    /// launch that reads them, sync_to_host after launches and before host reads: it overwrites all of
    /// `host`. Kernels must not use vector pointers (double8*) into it unless `host` is aligned for them;
    /// vload/vstore are safe.
    Buffer wrap(void* host, std::size_t bytes);
    void sync_to_host(Buffer& buffer);    ///< Waits for the launches before it.
    void sync_to_device(Buffer& buffer);  ///< Whole buffer.

    /// An array that kernels only read, and that outlives the buffer: wrapped, and on the device.
    template <class T>
    Buffer lend(const T* data, std::size_t count) {
        static_assert(std::is_trivially_copyable_v<T>);
        Buffer buffer = wrap(const_cast<T*>(data), count * sizeof(T));
        sync_to_device(buffer);
        return buffer;
    }

    /// Copies `count` values into the buffer from element `offset` on; the range must lie inside.
    template <class T>
    void upload(Buffer& buffer, const T* data, std::size_t count, std::size_t offset = 0) {
        static_assert(std::is_trivially_copyable_v<T>);
        upload_bytes(buffer, data, count * sizeof(T), offset * sizeof(T));
    }
    template <class T>
    Buffer upload(const std::vector<T>& data) {
        Buffer buffer = allocate(data.size() * sizeof(T));
        upload(buffer, data.data(), data.size());
        return buffer;
    }
    template <class T>
    void download(const Buffer& buffer, T* data, std::size_t count, std::size_t offset = 0) {
        static_assert(std::is_trivially_copyable_v<T>);
        download_bytes(buffer, data, count * sizeof(T), offset * sizeof(T));
    }
    template <class T>
    std::vector<T> download(const Buffer& buffer, std::size_t count, std::size_t offset = 0) {
        std::vector<T> data(count);
        download(buffer, data.data(), count, offset);
        return data;
    }

    /// Maps the whole buffer, or `count` values from `offset` on. Waits for the launches before it.
    template <class T>
    MappedSpan<T> map(Buffer& buffer, Access access) {
        return MappedSpan<T>(map_bytes(buffer, access, buffer.count<T>() * sizeof(T), 0));
    }
    template <class T>
    MappedSpan<T> map(Buffer& buffer, Access access, std::size_t count, std::size_t offset = 0) {
        return MappedSpan<T>(map_bytes(buffer, access, count * sizeof(T), offset * sizeof(T)));
    }

    void fill_zero(Buffer& buffer) { fill_zero(buffer, buffer.bytes()); }
    void fill_zero(Buffer& buffer, std::size_t bytes, std::size_t offset = 0);
    void copy(const Buffer& from, Buffer& to, std::size_t bytes, std::size_t from_offset = 0,
              std::size_t to_offset = 0);

    /// A kernel of kernels/`file` (e.g. "octree/descend.cl"), built at first use with `defines` (e.g.
    /// "-DTOPOLOGY=3"); programs are kept in memory, and in the cache folder between runs.
    Kernel kernel(const std::string& file, const std::string& entry, const std::string& defines = {});

    /// Builds a program with all its kernels, unless it is there already.
    void build(const ProgramName& program);

    /// Begins to load programs that lie in the cache folder, in this order, while the caller goes on; others
    /// are left alone. kernel() waits for those that are being loaded.
    void load_ahead(const std::vector<ProgramName>& programs);

    /// Runs a kernel over `items` work-items; the kernel's last parameter `uint items` is added here.
    /// Returns at once. No items: launches nothing.
    template <class... Arguments>
    Event launch(const Kernel& kernel, std::size_t items, const Arguments&... arguments) {
        const std::uint32_t count = checked_items(kernel, items);
        const Argument list[] = {Argument(arguments)..., Argument(count)};
        return launch_arguments(kernel, items, list, sizeof...(Arguments) + 1, Cut::kAllowed);
    }

    /// `look` is called several times a second while long launches run, by the thread that launches; it may
    /// throw. These are cut into slices, and launch() returns when the last of them begins. Null: not so.
    void set_look(void (*look)());

    /// out[i] = in[0] + ... + in[i-1] for 0 <= i <= n; returns out[n], the total.
    ///
    /// `in`: at least n uint32; `out`: at least n + 1 uint32 (uint64 for the second). The first throws
    /// Error(kDevice) if the total is 2^32 or more, and allows `in` and `out` to be the same buffer.
    std::uint64_t exclusive_scan_u32(const Buffer& in, Buffer& out, std::size_t n);
    std::uint64_t exclusive_scan_u64(const Buffer& in, Buffer& out, std::size_t n);

    /// C = A · B in double precision by CLBlast. Matrices are stored by columns without gaps: A is m × k, B
    /// k × n, C m × n, and C is neither A nor B. Returns at once, except that CLBlast builds its kernels at
    /// the first call of a process (tens of seconds on a CPU). `times` counts the last of its kernels only.
    Event multiply(const Buffer& a, const Buffer& b, Buffer& c, std::size_t m, std::size_t n, std::size_t k);

    void finish();  ///< Waits for everything launched so far.

    std::vector<KernelTime> times() const;  ///< Waits; sorted by seconds, longest first.
    void reset_times();
    MemoryUse memory() const;

  private:
    friend struct Internals;
    /// Kernels that ask for their group's number are not to be cut.
    enum class Cut : std::uint8_t { kAllowed, kNever };
    template <class... Arguments>
    Event launch_whole(const Kernel& kernel, std::size_t items, const Arguments&... arguments) {
        const std::uint32_t count = checked_items(kernel, items);
        const Argument list[] = {Argument(arguments)..., Argument(count)};
        return launch_arguments(kernel, items, list, sizeof...(Arguments) + 1, Cut::kNever);
    }
    static std::uint32_t checked_items(const Kernel& kernel, std::size_t items);
    Event launch_arguments(const Kernel& kernel, std::size_t items, const Argument* arguments,
                           std::size_t count, Cut cut);
    void upload_bytes(Buffer& buffer, const void* data, std::size_t bytes, std::size_t offset);
    void download_bytes(const Buffer& buffer, void* data, std::size_t bytes, std::size_t offset);
    Mapping map_bytes(Buffer& buffer, Access access, std::size_t bytes, std::size_t offset);
    std::uint64_t exclusive_scan(const Buffer& in, Buffer& out, std::size_t n, bool wide);

    struct Implementation;
    std::shared_ptr<Implementation> implementation_;
};

/// Waits for all launches when it goes: where kernels work in the host's own arrays (Device::wrap), these
/// must outlive it, however a run ends.
class KernelsEnd {
  public:
    explicit KernelsEnd(Device& device) : device_(device) {}
    ~KernelsEnd();
    KernelsEnd(const KernelsEnd&) = delete;
    KernelsEnd& operator=(const KernelsEnd&) = delete;

  private:
    Device& device_;
};

}  // namespace mortise::device
