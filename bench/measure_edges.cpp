// Lengths of a mesh's edges, and its boundary as a file: what other meshers are held against or start from.
#include "bench/edges.hpp"
#include "bench/models.hpp"
#include "bench/workers.hpp"
#include "mortise/mesher.hpp"

namespace mortise::bench {

nlohmann::json measure_edges(const Task& task) {
    MeshOptions options;
    options.threads = task.threads;
    set_size_of_cells(task, options);
    options.tetrahedra = task.tetrahedra;
    const Mesh mesh = generate_mesh(make_model(task.model), options);
    if (!task.path.empty()) write_surface(mesh, task.path);
    return {{"mean_edge", mean_edge_length(mesh)}};
}

}  // namespace mortise::bench
