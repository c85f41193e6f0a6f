// `mortise batch LIST -o FOLDER`: many models, one mesh file each, with everything warm.
//
// Each job is a process with a mesher of its own (device, kernels, one host thread), so a model that brings
// one down costs that model only. Models are taken in any order, results are told in the order of the list.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <thread>

#include "host/cli/commands.hpp"
#include "host/cli/documents.hpp"
#include "host/cli/files.hpp"
#include "host/cli/kernels_ahead.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/quality_text.hpp"
#include "host/cli/refusals.hpp"
#include "host/cli/signals.hpp"
#include "host/cli/text.hpp"
#include "host/cli/worker_pool.hpp"
#include "host/device/environment.hpp"
#include "mortise/check.hpp"
#include "mortise/io.hpp"

namespace mortise::cli {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

struct Item {
    std::string model;
    std::string output;
    std::size_t line;          ///< in the list
    std::string refusal = {};  ///< why it has no output of its own; empty: it has
};

std::filesystem::path place_of(const Item& item) {
    std::error_code ignored;
    return std::filesystem::absolute(item.model, ignored).lexically_normal();
}

/// The folder that all models lie in, at some depth.
std::filesystem::path common_folder(const std::vector<Item>& items) {
    std::filesystem::path common = place_of(items.front()).parent_path();
    for (const Item& item : items) {
        const std::filesystem::path folder = place_of(item).parent_path();
        const auto end = std::mismatch(common.begin(), common.end(), folder.begin(), folder.end()).first;
        std::filesystem::path shared;
        for (auto part = common.begin(); part != end; ++part) shared /= *part;
        common = shared;
    }
    return common;
}

std::string start_of(const Arguments& arguments, const Item& item) {
    return arguments.file + ":" + std::to_string(item.line) + ": '" + item.model + "' ";
}

/// A model that is listed twice is meshed once.
void refuse_repeated(const Arguments& arguments, std::vector<Item>& items) {
    std::map<std::filesystem::path, std::size_t> lines;
    for (Item& item : items) {
        const auto [first, fresh] = lines.emplace(place_of(item), item.line);
        if (fresh) continue;
        item.refusal = start_of(arguments, item) + "is listed in line " + std::to_string(first->second) +
                       " already; list it once";
    }
}

/// Each mesh gets the name of its model. Where two models have one name (shape_1/part.csg, shape_2/part.csg),
/// all keep their folders, as seen from the folder that has them all; one that has the name of another even
/// so (part.csg, part.stl) is refused.
void name_outputs(const Arguments& arguments, std::vector<Item>& items) {
    refuse_repeated(arguments, items);
    const std::filesystem::path folder = arguments.outputs.front();
    const std::filesystem::path common = common_folder(items);
    for (const bool in_folders : {false, true}) {
        std::map<std::string, const Item*> writers;
        bool clash = false;
        for (Item& item : items) {
            if (!item.refusal.empty()) continue;
            const std::filesystem::path place = place_of(item);
            const std::string name = place.stem().string() + "." + arguments.format;
            const std::filesystem::path inner =
                in_folders ? place.parent_path().lexically_relative(common) : std::filesystem::path();
            item.output = (folder / inner / name).lexically_normal().string();
            const auto [writer, fresh] = writers.emplace(item.output, &item);
            if (fresh) continue;
            clash = true;
            if (!in_folders) continue;
            item.refusal = start_of(arguments, item) + "and '" + writer->second->model +
                           "' would both be written to '" + item.output + "'; rename one";
        }
        if (!clash) return;
    }
}

/// One model a line; blank lines and those that begin with # say nothing. "-" is standard input.
std::vector<Item> read_list(const Arguments& arguments) {
    std::ifstream file;
    if (arguments.file != "-") {
        if (std::filesystem::is_directory(arguments.file))
            throw Error(ExitCode::kFiles, arguments.file + ": is a folder; expected a list, one path a line");
        file.open(arguments.file);
        if (!file) throw Error(ExitCode::kFiles, arguments.file + ": cannot be read");
    }
    std::istream& in = arguments.file == "-" ? std::cin : file;
    std::vector<Item> items;
    std::string line;
    for (std::size_t number = 1; std::getline(in, line); ++number) {
        const std::size_t begin = line.find_first_not_of(" \t\r");
        if (begin == std::string::npos || line[begin] == '#') continue;
        const std::size_t end = line.find_last_not_of(" \t\r");
        items.push_back({line.substr(begin, end - begin + 1), {}, number});
    }
    if (in.bad()) throw Error(ExitCode::kFiles, arguments.file + ": cannot be read to its end");
    if (items.empty()) throw Error(ExitCode::kUsage, arguments.file + ": lists no models");
    name_outputs(arguments, items);
    return items;
}

void make_folder_of(const Item& item) {
    std::error_code told_when_written;
    std::filesystem::create_directories(std::filesystem::path(item.output).parent_path(), told_when_written);
}

/// Warnings of thousands of models would bury everything else: --json has them.
std::string count_text(std::size_t warnings) {
    if (warnings == 0) return {};
    return "; " + counted(warnings, "warning");
}

/// What became of a model, as JSON from a worker: `report` as printed by --json, `line` for people.
Json mesh_one(Mesher& mesher, const Arguments& arguments, MeshOptions options, const Item& item) {
    const auto start = Clock::now();
    const char* late = nullptr;  // the stage in which time was up
    options.progress = [&](const char* stage, double) {
        report_aborts();
        if (arguments.time_limit > 0 && seconds_since(start) > arguments.time_limit) late = stage;
        return late == nullptr;
    };
    Json outcome = {{"code", 0}, {"line", ""}};
    Json document = {{"model", item.model}, {"warnings", Json::array()}};
    const auto fail = [&](ExitCode code, const std::string& message) {
        outcome["code"] = static_cast<int>(code);
        outcome["line"] = one_line(message);
        document["error"] = one_line(message);
    };
    try {
        if (!item.refusal.empty()) throw Error(ExitCode::kUsage, item.refusal);
        if (is_same_file(item.model, item.output))
            throw Error(ExitCode::kUsage, item.model + ": would be written over; give another folder (-o)");
        const Model model = read_model(item.model, arguments.read);
        document["warnings"] = model.warnings;
        MeshReport report;
        Mesh mesh = mesher.generate(model, options, &report);
        const MeshFigures figures = figures_of(mesh, report.scaled_jacobians, options.threads);
        refuse_inverted(figures);
        warn_of_slivers(figures, options, report);
        document["warnings"] = report.warnings;
        if (arguments.check) {
            const CheckReport check = check_mesh(mesh, options.threads);
            document["check"] = check_document(check);
            refuse_defects(check);
        }
        make_folder_of(item);
        MeshFileOptions file_options = arguments.file_options;
        file_options.threads = options.threads;
        write_mesh(mesh, item.output, report.scaled_jacobians, file_options);
        if (arguments.json) document.update(mesh_document(report, figures));
        document["outputs"] = Json::array({item.output});
        outcome["line"] = item.model + ": " + std::to_string(mesh.element_count()) + " elements, " +
                          rounded_text(seconds_since(start), 3) + " s, " + item.output +
                          count_text(report.warnings.size());
        const auto below = below_floor(mesh, report.scaled_jacobians, arguments.quality_floor);
        mesher.recycle(std::move(mesh));
        refuse_below(below);
    } catch (const Error& error) {
        const std::string message = late == nullptr
                                        ? error.what()
                                        : "took more than " + rounded_text(arguments.time_limit, 3) +
                                              " s, the last in '" + late +
                                              "'; give it more (--time-limit), or larger cells";
        const bool names_it = message.find(item.model) != std::string::npos;
        fail(error.code(), names_it ? message : item.model + ": " + message);
    } catch (const std::bad_alloc&) {
        fail(ExitCode::kDevice, item.model + ": out of memory; use a smaller --level or fewer --jobs");
    } catch (const std::exception& error) {
        fail(ExitCode::kMeshing, item.model + ": internal error, please report it: " + error.what());
    }
    document["exit_code"] = outcome["code"];
    document["seconds"] = seconds_since(start);
    if (arguments.json) outcome["report"] = std::move(document);
    return outcome;
}

/// A worker that did not come back.
Json lost(const Item& item, int how) {
    const std::string end =
        how > 0 ? "ended by signal " + std::to_string(how) : "ended with exit code " + std::to_string(-how);
    const std::string line =
        item.model + ": its process " + end + "; please report it, if memory was not short";
    return {{"code", static_cast<int>(ExitCode::kMeshing)},
            {"line", line},
            {"report",
             {{"model", item.model},
              {"warnings", Json::array()},
              {"error", line},
              {"exit_code", static_cast<int>(ExitCode::kMeshing)},
              {"seconds", nullptr}}}};
}

/// Tells outcomes in the order of the list, as soon as those before them are there.
class Teller {
  public:
    Teller(const Arguments& arguments, const std::vector<Item>& items)
        : arguments_(arguments), items_(items), progress_(arguments.quiet), outcomes_(items.size()) {}

    void add(std::size_t i, Json outcome) {
        outcomes_[i] = std::move(outcome);
        while (next_ < outcomes_.size() && !outcomes_[next_].is_null()) tell(outcomes_[next_++]);
        progress_.show("batch", static_cast<double>(next_) / static_cast<double>(outcomes_.size()));
    }

    ExitCode finish(double seconds) {
        progress_.clear();
        if (!arguments_.json && !arguments_.quiet) {
            const std::string poor =
                below_floor_ > 0 ? ", " + std::to_string(below_floor_) + " of them below the quality floor"
                                 : "";
            print(std::to_string(items_.size() - failed_) + " of " + std::to_string(items_.size()) +
                  " models meshed in " + rounded_text(seconds, 3) + " s, " +
                  rounded_text(60 * static_cast<double>(items_.size()) / seconds, 3) + " a minute" + poor +
                  "\n");
        }
        return first_failure_;
    }

  private:
    void tell(Json& outcome) {
        progress_.clear();
        const auto code = static_cast<ExitCode>(outcome["code"].get<int>());
        const std::string line = outcome["line"];
        if (code != ExitCode::kOk) {
            ++(code == ExitCode::kQuality ? below_floor_ : failed_);
            if (first_failure_ == ExitCode::kOk) first_failure_ = code;
            if (!arguments_.json) std::cerr << "mortise: " << line << "\n";
        }
        if (arguments_.json) {
            print(to_line(outcome["report"]) + "\n");
        } else if (code == ExitCode::kOk && !arguments_.quiet) {
            print(line + "\n");
        }
        outcome = Json::object();  // told; its memory is given back
    }

    const Arguments& arguments_;
    const std::vector<Item>& items_;
    Progress progress_;
    std::vector<Json> outcomes_;
    std::size_t next_ = 0;
    std::size_t failed_ = 0;
    std::size_t below_floor_ = 0;  ///< meshed, and written
    ExitCode first_failure_ = ExitCode::kOk;
};

}  // namespace

ExitCode batch_command(const Arguments& arguments) {
    const auto start = Clock::now();
    const std::vector<Item> items = read_list(arguments);
    check_mesh_format(items.front().output, traits_of(arguments.options));
    make_folder_of(items.front());
    check_mesh_output(items.front().output);

    MeshOptions options = arguments.options;
    {
        Progress progress(arguments.quiet);
        build_kernels_ahead(options, progress);
    }
    const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
    const std::size_t jobs = std::min<std::size_t>(
        arguments.jobs > 0 ? static_cast<std::size_t>(arguments.jobs) : cores, items.size());
    if (jobs > 1 && options.threads == 0) {
        options.threads = static_cast<int>(std::max<std::size_t>(1, cores / jobs));
        device::limit_driver_threads(options.threads);
    }

    Mesher mesher(options.device, options.work_group_size);  // each process opens its own
    Teller teller(arguments, items);
    run_in_processes(
        items.size(), jobs,
        [&](std::size_t i) {
            say_nothing_of_interruptions();
            return to_line(mesh_one(mesher, arguments, options, items[i]));
        },
        [&](std::size_t i, const std::string& result, int how) {
            teller.add(i, result.empty() ? lost(items[i], how) : Json::parse(result));
        });
    return teller.finish(seconds_since(start));
}

}  // namespace mortise::cli
