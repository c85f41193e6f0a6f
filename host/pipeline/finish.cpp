#include "host/pipeline/finish.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/common/parallel.hpp"
#include "host/features/features.hpp"
#include "host/hanging/restore.hpp"
#include "host/layers/layers.hpp"
#include "host/pipeline/findings.hpp"
#include "host/pipeline/names.hpp"
#include "host/pipeline/periodic.hpp"
#include "host/pipeline/periodic_improvement.hpp"
#include "host/quality/face_pairs.hpp"
#include "host/report/report.hpp"
#include "host/second_order/second_order.hpp"
#include "host/tetrahedra/split.hpp"

namespace mortise::pipeline {
namespace {

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
bool are_exact(const Root& root, int level) {
    double most = 0;
    for (const double x : root.origin) most = std::max({most, std::fabs(x), std::fabs(x + root.side)});
    return most <= jacobian::kExactEdges * std::ldexp(root.side, -level);
}

}  // namespace

Finish::Finish(device::Device& device, const Model& model, const MeshOptions& options,
               const Prepared& prepared, Stages& stages, MeshReport& report)
    : device_(device),
      model_(model),
      options_(options),
      prepared_(prepared),
      stages_(stages),
      out_(report),
      held_(held_surfaces(prepared.bound, prepared.periodic)),
      improve_options_(improvement_options(prepared, options)) {
    if (!held_.empty()) improve_options_.held = &held_;
    improve_options_.followed = &moved_cubes_;
}

void Finish::improve(Mesh& mesh) {
    moved_cubes_ = reposition_nodes(device_, prepared_, options_, improve_options_.held, stages_, mesh);
    if (!prepared_.periodic.empty()) {
        stages_.begin("planes");
        stages_.end(improve_planes(prepared_, improve_options_, mesh));
    }
    stages_.begin("improve");
    mesh = improve::improve(std::move(mesh), prepared_.bound, improve_options_, &counters_);
    stages_.end(counters_.zone_elements);
}

void Finish::match_planes(Mesh& mesh) {
    stages_.begin("periodic");
    copy_of_ = pipeline::match_planes(prepared_.periodic, model_, prepared_.bound, prepared_.root.cell(),
                                      mesh, out_.warnings);
    stages_.end(prepared_.periodic.size());
}

void Finish::split(Mesh& mesh, Mesh* old) {
    stages_.begin("tetrahedra");
    mesh = tetrahedra::split_around_cubes(std::move(mesh), options_.threads,
                                          copy_of_.empty() ? nullptr : &copy_of_, &moved_cubes_);
    // What good elements are split into may be worse.
    if (options_.improve && !raises()) raise(mesh);
    stages_.begin("tetrahedra");
    mesh = tetrahedra::split_cubes(std::move(mesh), options_.threads, moved_cubes_, &sixths_, old);
    if (raises() || !are_exact(prepared_.root, prepared_.tree.level)) sixths_ = {};
    moved_cubes_ = {};
    stages_.end(mesh.element_count());
}

void Finish::raise(Mesh& mesh) {
    stages_.begin("raise");
    const std::uint64_t before = counters_.zone_elements;
    mesh = raises() ? improve::raise(std::move(mesh), prepared_.bound, improve_options_, counters_)
                    : improve::mend_parts(std::move(mesh), prepared_.bound, improve_options_, counters_);
    stages_.end(counters_.zone_elements - before);
}

void Finish::restore_cells(Mesh& mesh) {
    stages_.begin("hanging");
    hanging::Restored restored = hanging::restore_cells(
        std::move(mesh), {prepared_.root.origin, prepared_.root.side, &prepared_.leaves}, options_.threads);
    mesh = std::move(restored.mesh);
    out_.hanging_cells = restored.cells;
    knows_shapes_ = restored.cells == 0;  // numbers of hexahedra are others now
    stages_.end(restored.cells);
}

void Finish::name(Mesh& mesh) {
    stages_.begin("names");
    facet_surface_ = mesh.facets.surface;
    name_surfaces(prepared_.compiled, prepared_.bound, options_.threads, mesh);
    stages_.end(mesh.facets.size());
}

void Finish::pair_planes(Mesh& mesh) {
    stages_.begin("periodic");
    mesh.periodic =
        pair_nodes(prepared_.periodic, prepared_.bound, prepared_.root.cell(), facet_surface_, mesh);
    stages_.end(0);
}

void Finish::add_layers(Mesh& mesh) {
    stages_.begin("layers");
    out_.layers =
        layers::add_layers(mesh, facet_surface_, prepared_.bound, options_.layers, options_.threads);
    report_layers(model_.source, out_);
    stages_.end(out_.layers.elements);
}

void Finish::verify(const Mesh& mesh) {
    stages_.begin("faces");
    if (!quality::faces_are_paired(mesh, options_.threads)) refuse_unpaired(model_.source);
    stages_.end(mesh.element_count());
}

void Finish::describe(Mesh& mesh) {
    if (options_.improve) report_improvement(counters_, options_, model_.source, out_);
    stages_.begin("features");
    features::Hinges hinges;
    parallel_chunks(2, 1, options_.threads, [&](std::size_t i, std::size_t, int) {  // most of both is serial
        if (i == 0)
            out_.features =
                features::find_features(mesh, facet_surface_, prepared_.bound, prepared_.leaves.level);
        else
            hinges = features::find_hinges(mesh.facets, mesh.node_count(), options_.threads);
    });
    mesh.model_dimension = out_.features.model_dimension;
    report_hinges(hinges, mesh.points, options_, model_.source, out_);
    stages_.end(mesh.facets.size());
    if (options_.quality) assess(mesh);
    stages_.begin("films");
    report_small_pieces(prepared_, mesh.points, mesh.facets, options_, model_.source, out_);
    report_false_facets(prepared_, mesh.points, mesh.facets, options_, model_.source, out_);
    stages_.end(mesh.facets.size());
    warn_of_empty_regions(mesh.region_names, regions_present(mesh), model_.source, out_);
}

void Finish::assess(const Mesh& mesh) {
    stages_.begin("quality");
    const LeafGrid& leaves = prepared_.leaves;
    out_.quality = report::assess(mesh, facet_surface_, prepared_.bound, out_.features,
                                  {leaves.level, kWorstElements, options_.threads, &leaves});
    stages_.end(mesh.element_count());
}

void Finish::raise_order(Mesh& mesh) {
    stages_.begin("second order");
    const second_order::Counts counts =
        second_order::raise_order(mesh, facet_surface_, prepared_.bound, out_.features, options_.threads);
    out_.middle_nodes = counts.nodes;
    out_.curved_edges = counts.curved;
    out_.relaxed_edges = counts.relaxed;
    stages_.end(counts.nodes);
}

void Finish::measure(const Mesh& mesh, std::optional<jacobian::Method> method, std::vector<float> memory) {
    stages_.begin("jacobians");
    const bool knows_shapes = knows_shapes_ && prepared_.periodic.empty() && options_.layers.count == 0;
    out_.scaled_jacobians = jacobian::scaled_jacobians(
        device_, mesh, method.value_or(jacobian::usual_method(mesh.element_count())), options_.threads,
        knows_shapes ? jacobian::KnownShapes{&moved_cubes_, &sixths_} : jacobian::KnownShapes{},
        std::move(memory));
    stages_.end(mesh.element_count());
}

}  // namespace mortise::pipeline
