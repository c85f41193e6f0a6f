// `mortise check FILE`: validity and figures of a mesh file.
#include "host/cli/commands.hpp"
#include "host/cli/documents.hpp"
#include "host/cli/files.hpp"
#include "host/cli/quality_text.hpp"
#include "host/cli/text.hpp"
#include "mortise/io.hpp"

namespace mortise::cli {
namespace {

std::string figures_text(const CheckReport& report) {
    std::string text;
    text += "  elements   " + list_elements(report.elements) + "\n";
    text += "  nodes      " + std::to_string(report.nodes);
    if (report.middle_nodes > 0)
        text += ", " + std::to_string(report.middle_nodes) + " of them in the middles of edges";
    text += "\n";
    text += "  volume     " + rounded_text(report.volume, 9) + "\n";
    text += "  boundary   area " + rounded_text(report.boundary_area, 9) + ", " +
            std::to_string(report.boundary_facets) + " facets, Euler characteristic " +
            std::to_string(report.euler_characteristic) + ", non-manifold " +
            std::to_string(report.nonmanifold_edges) + " edges, " + std::to_string(report.nonmanifold_nodes) +
            " nodes\n";
    text += "  inside     components " + std::to_string(report.components) + touching_text(report) +
            ", regions " + std::to_string(report.region_volume.size()) + ", interface facets " +
            std::to_string(report.interface_facets) + "\n";
    text += "  worst      scaled Jacobian " + list_jacobians(report.elements, report.min_scaled_jacobian) +
            "; dihedral angles " + rounded_text(report.min_dihedral, 4) + " to " +
            rounded_text(report.max_dihedral, 4) + " degrees\n";
    return text;
}

}  // namespace

ExitCode check_command(const Arguments& arguments) {
    const Mesh mesh = read_mesh(arguments.file);
    const CheckReport report = check_mesh(mesh);
    QualityReport quality;
    if (arguments.quality) quality = element_quality(mesh);
    if (arguments.json) {
        Json document = check_document(report);
        document["file"] = arguments.file;
        if (arguments.quality) document["quality"] = quality_document(quality);
        print(to_text(document));
    } else {
        std::string text = arguments.file + (report.valid() ? ": valid\n" : ": invalid\n");
        for (const Defect& defect : report.defects) text += "  defect     " + describe(defect) + "\n";
        text += figures_text(report);
        if (arguments.quality) text += quality_text(quality);
        print(text);
    }
    return report.valid() ? ExitCode::kOk : ExitCode::kMeshing;
}

}  // namespace mortise::cli
