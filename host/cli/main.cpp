// The program `mortise`: every failure becomes one line on stderr and an exit code (mortise/error.hpp).
#include <cstdio>
#include <exception>
#include <new>
#include <string>

#include "host/cli/commands.hpp"
#include "host/cli/files.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/signals.hpp"

namespace mortise::cli {
namespace {

ExitCode run(int count, const char* const* values) {
    const Arguments arguments = parse_arguments(count, values);
    switch (arguments.command) {
        case Command::kMesh: return mesh_command(arguments);
        case Command::kEstimate: return estimate_command(arguments);
        case Command::kBatch: return batch_command(arguments);
        case Command::kCheck: return check_command(arguments);
        case Command::kDevices: return devices_command(arguments);
        case Command::kDoctor: return doctor_command(arguments);
        case Command::kInfo: return info_command(arguments);
        case Command::kKernels: return kernels_command(arguments);
        case Command::kPrint: break;
    }
    print(arguments.text);
    return ExitCode::kOk;
}

ExitCode fail(ExitCode code, const char* message) noexcept {
    try {
        std::fprintf(stderr, "mortise: %s\n", one_line(message).c_str());
    } catch (const std::bad_alloc&) {
        std::fprintf(stderr, "mortise: out of memory\n");
    }
    return code;
}

}  // namespace
}  // namespace mortise::cli

int main(int count, char** values) {
    using mortise::ExitCode;
    namespace cli = mortise::cli;
    ExitCode code = ExitCode::kOk;
    try {
        cli::end_cleanly_on_signals();
        code = cli::run(count, values);
    } catch (const mortise::Error& error) {
        code = cli::fail(error.code(), error.what());
    } catch (const std::bad_alloc&) {
        code = cli::fail(ExitCode::kDevice, "out of memory; use a smaller --level or a larger --size");
    } catch (const std::exception& error) {
        code = cli::fail(ExitCode::kMeshing,
                         (std::string("internal error, please report it: ") + error.what()).c_str());
    }
    return static_cast<int>(code);
}
