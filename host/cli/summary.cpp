#include "host/cli/summary.hpp"

#include <sys/resource.h>

#include <vector>

#include "host/cli/text.hpp"

namespace mortise::cli {
namespace {

/// "1200 at level 5, 340 at level 6"
std::string list_levels(const std::vector<std::uint64_t>& leaves) {
    std::string text;
    for (std::size_t level = 0; level < leaves.size(); ++level) {
        if (leaves[level] == 0) continue;
        text +=
            (text.empty() ? "" : ", ") + std::to_string(leaves[level]) + " at level " + std::to_string(level);
    }
    return text;
}

/// Of a graded tree; nothing if cells have one size.
std::string cells_line(const MeshReport& report, const MeshFigures& figures) {
    if (report.leaves.empty()) return {};
    std::string text = "  cells      " + list_levels(report.leaves);
    if (report.transition_cells > 0) {
        text += "; " + std::to_string(report.transition_cells) + " inside beside smaller ones";
        // What is left of templates: cells with hanging nodes are an element each.
        const std::uint64_t divided = report.transition_cells - report.hanging_cells;
        if (report.hanging_cells > 0)
            text += ", " + std::to_string(report.hanging_cells) + " of them hexahedra with hanging nodes";
        if (divided > 0 && figures.kinds[3] > report.hanging_cells)
            text += std::string(report.hanging_cells > 0 ? ", the others" : ",") + " of " +
                    rounded_text(static_cast<double>(figures.kinds[3] - report.hanging_cells) /
                                     static_cast<double>(divided),
                                 3) +
                    " elements each";
    }
    return text + "\n";
}

std::string middles_line(const MeshReport& report) {
    if (report.middle_nodes == 0) return {};
    std::string text = "  order 2    " + std::to_string(report.middle_nodes) +
                       " nodes in the middles of edges; " + std::to_string(report.curved_edges) +
                       " edges are curved";
    if (report.relaxed_edges > 0)
        text += ", " + std::to_string(report.relaxed_edges) +
                " less than the model, for the shape of elements there";
    return text + "\n";
}

std::string layers_line(const LayerFigures& layers) {
    if (layers.facets == 0) return {};
    return "  layers     " + std::to_string(layers.elements) + " elements, " +
           rounded_text(layers.thickness, 3) + " thick in the mean, on " +
           std::to_string(layers.facets - layers.bare) + " of " + std::to_string(layers.facets) + " facets\n";
}

std::string worst_line(const MeshFigures& figures) {
    std::string text =
        "  worst      scaled Jacobian " + list_jacobians(figures.elements, figures.min_scaled_jacobian);
    if (figures.worst_place) text += "; the lowest at " + place_text(*figures.worst_place);
    return text + "\n";
}

std::string check_line(const CheckReport& check) {
    return "  check      valid; volume " + rounded_text(check.volume, 9) + ", area " +
           rounded_text(check.boundary_area, 9) + ", Euler characteristic " +
           std::to_string(check.euler_characteristic) + ", " + counted(check.components, "component") +
           touching_text(check) + "\n";
}

std::string files_line(const Arguments& arguments) {
    std::string files;
    for (const std::string& path : arguments.outputs) files += (files.empty() ? "" : ", ") + path;
    for (const std::string& path : {arguments.picture, arguments.report, arguments.features}) {
        if (!path.empty()) files += ", " + path;
    }
    return "  written    " + files + "\n";
}

}  // namespace

std::string summary(const Arguments& arguments, const MeshReport& report, const MeshFigures& figures,
                    const CheckReport* check) {
    std::string text = arguments.file + ": " + std::to_string(figures.element_count()) + " elements, " +
                       std::to_string(figures.nodes) + " nodes; level " + std::to_string(report.level) +
                       ", cell size " + rounded_text(report.cell_size, 4) + "\n";
    text += cells_line(report, figures);
    text += "  elements   " + list_elements(figures.elements) + "\n";
    text += middles_line(report) + layers_line(report.layers);
    for (const MeshFigures::Periodic& pair : figures.periodic)
        text += "  periodic   " + std::to_string(pair.nodes) + " nodes are copies of others, moved by " +
                place_text(pair.shift) + "\n";
    text += worst_line(figures);
    if (check != nullptr) text += check_line(*check);
    text += times_text(report.stages);
    text += "  device     " + report.device + "\n";
    if (arguments.in_parts) text += "  memory     " + std::to_string(peak_memory() >> 20) + " MiB at most\n";
    return text + files_line(arguments);
}

std::uint64_t peak_memory() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) << 10;
}

}  // namespace mortise::cli
