// Both ends of a worker process; see workers.hpp.
#include "bench/workers.hpp"

#include <cstdio>

#include "bench/process.hpp"
#include "mortise/error.hpp"
#include "mortise/mesher.hpp"

namespace mortise::bench {

void set_size_of_cells(const Task& task, MeshOptions& options) {
    options.level = task.size > 0 ? 0 : task.level;
    options.size = task.size;
}

void run_worker(const Task& task) {
    nlohmann::json result;
    if (task.kind == "copy") {
        result = measure_copy(task);
    } else if (task.kind == "octree") {
        result = measure_octree(task);
    } else if (task.kind == "balance") {
        result = measure_balance(task);
    } else if (task.kind == "graded") {
        result = measure_graded(task);
    } else if (task.kind == "mesh") {
        result = measure_mesh(task);
    } else if (task.kind == "edges") {
        result = measure_edges(task);
    } else if (task.kind == "stages") {
        result = measure_stages(task);
    } else if (task.kind == "jacobians") {
        result = measure_jacobians(task);
    } else if (task.kind == "stream") {
        result = measure_stream(task);
    } else {
        throw Error(ExitCode::kUsage, "worker '" + task.kind +
                                          "': expected copy, octree, balance, graded, mesh, edges, stages, "
                                          "jacobians or stream");
    }
    std::printf("%s\n", result.dump().c_str());
}

nlohmann::json measure_in_child(const Task& task) {
    const std::string threads = std::to_string(task.threads);
    std::vector<std::string> arguments = {
        own_path(), "worker", task.kind, "--threads", threads, "--repeats", std::to_string(task.repeats)};
    if (task.kind == "copy" || task.kind == "stream")
        arguments.insert(arguments.end(), {"--bytes", std::to_string(task.bytes)});
    if (task.kind != "copy") {
        arguments.insert(arguments.end(), {"--model", task.model, "--level", std::to_string(task.level)});
    }
    if (task.size > 0) arguments.insert(arguments.end(), {"--size", nlohmann::json(task.size).dump()});
    if (task.tetrahedra) arguments.push_back("--tetrahedra");
    if (!task.path.empty()) arguments.insert(arguments.end(), {"--path", task.path});
    // PoCL up to 3 reads the first variable, later ones the second.
    const ProgramResult result =
        run_program(arguments, {{"POCL_MAX_PTHREAD_COUNT", threads}, {"POCL_CPU_MAX_CU_COUNT", threads}});
    const nlohmann::json measured = nlohmann::json::parse(result.output, nullptr, false);
    if (result.exit_code != 0 || measured.is_discarded()) {
        std::string command = "mortise_bench";
        for (std::size_t i = 1; i < arguments.size(); ++i) command += " " + arguments[i];
        throw Error(ExitCode::kMeshing, "a measurement failed with exit code " +
                                            std::to_string(result.exit_code) +
                                            "; to see it alone, run: " + command);
    }
    return measured;
}

}  // namespace mortise::bench
