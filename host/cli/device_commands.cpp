// `mortise devices` and `mortise doctor`.
#include <exception>

#include "host/cli/commands.hpp"
#include "host/cli/documents.hpp"
#include "host/cli/files.hpp"
#include "host/cli/text.hpp"
#include "host/device/device.hpp"
#include "host/device/doctor.hpp"

namespace mortise::cli {
namespace {

std::string gibibytes(std::uint64_t bytes) {
    return rounded_text(static_cast<double>(bytes) / (1u << 30), 3) + " GiB";
}

}  // namespace

ExitCode devices_command(const Arguments& arguments) {
    const std::vector<device::DeviceInfo> devices = device::list_devices();
    // A choice that fails (no device at all, a wrong MORTISE_DEVICE) is said after the list.
    std::size_t chosen = devices.size();
    std::exception_ptr failure;
    try {
        chosen = device::choose_device({}, devices);
    } catch (const Error&) {
        failure = std::current_exception();
    }
    Json list = Json::array();
    std::string text;
    for (std::size_t i = 0; i < devices.size(); ++i) {
        const device::DeviceInfo& info = devices[i];
        list.push_back({{"index", i},
                        {"name", info.name},
                        {"platform", info.platform},
                        {"version", info.version},
                        {"driver", info.driver},
                        {"gpu", info.is_gpu},
                        {"double", info.has_double},
                        {"compute_units", info.compute_units},
                        {"memory_bytes", info.global_bytes},
                        {"default", i == chosen}});
        text += std::to_string(i) + (i == chosen ? " * " : "   ") + info.name + " (" + info.platform + ", " +
                std::to_string(info.compute_units) + " compute units, " + gibibytes(info.global_bytes) +
                (info.has_double ? "" : ", no double precision: cannot be used") + ")\n";
    }
    print(arguments.json ? to_text(list) : text);
    if (failure) std::rethrow_exception(failure);
    return ExitCode::kOk;
}

ExitCode doctor_command(const Arguments&) {
    bool healthy = true;
    std::string text;
    for (const device::DoctorLine& line : device::doctor()) {
        healthy = healthy && line.ok;
        text += (line.ok ? "ok    " : "FAIL  ") + line.what + ": " + line.detail + "\n";
        if (!line.remedy.empty()) text += "      " + line.remedy + "\n";
    }
    print(text);
    return healthy ? ExitCode::kOk : ExitCode::kDevice;
}

}  // namespace mortise::cli
