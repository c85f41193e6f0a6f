// The order of the stages, for meshes in memory; stream.cpp has it for those that are not.
#include "mortise/mesher.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

#include "host/common/parallel.hpp"
#include "host/common/watch.hpp"
#include "host/features/features.hpp"
#include "host/hanging/restore.hpp"
#include "host/improve/improve.hpp"
#include "host/jacobian/jacobian.hpp"
#include "host/pipeline/check_options.hpp"
#include "host/pipeline/findings.hpp"
#include "host/pipeline/names.hpp"
#include "host/pipeline/periodic.hpp"
#include "host/pipeline/periodic_improvement.hpp"
#include "host/pipeline/piece.hpp"
#include "host/pipeline/prepare.hpp"
#include "host/pipeline/stream.hpp"
#include "host/quality/face_pairs.hpp"
#include "host/report/report.hpp"
#include "host/tetrahedra/split.hpp"

namespace mortise {
namespace {

using pipeline::Extracted;
using pipeline::Prepared;
using pipeline::Stages;

/// Names the surfaces and classifies the nodes; the quality report if it is wanted.
void describe_mesh(const tape::CompiledModel& compiled, const tape::BoundModel& bound, const LeafGrid& leaves,
                   const MeshOptions& options, const std::string& source, Stages& stages, Mesh& mesh,
                   MeshReport& out) {
    stages.begin("features", 0.96);
    const std::vector<std::uint32_t> facet_surface = mesh.facets.surface;
    pipeline::name_surfaces(compiled, bound, mesh);
    features::Hinges hinges;
    parallel_chunks(2, 1, options.threads, [&](std::size_t i, std::size_t, int) {  // most of both is serial
        if (i == 0)
            out.features = features::find_features(mesh, facet_surface, bound, leaves.level);
        else
            hinges = features::find_hinges(mesh.facets, mesh.node_count(), options.threads);
    });
    mesh.model_dimension = out.features.model_dimension;
    pipeline::report_hinges(hinges, mesh.points, options, source, out);
    stages.end(mesh.facets.size());
    if (!options.quality) return;
    stages.begin("quality", 0.97);
    out.quality = report::assess(mesh, facet_surface, bound, out.features,
                                 {leaves.level, kWorstElements, options.threads, &leaves});
    stages.end(mesh.element_count());
}

/// Which regions have elements.
std::vector<bool> regions_present(const Mesh& mesh) {
    std::vector<bool> present(mesh.region_names.size() + 1, false);
    std::size_t missing = mesh.region_names.size();
    for (const ElementBlock& block : mesh.elements) {
        for (std::size_t i = 0; i < block.size() && missing > 0; ++i) {
            if (present[block.region[i]]) continue;
            present[block.region[i]] = true;
            --missing;
        }
    }
    return present;
}

/// Whether coordinates round little beside cells of a level.
bool are_exact(const pipeline::Root& root, int level) {
    double most = 0;
    for (const double x : root.origin) most = std::max({most, std::fabs(x), std::fabs(x + root.side)});
    return most <= jacobian::kExactEdges * std::ldexp(root.side, -level);
}

/// Extraction and assembly, range by range of the Morton order; the pieces do not know each other until they
/// are merged. `arena`: as assembly::Input::arena.
Extracted mesh_pieces(device::Device& device, const MeshOptions& options, Prepared& prepared, Stages& stages,
                      assembly::Arena* arena, Mesh* mesh) {
    const octree::Octree& tree = prepared.tree;
    Extracted result;
    const std::uint64_t count = std::max(static_cast<std::uint64_t>(options.pieces),
                                         pipeline::pieces_needed(tree, device.info().max_allocation_bytes));
    const octree::InRegions in_regions(tree);
    std::vector<assembly::Piece> pieces;
    std::uint64_t begin = 0;
    for (std::uint64_t p = 0; p < count; ++p) {
        assembly::MortonRange range;
        range.begin = begin;
        if (p + 1 < count) range.end = begin = pipeline::piece_end(tree, p + 1, count);
        if (range.begin == range.end) continue;  // all leaves are in few words
        const double step = 0.5 / static_cast<double>(count);
        const double done = 0.4 + step * static_cast<double>(p);
        pieces.push_back(pipeline::make_piece(device, options, prepared, in_regions, range, stages, done,
                                              done + step, result, count == 1 ? arena : nullptr));
    }
    stages.begin("merge", 0.92);
    *mesh = assembly::merge(std::move(pieces), options.threads);
    stages.end(mesh->element_count());
    return result;
}

}  // namespace

struct Mesher::Implementation {
    std::string choice;
    int work_group_size = 0;
    std::optional<device::Device> device;
    std::atomic<bool> is_busy{false};
    bool recycles = false;  ///< the caller hands meshes back
    assembly::Arena arena;  ///< what they, and what they were made of, leave; empty if the caller does not

    /// Keeps what a mesh has; an array that it lacks stays.
    void recycle(Mesh& mesh) {
        const auto keep = [](auto& kept, auto& values) {
            if (values.capacity() > 0) kept = std::move(values);
        };
        keep(arena.mesh.points, mesh.points);
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            keep(arena.mesh.elements[t].nodes, mesh.elements[t].nodes);
            keep(arena.mesh.elements[t].region, mesh.elements[t].region);
            keep(arena.mesh.elements[t].kind, mesh.elements[t].kind);
        }
    }

    /// For a run that reports its progress, or not.
    device::Device& open(const MeshOptions& options) {
        if (!device) {
            pipeline::check_work_group(work_group_size);
            device::DeviceOptions device_options;
            device_options.work_group_size = work_group_size;
            device.emplace(choice, device_options);
        }
        device->set_look(options.progress ? &keep_watch : nullptr);
        return *device;
    }
};

Mesher::Mesher(std::string device, int work_group_size) : implementation_(new Implementation) {
    implementation_->choice = std::move(device);
    implementation_->work_group_size = work_group_size;
}
Mesher::~Mesher() = default;
Mesher::Mesher(Mesher&&) noexcept = default;
Mesher& Mesher::operator=(Mesher&&) noexcept = default;

namespace {

/// What is left of a mesher after a move.
void refuse_moved(bool is_moved) {
    if (!is_moved) return;
    throw Error(ExitCode::kUsage, "this mesher has been moved from; use the one that it was moved to");
}

/// A mesher at work: two runs at once, from two threads or from a run's own progress, would share its device.
class Work {
  public:
    explicit Work(std::atomic<bool>& is_busy) : is_busy_(is_busy) {
        if (is_busy_.exchange(true))
            throw Error(ExitCode::kUsage, "this mesher is at work already; use another one beside it");
    }
    ~Work() { is_busy_ = false; }
    Work(const Work&) = delete;
    Work& operator=(const Work&) = delete;

  private:
    std::atomic<bool>& is_busy_;
};

}  // namespace

Mesh generate_mesh(const Model& model, const MeshOptions& options, MeshReport* report) {
    return Mesher(options.device, options.work_group_size).generate(model, options, report);
}

void Mesher::recycle(Mesh&& mesh) {
    refuse_moved(implementation_ == nullptr);
    const Work work(implementation_->is_busy);
    implementation_->recycle(mesh);
    implementation_->recycles = true;
    mesh = {};
}

Mesh Mesher::generate(const Model& model, const MeshOptions& asked, MeshReport* report) {
    refuse_moved(implementation_ == nullptr);
    const Work work(implementation_->is_busy);
    MeshOptions options = asked;
    options.memory = 0;  // what there is
    MeshReport local;
    MeshReport& out = report != nullptr ? *report : local;
    std::vector<float> jacobians = std::move(out.scaled_jacobians);
    out = MeshReport{};
    assembly::Arena local_arena = std::move(implementation_->arena);  // gone if the run fails
    implementation_->arena = {};
    assembly::Arena* const arena = implementation_->recycles ? &local_arena : nullptr;
    pipeline::check_options(options);
    const std::optional<jacobian::Method> jacobian_method = jacobian::wanted_method();
    Stages stages(options, out);
    const auto open = [&]() -> device::Device& { return implementation_->open(options); };
    Prepared prepared = pipeline::prepare(open, model, options, stages, out);
    device::Device& device = open();
    Mesh mesh;
    const Extracted extracted = mesh_pieces(device, options, prepared, stages, arena, &mesh);
    if (!options.tetrahedra) local_arena.mesh = {};
    improve::Counters counters;
    improve::Options improve_options = pipeline::improvement_options(prepared, options);
    const std::vector<std::uint8_t> held = pipeline::held_surfaces(prepared.bound, prepared.periodic);
    if (!held.empty()) improve_options.held = &held;
    IndexRuns moved_cubes;  ///< hexahedra of kind kIn, but for these, are boxes along the axes
    improve_options.followed = &moved_cubes;
    if (options.improve) {
        moved_cubes =
            pipeline::reposition_nodes(device, prepared, options, improve_options.held, stages, mesh);
        if (!prepared.periodic.empty()) {
            stages.begin("planes", 0.925);
            stages.end(pipeline::improve_planes(prepared, improve_options, mesh));
        }
        stages.begin("improve", 0.93);
        mesh = improve::improve(std::move(mesh), prepared.bound, improve_options, &counters);
        stages.end(counters.zone_elements);
    }
    if (mesh.element_count() == 0) pipeline::refuse_empty(model.source);
    mesh.region_names = prepared.compiled.region_names;

    std::vector<NodeId> copy_of;
    if (!prepared.periodic.empty()) {
        stages.begin("periodic", 0.945);
        copy_of = pipeline::match_planes(prepared.periodic, model, prepared.bound, prepared.root.cell(), mesh,
                                         out.warnings);
        stages.end(prepared.periodic.size());
    }
    const bool raises = improve_options.goal > improve::kGoodQuality;
    const auto raise = [&](double progress) {
        stages.begin("raise", progress);
        const std::uint64_t before = counters.zone_elements;
        mesh = raises ? improve::raise(std::move(mesh), prepared.bound, improve_options, counters)
                      : improve::mend_parts(std::move(mesh), prepared.bound, improve_options, counters);
        stages.end(counters.zone_elements - before);
    };
    IndexRuns sixths;
    if (options.tetrahedra) {
        stages.begin("tetrahedra", 0.95);
        mesh = tetrahedra::split_around_cubes(std::move(mesh), options.threads,
                                              copy_of.empty() ? nullptr : &copy_of, &moved_cubes);
        // What good elements are split into may be worse.
        if (options.improve && !raises) raise(0.951);
        stages.begin("tetrahedra", 0.952);
        mesh = tetrahedra::split_cubes(std::move(mesh), options.threads, moved_cubes, &sixths,
                                       arena != nullptr ? &arena->mesh : nullptr);
        if (raises || !are_exact(prepared.root, prepared.tree.level)) sixths = {};
        moved_cubes = {};
        stages.end(mesh.element_count());
    }
    if (raises) raise(0.953);
    if (options.hanging) {
        stages.begin("hanging", 0.954);
        hanging::Restored restored = hanging::restore_cells(
            std::move(mesh), {prepared.root.origin, prepared.root.side, &prepared.leaves}, options.threads);
        mesh = std::move(restored.mesh);
        out.hanging_cells = restored.cells;
        stages.end(restored.cells);
    }
    if (options.improve) pipeline::report_improvement(counters, options, model.source, out);
    stages.begin("faces", 0.955);
    if (!quality::faces_are_paired(mesh, options.threads)) pipeline::refuse_unpaired(model.source);
    stages.end(mesh.element_count());
    describe_mesh(prepared.compiled, prepared.bound, prepared.leaves, options, model.source, stages, mesh,
                  out);
    stages.begin("films", 0.985);
    pipeline::report_false_facets(prepared, mesh.points, mesh.facets, options, model.source, out);
    stages.end(mesh.facets.size());
    pipeline::warn_of_empty_regions(mesh.region_names, regions_present(mesh), model.source, out);
    if (report != nullptr) {
        stages.begin("jacobians", 0.99);
        out.scaled_jacobians = jacobian::scaled_jacobians(
            device, mesh, jacobian_method.value_or(jacobian::usual_method(mesh.element_count())),
            options.threads,
            prepared.periodic.empty() ? jacobian::KnownShapes{&moved_cubes, &sixths}
                                      : jacobian::KnownShapes{},
            std::move(jacobians));
        stages.end(mesh.element_count());
    }
    pipeline::report_cells(prepared, extracted, model, options, out);
    implementation_->arena = std::move(local_arena);
    return mesh;
}

void Mesher::stream(const Model& model, const MeshOptions& options, MeshSink& sink, MeshReport* report) {
    refuse_moved(implementation_ == nullptr);
    const Work work(implementation_->is_busy);
    MeshReport local;
    MeshReport& out = report != nullptr ? *report : local;
    out = MeshReport{};
    pipeline::stream([&]() -> device::Device& { return implementation_->open(options); }, model, options,
                     sink, out);
}

}  // namespace mortise
