// Meshes within a budget of memory; see sections.hpp.
#include <algorithm>
#include <cstdio>
#include <set>
#include <vector>

#include "bench/print.hpp"
#include "bench/sections.hpp"
#include "bench/statistics.hpp"
#include "bench/workers.hpp"
#include "mortise/error.hpp"

namespace mortise::bench {

using nlohmann::json;

json stream_section(const Settings& settings) {
    std::printf(
        "Part by part within a budget of memory (--memory), to a sink that keeps checksums; %s\n"
        "  each part is made two or three times; the budget does not change the mesh\n",
        count_of_threads(settings.threads).c_str());
    Table table({{"model, level", ""},
                 {"budget", "MB"},
                 {"peak", "MB"},
                 {"parts", ""},
                 {"elements", ""},
                 {"time", "s"},
                 {"elements", "M/s"},
                 {"checksum", ""}});
    json result = json::array();
    struct Case {
        const char* model;
        int level;
        std::size_t megabytes[2];
    };
    const int level = settings.level(8);
    const std::size_t least = level > 8 ? 2400 : 600;  // what is needed grows with the boundary
    std::vector<Case> cases = {{"halves", level, {least, 2 * least}}, {"sphere", level, {least, 2 * least}}};
    if (settings.with_billion) cases.push_back({"halves", 10, {4000, 3000}});
    for (const Case& chosen : cases) {
        std::set<std::string> checksums;
        for (const std::size_t megabytes : chosen.megabytes) {
            Task task;
            task.kind = "stream";
            task.model = chosen.model;
            task.level = chosen.level;
            task.threads = settings.threads;
            task.repeats = chosen.level > 9 ? 1 : std::min(settings.repeats, 2);
            task.bytes = megabytes * 1'000'000;
            announce("stream, " + task.model);
            json measured = measure_in_child(task);
            const Samples seconds = collect(measured.at("runs"), "seconds");
            const auto elements = measured.at("elements").get<std::uint64_t>();
            checksums.insert(measured.at("checksum").get<std::string>());
            table.add({task.model + ", " + std::to_string(task.level), std::to_string(megabytes),
                       fixed(1e-6 * measured.at("peak_bytes").get<double>(), 0),
                       std::to_string(measured.at("parts").get<std::uint64_t>()), grouped(elements),
                       short_number(seconds.median()),
                       short_number(1e-6 * static_cast<double>(elements) / seconds.median()),
                       measured.at("checksum").get<std::string>()});
            measured["model"] = task.model;
            measured["level"] = task.level;
            measured["budget_bytes"] = task.bytes;
            measured["seconds"] = to_json(seconds);
            result.push_back(measured);
        }
        if (checksums.size() > 1)
            throw Error(ExitCode::kMeshing,
                        std::string(chosen.model) + ": the budget of memory changed the mesh");
    }
    table.print();
    return result;
}

}  // namespace mortise::bench
