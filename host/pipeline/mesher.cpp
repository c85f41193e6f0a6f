// The order of the stages, for meshes in memory; stream.cpp has it for those that are not.
#include "mortise/mesher.hpp"

#include <atomic>
#include <new>
#include <optional>

#include "host/common/watch.hpp"
#include "host/jacobian/jacobian.hpp"
#include "host/pipeline/check_options.hpp"
#include "host/pipeline/estimate.hpp"
#include "host/pipeline/findings.hpp"
#include "host/pipeline/finish.hpp"
#include "host/pipeline/periodic_box.hpp"
#include "host/pipeline/piece.hpp"
#include "host/pipeline/prepare.hpp"
#include "host/pipeline/stream.hpp"

namespace mortise {
namespace {

using pipeline::Extracted;
using pipeline::Prepared;
using pipeline::Stages;

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
    stages.begin("merge");
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

    Mesh generate(const Model& model, const MeshOptions& asked, MeshReport* report);
    MeshEstimate estimate(const Model& model, const MeshOptions& options);

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

/// What `run` returns. Memory that is out ends it with an Error, like all that can go wrong.
template <class Run>
auto with_memory_told(Run run) {
    try {
        return run();
    } catch (const std::bad_alloc&) {
        throw Error(ExitCode::kDevice,
                    "out of memory; use larger cells (--level, --size), or fewer meshers at once (--jobs)");
    }
}

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

Mesh Mesher::Implementation::generate(const Model& model, const MeshOptions& asked, MeshReport* report) {
    MeshOptions options = asked;
    options.memory = 0;  // what there is
    MeshReport local;
    MeshReport& out = report != nullptr ? *report : local;
    std::vector<float> jacobians = std::move(out.scaled_jacobians);
    out = MeshReport{};
    assembly::Arena local_arena = std::move(arena);  // gone if the run fails
    arena = {};
    assembly::Arena* const kept = recycles ? &local_arena : nullptr;
    check_options(options);
    const std::optional<jacobian::Method> jacobian_method = jacobian::wanted_method();
    Stages stages(options, out);
    const auto open_device = [&]() -> device::Device& { return open(options); };
    Prepared prepared = pipeline::prepare(open_device, model, options, stages, out);
    device::Device& used = open_device();
    Mesh mesh;
    const Extracted extracted = mesh_pieces(used, options, prepared, stages, kept, &mesh);
    if (!options.tetrahedra) local_arena.mesh = {};
    pipeline::Finish finish(used, model, options, prepared, stages, out);
    if (options.improve) finish.improve(mesh);
    if (mesh.element_count() == 0) pipeline::refuse_empty(model.source);
    mesh.region_names = prepared.compiled.region_names;
    if (!prepared.periodic.empty()) finish.match_planes(mesh);
    if (options.tetrahedra) finish.split(mesh, kept != nullptr ? &kept->mesh : nullptr);
    if (finish.raises()) finish.raise(mesh);
    if (options.hanging) finish.restore_cells(mesh);
    finish.name(mesh);
    if (!prepared.periodic.empty()) finish.pair_planes(mesh);
    if (options.layers.count > 0) finish.add_layers(mesh);
    finish.verify(mesh);
    finish.describe(mesh);
    if (report != nullptr) finish.measure(mesh, jacobian_method, std::move(jacobians));
    if (options.second_order) finish.raise_order(mesh);
    pipeline::report_cells(prepared, extracted, model, options, out);
    arena = std::move(local_arena);
    return mesh;
}

Mesh Mesher::generate(const Model& model, const MeshOptions& options, MeshReport* report) {
    refuse_moved(implementation_ == nullptr);
    const Work work(implementation_->is_busy);
    return with_memory_told([&] {
        if (options.periodic.empty()) return implementation_->generate(model, options, report);
        const pipeline::PeriodicTask task = pipeline::repeat_in_box(model, options);
        return implementation_->generate(task.model, task.options, report);
    });
}

MeshEstimate Mesher::Implementation::estimate(const Model& model, const MeshOptions& options) {
    return pipeline::estimate([&]() -> device::Device& { return open(options); }, model, options,
                              [&](const Model& tried, const MeshOptions& trial, MeshReport& report) {
                                  return generate(tried, trial, &report);
                              });
}

MeshEstimate Mesher::estimate(const Model& model, const MeshOptions& options) {
    refuse_moved(implementation_ == nullptr);
    const Work work(implementation_->is_busy);
    return with_memory_told([&] {
        if (options.periodic.empty()) return implementation_->estimate(model, options);
        const pipeline::PeriodicTask task = pipeline::repeat_in_box(model, options);
        return implementation_->estimate(task.model, task.options);
    });
}

void Mesher::stream(const Model& model, const MeshOptions& options, MeshSink& sink, MeshReport* report) {
    refuse_moved(implementation_ == nullptr);
    const Work work(implementation_->is_busy);
    MeshReport local;
    MeshReport& out = report != nullptr ? *report : local;
    out = MeshReport{};
    with_memory_told([&] {
        pipeline::stream([&]() -> device::Device& { return implementation_->open(options); }, model, options,
                         sink, out);
    });
}

}  // namespace mortise
