// Writes OpenFOAM's polyMesh, a folder of text files: points, faces, owner, neighbour, boundary, cellZones.
//
// Every surface of the outer boundary is a patch, cyclic if it is periodic (Mesh::periodic), every region a
// cell zone; facets between regions are inner faces. Cells are numbered as the mesh lists its elements, inner
// faces as OpenFOAM wants them ("upper triangular order").
#include <algorithm>
#include <charconv>
#include <cstring>
#include <set>
#include <string>

#include "host/io/coordinates.hpp"
#include "host/io/facet_groups.hpp"
#include "host/io/foam_folder.hpp"
#include "host/io/formats.hpp"
#include "host/io/polyhedral_faces.hpp"

namespace mortise::io {
namespace {

/// A text file of an OpenFOAM case.
class FoamFile {
  public:
    FoamFile(FoamFolder& folder, const char* name, const char* type, const std::string& note = "")
        : file_(folder.file(name)) {
        text("FoamFile\n{\n    version     2.0;\n    format      ascii;\n    class       ");
        text(type);
        if (!note.empty()) text(";\n    note        \"" + note + "\"");
        text(";\n    location    \"constant/polyMesh\";\n    object      ");
        text(name);
        text(";\n}\n\n");
    }
    void text(const std::string& words) { file_.write(words); }
    template <class Number>
    void number(Number value) {
        char digits[32];
        const std::to_chars_result end = std::to_chars(digits, digits + sizeof digits, value);
        file_.write(digits, static_cast<std::size_t>(end.ptr - digits));
    }
    /// A list of `count` items that write(i) writes, a line each.
    template <class Write>
    void list(std::size_t count, const Write& write) {
        number(count);
        text("\n(\n");
        for (std::size_t i = 0; i < count; ++i) {
            write(i);
            text("\n");
        }
        text(")\n");
    }

  private:
    TemporaryFile& file_;
};

/// OpenFOAM's words: no white space, quotes, slashes, semicolons and braces; each once.
std::string foam_word(const std::string& name, std::set<std::string>& taken) {
    std::string word = name.empty() ? "unnamed" : name;
    for (char& c : word) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte <= ' ' || byte >= 127 || std::strchr("\"'/;{}()$#", c) != nullptr) c = '_';
    }
    return unique_name(word, taken);
}

void write_points(const Mesh& mesh, double scale, FoamFolder& folder) {
    const Coordinates points(mesh.points, scale);
    FoamFile file(folder, "points", "vectorField");
    file.list(mesh.node_count(), [&](std::size_t i) {
        for (std::size_t j = 0; j < 3; ++j) {
            file.text(j == 0 ? "(" : " ");
            file.number(points[3 * i + j]);
        }
        file.text(")");
    });
}

void write_faces(const PolyhedralFaces& faces, FoamFolder& folder) {
    FoamFile file(folder, "faces", "faceList");
    file.list(faces.faces().size(), [&](std::size_t i) {
        std::array<NodeId, PolyhedralFaces::kMostCorners> corners;
        const std::size_t count = faces.corners(faces.faces()[i], corners);
        file.number(count);
        for (std::size_t k = 0; k < count; ++k) {
            file.text(k == 0 ? "(" : " ");
            file.number(corners[k]);
        }
        file.text(")");
    });
}

void write_cells(const Mesh& mesh, const PolyhedralFaces& faces, FoamFolder& folder) {
    const std::string note = "nPoints:" + std::to_string(mesh.node_count()) +
                             "  nCells:" + std::to_string(faces.cell_count()) +
                             "  nFaces:" + std::to_string(faces.faces().size()) +
                             "  nInternalFaces:" + std::to_string(faces.inner_count());
    FoamFile owner(folder, "owner", "labelList", note);
    owner.list(faces.faces().size(), [&](std::size_t i) { owner.number(faces.faces()[i].owner); });
    FoamFile neighbour(folder, "neighbour", "labelList", note);
    neighbour.list(faces.inner_count(), [&](std::size_t i) { neighbour.number(faces.faces()[i].neighbour); });
}

void write_boundary(const Mesh& mesh, const PolyhedralFaces& faces, const std::vector<std::string>& walls,
                    FoamFolder& folder) {
    FoamFile file(folder, "boundary", "polyBoundaryMesh");
    std::set<std::string> taken;
    std::vector<std::string> words;
    for (const PolyhedralFaces::Patch& patch : faces.patches())
        words.push_back(foam_word(mesh.surface_names[patch.surface], taken));
    file.list(faces.patches().size(), [&](std::size_t i) {
        const PolyhedralFaces::Patch& patch = faces.patches()[i];
        const std::string& name = mesh.surface_names[patch.surface];
        const bool is_wall = std::find(walls.begin(), walls.end(), name) != walls.end();
        const bool is_cyclic = patch.partner != PolyhedralFaces::kNoPatch;
        file.text("    " + words[i] + "\n    {\n        type            " +
                  (is_cyclic ? "cyclic"
                   : is_wall ? "wall"
                             : "patch") +
                  ";\n");
        if (is_cyclic) file.text("        neighbourPatch  " + words[patch.partner] + ";\n");
        file.text("        nFaces          " + std::to_string(patch.count) + ";\n        startFace       " +
                  std::to_string(patch.first) + ";\n    }");
    });
}

void write_zones(const Mesh& mesh, FoamFolder& folder) {
    std::vector<std::vector<std::uint32_t>> cells(mesh.region_names.size());
    std::uint32_t cell = 0;
    for (const ElementBlock& block : mesh.elements) {
        for (const std::uint16_t region : block.region) cells[region - 1u].push_back(cell++);
    }
    FoamFile file(folder, "cellZones", "regIOobject");
    std::set<std::string> taken;
    file.list(cells.size(), [&](std::size_t r) {
        file.text(foam_word(mesh.region_names[r], taken) +
                  "\n{\n    type            cellZone;\n    cellLabels      List<label>\n");
        file.list(cells[r].size(), [&](std::size_t i) { file.number(cells[r][i]); });
        file.text(";\n}");
    });
}

}  // namespace

void write_foam(const Mesh& mesh, const std::string& path, const MeshFileOptions& options) {
    const PolyhedralFaces faces(mesh, options.threads);
    check_numbers(faces.faces().size(), path);
    FoamFolder folder(path);
    write_points(mesh, options.scale, folder);
    write_faces(faces, folder);
    write_cells(mesh, faces, folder);
    write_zones(mesh, folder);
    write_boundary(mesh, faces, options.walls, folder);
    folder.commit();
}

}  // namespace mortise::io
