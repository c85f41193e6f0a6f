// Prefix sums against the standard library, for both kernel forms and many work-group sizes; and the probe.
#include <doctest/doctest.h>

#include <numeric>

#include "host/device/device.hpp"
#include "host/device/doctor.hpp"
#include "host/device/internals.hpp"
#include "host/device/kernel_source.hpp"
#include "scratch.hpp"

using namespace mortise;
using namespace mortise::device;

namespace {

std::vector<std::uint32_t> counts(std::size_t n) {
    std::vector<std::uint32_t> values(n);
    std::uint32_t state = 1;
    for (std::uint32_t& value : values) value = (state = state * 1664525u + 1013904223u) >> 25;
    return values;
}

template <class Sum>
std::vector<Sum> expected_sums(const std::vector<std::uint32_t>& values) {
    std::vector<Sum> sums(values.size() + 1, 0);
    std::partial_sum(values.begin(), values.end(), sums.begin() + 1, [](Sum a, Sum b) { return a + b; });
    return sums;
}

void check_scans(Device& device, std::size_t n, bool wide_too) {
    CAPTURE(n);
    const std::vector<std::uint32_t> values = counts(n);
    const auto narrow = expected_sums<std::uint32_t>(values);
    Buffer in = device.allocate((n + 1) * sizeof(std::uint32_t));
    device.upload(in, values.data(), n);
    Buffer out = device.allocate((n + 1) * sizeof(std::uint32_t));
    CHECK(device.exclusive_scan_u32(in, out, n) == narrow.back());
    CHECK(device.download<std::uint32_t>(out, n + 1) == narrow);
    if (wide_too) {
        Buffer wide = device.allocate((n + 1) * sizeof(std::uint64_t));
        CHECK(device.exclusive_scan_u64(in, wide, n) == narrow.back());
        CHECK(device.download<std::uint64_t>(wide, n + 1) == expected_sums<std::uint64_t>(values));
    }
    CHECK(device.exclusive_scan_u32(in, in, n) == narrow.back());
    CHECK(device.download<std::uint32_t>(in, n + 1) == narrow);
}

}  // namespace

TEST_CASE("prefix sums equal the standard library's") {
    for (const int lanes : {1, 8}) {
        const std::vector<int> by_item = {1, 32,
                                          256};  // the form without barriers hardly depends on the size
        const std::vector<int> by_group = {1, 3, 32, 256};
        for (const int group : lanes == 1 ? by_group : by_item) {
            CAPTURE(lanes);
            CAPTURE(group);
            DeviceOptions options;
            options.lanes = lanes;
            options.work_group_size = group;
            options.probe = false;
            Device device("", options);
            const auto size = static_cast<std::size_t>(group);
            for (const std::size_t n :
                 {std::size_t{0}, std::size_t{1}, size - 1, size, size + 1, std::size_t{511},
                  std::size_t{512}, std::size_t{513}, std::size_t{100003}}) {
                check_scans(device, n, group == 32);
            }
            if (group == 32) check_scans(device, 1000000, true);
        }
    }
}

TEST_CASE("prefix sums beyond 32 bits are refused, or held in 64 bits") {
    Device device;
    const std::vector<std::uint32_t> values(3, 0xffffffffu);
    const Buffer in = device.upload(values);
    Buffer out = device.allocate(4 * sizeof(std::uint64_t));
    CHECK(device.exclusive_scan_u32(in, out, 1) == 0xffffffffu);
    CHECK(contains(device_error([&] { device.exclusive_scan_u32(in, out, 2); }), "8589934590"));
    CHECK(device.exclusive_scan_u64(in, out, 3) == 3ull * 0xffffffffu);
    CHECK(device.download<std::uint64_t>(out, 4)[3] == 3ull * 0xffffffffu);
    CHECK(contains(device_error([&] { device.exclusive_scan_u64(in, out, 4); }),
                   "expected at least 16 and 40"));
}

TEST_CASE("the probe finds double exact in scalar and vector form, and notices a wrong device") {
    ScratchFolder cache;
    const Variable folder("MORTISE_CACHE", cache.path());
    for (const int lanes : {1, 8}) {
        DeviceOptions options;
        options.lanes = lanes;
        Device device("", options);
        CHECK(probe_arithmetic(device).float_is_exact == device.float_is_exact());
    }
    // A kernel with contraction on stands for a device that rounds otherwise.
    ScratchFolder kernels;
    std::string text = kernel_source("probe.cl", {});
    const std::size_t at = text.find("x * y + z");
    REQUIRE(at != std::string::npos);
    kernels.write("probe.cl", text.replace(at, 9, "fma(x, y, z)"));
    DeviceOptions options;
    options.kernels_folder = kernels.path();
    options.disk_cache = false;
    const std::string message = device_error([&] { Device("", options); });
    CHECK(contains(message, "x * y + z gives"));
    CHECK(contains(message, "differs from the host's"));
}

TEST_CASE("the doctor finds this machine well, up to the load that other programs put on it") {
    const std::vector<DoctorLine> lines = doctor();
    CHECK(lines.size() >= 6);
    for (const DoctorLine& line : lines) {
        CAPTURE(line.what);
        CAPTURE(line.detail);
        CHECK(line.remedy.empty() == line.ok);
        if (line.what != "kernels run on all cores") CHECK(line.ok);
    }
}
