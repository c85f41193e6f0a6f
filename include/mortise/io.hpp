// Mesh files and pictures.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mortise/mesh.hpp"
#include "mortise/mesh_sink.hpp"
#include "mortise/quality.hpp"

namespace mortise {

/// Bounds of MeshFileOptions::scale.
inline constexpr double kLeastScale = 1e-12, kMostScale = 1e12;

struct MeshFileOptions {
    bool compress = true;  ///< arrays of .vtu by zlib; else several times larger files in less time
    int threads = 0;       ///< of the host that pack and write, 0: all cores; the same bytes for any
    std::vector<std::string> walls = {};  ///< names of surfaces that are OpenFOAM's patches of type `wall`
    /// What coordinates are multiplied by: 0.001 makes metres of millimetres; kLeastScale to kMostScale.
    double scale = 1;
};

/// Writes a mesh; the format follows from the extension, in any case of letters: .vtu (VTK XML, appended),
/// .msh (Gmsh 4.1, binary), .inp (input deck of Abaqus and CalculiX), .stl (binary: the outer boundary alone,
/// as triangles in single precision, curved if the mesh is; never over an .stl that others have made), or
/// from the name polyMesh: OpenFOAM's folder, a patch for each surface of the outer boundary and a cell zone
/// for each region. Written to a temporary name beside `path` and renamed at the end, so a file of that name
/// is always whole. Hanging nodes: not in .msh and .inp; second order: not in polyMesh, nor in .inp with
/// pyramids. Throws Error(kUsage) for an unknown extension and for these, Error(kMeshing) for arrays whose
/// lengths or indices do not fit, Error(kFiles) with the cause.
///
/// `jacobians`: what scaled_jacobians(mesh) gives (mortise/check.hpp), if it is known already.
void write_mesh(const Mesh& mesh, const std::string& path, const std::vector<float>& jacobians = {},
                const MeshFileOptions& options = {});

/// Writes a mesh that comes in parts (Mesher::stream): the same bytes as write_mesh, but .vtu only. What has
/// come waits, packed as it will be, in an unnamed temporary file beside `path`; commit() joins it, once.
/// Errors as those of write_mesh, and Error(kUsage) for calls in another order; without commit() there is no
/// file.
class MeshFileStream : public MeshSink {
  public:
    explicit MeshFileStream(const std::string& path, const MeshFileOptions& options = {});
    ~MeshFileStream() override;

    void begin(const MeshTotals& totals, const Mesh& outline) override;
    void add(const Mesh& part, const std::vector<float>& scaled_jacobians) override;
    void commit();

  private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

/// Whether write_mesh makes a folder of that name: its last part is polyMesh.
bool is_mesh_folder(const std::string& path);

/// What a mesh has that not every format can hold.
struct MeshTraits {
    bool hanging_nodes = false;
    bool second_order = false;
    bool pyramids = false;
};

/// Throws Error(kUsage) if the format that the name tells is unknown, or cannot hold what the mesh has.
void check_mesh_format(const std::string& path, const MeshTraits& mesh);

/// Throws what write_mesh(mesh, path) would throw for the name alone: unknown extension, missing or
/// unwritable folder. Called before the work starts.
void check_writable(const std::string& path);

/// Reads a file that write_mesh made, or elements of first or second order (serendipity) in Gmsh's text
/// formats 4.1 and 2.2: regions are then the file's volume entities, and facets carry no surfaces of a model.
/// Throws Error(kUsage) for an unknown extension, Error(kFiles) or Error(kInput) with the cause; never
/// crashes on damaged bytes. A .vtu carries facets and names too, so that a round trip is exact.
Mesh read_mesh(const std::string& path);

/// Writes crease curves and corners as VTK XML PolyData (.vtp). Throws Error(kMeshing) for nodes or surfaces
/// that the mesh does not have, Error(kFiles) with the cause; the file is whole or not there. Of the options
/// only `scale` is for it.
void write_features(const Mesh& mesh, const Features& features, const std::string& path,
                    const MeshFileOptions& options = {});

/// Opens a mesh: elements before a plane across an axis are left out, so that those behind it are seen.
struct PictureCut {
    int axis = 0;              ///< 0: x, 1: y, 2: z
    std::optional<double> at;  ///< model units; none: the middle of the mesh
};

struct PictureOptions {
    int width = 1200, height = 900;  ///< pixels, 16384 at most
    std::optional<PictureCut> cut;
};

/// Draws a mesh into a PNG picture, seen from the right, front and above: flat shading, element edges; facets
/// coloured by their surface, elements that a cut shows by their region, darker if they are not cubes.
void write_picture(const Mesh& mesh, const std::string& path, const PictureOptions& options = {});

}  // namespace mortise
