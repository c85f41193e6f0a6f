// Exclusive prefix sums: kernels/scan.cl sums chunks, the host scans the few sums (it needs the total
// anyway), and the kernels write the chunks. Integer sums, so the result does not depend on the chunks.
#include <algorithm>
#include <limits>
#include <vector>

#include "host/device/device.hpp"
#include "mortise/error.hpp"

namespace mortise::device {
namespace {

// Few enough for the host's part to be negligible, enough to balance the load; short scans use fewer.
constexpr std::size_t kChunksPerUnitItems = 64;  // chunk per work-item
constexpr std::size_t kChunksPerUnitGroups = 8;  // chunk per work-group
constexpr std::size_t kShortestChunk = 512;      // values; below, a launch costs more than the work

}  // namespace

std::uint64_t Device::exclusive_scan(const Buffer& in, Buffer& out, std::size_t n, bool wide) {
    const std::size_t out_bytes = (n + 1) * (wide ? sizeof(std::uint64_t) : sizeof(std::uint32_t));
    if (in.bytes() < n * sizeof(std::uint32_t) || out.bytes() < out_bytes) {
        throw Error(ExitCode::kDevice,
                    "prefix sum of " + std::to_string(n) + " values: input of " + std::to_string(in.bytes()) +
                        " bytes, output of " + std::to_string(out.bytes()) + " bytes, expected at least " +
                        std::to_string(n * sizeof(std::uint32_t)) + " and " + std::to_string(out_bytes));
    }
    if (n == 0) {
        fill_zero(out, out_bytes);
        return 0;
    }
    const bool by_groups = lanes() == 1;
    const std::size_t most =
        std::max(1u, info().compute_units) * (by_groups ? kChunksPerUnitGroups : kChunksPerUnitItems);
    const std::uint64_t chunk = std::max<std::uint64_t>(kShortestChunk, (n + most - 1) / most);
    const std::size_t chunks = (n + chunk - 1) / chunk;
    const std::size_t items = by_groups ? chunks * static_cast<std::size_t>(work_group_size()) : chunks;
    const std::uint64_t count = n;

    const std::string defines = wide ? "-DSUM=ulong" : "-DSUM=uint";
    Buffer sums = allocate(chunks * sizeof(std::uint64_t));
    launch_whole(kernel("scan.cl", "scan_sums", defines), items, in, sums, chunk, count);
    std::uint64_t total = 0;
    {
        const auto mapped = map<std::uint64_t>(sums, Access::kReadWrite);
        for (std::uint64_t& sum : mapped) {
            const std::uint64_t own = sum;
            sum = total;
            total += own;
        }
    }
    if (!wide && total > std::numeric_limits<std::uint32_t>::max()) {
        throw Error(ExitCode::kDevice, "prefix sum reaches " + std::to_string(total) +
                                           ", more than 32-bit numbers hold; choose a lower level");
    }
    launch_whole(kernel("scan.cl", "scan_fill", defines), items, in, out, sums, chunk, count);
    return total;
}

std::uint64_t Device::exclusive_scan_u32(const Buffer& in, Buffer& out, std::size_t n) {
    return exclusive_scan(in, out, n, false);
}

std::uint64_t Device::exclusive_scan_u64(const Buffer& in, Buffer& out, std::size_t n) {
    return exclusive_scan(in, out, n, true);
}

}  // namespace mortise::device
