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
        json measured;
        for (; measured.is_null() && task.level > 2; task.level -= 2) {
            announce("octree, " + task.model + ", " + std::to_string(task.level));
            try {
                measured = measure_in_child(task);
                break;
            } catch (const Error& error) {  // tapes may not fit into memory
                std::printf("  %s failed at level %d: %s\n", task.model.c_str(), task.level, error.what());
                result.push_back({{"model", task.model}, {"level", task.level}, {"failed", error.what()}});
            }
        }
        if (measured.is_null()) continue;
        const std::string title = task.model + ", " + std::to_string(task.level);
        device = measured.at("device").get<std::string>();
        if (measured.at("is_gpu").get<bool>()) device += " (a GPU: rates are of the whole device)";
        const double cores =
            measured.at("is_gpu").get<bool>() ? 1 : measured.at("compute_units").get<double>();
        const double cells = measured.at("cells").get<double>() / cores;
        const Samples kernels = collect(measured.at("runs"), "kernel_seconds");
        const Samples stage = collect(measured.at("runs"), "stage_seconds");
        const Samples reference = collect(measured.at("runs"), "reference_seconds");
        const double kernel_rate = cells / kernels.median();
        const double reference_rate = measured.at("reference_cells").get<double>() / reference.median();
        task.threads = settings.threads;
        announce("octree, " + title + ", " + count_of_threads(settings.threads));
        const json shared = measure_in_child(task);
        const Samples shared_kernels = collect(shared.at("runs"), "kernel_seconds");
        const double shared_rate = shared.at("cells").get<double>() / shared_kernels.median();
        if (task.model == "random:30") cost_at_30 = 1 / kernel_rate;
        const double cost = cost_at_30 > 0 ? 1 / (kernel_rate * cost_at_30) : 0;
        const double tree_bytes =
            measured.at("tree_bytes").get<double>() / std::max(1.0, measured.at("nio_cells").get<double>());
        table.add({title, grouped(measured.at("surfaces")), grouped(measured.at("cells")),
                   grouped(measured.at("reference_cells")), short_number(1e-6 * kernel_rate),
                   percent(kernels.spread()), short_number(1e-6 * cells / stage.median()),
                   percent(stage.spread()), short_number(1e-6 * reference_rate), percent(reference.spread()),
                   fixed(kernel_rate / reference_rate, 2), fixed(shared_rate / reference_rate, 2),
                   cost > 0 ? fixed(cost, 2) : "", short_number(tree_bytes)});
        if (cost > 0) measured["cell_cost_to_random_30"] = cost;
        measured["tree_bytes_per_undecided_cell"] = tree_bytes;
        measured["kernels_to_reference"] = kernel_rate / reference_rate;
        measured["all_threads_to_reference"] = shared_rate / reference_rate;
        measured.erase("runs");
        measured["model"] = task.model;
        measured["level"] = task.level;
        measured["kernel_seconds"] = to_json(kernels);
        measured["stage_seconds"] = to_json(stage);
        measured["reference_seconds"] = to_json(reference);
        measured["kernel_cells_per_second_per_core"] = kernel_rate;
        measured["reference_cells_per_second"] = reference_rate;
        result.push_back(measured);
    }
    table.print();
    std::printf("  device: %s\n", device.c_str());
    return result;
}

}  // namespace mortise::bench
