// A device: opening it, launching kernels, and their times. See device.hpp.
#include "host/device/device.hpp"

#include <algorithm>
#include <chrono>
#include <limits>

#include "host/device/build_options.hpp"
#include "host/device/device_state.hpp"
#include "host/device/environment.hpp"
#include "host/device/internals.hpp"
#include "host/device/kernel_cache.hpp"
#include "host/device/kernel_source.hpp"

namespace mortise::device {
namespace {

constexpr int kWorkGroupCpu = 32;
constexpr int kWorkGroupGpu = 128;
constexpr int kLanesCpu = 8;
/// Launches are cut into slices of so many items at first, and more where these take less than so long.
constexpr std::size_t kFirstSlice = 4096;
constexpr double kSliceSeconds = 0.04;
constexpr std::size_t kPendingEvents = 64;  // harvested beyond that, so that long runs hold few events

}  // namespace

void Device::Implementation::harvest(bool all) {
    while (!pending.empty()) {
        const compute::event held = pending.front().event;
        const cl_event event = held.get();
        KernelTime& time = times[pending.front().time_index];
        // A launch that failed is told by its state, which says more than the waiting does.
        const cl_int waited = all ? clWaitForEvents(1, &event) : CL_SUCCESS;
        cl_int status = CL_COMPLETE;
        check(clGetEventInfo(event, CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof status, &status, nullptr),
              "clGetEventInfo", "asking for a launch's state");
        if (status > CL_COMPLETE) {
            check(waited, "clWaitForEvents", "kernel " + time.entry);
            return;
        }
        if (status < 0) {
            // Those behind it belong to the run that fails here: the next one shall not be told of them.
            clFinish(queue.get());
            pending.clear();
            fail(status, "clEnqueueNDRangeKernel", "kernel " + time.entry);
        }
        pending.pop_front();
        cl_ulong start = 0;
        cl_ulong end = 0;
        if (clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_START, sizeof start, &start, nullptr) ==
                CL_SUCCESS &&
            clGetEventProfilingInfo(event, CL_PROFILING_COMMAND_END, sizeof end, &end, nullptr) ==
                CL_SUCCESS &&
            end > start) {
            time.seconds += 1e-9 * static_cast<double>(end - start);
        }
    }
}

int Device::Implementation::lanes() const {
    if (options.lanes != 0) return options.lanes;
    return found.is_cpu ? kLanesCpu : 1;
}
int Device::Implementation::work_group_size() const {
    if (options.work_group_size != 0) return options.work_group_size;
    const int usual = found.is_cpu ? kWorkGroupCpu : kWorkGroupGpu;
    return std::min(usual, static_cast<int>(found.info.max_work_group));
}

const std::string& Kernel::entry() const {
    static const std::string none = "(none)";
    return implementation_ ? implementation_->entry : none;
}

void Event::wait() const {
    if (!implementation_) return;
    const cl_event event = implementation_->handle.get();
    check(clWaitForEvents(1, &event), "clWaitForEvents", "kernel " + implementation_->entry);
}

bool Event::done() const {
    if (!implementation_) return true;
    cl_int status = CL_COMPLETE;
    check(clGetEventInfo(implementation_->handle.get(), CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof status,
                         &status, nullptr),
          "clGetEventInfo", "kernel " + implementation_->entry);
    return status <= CL_COMPLETE;
}

Device::Device(const std::string& choice, const DeviceOptions& options)
    : implementation_(std::make_shared<Implementation>()) {
    std::vector<FoundDevice> all = find_devices();
    std::vector<DeviceInfo> infos;
    for (const FoundDevice& device : all) infos.push_back(device.info);
    Implementation& self = *implementation_;
    self.found = all[choose_device(choice, infos)];
    self.options = options;
    const DeviceInfo& device = self.found.info;
    if (!device.has_double) {
        misuse("device " + device.name +
               " has no double precision, which Mortise needs; choose another device "
               "(`mortise devices` lists them)");
    }
    if (options.work_group_size < 0 || options.work_group_size > static_cast<int>(device.max_work_group)) {
        misuse("work-group size " + std::to_string(options.work_group_size) + " is not between 1 and " +
               std::to_string(device.max_work_group) + ", the limit of " + device.name);
    }
    const int lanes = options.lanes;
    if (lanes != 0 && lanes != 1 && lanes != 2 && lanes != 4 && lanes != 8 && lanes != 16) {
        misuse("lanes " + std::to_string(lanes) + " is not 1, 2, 4, 8 or 16");
    }
    require_linker(self.found);
    self.cache = kernel_cache(options);
    self.kernels_folder = chosen_kernels_folder(options.kernels_folder);
    guarded("clCreateContext", "opening device " + device.name, [&] {
        const compute::device handle(self.found.id);
        self.context = compute::context(handle);
        self.queue = compute::command_queue(self.context, handle, compute::command_queue::enable_profiling);
    });
    if (options.probe) {
        self.float_is_exact = probe_arithmetic(*this).float_is_exact;
        reset_times();
    }
}

const DeviceInfo& Device::info() const { return implementation_->found.info; }
int Device::lanes() const { return implementation_->lanes(); }
int Device::work_group_size() const { return implementation_->work_group_size(); }
bool Device::float_is_exact() const { return implementation_->float_is_exact; }

std::uint32_t Device::checked_items(const Kernel& kernel, std::size_t items) {
    if (items > std::numeric_limits<std::uint32_t>::max()) {
        misuse("kernel " + kernel.entry() + ": " + std::to_string(items) +
               " work-items in one launch, at most 4294967295 are possible; choose a lower level");
    }
    return static_cast<std::uint32_t>(items);
}

void Device::set_look(void (*look)()) { implementation_->look = look; }

Event Device::launch_arguments(const Kernel& kernel, std::size_t items, const Argument* arguments,
                               std::size_t count, Cut cut) {
    Implementation& self = *implementation_;
    Event event;
    if (!kernel.implementation_) misuse("launching an empty kernel handle");
    Kernel::Implementation& target = *kernel.implementation_;
    if (count != target.arguments) {
        misuse("kernel " + target.entry + " has " + std::to_string(target.arguments) +
               " parameters, the last of them `uint items`, but is launched with " + std::to_string(count) +
               " arguments including it");
    }
    if (items == 0) return event;
    for (std::size_t i = 0; i < count; ++i) {
        const Argument& argument = arguments[i];
        const void* value = argument.value_;
        std::size_t bytes = argument.bytes_;
        cl_mem memory = nullptr;
        if (argument.buffer_ != nullptr) {
            const auto& buffer = argument.buffer_->implementation_;
            if (!buffer || buffer->mappings != 0) {
                misuse("kernel " + target.entry + ": argument " + std::to_string(i) + " is " +
                       (buffer ? "a buffer that is still mapped" : "an empty buffer"));
            }
            memory = buffer->memory.get();
            value = &memory;
            bytes = sizeof memory;
        }
        const cl_int code = clSetKernelArg(target.handle.get(), static_cast<cl_uint>(i), bytes, value);
        if (code != CL_SUCCESS) {
            fail(code, "clSetKernelArg",
                 "kernel " + target.entry + ", argument " + std::to_string(i) + " of " +
                     std::to_string(bytes) + " bytes");
        }
    }
    const auto group = static_cast<std::size_t>(work_group_size());
    const std::size_t global = (items + group - 1) / group * group;
    KernelTime& time = self.times[target.time_index];
    ++time.launches;
    time.items += items;
    std::size_t slice =
        self.look != nullptr && cut == Cut::kAllowed ? (kFirstSlice + group - 1) / group * group : global;
    for (std::size_t first = 0; first < global; first += slice) {
        if (first > 0) {
            // What has been launched is done when look() is called, so it may throw.
            const auto start = std::chrono::steady_clock::now();
            event.wait();
            const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - start;
            self.look();
            if (waited.count() < kSliceSeconds) slice *= 2;
        }
        event.implementation_ = std::make_shared<Event::Implementation>();
        event.implementation_->entry = target.entry;
        event.implementation_->handle =
            guarded("clEnqueueNDRangeKernel",
                    "kernel " + target.entry + " with " + std::to_string(items) + " items", [&] {
                        compute::event launched = self.queue.enqueue_1d_range_kernel(
                            target.handle, first, std::min(slice, global - first), group);
                        self.queue.flush();
                        return launched;
                    });
        self.pending.push_back({event.implementation_->handle, target.time_index});
        if (self.pending.size() > kPendingEvents) self.harvest(false);
    }
    return event;
}

void Device::finish() {
    check(clFinish(implementation_->queue.get()), "clFinish", "waiting for " + info().name);
    implementation_->harvest(true);
}

KernelsEnd::~KernelsEnd() {
    try {
        device_.finish();
    } catch (const Error&) {
        // The failure has been told by whoever waited for its kernel, or nobody needs its result.
    }
}

std::vector<KernelTime> Device::times() const {
    implementation_->harvest(true);
    std::vector<KernelTime> times;
    for (const KernelTime& time : implementation_->times) {
        if (time.launches != 0) times.push_back(time);
    }
    std::stable_sort(times.begin(), times.end(),
                     [](const KernelTime& a, const KernelTime& b) { return a.seconds > b.seconds; });
    return times;
}

void Device::reset_times() {
    implementation_->harvest(true);
    for (KernelTime& time : implementation_->times) {
        time.launches = 0;
        time.items = 0;
        time.seconds = 0;
    }
}

cl_command_queue Internals::queue(const Device& device) { return device.implementation_->queue.get(); }
cl_mem Internals::memory(const Buffer& buffer) {
    return buffer.implementation_ ? buffer.implementation_->memory.get() : nullptr;
}
bool Internals::is_cpu(const Device& device) { return device.implementation_->found.is_cpu; }
const DiskCache& Internals::cache(const Device& device) { return device.implementation_->cache; }
std::string Internals::build_key(const Device& device) {
    const FoundDevice& found = device.implementation_->found;
    return binary_key(found, build_options(found, device.lanes(), device.work_group_size(), {}));
}

}  // namespace mortise::device
