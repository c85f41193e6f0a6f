// write_mesh, read_mesh and check_writable: what all mesh formats have in common.
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <new>
#include <string>

#include "host/common/lower_case.hpp"
#include "host/io/coordinates.hpp"
#include "host/io/element_table.hpp"
#include "host/io/foam_folder.hpp"
#include "host/io/formats.hpp"
#include "mortise/error.hpp"
#include "mortise/io.hpp"

namespace mortise {
namespace {

enum class Format { kVtu, kMsh, kInp, kStl, kFoam };

/// `reads`: .vtu and .msh are what else to use.
Format format_of(const std::string& path, bool reads = false) {
    if (is_mesh_folder(path)) return Format::kFoam;
    const std::size_t slash = path.find_last_of('/');
    const std::string name = slash == std::string::npos ? path : path.substr(slash + 1);
    const std::size_t dot = name.find_last_of('.');
    // A name that begins with its only dot has no extension.
    const std::string extension = dot == std::string::npos || dot == 0 ? "" : name.substr(dot);
    const std::string small = lower_case(extension);
    if (small == ".vtu") return Format::kVtu;
    if (small == ".msh") return Format::kMsh;
    if (small == ".inp") return Format::kInp;
    if (small == ".stl") return Format::kStl;
    throw Error(ExitCode::kUsage,
                "'" + path + "': unknown mesh format '" + extension +
                    (reads ? "', expected .vtu or .msh"
                           : "', expected .vtu, .msh, .inp, .stl (the surface), or a folder polyMesh "
                             "(OpenFOAM)"));
}

[[noreturn]] void refuse(const std::string& path, const std::string& cause) {
    throw Error(ExitCode::kFiles, "cannot write '" + path + "': " + cause);
}

template <class Value>
bool all_below(const std::vector<Value>& values, std::uint64_t limit) {
    return std::all_of(values.begin(), values.end(), [limit](Value value) { return value < limit; });
}

template <class Value>
bool none_zero(const std::vector<Value>& values) {
    return std::find(values.begin(), values.end(), Value{0}) == values.end();
}

}  // namespace

std::string io::find_range_error(const Mesh& mesh) {
    const std::size_t nodes = mesh.node_count(), regions = mesh.region_names.size();
    if (mesh.points.size() % 3 != 0) return "number of coordinates not a multiple of three";
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[t];
        if (block.nodes.size() != block.size() * nodes_per_element(t) || block.kind.size() != block.size())
            return "element arrays of unequal length";
        if (!all_below(block.nodes, nodes)) return "element with a node index out of range";
        if (!all_below(block.region, regions + 1) || !none_zero(block.region))
            return "element with a region out of range";
    }
    const bool second_order = mesh.is_second_order();
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[t];
        if (block.middles.size() != (second_order ? middles_per_element(t) * block.size() : 0))
            return "elements of first and of second order in one mesh";
        if (!all_below(block.middles, nodes)) return "element with a node index out of range";
    }
    const FacetBlock& facets = mesh.facets;
    const std::size_t count = facets.size();
    if (facets.middles.size() != (second_order ? 4 * count : 0))
        return "facets and elements of different order";
    if (!all_below(facets.middles, nodes)) return "facet with a node index out of range";
    if (facets.nodes.size() != 4 * count || facets.inside.size() != count || facets.outside.size() != count)
        return "facet arrays of unequal length";
    if (!all_below(facets.nodes, nodes)) return "facet with a node index out of range";
    if (!all_below(facets.surface, mesh.surface_names.size())) return "facet with a surface out of range";
    if (!all_below(facets.inside, regions + 1) || !none_zero(facets.inside) ||
        !all_below(facets.outside, regions + 1))
        return "facet with a region out of range";
    if (!mesh.model_dimension.empty() && mesh.model_dimension.size() != nodes)
        return "model_dimension and points of unequal length";
    if (mesh.hanging.masters.size() != 4 * mesh.hanging.size())
        return "hanging nodes and their masters of unequal number";
    if (!all_below(mesh.hanging.node, nodes) || !all_below(mesh.hanging.masters, nodes))
        return "hanging node with a node index out of range";
    for (const PeriodicNodes& pair : mesh.periodic) {
        if (pair.original.size() != pair.size())
            return "periodic nodes and their originals of unequal number";
        if (!all_below(pair.node, nodes) || !all_below(pair.original, nodes))
            return "periodic node with a node index out of range";
        if (!std::all_of(pair.shift.begin(), pair.shift.end(),
                         [](double along) { return std::isfinite(along); }))
            return "periodic nodes whose shift is not finite";
        std::vector<std::uint8_t> seen(nodes, 0);  // 1: a copy, 2: an original
        for (std::size_t i = 0; i < pair.size(); ++i) {
            if ((seen[pair.node[i]] & 1) != 0 || (seen[pair.original[i]] & 2) != 0 ||
                pair.node[i] == pair.original[i])
                return "periodic node that is paired twice, or with itself";
            seen[pair.node[i]] |= 1;
            seen[pair.original[i]] |= 2;
        }
    }
    return {};
}

void io::check_numbers(std::uint64_t count, const std::string& path) {
    constexpr std::uint64_t kMost = 0x7fffffff;
    if (count <= kMost) return;
    throw Error(ExitCode::kUsage, "cannot write '" + path + "': " + std::to_string(count) +
                                      " elements or faces, where the format's programs number " +
                                      std::to_string(kMost) + " at most; use .vtu, or larger cells");
}

void write_mesh(const Mesh& mesh, const std::string& path, const std::vector<float>& jacobians,
                const MeshFileOptions& options) {
    check_mesh_format(path, {mesh.hanging.size() > 0, mesh.is_second_order(),
                             mesh.block(ElementType::kPyramid).size() > 0});
    const Format format = format_of(path);
    std::string error = io::find_range_error(mesh);
    if (error.empty() && !jacobians.empty() && jacobians.size() != mesh.element_count())
        error = "scaled Jacobians and elements of unequal number";
    if (!error.empty())
        throw Error(ExitCode::kMeshing,
                    "cannot write '" + path + "': invalid mesh: " + error + "; see check_mesh");
    io::check_scale(options.scale, path);
    if (format == Format::kStl) io::check_stl_is_own(path);
    if (format == Format::kFoam || format == Format::kInp) io::check_numbers(mesh.element_count(), path);
    if (format == Format::kFoam) return io::write_foam(mesh, path, options);
    io::TemporaryFile file(path);
    switch (format) {
        case Format::kVtu: io::write_vtu(mesh, jacobians, options, file); break;
        case Format::kMsh: io::write_msh(mesh, options, file); break;
        case Format::kInp: io::write_inp(mesh, options, file); break;
        case Format::kStl: io::write_stl(mesh, options, file); break;
        case Format::kFoam: break;  // a folder, above
    }
    file.commit();
}

bool is_mesh_folder(const std::string& path) {
    const std::string name = "polyMesh";
    const std::size_t end = path.find_last_not_of('/') + 1;
    if (end < name.size() || path.compare(end - name.size(), name.size(), name) != 0) return false;
    return end == name.size() || path[end - name.size() - 1] == '/';
}

void check_mesh_format(const std::string& path, const MeshTraits& mesh) {
    const Format format = format_of(path);
    const std::string what = "cannot write '" + path + "': ";
    if ((format == Format::kMsh || format == Format::kInp) && mesh.hanging_nodes)
        throw Error(ExitCode::kUsage, what + (format == Format::kMsh ? ".msh" : ".inp") +
                                          " files have no place for hanging nodes; use .vtu");
    if (format == Format::kInp && mesh.second_order && mesh.pyramids)
        throw Error(ExitCode::kUsage, what +
                                          ".inp files have no pyramids of second order; use --elements tet "
                                          "(C3D10), or leave --order 2 out");
    if (format == Format::kFoam && mesh.second_order)
        throw Error(ExitCode::kUsage,
                    what + "OpenFOAM's meshes have no elements of second order; leave --order 2 out");
}

void check_writable(const std::string& path) {
    const bool is_folder = format_of(path) == Format::kFoam;
    struct stat status;
    const bool is_there = stat(path.c_str(), &status) == 0;
    if (is_there && is_folder != S_ISDIR(status.st_mode))
        refuse(path, is_folder ? "it is a file, expected a folder" : std::strerror(EISDIR));
    // The folder that is written to: of a polyMesh that is not there yet the one above it, in which it is
    // made with the folders of its case.
    const auto above = [](const std::string& below) -> std::string {
        const std::size_t slash = below.find_last_of('/', below.find_last_not_of('/'));
        return slash == std::string::npos ? "." : below.substr(0, slash + 1);
    };
    std::string folder = is_folder && is_there ? path : above(path);
    const auto is_missing = [&status](const std::string& name) {
        return lstat(name.substr(0, name.find_last_not_of('/') + 1).c_str(), &status) != 0 && errno == ENOENT;
    };
    for (int made = 0; is_folder && made < io::kMostCaseFolders && is_missing(folder); ++made)
        folder = above(folder);
    if (stat(folder.c_str(), &status) != 0)
        refuse(path, "folder '" + folder + "': " + std::strerror(errno) + "; create it first");
    if (!S_ISDIR(status.st_mode)) refuse(path, "'" + folder + "' is not a folder");
    if (access(folder.c_str(), W_OK | X_OK) != 0)
        refuse(path, "folder '" + folder + "': " + std::strerror(errno));
    if (format_of(path) == Format::kStl) io::check_stl_is_own(path);
}

Mesh read_mesh(const std::string& path) {
    const Format format = format_of(path, true);
    if (format == Format::kFoam)
        throw Error(
            ExitCode::kUsage,
            "'" + path + "': OpenFOAM's meshes are written only, not read; its checkMesh tells of them");
    if (format == Format::kInp)
        throw Error(ExitCode::kUsage,
                    "'" + path + "': .inp files are written only, not read; use .vtu or .msh");
    if (format == Format::kStl)
        throw Error(ExitCode::kUsage,
                    "'" + path + "': .stl files have a surface only, no elements; use .vtu or .msh");
    try {
        const io::FileReader file(path);
        Mesh mesh = format == Format::kVtu ? io::read_vtu(file) : io::read_msh(file);
        const std::string error = io::find_range_error(mesh);
        if (!error.empty()) file.damaged(error);
        return mesh;
    } catch (const std::bad_alloc&) {
        throw Error(ExitCode::kDevice, "cannot read '" + path + "': out of memory");
    }
}

}  // namespace mortise
