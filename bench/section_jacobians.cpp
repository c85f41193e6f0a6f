// Our own kernel against CLBlast's matrix product, which decides for each class of device; see sections.hpp.
#include <cstdio>

#include "bench/print.hpp"
#include "bench/sections.hpp"
#include "bench/statistics.hpp"
#include "bench/workers.hpp"

namespace mortise::bench {

using nlohmann::json;

json jacobians_section(const Settings& settings) {
    std::printf(
        "Scaled Jacobians of a mesh in memory: million elements/s, %s\n"
        "  host: its threads, in lanes; own: our kernel; first call: kernels built or loaded\n",
        count_of_threads(settings.threads).c_str());
    Table table({{"model, level", ""},
                 {"elements", ""},
                 {"host", "M/s"},
                 {"own", "M/s"},
                 {"CLBlast", "M/s"},
                 {"own to host", "ratio"},
                 {"own to CLBlast", "ratio"},
                 {"first own", "s"},
                 {"first CLBlast", "s"}});
    json result = json::array();
    for (const char* model : {"sphere", "bracket"}) {
        Task task;
        task.kind = "jacobians";
        task.model = model;
        task.level = settings.level(7);
        task.threads = settings.threads;
        task.repeats = settings.repeats;
        announce("jacobians, " + task.model);
        json measured = measure_in_child(task);
        const Samples host = collect(measured.at("runs"), "host_seconds");
        const Samples own = collect(measured.at("runs"), "own_seconds");
        const Samples product = collect(measured.at("runs"), "product_seconds");
        const double millions = 1e-6 * measured.at("elements").get<double>();
        table.add({task.model + ", " + std::to_string(task.level),
                   grouped(measured.at("elements").get<std::uint64_t>()),
                   short_number(millions / host.median()), short_number(millions / own.median()),
                   short_number(millions / product.median()), fixed(host.median() / own.median(), 2),
                   fixed(product.median() / own.median(), 2),
                   fixed(measured.at("own_first_seconds").get<double>(), 3),
                   fixed(measured.at("product_first_seconds").get<double>(), 3)});
        measured["model"] = task.model;
        measured["level"] = task.level;
        measured["host"] = to_json(host);
        measured["own"] = to_json(own);
        measured["product"] = to_json(product);
        result.push_back(measured);
    }
    table.print();
    return result;
}

}  // namespace mortise::bench
