// Copy bandwidth and octree descent; see sections.hpp.
#include "bench/sections.hpp"

#include <algorithm>
#include <cstdio>

#include "bench/print.hpp"
#include "bench/statistics.hpp"
#include "bench/workers.hpp"
#include "mortise/error.hpp"

namespace mortise::bench {

using nlohmann::json;

void announce(const std::string& what) { std::fprintf(stderr, "mortise_bench: %s\n", what.c_str()); }

std::string count_of_threads(int threads) {
    return std::to_string(threads) + (threads == 1 ? " thread" : " threads");
}

json copy_section(const Settings& settings) {
    std::printf("Copy bandwidth: memcpy of %zu MiB; each byte copied counts once (it is read and written)\n",
                settings.copy_bytes >> 20);
    json result = {{"buffer_bytes", settings.copy_bytes}, {"runs", json::array()}};
    Table table({{"", ""}, {"copied", "GB/s"}, {"spread", ""}, {"to one thread", "ratio"}});
    double one_thread = 0;
    for (const int threads : {1, settings.threads}) {
        if (threads == 1 && one_thread > 0) break;  // a machine with one core
        announce("copy bandwidth, " + count_of_threads(threads));
        Task task;
        task.kind = "copy";
        task.threads = threads;
        task.repeats = 3 * settings.repeats;  // they are short
        task.bytes = settings.copy_bytes;
        const Samples seconds = collect(measure_in_child(task).at("runs"), "seconds");
        const double rate = static_cast<double>(settings.copy_bytes) / seconds.median();
        if (one_thread == 0) one_thread = rate;
        table.add({count_of_threads(threads), short_number(1e-9 * rate), percent(seconds.spread()),
                   fixed(rate / one_thread, 2)});
        result["runs"].push_back(
            {{"threads", threads}, {"seconds", to_json(seconds)}, {"bytes_per_second", rate}});
        result["bytes_per_second"] = rate;  // of all threads: the last one
    }
    table.print();
    return result;
}

namespace {

/// Measures a model in cells of a level, or of two levels less if these do not fit into memory, and so on;
/// null if none do. Failures are told, and appended to `failures`.
json measure_fitting(Task& task, json& failures) {
    for (; task.level > 2; task.level -= 2) {
        announce("octree, " + task.model + ", " + std::to_string(task.level));
        try {
            return measure_in_child(task);
        } catch (const Error& error) {  // tapes may not fit into memory
            std::printf("  %s failed at level %d: %s\n", task.model.c_str(), task.level, error.what());
            failures.push_back({{"model", task.model}, {"level", task.level}, {"failed", error.what()}});
        }
    }
    return nullptr;
}

struct OctreeRates {
    double cells;  ///< per core, or of a GPU
    Samples kernels, stage, reference;
    double kernel_rate, reference_rate;
    double shared_rate;  ///< of all threads
};

OctreeRates octree_rates(const json& measured, const json& shared) {
    OctreeRates rates{};
    const double cores = measured.at("is_gpu").get<bool>() ? 1 : measured.at("compute_units").get<double>();
    rates.cells = measured.at("cells").get<double>() / cores;
    rates.kernels = collect(measured.at("runs"), "kernel_seconds");
    rates.stage = collect(measured.at("runs"), "stage_seconds");
    rates.reference = collect(measured.at("runs"), "reference_seconds");
    rates.kernel_rate = rates.cells / rates.kernels.median();
    rates.reference_rate = measured.at("reference_cells").get<double>() / rates.reference.median();
    const Samples shared_kernels = collect(shared.at("runs"), "kernel_seconds");
    rates.shared_rate = shared.at("cells").get<double>() / shared_kernels.median();
    return rates;
}

/// Instead of single runs: what they come to.
void conclude(json& measured, const OctreeRates& rates, const Task& task) {
    measured["kernels_to_reference"] = rates.kernel_rate / rates.reference_rate;
    measured["all_threads_to_reference"] = rates.shared_rate / rates.reference_rate;
    measured.erase("runs");
    measured["model"] = task.model;
    measured["level"] = task.level;
    measured["kernel_seconds"] = to_json(rates.kernels);
    measured["stage_seconds"] = to_json(rates.stage);
    measured["reference_seconds"] = to_json(rates.reference);
    measured["kernel_cells_per_second_per_core"] = rates.kernel_rate;
    measured["reference_cells_per_second"] = rates.reference_rate;
}

}  // namespace

json octree_section(const Settings& settings) {
    std::printf(
        "Octree descent: cells classified as in, out or undecided, in million cells/s on one core\n"
        "  kernels: time in `descend` and `gather_children` by OpenCL profiling, one device thread\n"
        "  stage: wall time of the whole octree stage, one device thread (adds scans, bitmaps, downloads)\n"
        "  reference: the scalar host code (double precision, not tuned) on the same model, one thread; the\n"
        "  two differ in a few cells, as their bounds round differently and only one drops redundant "
        "surfaces\n");
    json result = json::array();
    Table table({{"model, level", ""},
                 {"surfaces", ""},
                 {"cells", "device"},
                 {"cells", "reference"},
                 {"kernels", "Mcells/s"},
                 {"spread", ""},
                 {"stage", "Mcells/s"},
                 {"spread", ""},
                 {"reference", "Mcells/s"},
                 {"spread", ""},
                 {"kernels /", "reference"},
                 {count_of_threads(settings.threads) + " /", "reference"},
                 {"cost a cell", "to 30's"},
                 {"tree, bytes", "/undecided"}});
    std::string device;
    double cost_at_30 = 0;
    for (const char* model : {"sphere", "random:30", "random:300", "random:3000"}) {
        Task task;
        task.kind = "octree";
        task.model = model;
        task.level = settings.level(task.model == "sphere" ? 8 : 7);
        task.repeats = std::min(settings.repeats, 3);
        json measured = measure_fitting(task, result);
        if (measured.is_null()) continue;
        const std::string title = task.model + ", " + std::to_string(task.level);
        device = measured.at("device").get<std::string>();
        if (measured.at("is_gpu").get<bool>()) device += " (a GPU: rates are of the whole device)";
        task.threads = settings.threads;
        announce("octree, " + title + ", " + count_of_threads(settings.threads));
        const json shared = measure_in_child(task);
        const OctreeRates rates = octree_rates(measured, shared);
        if (task.model == "random:30") cost_at_30 = 1 / rates.kernel_rate;
        const double cost = cost_at_30 > 0 ? 1 / (rates.kernel_rate * cost_at_30) : 0;
        const double tree_bytes =
            measured.at("tree_bytes").get<double>() / std::max(1.0, measured.at("nio_cells").get<double>());
        table.add({title, grouped(measured.at("surfaces")), grouped(measured.at("cells")),
                   grouped(measured.at("reference_cells")), short_number(1e-6 * rates.kernel_rate),
                   percent(rates.kernels.spread()), short_number(1e-6 * rates.cells / rates.stage.median()),
                   percent(rates.stage.spread()), short_number(1e-6 * rates.reference_rate),
                   percent(rates.reference.spread()), fixed(rates.kernel_rate / rates.reference_rate, 2),
                   fixed(rates.shared_rate / rates.reference_rate, 2), cost > 0 ? fixed(cost, 2) : "",
                   short_number(tree_bytes)});
        if (cost > 0) measured["cell_cost_to_random_30"] = cost;
        measured["tree_bytes_per_undecided_cell"] = tree_bytes;
        conclude(measured, rates, task);
        result.push_back(measured);
    }
    table.print();
    std::printf("  device: %s\n", device.c_str());
    return result;
}

}  // namespace mortise::bench
