#include "host/device/build_record.hpp"

#include <cstdlib>

#include "host/device/disk_cache.hpp"
#include "host/device/environment.hpp"
#include "host/device/kernel_source.hpp"

namespace mortise::device {
namespace {

std::string record_key(const std::vector<ProgramName>& programs, const std::string& choice,
                       const DeviceOptions& options) {
    const char* const variable = std::getenv("MORTISE_DEVICE");
    std::string key = "built\n" + choice + "\n" + (variable == nullptr ? "" : variable) + "\n" +
                      std::to_string(options.work_group_size) + " " + std::to_string(options.lanes) + "\n";
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
    if (!options.disk_cache || !is_writable_folder(cache_folder())) return true;
    prepare_environment();  // once for the processes that may be forked now
    return DiskCache(cache_folder()).load(record_key(programs, choice, options)).has_value();
}

void remember_built(const std::vector<ProgramName>& programs, const std::string& choice,
                    const DeviceOptions& options) {
    if (!options.disk_cache) return;
    DiskCache(cache_folder()).store(record_key(programs, choice, options), "");
}

}  // namespace mortise::device
