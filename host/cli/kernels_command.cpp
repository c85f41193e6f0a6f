// `mortise kernels`: all kernels compiled now, so that no run waits for them.
#include <chrono>

#include "host/cli/commands.hpp"
#include "host/cli/documents.hpp"
#include "host/cli/files.hpp"
#include "host/cli/kernels_ahead.hpp"
#include "host/cli/text.hpp"
#include "host/device/environment.hpp"

namespace mortise::cli {
namespace {

std::string target_folder(const Arguments& arguments) {
    if (arguments.outputs.size() > 1) throw Error(ExitCode::kUsage, "kernels: expected one folder");
    const std::string folder = arguments.outputs.empty() ? device::cache_folder() : arguments.outputs.front();
    if (folder.empty()) {
        throw Error(ExitCode::kFiles,
                    "kernels: no cache folder; set HOME or MORTISE_CACHE, or give a folder with -o");
    }
    if (!device::is_writable_folder(folder))
        throw Error(ExitCode::kFiles, folder + ": cannot be written; give another folder with -o");
    return folder;
}

}  // namespace

ExitCode kernels_command(const Arguments& arguments) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    const std::string folder = target_folder(arguments);
    const MeshOptions& options = arguments.options;
    KernelBuilder builder(options.device, options.work_group_size, folder);
    const std::size_t needed = builder.needed();
    std::size_t built = 0;
    {
        Progress progress(false);
        built = build_in_processes(builder, options.threads, progress);
    }
    if (built < needed) {
        for (std::size_t i = 0; i < needed; ++i) builder.build(i);  // throws what the processes came to
        builder.finish();
    }
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    if (arguments.json) {
        print(to_text(Json{{"folder", folder}, {"compiled", needed}, {"seconds", seconds}}));
    } else {
        print(needed == 0 ? folder + ": all kernels are there\n"
                          : folder + ": " + std::to_string(needed) + " programs compiled, " +
                                rounded_text(seconds, 3) + " s\n");
    }
    return ExitCode::kOk;
}

}  // namespace mortise::cli
