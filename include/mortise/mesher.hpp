// From a model to a mesh: the one call that the command line, the tests and other programs use.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mortise/mesh.hpp"
#include "mortise/mesh_sink.hpp"
#include "mortise/model.hpp"
#include "mortise/quality.hpp"

namespace mortise {

/// Level of the smallest cells that sizes, `refine` and curvature can ask for; MeshOptions::level, of cells
/// of one size, ends at kMostLevel. 3 × 19 bits of coordinate, 5 of level and 2 of axis fill a 64-bit key.
inline constexpr int kMaxLevel = 18;

/// Limits of MeshOptions::level, min_angle, smooth, merge_distance and curvature_elements.
inline constexpr int kMostLevel = 11;
inline constexpr double kLeastMinAngle = 18;
inline constexpr double kMostMinAngle = 44;
inline constexpr int kMostSmooth = 100;
inline constexpr double kMostMergeDistance = 0.25;
inline constexpr double kLeastCurvatureElements = 3;
/// Those of LayerOptions.
inline constexpr int kMostLayers = 100;
inline constexpr double kLeastLayerGrowth = 0.5;
inline constexpr double kMostLayerGrowth = 3;

/// A wish for small cells around a point: at distance d from it none is larger than size + grading × d.
struct SizeSource {
    Vec3 at{};
    double size = 0;     ///< edge of a cell in model units
    double grading = 1;  ///< growth of the edge per unit of distance; 0: everywhere
};

/// Layers of flat elements at walls, for flow along them.
struct LayerOptions {
    int count = 0;        ///< how many, 100 at most; 0: none
    double first = 0;     ///< height of the one at the wall, model units; 0: the last one is 0.4 of an edge
                          ///< of the wall, all together an edge at most
    double growth = 1.2;  ///< height of each to the one before it, 0.5 to 3
    /// Names of surfaces and regions. Of regions all their boundary gets layers, on its inside; of surfaces
    /// these; of both what is both. None: the outer boundary.
    std::vector<std::string> on;
};

struct MeshOptions {
    int level = 0;    ///< root box split `level` times, 11 at most; 0: from `size`, or the default of 6
    double size = 0;  ///< edge length of a cell in model units, instead of `level`; 0: from `level`
    // What follows makes cells of several sizes, in steps of two, and `level` or `size` those at a boundary
    // that asks for nothing else.
    int refine = 0;                 ///< levels by which cells may be smaller where features ask for it
    double curvature_elements = 0;  ///< cells per full turn of a surface, from 3, within `refine`; 0: any
    bool model_sizes = true;        ///< follow the sizes in the model's file
    std::vector<SizeSource> sizes;  ///< smaller cells around points
    /// Smaller cells on surfaces and in regions, by their names: no cell is larger than the length.
    std::vector<std::pair<std::string, double>> named_sizes;
    std::string size_formula;     ///< largest cell as a function of x, y, z (docs/formulas.md); empty: none
    double size_max = 0;          ///< no cell is larger, if positive
    double size_min = 0;          ///< no cell is smaller, if positive; at most size_max
    int interior_coarsening = 0;  ///< levels by which IN cells away from the boundary may be larger
    /// Enlarge cells by up to a quarter, so that more faces of the model lie on the grid.
    bool box_fit = false;
    std::optional<Box3> box;  ///< cuts the solid; its faces become boundaries box_xmin, ...
    /// Axes, "xyz" or some of it, across which the solid repeats in the box (or in that of the model's file):
    /// opposite faces have the same facets, Mesh::periodic. Not with layers, nor in parts.
    std::string periodic;
    bool templates = true;  ///< false: every NIO cell by the certificate
    bool snap = true;       ///< vertices near a smooth surface move onto it; needs `templates`
    bool improve = true;    ///< false: elements stay as templates and certificate make them
    int smooth = 4;         ///< rounds of node repositioning, 100 at most; 0: nodes move only onto the model
    /// Degrees: elements are improved until no dihedral angle is smaller, 18 to 44. What goes with it, for
    /// 18, 25 and 32 degrees: angles of 155, 145 and 134 at most, scaled Jacobians of 0.2, 0.27 and 0.34;
    /// those of elements between cells of two sizes stay at 0.258 and more.
    double min_angle = kLeastMinAngle;
    /// Nodes of creases and corners closer than this to other features, in cells, may be merged with them
    /// where elements would be slivers, and nodes may lie beside the model by three times as much where
    /// nothing else helps. At most 0.25; 0, or `strict`: never.
    double merge_distance = 0.05;
    bool tetrahedra = false;  ///< split everything into tetrahedra
    /// Cells beside smaller ones stay hexahedra, with nodes in the middles of their edges and faces
    /// (Mesh::hanging), where only cells inside the solid are concerned; else the mesh conforms everywhere.
    bool hanging = false;
    /// Elements of second order: a node in the middle of each edge, on the model where the edge lies on it;
    /// not with `hanging`.
    bool second_order = false;
    LayerOptions layers;   ///< of wedges and hexahedra; not with `hanging`, `second_order`, periodic planes
    int pieces = 1;        ///< parts of the Morton range that are meshed apart and merged: the same mesh
    bool quality = false;  ///< also make MeshReport::quality
    bool strict = false;   ///< Error(kMeshing) if a feature of the model may be missing, or regions overlap
    /// Mesher::stream only: bytes of memory that the run tries to keep to; 0: 4 GiB.
    std::uint64_t memory = 0;
    int threads = 0;          ///< host threads; 0: all cores
    std::string device;       ///< as printed by `mortise devices`; empty: environment, else default
    int work_group_size = 0;  ///< 0: the device class's default
    /// Called with a stage's name and progress in [0, 1] when the stage begins, and again some ten times a
    /// second until it ends, by the thread that meshes; may be empty. Returning false stops the run there,
    /// within half a second as a rule, with Interrupted; what it throws goes to the caller of the mesher.
    std::function<bool(const char* stage, double progress)> progress;
};

/// Time of one stage, or of one kind of cell inside a stage.
struct StageTime {
    std::string stage;
    double wall_seconds = 0;
    double cpu_seconds = 0;   ///< process CPU time, all threads
    std::uint64_t items = 0;  ///< cells, nodes or elements that the stage handled
};

/// A part of the solid, or a hole in it, that no vertex, face centre or cell centre of the grid sees.
struct MissedFeature {
    Vec3 position{};       ///< a point well inside it
    double size = 0;       ///< its largest extent along an axis, model units, to 1/8 of a cell
    double thickness = 0;  ///< the shortest chord through `position`, within its cell, model units
    bool material = true;  ///< false: a hole
    bool kept = false;     ///< the mesh shows it all the same
};

/// What walls got of the layers that were asked for, MeshOptions::layers.
struct LayerFigures {
    std::uint64_t facets = 0;    ///< of the walls
    std::uint64_t lower = 0;     ///< of these, with lower layers at some corner: others would be too flat
    std::uint64_t bare = 0;      ///< without layers
    std::uint64_t elements = 0;  ///< in layers
    double thickness = 0;        ///< of all layers, mean over the walls' nodes that have some; model units
    double asked = 0;            ///< the same if there were room, mean over all nodes of the walls
    double edge = 0;             ///< mean length of the walls' edges
    std::optional<Vec3> first_bare;     ///< where the first facet without layers is
    std::vector<std::string> surfaces;  ///< of the walls' facets on the outer boundary, by their order
    std::vector<std::string> unused;    ///< names of LayerOptions::on that no facet of a wall has
};

/// What happened besides the mesh.
struct MeshReport {
    std::string device;                  ///< its name, as `mortise devices` prints it
    int level = 0;                       ///< of cells at a boundary that asks for nothing else
    double cell_size = 0;                ///< their edge, model units
    int finest_level = 0;                ///< of the smallest cells
    std::vector<std::uint64_t> leaves;   ///< cells that are not OUT, by level; empty: all have `level`
    std::uint64_t transition_cells = 0;  ///< inside a region, beside smaller ones: elements of kTransition
    std::uint64_t hanging_cells = 0;     ///< of these, hexahedra with hanging nodes
    std::uint64_t middle_nodes = 0;      ///< of second order, in the middles of edges
    std::uint64_t curved_edges = 0;      ///< of second order, edges that are not straight
    std::uint64_t relaxed_edges = 0;     ///< that would be curved more, but for the shape of elements there
    LayerFigures layers;                 ///< if there are any
    Box3 root{};                         ///< the root box, a cube
    std::uint64_t cells_evaluated = 0;   ///< of all levels, against the model
    std::uint64_t in_cells = 0;          ///< inside a region: one hexahedron each, as a rule
    std::uint64_t nio_cells = 0;         ///< neither in nor out: at the boundary
    std::uint64_t snio_cells = 0;        ///< meshed by templates
    std::uint64_t cnio_cells = 0;        ///< meshed by the certificate
    std::uint64_t refused_splits = 0;    ///< bisections that would have made an element too flat
    std::uint64_t unresolved = 0;        ///< tetrahedra that were labelled by their centroid
    std::uint64_t merged_nodes = 0;      ///< of features closer than MeshOptions::merge_distance
    std::uint64_t loosened_nodes = 0;    ///< that lie beside the model
    std::uint64_t below_min_angle = 0;   ///< elements that nothing helped to a `min_angle` above 18
    /// Pieces left out that share no face with the rest: of less than 5e-5 of a cell in volume, or of less
    /// than 0.15 if they hung on it by an edge or a node.
    std::uint64_t crumbs = 0;
    std::uint64_t hinge_edges = 0;       ///< with more than two boundary facets
    std::uint64_t hinge_nodes = 0;       ///< others at which parts of the boundary touch
    std::uint64_t loose_pieces = 0;      ///< small pieces of the mesh where the model goes on
    std::uint64_t closed_hollows = 0;    ///< the same of holes: small hollows without a way out
    std::uint64_t dropped_features = 0;  ///< complex cells with a refused split or an unresolved tetrahedron
    std::optional<Vec3> first_dropped;   ///< centre of the first of these, in Morton order
    std::vector<MissedFeature> missed;   ///< features smaller than a cell, the largest first
    Features features;                   ///< nodes against the model, creases and corners
    std::optional<QualityReport> quality;  ///< if MeshOptions::quality
    std::vector<StageTime> stages;
    std::vector<std::string> warnings;
    /// Per element, as by scaled_jacobians(mesh) of mortise/check.hpp.
    std::vector<float> scaled_jacobians;
};

/// What a mesh of the model would have, without making one.
struct ModelSummary {
    std::optional<Box3> bounds;         ///< of the solid, to a few percent; none: empty or unbounded
    std::string unbounded;              ///< why there are no bounds
    std::vector<std::string> surfaces;  ///< names of its smooth surfaces
    std::vector<double> surface_size;   ///< parallel: element size that the model wants there; 0: none
};

/// What a mesh of a model would have, and what making it would take.
struct MeshEstimate {
    int level = 0;         ///< of the cells at the boundary
    int finest_level = 0;  ///< of the smallest
    double cell_size = 0;  ///< of `level`
    std::uint64_t in_cells = 0, nio_cells = 0;
    std::uint64_t elements = 0, nodes = 0;
    std::uint64_t memory_bytes = 0;     ///< of the process at its peak
    std::uint64_t file_bytes = 0;       ///< of a .vtu with plain arrays; compressed ones have about a quarter
    double seconds = 0;                 ///< of the mesher; reading the model and writing files is not in it
    bool is_exact = false;              ///< elements and nodes are those of the mesh, which was made
    std::vector<std::string> warnings;  ///< of that mesh
};

/// Throws Error(kUsage), with name, value and what to use, for the first option that is out of range, or that
/// excludes another. Whatever takes options calls it; what they ask of the model (names, a box, formulas) and
/// of the device is looked at later.
void check_options(const MeshOptions& options);

/// Throws Error(kInput) for a model that check_model refuses, or that is empty by its structure.
ModelSummary summarize(const Model& model);

/// Meshes a model. Deterministic: the same model and options give the same mesh, bit for bit, whatever the
/// device, thread count and work-group size. Throws
/// - Error(kUsage) for what check_options refuses, and for names that the model does not have;
/// - Error(kInput) for what check_model refuses, for an empty or unbounded solid, and for formulas that are
///   not understood;
/// - Error(kMeshing) if no valid mesh comes out, if it would have more than 2^32 nodes, and for what `strict`
///   refuses; Interrupted, one of these, if `progress` returned false;
/// - Error(kDevice) without a device, for kernels that cannot be built or fail, and when memory is out.
///
/// The first use of OpenCL in a process sets environment variables of PoCL that are not set yet (POCL_…,
/// docs/options.md), so that no other thread should read or write the environment meanwhile.
///
/// With PoCL, the first mesh of a process loads LLVM, which sets handlers for SIGINT, SIGTERM, SIGHUP,
/// SIGABRT, SIGSEGV and the like. They remove LLVM's own files, put back the handlers that were there before
/// and hand the signal on to them. Handlers that are set after the first mesh replace them.
Mesh generate_mesh(const Model& model, const MeshOptions& options = {}, MeshReport* report = nullptr);

/// Meshes one model after another on one device, whose kernels stay loaded: for many small models, where
/// loading them would take longer than meshing. Used by one thread at a time; several meshers may run at
/// once. One that is at work already, or has been moved from, throws Error(kUsage).
class Mesher {
  public:
    /// The device is opened at the first mesh; arguments as MeshOptions::device and work_group_size.
    explicit Mesher(std::string device = {}, int work_group_size = 0);
    ~Mesher();
    Mesher(Mesher&&) noexcept;
    Mesher& operator=(Mesher&&) noexcept;

    /// As generate_mesh, with the same result, but on this device, whatever the options say of it. After an
    /// error the mesher is as before, but for memory that was recycled. A report that has served before hands
    /// its arrays' memory on.
    Mesh generate(const Model& model, const MeshOptions& options = {}, MeshReport* report = nullptr);

    /// Counts the cells that generate() would have, and meshes the model in larger ones, or a part of it
    /// where that takes long, to see what a cell at the boundary gives and takes; models with few cells there
    /// are meshed as they are. Roughly (docs/options.md), in a tenth of a second to some ten, where a run may
    /// take minutes. Throws what generate() throws for the model and the options; what only the mesh would
    /// show (`strict`, too many nodes) it does not see.
    MeshEstimate estimate(const Model& model, const MeshOptions& options = {});

    /// Takes a mesh that is no longer needed, and leaves an empty one: the next of about that size is made in
    /// its memory, without asking the system for new pages and zeroing them (docs/benchmarks.md tells what
    /// that saves). Until then, or the mesher's end, the memory stays with the mesher.
    void recycle(Mesh&& mesh);

    /// Meshes in parts that are handed on and forgotten: `sink` receives what generate() returns, in the
    /// same order and with the same numbers. What is kept takes memory with the model's boundary, not with
    /// its volume. Each part is made two or three times. In the report, scaled_jacobians and
    /// Features::model_dimension stay empty. Throws what generate() throws, what the sink throws, and
    /// Error(kUsage) for options that need the whole mesh (cells of several sizes, tetrahedra, second order,
    /// layers, periodic, quality), Error(kDevice) if the boundary alone does not fit into
    /// MeshOptions::memory. A model's own periodic planes do not match; a warning says so.
    void stream(const Model& model, const MeshOptions& options, MeshSink& sink, MeshReport* report = nullptr);

  private:
    struct Implementation;
    std::unique_ptr<Implementation> implementation_;
};

}  // namespace mortise
