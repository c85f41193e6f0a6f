// What the benchmark measures, each in a child process: a fresh heap for memory figures, and PoCL reads the
// number of its threads from the environment only once.
//
// A worker prints one line of JSON on stdout. Times are in seconds, sizes in bytes.
#pragma once

#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>

namespace mortise {
struct MeshOptions;
}

namespace mortise::bench {

/// What a worker is to measure.
struct Task {
    std::string kind;              ///< as run_worker names them
    std::string model = "sphere";  ///< for make_model; not for "copy", "balance"
    int level = 6;                 ///< not for "copy"
    double size = 0;               ///< "mesh", "edges": edge of a cell, if positive, instead of the level
    int threads = 1;               ///< host threads, and device threads if the device is PoCL's CPU
    int repeats = 1;
    std::size_t bytes = std::size_t{64} << 20;  ///< "copy"; "stream": of memory
    bool tetrahedra = false;                    ///< "mesh", "edges": MeshOptions::tetrahedra
    std::string path;                           ///< "edges": file for the boundary (write_surface), or empty
};

void set_size_of_cells(const Task& task, MeshOptions& options);

/// Copies `bytes` with memcpy, cut into one part per thread.
/// {"runs": [{"seconds"}]}
nlohmann::json measure_copy(const Task& task);

/// Builds the octree, and classifies the cells of the same model with the scalar host reference.
/// {"device", "compute_units", "is_gpu", "surfaces", "cells", "nio_cells", "tree_bytes" (NIO leaves and all
/// tapes),
///  "reference_cells",
///  "runs": [{"kernel_seconds", "stage_seconds", "reference_seconds"}]}
nlohmann::json measure_octree(const Task& task);

/// Balances the octree of a sphere's surface, 2:1.
/// {"leaves", "runs": [{"seconds"}]}
nlohmann::json measure_balance(const Task& task);

/// Meshes the model with as coarse an interior as there can be, conforming and with hanging nodes, once.
/// {"uniform_elements" (of a mesh of one size, by the leaves), "boundary_elements" (of these, in NIO cells),
///  "transition_cells", "transition_elements" (in these, conforming), "conforming_elements",
///  "conforming_seconds", "hanging_elements", "hanging_seconds"}
nlohmann::json measure_graded(const Task& task);

/// Meshes the model in memory by one Mesher, after a small mesh that loads the kernels.
/// {"device", "level", "cell_size", "elements", "nodes", "mesh_bytes", "geometry_bytes" (coordinates and
///  connectivity), "cnio_cells", "idle_bytes" (resident after the small mesh), "peak_bytes" (after the first
///  run), "runs": [{"seconds", "stages": [{"stage", "wall", "cpu"}]}]}
nlohmann::json measure_mesh(const Task& task);

/// Meshes the model and measures its edges.
/// {"mean_edge"}
nlohmann::json measure_edges(const Task& task);

/// Meshes the model stage by stage and writes it; each stage with the bytes that it moves by stage_bytes.hpp.
/// {"elements", "nodes", "kernels" (of the last run, by time, before extraction and in assembly),
///  "runs": [{"seconds" (without writing), "files": {"compressed" and "plain_arrays": {"bytes", "seconds",
///  "plain_write_seconds" (of as many bytes)}}, "stages": [{"stage", "seconds", "bytes"}]}]}
nlohmann::json measure_stages(const Task& task);

/// Meshes the model, then computes its scaled Jacobians on the host, by our kernel and by CLBlast.
/// {"device", "is_gpu", "elements", "own_first_seconds", "product_first_seconds" (kernels built or loaded),
///  "runs": [{"host_seconds", "own_seconds", "product_seconds"}]}
nlohmann::json measure_jacobians(const Task& task);

/// Meshes the model part by part within task.bytes of memory.
/// {"elements", "nodes", "parts", "checksum" (of all arrays), "peak_bytes", "runs": [{"seconds"}]}
nlohmann::json measure_stream(const Task& task);

/// The worker's side: measures and prints.
void run_worker(const Task& task);

/// Runs a worker for the task and returns what it measured. Throws Error(kMeshing) if it fails.
nlohmann::json measure_in_child(const Task& task);

}  // namespace mortise::bench
