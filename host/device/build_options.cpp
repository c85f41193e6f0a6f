// See build_options.hpp. Never a fast-math option: results must equal the host's bit for bit.
#include "host/device/build_options.hpp"

#include <iomanip>
#include <sstream>
#include <vector>

#include "host/device/environment.hpp"
#include "mortise/error.hpp"

namespace mortise::device {

std::string build_options(const FoundDevice& device, int lanes, int work_group_size,
                          const std::string& defines) {
    std::string options = "-cl-std=CL1.2";
    // Other vendors' compilers warn about things that are none of the kernels' fault.
    if (device.is_pocl) options += " -Werror";
    if (device.has_exact_float) options += " -cl-fp32-correctly-rounded-divide-sqrt";
    options += " -DLANES=" + std::to_string(lanes);
    options += " -DMORTISE_WORK_GROUP=" + std::to_string(work_group_size);
    if (!defines.empty()) options += " " + defines;
    return options;
}

std::string with_prelude(const std::string& source) {
    // Processors without 512-bit registers get vectors of eight in pieces; Clang warns of a calling
    // convention that only calls between programs would have to agree on.
    return "#pragma OPENCL FP_CONTRACT OFF\n"
           "#ifdef __clang__\n#pragma clang diagnostic ignored \"-Wpsabi\"\n#endif\n"
           "#define MORTISE_KERNEL __kernel __attribute__((reqd_work_group_size(MORTISE_WORK_GROUP, 1, "
           "1)))\n" +
           source;
}

std::string binary_key(const FoundDevice& device, const std::string& options) {
    const DeviceInfo& info = device.info;
    std::string key;
    for (const std::string& part :
         {info.platform, device.platform_version, info.name, info.version, info.driver, options}) {
        key += part + "\n";
    }
    return key;
}

std::string with_places(const std::string& log, const std::string& source) {
    std::vector<std::string> place = {""};  // of each line, from 1 on
    std::istringstream lines(source);
    std::string file;
    std::size_t number = 0;
    for (std::string line; std::getline(lines, line);) {
        place.push_back(file.empty() ? "" : file + ":" + std::to_string(number++) + ":");
        std::istringstream words(line);
        std::string directive;
        if (words >> directive && directive == "#line") words >> number >> std::quoted(file);
    }
    static const std::string kMark = "<kernel>:";
    std::string result;
    std::size_t at = 0;
    for (std::size_t mark; (mark = log.find(kMark, at)) != std::string::npos;) {
        std::size_t end = mark + kMark.size();
        std::size_t line = 0;
        while (end < log.size() && log[end] >= '0' && log[end] <= '9' && line < place.size())
            line = 10 * line + static_cast<std::size_t>(log[end++] - '0');
        const bool is_known =
            end < log.size() && log[end] == ':' && line < place.size() && !place[line].empty();
        result += log.substr(at, mark - at) + (is_known ? place[line] : log.substr(mark, end + 1 - mark));
        at = std::min(end + 1, log.size());
    }
    return result + log.substr(at);
}

std::string build_failure(const FoundDevice& device, const std::string& file, const std::string& options,
                          const std::string& source, const std::string& log) {
    std::string text =
        "kernels/" + file + " does not build on " + device.info.name + " (options: " + options + ")";
    text += log.empty() ? "; the compiler gave no reason" : ":\n" + with_places(log, source);
    while (!text.empty() && text.back() == '\n') text.pop_back();
    if (log.find("shared data") != std::string::npos)  // NVIDIA's word for local memory
        text += "\nit needs too much local memory; choose a smaller work-group size";
    return text;
}

void require_linker(const FoundDevice& device) {
    if (device.is_pocl && find_on_path("ld").empty()) {
        throw Error(
            ExitCode::kDevice,
            "no linker `ld` on PATH, which PoCL needs to build kernels: `apt-get install binutils`, or add "
            "its folder to PATH");
    }
}

}  // namespace mortise::device
