#include "host/pipeline/periodic_improvement.hpp"

#include <algorithm>
#include <utility>

#include "host/pipeline/glue.hpp"

namespace mortise::pipeline {
namespace {

/// Cells on both sides of a plane whose elements are improved, and how far around them, at first, others are
/// at hand.
constexpr std::int64_t kImprovedBeside = 2;
constexpr std::int64_t kFirstPeriodicReach = 8;
constexpr std::int64_t kApart = 2;  ///< cells: no element reaches from one side's to another's

/// Improves what is near all these planes; the number of tetrahedra that were tried.
std::uint64_t improve_where_all_meet(const Prepared& prepared, const improve::Options& options,
                                     const std::vector<const PeriodicAxis*>& pairs, Mesh& mesh) {
    const std::optional<Gluing> gluing = make_gluing(prepared, pairs, mesh);
    if (!gluing) return 0;
    std::int64_t farthest = std::int64_t{1} << gluing->level;
    std::vector<improve::Slab> slabs;
    const std::int64_t middle = std::int64_t{1} << (gluing->level - 1);
    for (const GluedPair& pair : gluing->pairs) {
        farthest = std::min(farthest, pair.cells_between() / 2 - kApart);
        slabs.push_back({pair.axis, middle - kImprovedBeside, middle + kImprovedBeside});
    }
    if (farthest <= kImprovedBeside) return 0;
    for (std::int64_t reach = std::min(kFirstPeriodicReach, farthest);;
         reach = std::min(2 * reach, farthest)) {
        const std::optional<GluedModel> model = glue_model(*gluing, prepared, options, reach, mesh);
        if (!model) return 0;
        const GluedMesh glued = glue_mesh(*gluing, *model, reach, mesh);
        improve::Options glued_options = options;
        glued_options.held = &model->held;
        glued_options.poles = &model->poles;
        glued_options.is_open = &glued.is_open;
        glued_options.slabs = &slabs;
        // Loose nodes would leave the planes.
        glued_options.merge_distance = 0;
        improve::Counters counters;
        improve::Trace trace;
        const Mesh improved = improve::improve(glued.mesh, model->bound, glued_options, &counters, &trace);
        if (counters.reached_open && reach < farthest) continue;
        if (counters.reached_open || counters.zone_elements == 0) return 0;
        Mesh result = mesh;
        if (!separate(*gluing, *model, glued, improved, trace, result)) return 0;
        for (const PeriodicAxis& axis : prepared.periodic) {
            const bool was_same = !match_plane(axis, prepared.bound, prepared.root.cell(), mesh).empty();
            if (was_same && match_plane(axis, prepared.bound, prepared.root.cell(), result).empty()) return 0;
        }
        mesh = std::move(result);
        return counters.zone_elements;
    }
}

}  // namespace

std::uint64_t improve_planes(const Prepared& prepared, const improve::Options& options, Mesh& mesh) {
    if (!prepared.leaves.is_uniform()) return 0;
    std::uint64_t tried = 0;
    const std::size_t count = prepared.periodic.size();
    // Corners first, where the most planes may change, then edges.
    for (std::size_t together = std::min<std::size_t>(count, 3); together > 0; --together) {
        for (std::size_t set = 1; set < std::size_t{1} << count; ++set) {
            std::vector<const PeriodicAxis*> pairs;
            for (std::size_t i = 0; i < count; ++i) {
                if ((set >> i & 1) != 0) pairs.push_back(&prepared.periodic[i]);
            }
            const auto is_parallel = [&](std::size_t i) {
                return std::any_of(pairs.begin(), pairs.begin() + static_cast<std::ptrdiff_t>(i),
                                   [&](const PeriodicAxis* p) { return p->axis == pairs[i]->axis; });
            };
            bool crosses = pairs.size() == together;
            for (std::size_t i = 0; i < pairs.size(); ++i) crosses = crosses && !is_parallel(i);
            if (crosses) tried += improve_where_all_meet(prepared, options, pairs, mesh);
        }
    }
    return tried;
}

}  // namespace mortise::pipeline
