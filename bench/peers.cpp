// Runs Gmsh, Netgen, CGAL, TetGen and Quartet; see peers.hpp.
#include "bench/peers.hpp"

#include <cstdio>
#include <fstream>
#include <optional>
#include <sstream>

#include "bench/edges.hpp"
#include "bench/process.hpp"
#include "mortise/error.hpp"
#include "mortise/io.hpp"

namespace mortise::bench {
namespace {

using std::filesystem::path;

const path kModels = path(MORTISE_SOURCE_DIR) / "bench" / "models";

/// Number that follows the last occurrence of `label`.
std::optional<double> number_after(const std::string& text, const std::string& label) {
    const std::size_t place = text.rfind(label);
    if (place == std::string::npos) return std::nullopt;
    std::istringstream rest(text.substr(place + label.size()));
    double value = 0;
    if (!(rest >> value)) return std::nullopt;
    return value;
}

std::string digits(double value) {
    std::ostringstream text;
    text.precision(17);
    text << value;
    return text.str();
}

[[noreturn]] void refuse(const std::string& program, const std::string& why) {
    throw Error(ExitCode::kMeshing, program + " " + why);
}

double expect(const std::optional<double>& value, const std::string& program, const std::string& label) {
    if (!value) refuse(program, "did not print '" + label + "'");
    return *value;
}

/// Runs a program to its end. It gets the machine's threads as the arguments say, and ten times the limit at
/// most.
ProgramResult run_peer(const Settings& settings, std::vector<std::string> arguments) {
    const std::string program = path(arguments[0]).filename().string();
    arguments.insert(arguments.begin(), {"timeout", digits(10 * settings.peer_seconds)});
    ProgramResult result = run_program(arguments, {}, true);
    if (result.exit_code == 124) refuse(program, "took more than ten times the limit of --peer-seconds");
    if (result.exit_code != 0) {
        const std::size_t end = result.output.find_last_not_of('\n');
        const std::size_t begin = result.output.find_last_of('\n', end);
        const std::string last =
            end == std::string::npos
                ? ""
                : result.output.substr(begin == std::string::npos ? 0 : begin + 1, end - begin);
        refuse(program, "ended with exit code " + std::to_string(result.exit_code) + ": " + last);
    }
    return result;
}

PeerRun describe(const Mesh& mesh, double seconds, const std::string& program) {
    PeerRun run;
    run.elements = static_cast<double>(mesh.element_count());
    run.nodes = static_cast<double>(mesh.node_count());
    run.seconds = seconds;
    if (!(run.elements > 0 && seconds > 0)) refuse(program, "made no mesh");
    run.mean_edge = mean_edge_length(mesh);
    return run;
}

Peer gmsh_hxt(const Settings& settings, const path& folder, int threads) {
    return {"Gmsh HXT, " + count_of_threads(threads), "curves, surface, volume and optimisation",
            [&settings, folder, threads](const PeerJob& job) {
                const path file = folder / "gmsh.msh";
                const std::string size = digits(job.size);
                const std::string output =
                    run_peer(settings,
                             {"gmsh", (kModels / "gmsh" / (job.model + ".geo")).string(), "-3", "-o",
                              file.string(), "-format", "msh22", "-v", "5", "-nt", std::to_string(threads),
                              "-clmin", size, "-clmax", size, "-setnumber", "Mesh.Algorithm3D", "10"})
                        .output;
                double seconds = 0;
                for (const char* dimension : {"1", "2", "3"}) {
                    const std::string label = std::string("Done meshing ") + dimension + "D (Wall ";
                    seconds += expect(number_after(output, label), "gmsh", label);
                }
                return describe(read_mesh(file.string()), seconds, "gmsh");
            }};
}

Peer netgen(const Settings& settings, const path& folder) {
    return {"Netgen, 1 thread", "surface, volume and optimisation", [&settings, folder](const PeerJob& job) {
                const path file = folder / "netgen.msh";
                const std::string output =
                    run_peer(settings,
                             {settings.python_netgen, MORTISE_SOURCE_DIR "/bench/netgen_mesh.py",
                              (kModels / (job.model + ".geo")).string(), digits(job.size), file.string()})
                        .output;
                const double seconds = expect(number_after(output, "meshing "), "netgen", "meshing");
                return describe(read_mesh(file.string()), seconds, "netgen");
            }};
}

Peer cgal(const Settings& settings, const path& folder, int threads, bool optimised) {
    return {std::string("CGAL Mesh_3") + (optimised ? " optimised, " : ", ") + count_of_threads(threads),
            std::string("refinement of an implicit surface and its volume") +
                (optimised ? ", perturbation, exudation" : ""),
            [&settings, folder, threads, optimised](const PeerJob& job) {
                const path file = folder / "cgal.msh";
                const std::string output =
                    run_peer(settings,
                             {settings.cgal_program, job.model, digits(job.size), std::to_string(threads),
                              optimised ? "optimised" : "plain", file.string()})
                        .output;
                const double seconds = expect(number_after(output, "meshing "), "cgal_mesh", "meshing");
                return describe(read_mesh(file.string()), seconds, "cgal_mesh");
            }};
}

/// Points and tetrahedra of TetGen's .node and .ele files with numbers from 0 (-z).
Mesh read_tetgen(const path& stem) {
    Mesh mesh;
    std::size_t count = 0;
    std::size_t skip = 0;
    std::string line;
    std::ifstream nodes(stem.string() + ".node");
    nodes >> count;
    std::getline(nodes, line);
    mesh.points.resize(3 * count);
    for (std::size_t i = 0; i < count && nodes; ++i) {
        nodes >> skip >> mesh.points[3 * i] >> mesh.points[3 * i + 1] >> mesh.points[3 * i + 2];
        std::getline(nodes, line);
    }
    std::ifstream elements(stem.string() + ".ele");
    elements >> count;
    std::getline(elements, line);
    ElementBlock& block = mesh.block(ElementType::kTetrahedron);
    block.nodes.resize(4 * count);
    block.region.assign(count, 1);
    for (std::size_t i = 0; i < count && elements; ++i) {
        elements >> skip;
        for (std::size_t j = 0; j < 4; ++j) elements >> block.nodes[4 * i + j];
        std::getline(elements, line);
    }
    bool whole = nodes && elements;
    for (const NodeId node : block.nodes) whole = whole && node < mesh.node_count();
    if (!whole) refuse("tetgen", "wrote no .node and .ele file that can be read");
    return mesh;
}

Peer tetgen(const Settings& settings, const path& folder) {
    return {
        "TetGen, 1 thread", "volume only, in the surface of Mortise's tetrahedra, whose time is not counted",
        [&settings, folder](const PeerJob& job) {
            const path input = folder / "tetgen.smesh";
            std::filesystem::copy_file(job.surface, input, std::filesystem::copy_options::overwrite_existing);
            // A regular tetrahedron with edges of that size.
            const double volume = job.size * job.size * job.size / 8.485281374238571;
            const ProgramResult result =
                run_peer(settings, {"tetgen", "-pqzFBa" + digits(volume), input.string()});
            // It prints CPU time.
            const double all = expect(number_after(result.output, "Total running seconds:"), "tetgen",
                                      "Total running seconds");
            const double writing =
                expect(number_after(result.output, "Output seconds:"), "tetgen", "Output seconds");
            if (!(all > writing)) refuse("tetgen", "took too little time to be measured");
            const double seconds = result.wall_seconds * (all - writing) / all;
            return describe(read_tetgen(folder / "tetgen.1"), seconds, "tetgen");
        }};
}

/// A surface as Quartet reads it, from TetGen's .smesh (edges.hpp); both number points from 1.
void write_obj(const path& smesh, const path& obj) {
    std::ifstream in(smesh);
    std::ofstream out(obj);
    out.precision(9);
    std::size_t points = 0, facets = 0, skip = 0;
    std::string line;
    in >> points;
    std::getline(in, line);
    for (std::size_t i = 0; i < points && in; ++i) {
        double x = 0, y = 0, z = 0;
        in >> skip >> x >> y >> z;
        std::getline(in, line);
        out << "v " << x << " " << y << " " << z << "\n";
    }
    in >> facets;
    std::getline(in, line);
    for (std::size_t i = 0; i < facets && in; ++i) {
        std::size_t a = 0, b = 0, c = 0;
        in >> skip >> a >> b >> c;
        std::getline(in, line);
        out << "f " << a << " " << b << " " << c << "\n";
    }
    if (!in || !out.flush()) refuse("quartet", "got no surface: " + smesh.string() + " cannot be read");
}

/// Quartet's .tet file.
Mesh read_quartet(const path& file) {
    Mesh mesh;
    std::ifstream in(file);
    std::string word;
    std::size_t points = 0, elements = 0;
    in >> word >> points >> elements;
    mesh.points.resize(3 * points);
    for (double& x : mesh.points) in >> x;
    ElementBlock& block = mesh.block(ElementType::kTetrahedron);
    block.nodes.resize(4 * elements);
    block.region.assign(elements, 1);
    for (NodeId& node : block.nodes) in >> node;
    bool whole = word == "tet" && in;
    for (const NodeId node : block.nodes) whole = whole && node < mesh.node_count();
    if (!whole) refuse("quartet", "wrote no .tet file that can be read");
    return mesh;
}

Peer quartet(const Settings& settings, const path& folder) {
    return {"Quartet, 1 thread",
            "isosurface stuffing alone; the distance field, from the surface of Mortise's tetrahedra, is not "
            "counted; edges are rounded",
            [&settings, folder](const PeerJob& job) {
                const path surface = folder / "quartet.obj", file = folder / "quartet.tet";
                write_obj(job.surface, surface);
                const std::string output = run_peer(settings, {settings.quartet_program, surface.string(),
                                                               digits(job.size), file.string()})
                                               .output;
                const double seconds =
                    expect(number_after(output, "mesh generation took "), "quartet", "mesh generation took");
                return describe(read_quartet(file), seconds, "quartet");
            }};
}

bool runs(const std::vector<std::string>& arguments) {
    const bool is_there = arguments[0].find('/') == std::string::npos ? is_on_path(arguments[0])
                                                                      : std::filesystem::exists(arguments[0]);
    return is_there && run_program(arguments, {}, true).exit_code == 0;
}

}  // namespace

std::vector<Peer> find_peers(const Settings& settings, const path& folder, nlohmann::json& skipped) {
    std::vector<Peer> peers;
    skipped = nlohmann::json::object();
    const auto skip = [&skipped](const std::string& name, const std::string& reason) {
        std::printf("  skipped: %s: %s\n", name.c_str(), reason.c_str());
        skipped[name] = reason;
    };
    const bool wanted = settings.with_peers;
    if (wanted && is_on_path("gmsh")) {
        const std::string options = run_program({"gmsh", "-info"}, {}, true).output;
        if (options.find("OpenCASCADE") != std::string::npos && options.find("Hxt") != std::string::npos) {
            peers.push_back(gmsh_hxt(settings, folder, 1));
            if (settings.threads > 1) peers.push_back(gmsh_hxt(settings, folder, settings.threads));
        } else {
            skip("Gmsh HXT", "this gmsh has no OpenCASCADE or HXT");
        }
    } else {
        skip("Gmsh HXT", "no gmsh (Debian: gmsh)");
    }
    if (wanted && runs({settings.python_netgen, "-c", "import netgen.csg"})) {
        peers.push_back(netgen(settings, folder));
    } else {
        skip("Netgen", "no Netgen for Python (Debian: python3-netgen)");
    }
    if (wanted && !settings.cgal_program.empty()) {
        for (const bool optimised : {false, true}) {
            peers.push_back(cgal(settings, folder, 1, optimised));
            if (settings.threads > 1) peers.push_back(cgal(settings, folder, settings.threads, optimised));
        }
    } else {
        skip("CGAL Mesh_3",
             "no program for it (--cgal; bench/run.sh builds it: Debian: libcgal-dev, libtbb-dev)");
    }
    if (wanted && is_on_path("tetgen")) {
        peers.push_back(tetgen(settings, folder));
    } else {
        skip("TetGen", "no tetgen (Debian: tetgen)");
    }
    if (wanted && !settings.quartet_program.empty()) {
        peers.push_back(quartet(settings, folder));
    } else {
        skip("Quartet", "no program (--quartet; github.com/crawforddoran/quartet, no Debian package)");
    }
    return peers;
}

}  // namespace mortise::bench
