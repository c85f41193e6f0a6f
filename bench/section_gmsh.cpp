// Mortise beside Gmsh's parallel tetrahedral mesher HXT, if Gmsh is installed; see sections.hpp.
//
// Speeds of meshers compare only within one run on one machine, so the two take turns. Both mesh a unit
// sphere in memory with the same number of threads; nodes are what a solver pays for, so Gmsh gets the edge
// length that gives about as many.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>
#include <sstream>

#include "bench/print.hpp"
#include "bench/process.hpp"
#include "bench/sections.hpp"
#include "bench/statistics.hpp"
#include "bench/workers.hpp"

namespace mortise::bench {
namespace {

using nlohmann::json;

struct GmshRun {
    double nodes = 0;
    double tetrahedra = 0;
    double seconds = 0;         ///< "Done meshing" of dimensions 1 to 3 as Gmsh reports them
    double volume_seconds = 0;  ///< of dimension 3 alone
};

/// Number that follows the last occurrence of `label`.
std::optional<double> number_after(const std::string& text, const std::string& label) {
    const std::size_t place = text.rfind(label);
    if (place == std::string::npos) return std::nullopt;
    std::istringstream rest(text.substr(place + label.size()));
    double value = 0;
    if (!(rest >> value)) return std::nullopt;
    return value;
}

/// Meshes the unit sphere; nothing if Gmsh fails or says something unexpected.
std::optional<GmshRun> run_gmsh(const ScratchFolder& folder, double edge, int threads) {
    const std::string script = (folder.path() / "sphere.geo").string();
    std::ofstream(script)
        << "SetFactory(\"OpenCASCADE\");\n"
        << "Sphere(1) = {0, 0, 0, 1};\n"
        << "Mesh.MeshSizeMin = " << edge << ";\n"
        << "Mesh.MeshSizeMax = " << edge << ";\n"
        << "Mesh.Algorithm3D = 10;\n"  // HXT
        << "Mesh 3;\n"
        << "Printf(\"counts nodes= %g tetrahedra= %g\", Mesh.NbNodes, Mesh.NbTetrahedra);\n";
    const ProgramResult result =
        run_program({"gmsh", script, "-", "-nt", std::to_string(threads), "-v", "5"}, {}, true);
    if (result.exit_code != 0) return std::nullopt;
    GmshRun run;
    for (const char* dimension : {"1", "2", "3"}) {
        const auto seconds =
            number_after(result.output, std::string("Done meshing ") + dimension + "D (Wall ");
        if (!seconds) return std::nullopt;
        run.seconds += *seconds;
        run.volume_seconds = *seconds;
    }
    run.nodes = number_after(result.output, "counts nodes= ").value_or(0);
    run.tetrahedra = number_after(result.output, " tetrahedra= ").value_or(0);
    if (!(run.nodes > 0 && run.tetrahedra > 0 && run.volume_seconds > 0)) return std::nullopt;
    return run;
}

json skip(const std::string& reason) {
    std::printf("  skipped: %s\n", reason.c_str());
    return {{"skipped", reason}};
}

}  // namespace

json gmsh_section(const Settings& settings) {
    std::printf(
        "Gmsh HXT: a unit sphere with about as many nodes, the two in turn, %s each\n"
        "  Gmsh: its own wall times for curves, surface and volume, no file; Mortise: generate_mesh\n",
        count_of_threads(settings.threads).c_str());
    if (!is_on_path("gmsh")) return skip("no gmsh on PATH");
    const std::string version = run_program({"gmsh", "--version"}, {}, true).output;
    const ScratchFolder folder;
    Task task;
    task.kind = "mesh";
    task.model = "sphere";
    task.level = settings.level(6);
    task.threads = settings.threads;
    announce("Gmsh HXT, edge length");
    const json ours = measure_in_child(task);
    const double nodes = ours.at("nodes");
    const double elements = ours.at("elements");

    // A coarse run tells how nodes depend on the edge length, a second one corrects it.
    double edge = 0.15;
    for (int round = 0; round < 2; ++round) {
        const std::optional<GmshRun> run = run_gmsh(folder, edge, settings.threads);
        if (!run) return skip("gmsh failed, or has no OpenCASCADE or HXT");
        edge *= std::cbrt(run->nodes / nodes);
    }
    Samples gmsh_seconds;
    Samples volume_seconds;
    Samples mortise_seconds;
    GmshRun last;
    for (int i = 0; i < settings.repeats; ++i) {
        announce("Gmsh HXT and Mortise, run " + std::to_string(i + 1));
        const std::optional<GmshRun> run = run_gmsh(folder, edge, settings.threads);
        if (!run) return skip("gmsh failed in run " + std::to_string(i + 1));
        last = *run;
        gmsh_seconds.values.push_back(run->seconds);
        volume_seconds.values.push_back(run->volume_seconds);
        mortise_seconds.values.push_back(collect(measure_in_child(task).at("runs"), "seconds").median());
    }
    const double element_ratio =
        (elements / mortise_seconds.median()) / (last.tetrahedra / gmsh_seconds.median());
    const double node_ratio = (nodes / mortise_seconds.median()) / (last.nodes / gmsh_seconds.median());
    Table table({{"", ""},
                 {"elements", ""},
                 {"nodes", ""},
                 {"time", "s"},
                 {"spread", ""},
                 {"elements", "k/s"},
                 {"nodes", "k/s"}});
    const auto add = [&table](const std::string& name, double element_count, double node_count,
                              const Samples& seconds) {
        table.add({name, grouped(static_cast<std::uint64_t>(element_count)),
                   grouped(static_cast<std::uint64_t>(node_count)), short_number(seconds.median()),
                   percent(seconds.spread()), short_number(1e-3 * element_count / seconds.median()),
                   short_number(1e-3 * node_count / seconds.median())});
    };
    add("Mortise, level " + std::to_string(task.level), elements, nodes, mortise_seconds);
    add("Gmsh HXT, all (tetrahedra)", last.tetrahedra, last.nodes, gmsh_seconds);
    add("Gmsh HXT, volume only", last.tetrahedra, last.nodes, volume_seconds);
    table.print();
    std::printf("  Mortise to Gmsh HXT, all: %s times the elements/s, %s times the nodes/s\n",
                short_number(element_ratio).c_str(), short_number(node_ratio).c_str());
    return {{"version", version.substr(0, version.find('\n'))},
            {"edge_length", edge},
            {"gmsh_nodes", last.nodes},
            {"gmsh_tetrahedra", last.tetrahedra},
            {"gmsh_seconds", to_json(gmsh_seconds)},
            {"gmsh_volume_seconds", to_json(volume_seconds)},
            {"mortise_nodes", nodes},
            {"mortise_elements", elements},
            {"mortise_seconds", to_json(mortise_seconds)},
            {"elements_per_second_ratio", element_ratio},
            {"nodes_per_second_ratio", node_ratio}};
}

}  // namespace mortise::bench
