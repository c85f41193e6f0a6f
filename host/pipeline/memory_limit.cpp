#include "host/pipeline/memory_limit.hpp"

#include <unistd.h>

#include <cstdio>
#include <string>

#include "mortise/error.hpp"

namespace mortise::pipeline {

std::uint64_t memory_now() {
    std::FILE* file = std::fopen("/proc/self/statm", "r");
    if (file == nullptr) return 0;
    unsigned long long total = 0, resident = 0;
    const int read = std::fscanf(file, "%llu %llu", &total, &resident);
    std::fclose(file);
    return read == 2 ? resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) : 0;
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
