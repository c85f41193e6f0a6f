// End to end in memory: rates, stages, memory, growth, and what threads bring; see sections.hpp.
#include <cstdio>
#include <map>

#include "bench/print.hpp"
#include "bench/sections.hpp"
#include "bench/statistics.hpp"
#include "bench/workers.hpp"

namespace mortise::bench {
namespace {

using nlohmann::json;

struct Case {
    const char* model;
    int level;
};

std::string title_of(const Task& task) { return task.model + ", " + std::to_string(task.level); }

Task mesh_task(const Settings& settings, const Case& chosen, int threads) {
    Task task;
    task.kind = "mesh";
    task.model = chosen.model;
    task.level = settings.level(chosen.level);
    task.threads = threads;
    task.repeats = task.model == "lattice" ? 1 : settings.repeats;
    return task;
}

/// Median over the runs of each stage's wall and CPU time, in the order of the stages.
json median_stages(const json& runs) {
    json result = json::array();
    for (std::size_t i = 0; i < runs.at(0).at("stages").size(); ++i) {
        Samples wall;
        Samples cpu;
        for (const json& run : runs) {
            wall.values.push_back(run.at("stages").at(i).at("wall").get<double>());
            cpu.values.push_back(run.at("stages").at(i).at("cpu").get<double>());
        }
        result.push_back({{"stage", runs.at(0).at("stages").at(i).at("stage")},
                          {"wall_seconds", wall.median()},
                          {"cpu_seconds", cpu.median()}});
    }
    return result;
}

/// Measures a case; the runs are replaced by their summaries.
json measure(const Task& task) {
    announce("mesh, " + title_of(task) + ", " + count_of_threads(task.threads));
    json measured = measure_in_child(task);
    const Samples seconds = collect(measured.at("runs"), "seconds");
    measured["model"] = task.model;
    measured["threads"] = task.threads;
    measured["seconds"] = to_json(seconds);
    measured["spread"] = seconds.spread();
    measured["stages"] = median_stages(measured.at("runs"));
    measured["elements_per_second"] = measured.at("elements").get<double>() / seconds.median();
    measured["nodes_per_second"] = measured.at("nodes").get<double>() / seconds.median();
    measured["geometry_bytes_per_second"] = measured.at("geometry_bytes").get<double>() / seconds.median();
    measured.erase("runs");
    return measured;
}

double median_seconds(const json& measured) { return measured.at("seconds").at("median").get<double>(); }

void print_rates(const json& cases, double copy_bytes_per_second) {
    Table table({{"model, level", ""},
                 {"elements", ""},
                 {"nodes", ""},
                 {"time", "s"},
                 {"spread", ""},
                 {"first", "s"},
                 {"elements", "M/s"},
                 {"nodes", "M/s"},
                 {"mesh made", "MB/s"},
                 {"of copy", "bandwidth"},
                 {"peak memory", "MB"},
                 {"peak memory", "bytes/element"},
                 {"mesh itself", "bytes/element"},
                 {"peak to", "mesh"},
                 {"later ones", "bytes/element"}});
    for (const json& one : cases) {
        const double elements = one.at("elements");
        const double grown = one.at("peak_bytes").get<double>() - one.at("idle_bytes").get<double>();
        table.add(
            {one.at("title"), grouped(one.at("elements")), grouped(one.at("nodes")),
             short_number(median_seconds(one)), percent(one.at("spread")),
             short_number(one.at("first_seconds").get<double>()),
             short_number(1e-6 * one.at("elements_per_second").get<double>()),
             short_number(1e-6 * one.at("nodes_per_second").get<double>()),
             short_number(1e-6 * one.at("geometry_bytes_per_second").get<double>()),
             copy_bytes_per_second > 0
                 ? percent(one.at("geometry_bytes_per_second").get<double>() / copy_bytes_per_second)
                 : "?",
             short_number(1e-6 * one.at("peak_bytes").get<double>()), short_number(grown / elements),
             short_number(one.at("mesh_bytes").get<double>() / elements),
             fixed(grown / one.at("mesh_bytes").get<double>(), 2),
             short_number((one.at("warm_peak_bytes").get<double>() - one.at("idle_bytes").get<double>()) /
                          elements)});
    }
    table.print();
}

void print_stages(const json& cases) {
    std::printf(
        "  Time by stage: wall ms, and in brackets the cores that were busy (CPU time / wall time)\n");
    std::vector<Table::Heading> headings = {{"model, level", ""}};
    for (const json& stage : cases.at(0).at("stages")) headings.push_back({stage.at("stage"), ""});
    Table table(headings);
    for (const json& one : cases) {
        std::vector<std::string> row = {one.at("title")};
        for (const json& stage : one.at("stages")) {
            const double wall = stage.at("wall_seconds");
            const double cores = wall > 0 ? stage.at("cpu_seconds").get<double>() / wall : 0;
            row.push_back(short_number(1e3 * wall) + " (" + fixed(cores, 1) + ")");
        }
        table.add(row);
    }
    table.print();
}

/// Exponent of time in elements, for each model with several sizes.
json print_growth(const json& cases) {
    std::map<std::string, std::pair<std::vector<double>, std::vector<double>>> points;
    for (const json& one : cases) {
        auto& [elements, seconds] = points[one.at("model")];
        elements.push_back(one.at("elements"));
        seconds.push_back(median_seconds(one));
    }
    json result = json::object();
    for (const auto& [model, series] : points) {
        if (series.first.size() < 2) continue;
        const double exponent = growth_exponent(series.first, series.second);
        result[model] = exponent;
        std::printf("  Growth, %s: time ~ elements^%s over %s times the elements\n", model.c_str(),
                    fixed(exponent, 2).c_str(),
                    short_number(series.first.back() / series.first.front()).c_str());
    }
    return result;
}

/// Models with many complex cells against the largest sphere.
void print_complex(const json& cases) {
    double sphere = 0;
    for (const json& one : cases) {
        if (one.at("model") == "sphere") sphere = one.at("elements_per_second");
    }
    for (const json& one : cases) {
        if (one.at("model") == "sphere") continue;
        std::printf("  %s: %s of the largest sphere's elements/s\n",
                    one.at("title").get<std::string>().c_str(),
                    percent(one.at("elements_per_second").get<double>() / sphere).c_str());
    }
}

}  // namespace

json mesh_section(const Settings& settings, double copy_bytes_per_second) {
    std::printf(
        "End to end in memory: Mesher::generate, from a parsed model to a finished mesh, kernels loaded, "
        "each\n"
        "  in the memory of the one before (Mesher::recycle), %s; first: the first of a process\n"
        "  peak memory: largest resident size of the process during its first mesh; per element without "
        "what\n"
        "  was resident before (program, OpenCL, kernels); later ones: with what is kept for the next mesh\n"
        "  mesh made: its coordinates and connectivity\n",
        count_of_threads(settings.threads).c_str());
    json cases = json::array();
    for (const Case& chosen : {Case{"sphere", 6}, Case{"sphere", 7}, Case{"sphere", 8}, Case{"bracket", 6},
                               Case{"bracket", 7}, Case{"bracket", 8}, Case{"lattice", 7}}) {
        const Task task = mesh_task(settings, chosen, settings.threads);
        if (task.model == "lattice" && !settings.with_lattice) continue;
        if (!cases.empty() && cases.back().at("title") == title_of(task))
            continue;  // lowered to the same level
        json measured = measure(task);
        measured["title"] = title_of(task);
        cases.push_back(measured);
    }
    print_rates(cases, copy_bytes_per_second);
    std::printf("\n");
    print_stages(cases);
    std::printf("\n");
    const json growth = print_growth(cases);
    print_complex(cases);
    return {{"cases", cases}, {"growth_exponents", growth}};
}

json threads_section(const Settings& settings, double copy_gain) {
    std::printf(
        "Threads: the same with 1 and with %d threads, host and device (if it is PoCL's CPU);\n"
        "figures by stage are time with 1 / time with %d\n",
        settings.threads, settings.threads);
    if (copy_gain > 0 && settings.threads > 1) {
        std::printf("  copy bandwidth, the limit of what only moves memory: %s times that of 1 thread\n",
                    fixed(copy_gain, 2).c_str());
    }
    if (settings.threads == 1) {
        std::printf("  skipped: this machine has one core\n");
        return {{"skipped", "one core"}};
    }
    json result = json::array();
    for (const Case& chosen : {Case{"sphere", 7}, Case{"bracket", 7}}) {
        const Task task = mesh_task(settings, chosen, settings.threads);
        Task alone = task;
        alone.threads = 1;
        const json one = measure(alone);
        const json all = measure(task);
        const double speedup = median_seconds(one) / median_seconds(all);
        std::printf("  %s: %s s with 1 (spread %s), %s s with %d (spread %s): %s times as fast\n",
                    title_of(task).c_str(), short_number(median_seconds(one)).c_str(),
                    percent(one.at("spread")).c_str(), short_number(median_seconds(all)).c_str(),
                    settings.threads, percent(all.at("spread")).c_str(), fixed(speedup, 2).c_str());
        std::string stages;
        for (std::size_t i = 0; i < one.at("stages").size(); ++i) {
            const double before = one.at("stages").at(i).at("wall_seconds");
            const double after = all.at("stages").at(i).at("wall_seconds");
            if (before < 0.02 * median_seconds(one)) continue;
            stages += (stages.empty() ? "" : ", ") + one.at("stages").at(i).at("stage").get<std::string>() +
                      " " + fixed(before / after, 2);
        }
        std::printf("    by stage (those above 2 %% of the time): %s\n", stages.c_str());
        result.push_back({{"one_thread", one}, {"all_threads", all}, {"speedup", speedup}});
    }
    return result;
}

}  // namespace mortise::bench
