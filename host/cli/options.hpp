// The options and commands of the command line, and the words that they receive.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "host/cli/arguments.hpp"

namespace mortise::cli {

/// The words as CLI11 leaves them.
struct Words {
    std::string level, size, elements, order, extrude, floor, threads, work_group, facets, jobs, time_limit;
    std::string memory;
    std::string refine, curvature, size_min, size_max, coarsening;
    std::vector<std::string> box, size_at, size_of;
    bool no_model_sizes = false;
    bool box_fit = false;
    bool no_templates = false;
    bool no_snap = false;
    bool hanging = false;
    bool no_improve = false;
    bool no_compress = false;
    std::string scale;
    bool dry_run = false;
    std::string smooth, min_angle, merge;
    std::string layers, first_layer, layer_growth, cut;
};

struct Commands {
    CLI::App* batch = nullptr;
    CLI::App* check = nullptr;
    CLI::App* devices = nullptr;
    CLI::App* doctor = nullptr;
    CLI::App* info = nullptr;
    CLI::App* kernels = nullptr;
};

/// Declares everything. `arguments` and `words`, which parsing fills, must outlive `app`, which has the
/// commands.
Commands declare_options(CLI::App& app, Arguments& arguments, Words& words);

}  // namespace mortise::cli
