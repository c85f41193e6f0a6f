// Cells of several sizes; see sections.hpp.
#include <algorithm>
#include <cstdio>

#include "bench/print.hpp"
#include "bench/sections.hpp"
#include "bench/statistics.hpp"
#include "bench/workers.hpp"

namespace mortise::bench {

using nlohmann::json;

namespace {

json measure_all_balances(const Settings& settings) {
    std::printf(
        "2:1 balance across faces, edges and corners, of the octree of a sphere's surface; result equal to a "
        "slow reference's: tests/octree\n");
    json result = json::array();
    Table table({{"level", ""}, {"", ""}, {"leaves", ""}, {"time", "ms"}, {"spread", ""}, {"leaves", "M/s"}});
    Task task;
    task.kind = "balance";
    task.level = settings.level(9);
    task.repeats = settings.repeats;
    for (const int threads : {1, settings.threads}) {
        if (threads == task.threads && !result.empty()) break;  // a machine with one core
        task.threads = threads;
        announce("balance, " + count_of_threads(threads));
        json measured = measure_in_child(task);
        const Samples seconds = collect(measured.at("runs"), "seconds");
        const double leaves = measured.at("leaves");
        table.add({std::to_string(task.level), count_of_threads(threads), grouped(measured.at("leaves")),
                   short_number(1e3 * seconds.median()), percent(seconds.spread()),
                   short_number(1e-6 * leaves / seconds.median())});
        result.push_back({{"level", task.level},
                          {"threads", threads},
                          {"leaves", measured.at("leaves")},
                          {"seconds", to_json(seconds)},
                          {"leaves_per_second", leaves / seconds.median()}});
    }
    table.print();
    return result;
}

json measure_coarse_interiors(const Settings& settings) {
    std::printf(
        "\nCoarse interior of a sphere: elements of a mesh of one size to those with interior coarsening\n"
        "  bound: with nothing inside; cell: elements of a conforming mesh in each cell beside smaller "
        "ones\n");
    json result = json::array();
    Table table({{"level", ""},
                 {"elements", "one size"},
                 {"bound", ""},
                 {"conforming", "saved"},
                 {"", "s"},
                 {"hanging nodes", "saved"},
                 {"", "s"},
                 {"elements", "/cell"}});
    int before = 0;
    for (const int wanted : {7, 8, 9}) {
        Task task;
        task.kind = "graded";
        task.level = settings.level(wanted);
        task.threads = settings.threads;
        if (task.level == before) break;
        before = task.level;
        announce("coarse interior, level " + std::to_string(task.level));
        json measured = measure_in_child(task);
        const auto of = [&](const char* name) { return measured.at(name).get<double>(); };
        const auto saved = [&](const char* name) { return of("uniform_elements") / std::max(1.0, of(name)); };
        measured["level"] = task.level;
        measured["bound"] = saved("boundary_elements");
        measured["conforming_saved"] = saved("conforming_elements");
        measured["hanging_saved"] = saved("hanging_elements");
        table.add({std::to_string(task.level), grouped(measured.at("uniform_elements")),
                   fixed(measured.at("bound"), 2), fixed(measured.at("conforming_saved"), 2),
                   short_number(of("conforming_seconds")), fixed(measured.at("hanging_saved"), 2),
                   short_number(of("hanging_seconds")),
                   fixed(of("transition_elements") / std::max(1.0, of("transition_cells")), 1)});
        result.push_back(measured);
    }
    table.print();
    return result;
}

}  // namespace

json graded_section(const Settings& settings) {
    json result;
    result["balance"] = measure_all_balances(settings);
    result["coarse_interior"] = measure_coarse_interiors(settings);
    return result;
}

}  // namespace mortise::bench
