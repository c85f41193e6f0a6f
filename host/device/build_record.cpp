#include "host/device/build_record.hpp"

#include <cstdlib>
#include <fstream>
#include <string>

#include "host/device/environment.hpp"
#include "host/device/kernel_cache.hpp"
#include "host/device/kernel_source.hpp"

namespace mortise::device {
namespace {

/// The processor's model: kernels that were compiled for another are no use. Empty if the system tells none.
std::string processor() {
    std::ifstream lines("/proc/cpuinfo");
    for (std::string line; std::getline(lines, line);) {
        if (line.rfind("model name", 0) == 0) return line;
    }
    return {};
}

std::string record_key(const std::vector<ProgramName>& programs, const std::string& choice,
                       const DeviceOptions& options) {
    const char* const variable = std::getenv("MORTISE_DEVICE");
    std::string key = "built\n" + processor() + "\n" + choice + "\n" + (variable == nullptr ? "" : variable) +
                      "\n" + std::to_string(options.work_group_size) + " " + std::to_string(options.lanes) +
                      "\n";
    const std::string folder = chosen_kernels_folder(options.kernels_folder);
    for (const ProgramName& program : programs) {
        key += program.file + " " + program.defines + " " + hash_text(kernel_source(program.file, folder)) +
               "\n";
    }
    return key;
}

}  // namespace

bool are_built(const std::vector<ProgramName>& programs, const std::string& choice,
               const DeviceOptions& options) {
    if (!is_writable_folder(chosen_cache_folder(options))) return true;
    prepare_environment();  // once for the processes that may be forked now
    return kernel_cache(options).load(record_key(programs, choice, options)).has_value();
}

void remember_built(const std::vector<ProgramName>& programs, const std::string& choice,
                    const DeviceOptions& options) {
    kernel_cache(options).store(record_key(programs, choice, options), "");
}

}  // namespace mortise::device
