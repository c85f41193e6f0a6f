// mortise_bench: how fast Mortise is on this machine, as text and as JSON. See --help and bench/run.sh.
//
// Everything is measured in child processes of this program (workers.hpp), one at a time.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "bench/print.hpp"
#include "bench/process.hpp"
#include "bench/sections.hpp"
#include "bench/workers.hpp"
#include "mortise/error.hpp"

namespace mortise::bench {
namespace {

using nlohmann::json;

const std::vector<std::string> kSections = {"copy",    "octree", "graded", "mesh",      "stages", "threads",
                                            "command", "batch",  "stream", "jacobians", "peers"};

/// Share of the machine's cores used by others above which figures are marked as unreliable.
constexpr double kBusy = 0.1;

struct Arguments {
    Settings settings;
    std::vector<std::string> only;
    std::string json_path;
    bool quick = false;
};

std::string processor_name() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);) {
        if (line.compare(0, 10, "model name") == 0 && line.find(": ") != std::string::npos) {
            return line.substr(line.find(": ") + 2);
        }
    }
    return "unknown processor";
}

json describe_machine(const Settings& settings) {
    double load[3] = {0, 0, 0};
    const bool has_load = getloadavg(load, 3) > 0;
    const double memory =
        static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
    json machine = {{"processor", processor_name()}, {"cores", settings.threads}, {"memory_bytes", memory}};
    machine["load_before"] = has_load ? json(load[0]) : json();
    return machine;
}

/// One line on how far the figures above it can be trusted.
json print_load(const LoadWatch& watch, double seconds) {
    const LoadWatch::Load load = watch.so_far();
    if (!load.known) {
        std::printf("  [%s s]\n", fixed(seconds, 0).c_str());
        return {{"seconds", seconds}};
    }
    std::printf("  [%s s; other processes used %s of the machine's cores meanwhile, other machines %s%s]\n",
                fixed(seconds, 0).c_str(), percent(load.others).c_str(), percent(load.stolen).c_str(),
                load.others + load.stolen > kBusy ? "; too busy for figures worth keeping" : "");
    return {{"seconds", seconds}, {"others_share", load.others}, {"stolen_share", load.stolen}};
}

void write_report(const json& report, const std::string& path) {
    std::ofstream file(path);
    file << report.dump(2) << "\n";
    if (!file.flush()) {
        throw Error(ExitCode::kFiles,
                    "cannot write '" + path + "'; choose a file in a folder that can be written to");
    }
}

/// Whether all went well: a section that fails is told of, and the others are still run.
bool run_sections(const Arguments& arguments) {
    const Settings& settings = arguments.settings;
    json report = {{"format", "mortise-bench 1"}, {"repeats", settings.repeats}};
    report["machine"] = describe_machine(settings);
    if (!arguments.json_path.empty()) write_report(report, arguments.json_path);  // fails now if ever
    const json& machine = report["machine"];
    std::printf(
        "Mortise benchmark: %s, %d cores, %s GB of memory; load average before the run %s\n",
        machine.at("processor").get<std::string>().c_str(), settings.threads,
        short_number(1e-9 * machine.at("memory_bytes").get<double>()).c_str(),
        machine.at("load_before").is_null() ? "unknown" : fixed(machine.at("load_before"), 2).c_str());
    std::printf(
        "Each time is the median of %d run%s; spread: (largest - smallest) / median. M = 10^6, k = 10^3.\n",
        settings.repeats, settings.repeats == 1 ? "" : "s");

    double copy_rate = 0;
    double copy_gain = 0;
    const std::vector<std::function<json()>> actions = {
        [&] {
            json result = copy_section(settings);
            copy_rate = result.at("bytes_per_second");
            copy_gain = copy_rate / result.at("runs").at(0).at("bytes_per_second").get<double>();
            return result;
        },
        [&] { return octree_section(settings); },
        [&] { return graded_section(settings); },
        [&] { return mesh_section(settings, copy_rate); },
        [&] { return stages_section(settings, copy_rate); },
        [&] { return threads_section(settings, copy_gain); },
        [&] { return command_section(settings); },
        [&] { return batch_section(settings); },
        [&] { return stream_section(settings); },
        [&] { return jacobians_section(settings); },
        [&] { return peers_section(settings); },
    };
    for (std::size_t i = 0; i < kSections.size(); ++i) {
        const bool chosen = arguments.only.empty() || std::find(arguments.only.begin(), arguments.only.end(),
                                                                kSections[i]) != arguments.only.end();
        if (!chosen) continue;
        std::printf("\n%zu. ", i + 1);
        const LoadWatch watch;
        const auto begin = std::chrono::steady_clock::now();
        try {
            report[kSections[i]] = actions[i]();
        } catch (const Error& error) {
            std::printf("  failed: %s\n", error.what());
            std::fprintf(stderr, "mortise_bench: %s: %s\n", kSections[i].c_str(), error.what());
            report["failed"][kSections[i]] = error.what();
        }
        const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
        report["load"][kSections[i]] = print_load(watch, wall.count());
        if (!arguments.json_path.empty()) write_report(report, arguments.json_path);
        std::fflush(stdout);
    }
    return !report.contains("failed");
}

void add_options(CLI::App& app, Arguments& arguments) {
    app.add_option("--repeats", arguments.settings.repeats, "runs of which the median is taken")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    app.add_option("--mortise", arguments.settings.program,
                   "the program `mortise`, for the sections command and batch")
        ->check(CLI::ExistingFile);
    app.add_option("--json", arguments.json_path, "write all figures, with every sample, to this file");
    app.add_option(
           "--only", arguments.only,
           "sections to run: copy octree graded mesh stages threads command batch stream jacobians peers")
        ->check(CLI::IsMember(kSections));
    app.add_flag("--quick", arguments.quick,
                 "level 3, one run, small copies, no CLBlast, no other meshers: shows that it works, "
                 "measures nothing");
    app.add_option("--finer", arguments.settings.finer,
                   "levels to add to all; each has eight times the elements of the one before")
        ->check(CLI::Range(0, 5))
        ->capture_default_str();
    app.add_option("--batch-models", arguments.settings.batch_models, "random brackets of the section batch")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    app.add_flag("--lattice", arguments.settings.with_lattice,
                 "section mesh: also 10 x 10 x 10 cells of struts, once; takes minutes");
    app.add_flag("--billion", arguments.settings.with_billion,
                 "section stream: also 10^9 elements, twice; takes a quarter of an hour");
    app.add_flag("!--no-peers", arguments.settings.with_peers, "other meshers count as not installed");
    app.add_option("--peer-seconds", arguments.settings.peer_seconds,
                   "another mesher that would take longer for one mesh makes a coarser one")
        ->check(CLI::PositiveNumber)
        ->capture_default_str();
    app.add_option("--peer-repeats", arguments.settings.peer_repeats,
                   "runs of other meshers, at most --repeats")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    app.add_option("--cgal", arguments.settings.cgal_program, "the program made from bench/cgal_mesh.cpp")
        ->check(CLI::ExistingFile);
    app.add_option("--quartet", arguments.settings.quartet_program, "the program of Quartet, if you have it")
        ->check(CLI::ExistingFile);
    app.add_option("--python-netgen", arguments.settings.python_netgen,
                   "a Python that may have Netgen's module")
        ->capture_default_str();
}

/// `mortise_bench worker KIND ...`: not in the help, as only measure_in_child calls it.
int worker(int argc, char** argv) {
    Task task;
    CLI::App app("Measures one thing and prints it as JSON.");
    app.name("mortise_bench worker");
    app.add_option("kind", task.kind)->required();
    app.add_option("--model", task.model)->capture_default_str();
    app.add_option("--level", task.level)->check(CLI::Range(2, 10))->capture_default_str();
    app.add_option("--size", task.size)->check(CLI::PositiveNumber);
    app.add_option("--threads", task.threads)->check(CLI::PositiveNumber)->capture_default_str();
    app.add_option("--repeats", task.repeats)->check(CLI::PositiveNumber)->capture_default_str();
    app.add_option("--bytes", task.bytes)->check(CLI::PositiveNumber)->capture_default_str();
    app.add_flag("--tetrahedra", task.tetrahedra);
    app.add_option("--path", task.path);
    CLI11_PARSE(app, argc, argv);
    run_worker(task);
    return 0;
}

int run(int argc, char** argv) {
    if (argc > 1 && std::string(argv[1]) == "worker") return worker(argc - 1, argv + 1);
    Arguments arguments;
    CLI::App app("Measures how fast Mortise is on this machine; takes some minutes on an idle one.");
    app.name("mortise_bench");
    add_options(app, arguments);
    CLI11_PARSE(app, argc, argv);
    Settings& settings = arguments.settings;
    if (settings.python_netgen.empty()) settings.python_netgen = "/usr/bin/python3";
    settings.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    if (arguments.quick) {
        settings.repeats = 1;
        settings.command_repeats = 1;
        settings.batch_models = 4;
        settings.level_limit = 3;
        settings.large_meshes = {2e4};
        settings.with_peers = false;
        settings.copy_bytes = std::size_t{4} << 20;
        if (arguments.only.empty()) {
            for (const std::string& section : kSections) {
                if (section != "jacobians") arguments.only.push_back(section);
            }
        }
    }
    return run_sections(arguments) ? 0 : static_cast<int>(ExitCode::kMeshing);
}

}  // namespace
}  // namespace mortise::bench

int main(int argc, char** argv) {
    try {
        return mortise::bench::run(argc, argv);
    } catch (const mortise::Error& error) {
        std::fprintf(stderr, "mortise_bench: %s\n", error.what());
        return static_cast<int>(error.code());
    } catch (const std::exception& error) {
        std::fprintf(stderr, "mortise_bench: internal error: %s\n", error.what());
        return static_cast<int>(mortise::ExitCode::kMeshing);
    }
}
