// See doctor.hpp. Each check either adds a line or, where later checks cannot run without it, ends the list.
#include "host/device/doctor.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>

#include "host/device/device.hpp"
#include "host/device/environment.hpp"
#include "host/device/internals.hpp"
#include "mortise/error.hpp"

namespace mortise::device {
namespace {

void add(std::vector<DoctorLine>& lines, bool ok, const std::string& what, const std::string& detail,
         const std::string& remedy) {
    lines.push_back({ok, what, detail, ok ? std::string() : remedy});
}

std::string decimals(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.2f", value);
    return text;
}

/// Process CPU time per wall time while a kernel keeps every compute unit busy for about a third of a second.
double busy_cores(Device& device) {
    const std::size_t items =
        static_cast<std::size_t>(device.work_group_size()) * std::max(1u, device.info().compute_units) * 16;
    Buffer out = device.allocate(items * sizeof(std::uint32_t));
    const Kernel busy = device.kernel("probe.cl", "probe_busy");
    using Clock = std::chrono::steady_clock;
    double wall = 0;
    double cores = 0;
    // Rounds double until the time is long enough to be measured.
    for (std::uint32_t rounds = 1u << 14; wall < 0.15 && rounds < 1u << 30; rounds *= 2) {
        const std::clock_t cpu_start = std::clock();
        const Clock::time_point start = Clock::now();
        device.launch(busy, items, out, rounds);
        device.finish();
        wall = std::chrono::duration<double>(Clock::now() - start).count();
        cores = static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC / wall;
    }
    return cores;
}

void check_scaling(std::vector<DoctorLine>& lines, Device& device) {
    if (!Internals::is_cpu(device) || device.info().compute_units < 2) return;
    const double cores = busy_cores(device);
    const unsigned units = device.info().compute_units;
    add(lines, cores > 0.6 * units, "kernels run on all cores",
        decimals(cores) + " of " + std::to_string(units) + " busy",
        "another program may be using them; if not, set POCL_AFFINITY=1, which pins the driver's threads");
}

void check_kernels(std::vector<DoctorLine>& lines, Device& device) {
    try {
        device.kernel("scan.cl", "scan_sums", "-DSUM=uint");
        add(lines, true, "kernels build", "kernels/scan.cl", {});
    } catch (const Error& error) {
        add(lines, false, "kernels build", error.what(),
            "unset MORTISE_KERNELS if it is set; else report this text as a bug");
        return;
    }
    try {
        const bool float_too = probe_arithmetic(device).float_is_exact;
        add(lines, true, "arithmetic equals the host's",
            float_too ? "double and float" : "double; float differs", {});
    } catch (const Error& error) {
        add(lines, false, "arithmetic equals the host's", error.what(), "choose another device or driver");
    }
    check_scaling(lines, device);
}

}  // namespace

std::vector<DoctorLine> doctor(const std::string& choice) {
    std::vector<DoctorLine> lines;
    const std::string linker = find_on_path("ld");
    add(lines, !linker.empty(), "linker on PATH", linker.empty() ? "no `ld`" : linker,
        "`apt-get install binutils`");
    const std::string pocl_before = pocl_cache_folder();
    const bool pocl_writable = is_writable_folder(pocl_before);
    add(lines, pocl_writable, "PoCL's cache folder", pocl_before.empty() ? "none" : pocl_before,
        "make it writable, or set POCL_CACHE_DIR; a temporary folder is used instead, so every run compiles "
        "again");
    const std::string cache = cache_folder();
    add(lines, is_writable_folder(cache), "Mortise's cache folder", cache.empty() ? "none" : cache,
        "make it writable, or set MORTISE_CACHE; without it every run builds its kernels again");
    try {
        const std::vector<DeviceInfo> devices = list_devices();
        add(lines, !devices.empty(), "OpenCL devices", std::to_string(devices.size()) + " found",
            no_device_remedy());
        if (devices.empty()) return lines;
        const DeviceInfo& chosen = devices[choose_device(choice, devices)];
        add(lines, chosen.has_double, "double precision", chosen.name,
            "choose another device: `mortise devices`");
        if (!chosen.has_double || linker.empty()) return lines;
        DeviceOptions options;
        options.probe = false;  // checked below, so that its failure is a line and not the end
        Device device(choice, options);
        check_kernels(lines, device);
    } catch (const std::exception& error) {
        add(lines, false, "opening the device", error.what(),
            "see the message; `mortise devices` lists devices");
    }
    return lines;
}

}  // namespace mortise::device
