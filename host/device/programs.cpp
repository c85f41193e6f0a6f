// Programs and kernels: a program is looked for in memory, then as a binary in the cache folder, then built
// from its text. Limits that would make a launch abort are checked when a kernel is made.
#include <boost/compute/exception/program_build_failure.hpp>
#include <system_error>

#include "host/device/build_options.hpp"
#include "host/device/device_state.hpp"
#include "host/device/kernel_source.hpp"

namespace mortise::device {

namespace {

std::string key_of(const std::string& file, const std::string& defines) { return file + "\n" + defines; }

/// A key of the cache folder: all that the binary depends on.
std::string cache_key(const FoundDevice& device, const std::string& build_flags, const std::string& source) {
    return binary_key(device, build_flags) + source;
}

}  // namespace

std::string Device::Implementation::source_of(const std::string& file) const {
    return with_prelude(kernel_source(file, kernels_folder));
}

std::string Device::Implementation::flags_of(const std::string& defines) const {
    return build_options(found, lanes(), work_group_size(), defines);
}

const compute::program& Device::Implementation::program(const std::string& file, const std::string& defines) {
    const std::string key = key_of(file, defines);
    const auto known = programs.find(key);
    if (known != programs.end()) return known->second;
    std::optional<compute::program> loaded;
    if (const auto coming = ahead.find(key); coming != ahead.end()) {
        auto result = std::move(coming->second);
        ahead.erase(coming);
        loaded = result.get();
    }
    return programs.emplace(key, loaded ? *loaded : build(file, defines)).first->second;
}

std::optional<compute::program> Device::Implementation::load(const std::string& source,
                                                             const std::string& build_flags) const {
    const auto binary = cache.load(cache_key(found, build_flags, source));
    if (!binary) return std::nullopt;
    try {
        auto program = compute::program::create_with_binary(
            reinterpret_cast<const unsigned char*>(binary->data()), binary->size(), context);
        program.build(build_flags);
        return program;
    } catch (const compute::opencl_error&) {
        return std::nullopt;  // the driver refuses its own binary (an update, say)
    }
}

compute::program Device::Implementation::build(const std::string& file, const std::string& defines) const {
    const std::string source = source_of(file);
    const std::string build_flags = flags_of(defines);
    if (auto loaded = load(source, build_flags)) return *loaded;
    compute::program program;
    try {
        program = compute::program::create_with_source(source, context);
        program.build(build_flags);
    } catch (const compute::program_build_failure& error) {
        misuse(build_failure(found, file, build_flags, source, error.build_log()));
    } catch (const compute::opencl_error& error) {
        fail(error.error_code(), "clBuildProgram", "kernels/" + file + " with options " + build_flags);
    }
    if (cache.keeps()) {
        try {
            // PoCL compiles kernels when they are asked for, or else at their first launch.
            const std::vector<unsigned char> bytes = program.binary();
            const std::string key = cache_key(found, build_flags, source);
            cache.store(key, std::string(bytes.begin(), bytes.end()));
        } catch (const compute::opencl_error&) {
            // No binary to be had: the next run builds again.
        }
    }
    return program;
}

void Device::build(const ProgramName& program) { implementation_->program(program.file, program.defines); }

void Device::load_ahead(const std::vector<ProgramName>& programs) {
    Implementation& self = *implementation_;
    if (self.loader.joinable()) {
        if (!self.ahead.empty()) return;  // at work still
        self.loader.join();
    }
    std::vector<std::packaged_task<std::optional<compute::program>()>> tasks;
    for (const ProgramName& name : programs) {
        const std::string key = key_of(name.file, name.defines);
        if (self.programs.count(key) != 0) continue;
        tasks.emplace_back(
            [&self, name] { return self.load(self.source_of(name.file), self.flags_of(name.defines)); });
        self.ahead[key] = tasks.back().get_future();
    }
    if (tasks.empty()) return;
    try {
        self.loader = std::thread([list = std::move(tasks)]() mutable {
            for (auto& task : list) task();
        });
    } catch (const std::system_error&) {
        self.ahead.clear();  // no thread to be had: programs are loaded when they are asked for
    }
}

Kernel Device::kernel(const std::string& file, const std::string& entry, const std::string& defines) {
    Implementation& self = *implementation_;
    Kernel& kernel = self.kernels[key_of(file, defines) + "\n" + entry];
    if (kernel.implementation_) return kernel;
    const compute::program& program = self.program(file, defines);
    auto made = std::make_shared<Kernel::Implementation>();
    guarded("clCreateKernel", "kernel " + entry + " of kernels/" + file,
            [&] { made->handle = compute::kernel(program, entry); });
    made->file = file;
    made->entry = entry;
    const cl_kernel handle = made->handle.get();
    cl_uint arguments = 0;
    check(clGetKernelInfo(handle, CL_KERNEL_NUM_ARGS, sizeof arguments, &arguments, nullptr),
          "clGetKernelInfo", "kernel " + entry);
    made->arguments = arguments;
    std::size_t group = 0;
    cl_ulong local_bytes = 0;
    check(clGetKernelWorkGroupInfo(handle, self.found.id, CL_KERNEL_WORK_GROUP_SIZE, sizeof group, &group,
                                   nullptr),
          "clGetKernelWorkGroupInfo", "kernel " + entry);
    check(clGetKernelWorkGroupInfo(handle, self.found.id, CL_KERNEL_LOCAL_MEM_SIZE, sizeof local_bytes,
                                   &local_bytes, nullptr),
          "clGetKernelWorkGroupInfo", "kernel " + entry);
    if (group < static_cast<std::size_t>(work_group_size())) {
        misuse("kernel " + entry + " runs in work-groups of at most " + std::to_string(group) + " on " +
               info().name + ", not " + std::to_string(work_group_size()) +
               "; choose a smaller work-group size");
    }
    if (local_bytes > info().local_bytes) {  // PoCL would abort at the launch
        misuse("kernel " + entry + " needs " + amount(local_bytes) + " of local memory, " + info().name +
               " has " + amount(info().local_bytes) + "; choose a smaller work-group size");
    }
    const auto same_entry = std::find_if(self.times.begin(), self.times.end(),
                                         [&](const KernelTime& time) { return time.entry == entry; });
    made->time_index = static_cast<std::size_t>(same_entry - self.times.begin());
    if (same_entry == self.times.end()) {
        self.times.emplace_back();
        self.times.back().entry = entry;
    }
    kernel.implementation_ = std::move(made);
    return kernel;
}

}  // namespace mortise::device
