#include "host/pipeline/findings.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/message_text.hpp"
#include "host/probe/false_facets.hpp"
#include "host/probe/loose_pieces.hpp"
#include "mortise/error.hpp"

namespace mortise::pipeline {
namespace {

/// Degrees: from here on one element in four and more is short of what is asked.
constexpr double kFewHaveIt = 35;

/// From which on cells show what is so thick: a ball holds a vertex of the grid, wherever it lies, if its
/// diameter is that of a cell. What rises from other material is seen by coarser cells as a rule.
int level_to_see(double thickness, const Root& root) {
    int level = root.level;
    while (level < kMaxLevel && std::ldexp(root.side, -level) * std::sqrt(3.0) > thickness) ++level;
    return level;
}

/// One line on the features smaller than a cell: how many, the largest, and which cells would show them.
std::string describe_missed(const std::vector<MissedFeature>& missed, const Root& root, int refine) {
    std::size_t lost = 0;
    double thinnest = root.side;
    const MissedFeature* largest = nullptr;
    for (const MissedFeature& feature : missed) {
        if (!feature.kept) ++lost;
        thinnest = std::min(thinnest, feature.thickness);
        if (largest == nullptr || (largest->kept && !feature.kept)) largest = &feature;
    }
    const int level = level_to_see(thinnest, root);
    std::string text = counted(missed.size(), "feature") + " between the vertices of the grid, ";
    text += lost == 0 ? "kept coarsely" : std::to_string(lost) + " of them lost";
    text += std::string("; the largest") + (lost == 0 ? "" : " lost") + ": " +
            (largest->material ? "material, " : "a hole, ") + rounded_text(largest->size) + " long and " +
            rounded_text(largest->thickness) + " thick, at " + place_text(largest->position) + "; ";
    if (level <= root.level + refine)
        return text +
               (refine == 0 ? std::string("cells are as small as that")
                            : "--refine " + std::to_string(refine) + " allows cells as small as that") +
               " already; what narrows to a tip, as beside surfaces that touch, is never shown whole";
    text += "--refine " + std::to_string(level - root.level);
    if (level <= octree::kMaxUniformLevel) text += ", or level " + std::to_string(level) + ",";
    text += std::string(" makes cells as small as ") + (missed.size() == 1 ? "it" : "the thinnest of them");
    if (level == root.level + refine + 1) return text;
    return text + "; --refine " + std::to_string(refine + 1) + " may do";
}

/// Centre of a leaf, in the model's units.
Vec3 centre_of(std::uint64_t leaf, const Prepared& prepared) {
    const double edge = octree::Octree::edge_of(prepared.tree.level_of(leaf));
    Vec3 at{};
    for (std::size_t j = 0; j < 3; ++j) {
        const double low = gather_bits(leaf >> j) * prepared.tree.finest_edge();
        at[j] = prepared.root.origin[j] + prepared.root.side * (low + 0.5 * edge);
    }
    return at;
}

}  // namespace

void warn_or_refuse(const std::string& text, const MeshOptions& options, const std::string& source,
                    MeshReport& out) {
    if (options.strict) throw Error(ExitCode::kMeshing, source + ": strict: " + text);
    out.warnings.push_back(text);
}

void refuse_flat(const std::optional<std::uint64_t>& flat, const Prepared& prepared,
                 const std::string& source) {
    if (!flat) return;
    throw Error(ExitCode::kInput,
                source + ": a function is 0 throughout a part of space, as around " +
                    place_text(centre_of(*flat, prepared)) +
                    ", which is neither inside nor outside; add a small number to it, or subtract one");
}

void refuse_missed(const std::vector<MissedFeature>& missed, const Root& root, int refine,
                   const std::string& source) {
    if (std::all_of(missed.begin(), missed.end(), [](const MissedFeature& f) { return f.kept; })) return;
    throw Error(ExitCode::kMeshing, source + ": strict: " + describe_missed(missed, root, refine));
}

void refuse_surely_missed(const std::vector<MissedFeature>& missed, const Root& root, int refine,
                          const std::string& source) {
    const double most = 2 * root.cell();
    if (std::any_of(missed.begin(), missed.end(),
                    [most](const MissedFeature& f) { return !f.kept && f.size > most; }))
        refuse_missed(missed, root, refine, source);
}

void report_overlaps(const std::vector<probe::Overlap>& overlaps, const Model& model,
                     const MeshOptions& options, MeshReport& out) {
    constexpr std::size_t kMostLines = 5;
    for (std::size_t k = 0; k < std::min(overlaps.size(), kMostLines); ++k) {
        const probe::Overlap& overlap = overlaps[k];
        const auto name = [&model](std::int32_t region) {
            return "'" + model.regions[static_cast<std::size_t>(region) - 1].name + "'";
        };
        const std::string first = name(overlap.first);
        const std::string second = name(overlap.second);
        const std::string text = "the regions " + first + " and " + second + " overlap, around " +
                                 place_text(overlap.at) + " by " + rounded_text(2 * overlap.depth) +
                                 " or more; what both claim belongs to " + first + "; cut it from " + second +
                                 " if that is meant ('and not'), or move them apart";
        warn_or_refuse(text, options, model.source, out);
    }
    if (overlaps.size() > kMostLines) {
        const std::size_t others = overlaps.size() - kMostLines;
        out.warnings.push_back(
            counted(others, "other pair of regions overlaps", "other pairs of regions overlap"));
    }
}

void report_small_pieces(const Prepared& prepared, const std::vector<double>& points,
                         const FacetBlock& facets, const MeshOptions& options, const std::string& source,
                         MeshReport& out) {
    if (prepared.folded.empty() && out.missed.empty()) return;
    const std::vector<MissedFeature> torn =
        probe::find_torn_pieces(prepared.bound, prepared.tree, points, facets, options.threads, out.missed);
    if (torn.empty()) return;
    for (const MissedFeature& piece : torn) ++(piece.material ? out.loose_pieces : out.closed_hollows);
    const MissedFeature& first = torn.front();
    std::string what = out.loose_pieces > 0 ? counted(out.loose_pieces, "loose piece") : "";
    if (out.closed_hollows > 0)
        what += (what.empty() ? "" : " and ") + counted(out.closed_hollows, "closed hollow");
    const int finest = prepared.root.level + options.refine;
    const int more = std::max(level_to_see(first.thickness, prepared.root), finest + 1) - prepared.root.level;
    warn_or_refuse("the mesh has " + what + " where the model goes on, the first around " +
                       place_text(first.position) + ": parts of something about " +
                       rounded_text(first.thickness) + " thick, which the cells miss beyond; --refine " +
                       std::to_string(more) + ", or smaller cells, would show it",
                   options, source, out);
}

void report_false_facets(const Prepared& prepared, const std::vector<double>& points,
                         const FacetBlock& facets, const MeshOptions& options, const std::string& source,
                         MeshReport& out) {
    const double cell = prepared.root.cell();
    for (const MissedFeature& found : probe::find_false_facets(prepared.bound, prepared.tree, prepared.folded,
                                                               points, facets, options.threads)) {
        const auto is_told = [&](const MissedFeature& other) {
            const double reach = cell + 0.5 * other.size;
            return !other.kept && other.material == found.material &&
                   std::fabs(other.position[0] - found.position[0]) <= reach &&
                   std::fabs(other.position[1] - found.position[1]) <= reach &&
                   std::fabs(other.position[2] - found.position[2]) <= reach;
        };
        if (std::none_of(out.missed.begin(), out.missed.end(), is_told)) out.missed.push_back(found);
    }
    std::stable_sort(out.missed.begin(), out.missed.end(),
                     [](const MissedFeature& a, const MissedFeature& b) { return a.size > b.size; });
    if (options.strict) refuse_missed(out.missed, prepared.root, options.refine, source);
}

void report_cells(const Prepared& prepared, const Extracted& extracted, const Model& model,
                  const MeshOptions& options, MeshReport& out) {
    const Root& root = prepared.root;
    const octree::Octree& tree = prepared.tree;
    out.level = root.level;
    out.cell_size = root.cell();
    out.finest_level = tree.level;
    if (tree.graded) {
        out.leaves.assign(static_cast<std::size_t>(tree.level) + 1, 0);
        for (const std::uint8_t mark : tree.leaf_marks) ++out.leaves[mark & kMarkLevel];
        out.transition_cells = prepared.transition_cells;
    }
    out.root = {root.origin,
                {root.origin[0] + root.side, root.origin[1] + root.side, root.origin[2] + root.side}};
    out.cells_evaluated = tree.cells_evaluated;
    out.cnio_cells = prepared.classification.cnio.size();
    out.snio_cells = out.nio_cells - out.cnio_cells;
    out.refused_splits = extracted.refused;
    out.unresolved = extracted.unresolved;
    out.dropped_features = extracted.troubled;
    out.warnings.insert(out.warnings.begin(), model.warnings.begin(), model.warnings.end());
    if (!out.missed.empty()) out.warnings.push_back(describe_missed(out.missed, root, options.refine));
    if (extracted.troubled > 0) {
        const Vec3 at = centre_of(extracted.first_troubled, prepared);
        out.first_dropped = at;
        const std::string text =
            std::to_string(extracted.troubled) + " of " + std::to_string(out.cnio_cells) +
            " complex cells hold features too fine to be kept exactly, the first around " + place_text(at) +
            "; --refine, or smaller cells, would keep more of them";
        warn_or_refuse(text, options, model.source, out);
    }
}

void report_improvement(const improve::Counters& counters, const MeshOptions& options,
                        const std::string& source, MeshReport& out) {
    out.crumbs = counters.crumbs.count;
    if (out.crumbs > 0) {
        const improve::Point& at = *counters.crumbs.first;
        const std::string text = counted(out.crumbs, "piece that shares no face with the rest was",
                                         "pieces that share no face with the rest were") +
                                 " left out, of " + rounded_text(counters.crumbs.largest, 2) +
                                 " of a cell's volume at most; the first at " + place_text(at);
        warn_or_refuse(text, options, source, out);
    }
    const auto told = [&out](std::uint64_t count, const std::string& which, const std::string& done) {
        if (count == 0) return;
        out.warnings.push_back(counted(count, "node") + which + (count == 1 ? " was " : " were ") + done);
    };
    const std::string distance = rounded_text(options.merge_distance) + " cells";
    out.merged_nodes = counters.block.merged;
    told(out.merged_nodes, " of features closer than " + distance,
         std::string("merged with others, or elements would be slivers; --merge 0 keeps ") +
             (out.merged_nodes == 1 ? "it" : "them") + " apart");
    out.below_min_angle = counters.below_goal;
    if (out.below_min_angle > 0) {
        out.warnings.push_back(counted(out.below_min_angle, "element is", "elements are") +
                               " worse than asked by a smallest angle of " + rounded_text(options.min_angle) +
                               " degrees: " +
                               (options.min_angle < kFewHaveIt
                                    ? "the model is sharper there, or finer than cells; see --quality"
                                    : "few elements have that much at all their edges; see --quality"));
    }
    out.loosened_nodes = counters.loosened;
    told(out.loosened_nodes, " where features are too fine for good elements",
         "moved off the model's surfaces, by " + rounded_text(improve::kMostLoose * options.merge_distance) +
             " cells at most" + "; --merge 0 keeps " + (out.loosened_nodes == 1 ? "it" : "them") +
             " there, smaller cells avoid that");
}

void report_hinges(const features::Hinges& hinges, const std::vector<double>& points,
                   const MeshOptions& options, const std::string& source, MeshReport& out) {
    out.hinge_edges = hinges.edges;
    out.hinge_nodes = hinges.nodes;
    if (!hinges.any()) return;
    std::string by = hinges.edges > 0 ? counted(hinges.edges, "edge") : "";
    if (hinges.nodes > 0) by += (by.empty() ? "" : " and ") + counted(hinges.nodes, "node");
    const double* at = points.data() + 3 * std::size_t{*hinges.first};
    const std::string text = "the skin of the mesh touches itself at " + by + ", the first at " +
                             place_text({at[0], at[1], at[2]}) +
                             ": a wall or a gap is thinner than the cells there, or parts of the model only "
                             "touch; smaller cells, or --refine, may show which";
    warn_or_refuse(text, options, source, out);
}

void report_layers(const std::string& source, MeshReport& out) {
    const LayerFigures& found = out.layers;
    for (const std::string& name : found.unused)
        out.warnings.push_back(source + ": no layers on '" + name +
                               "': none of its facets bounds the regions that get layers; if it lies between "
                               "two regions, name the one that is to have them, too (--layers-on)");
    if (found.facets == 0) return;
    const auto percent = [&found](std::uint64_t facets) {
        return rounded_text(
                   std::ceil(1000.0 * static_cast<double>(facets) / static_cast<double>(found.facets)) / 10) +
               " %";
    };
    if (found.lower + found.bare == 0) return;
    std::string text = source + ": layers are ";
    if (found.lower > 0) text += "lower than asked on " + percent(found.lower);
    if (found.bare > 0) text += (found.lower > 0 ? " and missing on " : "missing on ") + percent(found.bare);
    text += " of the walls' facets";
    if (found.bare > 0) text += ", first near " + place_text(*found.first_bare);
    text += ", where elements behind them would be too flat: as asked they are " + rounded_text(found.asked) +
            " thick together, on edges of " + rounded_text(found.edge) +
            " in the mean; fewer layers, or a smaller --first-layer, need less room";
    out.warnings.push_back(text);
}

void warn_of_empty_regions(const std::vector<std::string>& names, const std::vector<bool>& present,
                           const std::string& source, MeshReport& report) {
    for (std::size_t r = 1; r <= names.size(); ++r) {
        if (r < present.size() && present[r]) continue;
        report.warnings.push_back(source + ": region '" + names[r - 1] +
                                  "' has no elements: it is empty, covered by regions before it, or thinner "
                                  "than the cells");
    }
}

void refuse_unpaired(const std::string& source) {
    throw Error(ExitCode::kMeshing,
                source +
                    ": internal error: faces of the mesh do not fit together; please report the model "
                    "(--no-templates, or another --level, may mesh it)");
}

void refuse_empty(const std::string& source) {
    throw Error(ExitCode::kInput, source +
                                      ": the solid is empty, or thinner than the cells everywhere; "
                                      "if it is not empty, use smaller cells, or --refine");
}

}  // namespace mortise::pipeline
