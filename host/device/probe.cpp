// The arithmetic probe: kernels/probe.cl against the host on special and pseudo-random operands. Double must
// agree bit for bit, or decisions taken on device and host would differ; float need not (OpenCL leaves its
// denormals, division and square root to the device), and is only reported. A NaN equals any NaN.
//
// The host side relies on -ffp-contract=off.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <vector>

#include "host/device/disk_cache.hpp"
#include "host/device/internals.hpp"
#include "host/device/kernel_source.hpp"
#include "mortise/error.hpp"

namespace mortise::device {
namespace {

constexpr int kOperations = 8;
constexpr const char* kOperationNames[kOperations] = {"x + y",   "x - y",        "x * y",     "x / y",
                                                      "sqrt(x)", "fma(x, y, z)", "x * y + z", "rint(x)"};
constexpr const char* kAgrees = "float agrees";
constexpr const char* kDiffers = "float differs";

template <class Real>
std::vector<Real> special_operands() {
    using Limits = std::numeric_limits<Real>;
    const Real one = 1;
    std::vector<Real> values = {0,
                                one,
                                one + Limits::epsilon(),
                                one - Limits::epsilon() / 2,
                                one / 3,
                                Real(0.1),
                                Real(2.5),
                                Real(3.5),
                                Real(1e10),
                                Limits::max(),
                                Limits::min(),
                                Limits::denorm_min(),
                                Limits::min() - Limits::denorm_min(),
                                std::sqrt(Limits::min()),
                                std::sqrt(Limits::max()),
                                Limits::infinity(),
                                Limits::quiet_NaN()};
    const std::size_t positive = values.size();
    for (std::size_t i = 0; i < positive; ++i) values.push_back(-values[i]);
    return values;
}

/// Operands by columns: every pair of special ones with a third, then random mantissas of moderate exponents,
/// where contraction and double rounding would show.
template <class Real>
struct Operands {
    std::vector<Real> x, y, z;
};

template <class Real>
Operands<Real> probe_operands(std::size_t multiple) {
    Operands<Real> operands;
    const std::vector<Real> special = special_operands<Real>();
    for (std::size_t i = 0; i < special.size(); ++i) {
        for (std::size_t j = 0; j < special.size(); ++j) {
            operands.x.push_back(special[i]);
            operands.y.push_back(special[j]);
            operands.z.push_back(special[(7 * i + 3 * j) % special.size()]);
        }
    }
    std::uint64_t state = 88172645463325252ull;  // xorshift64, Marsaglia 2003
    const auto random = [&state] {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        const Real mantissa =
            static_cast<Real>(static_cast<std::int64_t>(state)) / Real(9223372036854775808.0);
        return std::ldexp(mantissa, static_cast<int>(state % 9) - 4);
    };
    while (operands.x.size() < 4096 || operands.x.size() % multiple != 0) {
        operands.x.push_back(random());
        operands.y.push_back(random());
        operands.z.push_back(random());
    }
    return operands;
}

template <class Real>
Real on_host(int operation, Real x, Real y, Real z) {
    switch (operation) {
        case 0: return x + y;
        case 1: return x - y;
        case 2: return x * y;
        case 3: return x / y;
        case 4: return std::sqrt(x);
        case 5: return std::fma(x, y, z);
        case 6: return x * y + z;
        default: return std::rint(x);
    }
}

template <class Real>
bool same(Real a, Real b) {
    if (std::isnan(a) || std::isnan(b)) return std::isnan(a) && std::isnan(b);
    return std::memcmp(&a, &b, sizeof a) == 0;
}

/// Empty if device and host agree, else the first difference.
template <class Real>
std::string first_difference(Device& device, const std::string& entry) {
    const auto lanes = static_cast<std::size_t>(device.lanes());
    const Operands<Real> operands = probe_operands<Real>(lanes);
    const std::size_t count = operands.x.size();
    const Buffer x = device.upload(operands.x);
    const Buffer y = device.upload(operands.y);
    const Buffer z = device.upload(operands.z);
    Buffer out = device.allocate(kOperations * count * sizeof(Real));
    const auto stride = static_cast<std::uint32_t>(count);
    device.launch(device.kernel("probe.cl", entry), count / lanes, x, y, z, out, stride);
    const auto results = device.map<Real>(out, Access::kRead);
    for (int operation = 0; operation < kOperations; ++operation) {
        for (std::size_t i = 0; i < count; ++i) {
            const Real expected = on_host(operation, operands.x[i], operands.y[i], operands.z[i]);
            const Real found = results[static_cast<std::size_t>(operation) * count + i];
            if (same(expected, found)) continue;
            char text[256];
            std::snprintf(text, sizeof text, "%s gives %a for x = %a, y = %a, z = %a; the host gives %a",
                          kOperationNames[operation], static_cast<double>(found),
                          static_cast<double>(operands.x[i]), static_cast<double>(operands.y[i]),
                          static_cast<double>(operands.z[i]), static_cast<double>(expected));
            return text;
        }
    }
    return {};
}

}  // namespace

ProbeResult probe_arithmetic(Device& device) {
    const DiskCache& cache = Internals::cache(device);
    const std::string key = Internals::build_key(device) + "probe\n" + kernel_source("probe.cl", {});
    if (const auto known = cache.load(key)) return {*known == kAgrees};
    const std::string difference = first_difference<double>(device, "probe_double");
    if (!difference.empty()) {
        throw Error(ExitCode::kDevice, "double precision of " + device.info().name + " (driver " +
                                           device.info().driver + ") differs from the host's: " + difference +
                                           "; choose another device (`mortise devices` lists them)");
    }
    const bool float_agrees = first_difference<float>(device, "probe_float").empty();
    cache.store(key, float_agrees ? kAgrees : kDiffers);
    return {float_agrees};
}

}  // namespace mortise::device
