#include "host/pipeline/memory_limit.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <string>

#include "mortise/error.hpp"

namespace mortise::pipeline {

std::uint64_t memory_now() {
    unsigned long long total = 0, resident = 0;
    if (std::FILE* const file = std::fopen("/proc/self/statm", "r")) {
        const int read = std::fscanf(file, "%llu %llu", &total, &resident);
        std::fclose(file);
        if (read == 2) return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
    }
    // Without /proc: what the process has had at most, which is no less.
    rusage usage{};
    constexpr std::uint64_t kUnit = 1024;  // bytes, Linux's unit of ru_maxrss
    return getrusage(RUSAGE_SELF, &usage) == 0 ? static_cast<std::uint64_t>(usage.ru_maxrss) * kUnit : 0;
}

void check_memory(std::uint64_t needed, const char* what, const MeshOptions& options) {
    if (needed <= options.memory) return;
    constexpr std::uint64_t kMega = std::uint64_t{1} << 20;
    const std::string allowed = options.memory < 10 * kMega ? std::to_string(options.memory) + " bytes"
                                                            : std::to_string(options.memory / kMega) + " MiB";
    throw Error(ExitCode::kDevice, std::string(what) + " need about " + std::to_string(needed / kMega + 1) +
                                       " MiB of memory, and " + allowed +
                                       " are allowed; allow more by --memory, or use larger cells");
}

}  // namespace mortise::pipeline
