// The command line as data: what the user asked for, checked as far as that is possible without any work.
#pragma once

#include <string>
#include <vector>

#include "mortise/io.hpp"
#include "mortise/mesher.hpp"

namespace mortise::cli {

enum class Command { kMesh, kBatch, kCheck, kEstimate, kDevices, kDoctor, kInfo, kKernels, kPrint };

struct Arguments {
    Command command = Command::kMesh;
    std::string file;                  ///< the model, the mesh of `check`, the list of `batch`
    std::vector<std::string> outputs;  ///< mesh files, each once; of `batch` and `kernels`: the folder
    std::string format = "vtu";        ///< of the files of `batch`
    int jobs = 0;                      ///< of `batch`: models meshed at once; 0: as many as cores
    double time_limit = 0;             ///< of `batch`: seconds that a model may take; 0: any
    std::string picture;               ///< empty: none
    PictureOptions picture_options;
    std::string report;    ///< empty: none
    std::string features;  ///< file of creases and corners; empty: none
    bool json = false;
    bool quiet = false;
    bool check = false;
    bool quality = false;   ///< print the quality report
    bool in_parts = false;  ///< within MeshOptions::memory, part by part
    MeshFileOptions file_options;
    double quality_floor = -1;  ///< smallest scaled Jacobian that is good enough; negative: any
    ReadOptions read;
    MeshOptions options;
    std::string text;  ///< kPrint: what to print, for --help and --version
};

/// Throws Error(kUsage) for anything that is not understood.
Arguments parse_arguments(int count, const char* const* values);

}  // namespace mortise::cli
