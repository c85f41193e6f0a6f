// Each stage by itself: its rate, the bytes that it moves, and how near that is to the machine's copy
// bandwidth; see sections.hpp.
#include <cstdio>
#include <string>

#include "bench/print.hpp"
#include "bench/sections.hpp"
#include "bench/statistics.hpp"
#include "bench/workers.hpp"

namespace mortise::bench {

using nlohmann::json;

namespace {

/// Summary of one stage over the runs. A copied byte is one read and one written, so its share of the copy
/// bandwidth takes half of the bytes moved.
json summarize(const json& runs, std::size_t stage, double elements, double copy_bytes_per_second) {
    Samples seconds;
    for (const json& run : runs)
        seconds.values.push_back(run.at("stages").at(stage).at("seconds").get<double>());
    const json& first = runs.at(0).at("stages").at(stage);
    const double bytes = first.at("bytes");
    json result = {{"stage", first.at("stage")}, {"seconds", to_json(seconds)}, {"bytes", bytes}};
    if (seconds.median() > 0) {  // a model may have nothing for a stage to do
        const double rate = bytes / seconds.median();
        result["spread"] = seconds.spread();
        result["elements_per_second"] = elements / seconds.median();
        result["bytes_per_second"] = rate;
        if (copy_bytes_per_second > 0) result["share_of_copy_bandwidth"] = rate / (2 * copy_bytes_per_second);
    }
    return result;
}

/// Prints how fast a file was written, beside a plain write of as many bytes; returns the figures.
json print_file(const json& runs, const char* kind) {
    Samples seconds, plain;
    for (const json& run : runs) {
        const json& file = run.at("files").at(kind);
        seconds.values.push_back(file.at("seconds"));
        plain.values.push_back(file.at("plain_write_seconds"));
    }
    const double bytes = runs.at(0).at("files").at(kind).at("bytes");
    const double share = plain.median() / seconds.median();
    std::printf("  .vtu %s: %s MB in %s ms, %s of the rate of a plain write of its bytes\n",
                std::string(kind) == "compressed" ? "compressed" : "with --no-compress",
                short_number(1e-6 * bytes).c_str(), short_number(1e3 * seconds.median()).c_str(),
                percent(share).c_str());
    return {{"bytes", bytes},
            {"seconds", to_json(seconds)},
            {"plain_write_seconds", to_json(plain)},
            {"share_of_plain_rate", share}};
}

}  // namespace

json stages_section(const Settings& settings, double copy_bytes_per_second) {
    std::printf(
        "Stages, %s: elements of the finished mesh by each stage's own time, and bytes that it reads and "
        "writes\n"
        "(bench/stage_bytes.hpp: each array once a pass) against those that a copy reads and writes\n"
        "  descent to templates: time of their kernels by OpenCL profiling; the others: wall time\n",
        count_of_threads(settings.threads).c_str());
    json result = json::array();
    for (const char* model : {"sphere", "bracket"}) {
        Task task;
        task.kind = "stages";
        task.model = model;
        task.level = settings.level(7);
        task.threads = settings.threads;
        task.repeats = settings.repeats;
        announce("stages, " + task.model);
        json measured = measure_in_child(task);
        const json runs = measured.at("runs");
        const double elements = measured.at("elements");
        const Samples seconds = collect(runs, "seconds");
        Table table({{task.model + ", " + std::to_string(task.level), ""},
                     {"time", "ms"},
                     {"spread", ""},
                     {"elements", "M/s"},
                     {"moved", "MB"},
                     {"moved", "GB/s"},
                     {"of copy", "bandwidth"}});
        json stages = json::array();
        for (std::size_t i = 0; i < runs.at(0).at("stages").size(); ++i) {
            const json stage = summarize(runs, i, elements, copy_bytes_per_second);
            stages.push_back(stage);
            if (!stage.contains("spread")) continue;
            table.add({stage.at("stage"), short_number(1e3 * stage.at("seconds").at("median").get<double>()),
                       percent(stage.at("spread")),
                       short_number(1e-6 * stage.at("elements_per_second").get<double>()),
                       short_number(1e-6 * stage.at("bytes").get<double>()),
                       short_number(1e-9 * stage.at("bytes_per_second").get<double>()),
                       stage.contains("share_of_copy_bandwidth")
                           ? percent(stage.at("share_of_copy_bandwidth"))
                           : "?"});
        }
        table.print();
        std::printf("  all but writing: %s ms\n", short_number(1e3 * seconds.median()).c_str());
        json files = json::object();
        for (const char* kind : {"compressed", "plain_arrays"}) files[kind] = print_file(runs, kind);
        measured.erase("runs");
        measured["model"] = task.model;
        measured["level"] = task.level;
        measured["seconds"] = to_json(seconds);
        measured["files"] = files;
        measured["stages"] = stages;
        result.push_back(measured);
    }
    return result;
}

}  // namespace mortise::bench
