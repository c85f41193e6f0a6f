// The whole way from a model in memory to a mesh in memory.
#include <algorithm>
#include <chrono>

#include "bench/models.hpp"
#include "bench/process.hpp"
#include "bench/stage_bytes.hpp"
#include "bench/workers.hpp"
#include "mortise/mesher.hpp"

namespace mortise::bench {
nlohmann::json measure_mesh(const Task& task) {
    const Model model = make_model(task.model);
    MeshOptions options;
    options.threads = task.threads;
    options.tetrahedra = task.tetrahedra;
    options.level = std::min(task.level, 3);
    Mesher mesher;
    mesher.generate(make_model("sphere"), options);  // loads the kernels
    set_size_of_cells(task, options);

    // Each mesh after the first is made in the memory of the one before, as `mortise batch` makes them. The
    // first, for whose memory the system must be asked, counts apart, unless it is the only one.
    const int first_that_counts = task.repeats > 1 ? 1 : 0;
    nlohmann::json result = {{"idle_bytes", resident_bytes()}, {"runs", nlohmann::json::array()}};
    MeshReport report;
    for (int run = 0; run < task.repeats + first_that_counts; ++run) {
        const auto begin = std::chrono::steady_clock::now();
        Mesh mesh = mesher.generate(model, options, &report);
        const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
        nlohmann::json stages = nlohmann::json::array();
        for (const StageTime& stage : report.stages) {
            stages.push_back(
                {{"stage", stage.stage}, {"wall", stage.wall_seconds}, {"cpu", stage.cpu_seconds}});
        }
        if (run >= first_that_counts)
            result["runs"].push_back({{"seconds", wall.count()}, {"stages", stages}});
        if (run == 0) {
            result["first_seconds"] = wall.count();
            result["peak_bytes"] = peak_resident_bytes();
            result["device"] = report.device;
            result["level"] = report.level;
            result["cell_size"] = report.cell_size;
            result["elements"] = mesh.element_count();
            result["nodes"] = mesh.node_count();
            result["mesh_bytes"] = mesh_bytes(mesh);
            result["geometry_bytes"] = geometry_bytes(mesh);
            result["cnio_cells"] = report.cnio_cells;
        }
        mesher.recycle(std::move(mesh));
    }
    result["warm_peak_bytes"] = peak_resident_bytes();
    return result;
}

}  // namespace mortise::bench
