// The order of the stages for meshes that never lie in memory whole.
//
// Parts of the Morton order are made twice: once to count, to number and to find what needs improvement, once
// to hand them on; those near poor elements also between the two. What is kept all the time grows with the
// boundary: the tree, the facets, the nodes between parts and the elements around poor ones.
#include <malloc.h>

#include <algorithm>
#include <deque>
#include <optional>

#include "host/common/element_block.hpp"
#include "host/common/sort_unique.hpp"
#include "host/features/features.hpp"
#include "host/jacobian/jacobian.hpp"
#include "host/pipeline/check_options.hpp"
#include "host/pipeline/findings.hpp"
#include "host/pipeline/memory_limit.hpp"
#include "host/pipeline/names.hpp"
#include "host/pipeline/partial_improvement.hpp"
#include "host/pipeline/stream.hpp"
#include "host/quality/face_pairs.hpp"

namespace mortise::pipeline {
namespace {

constexpr std::uint64_t kUsualMemory = std::uint64_t{4} << 30;
/// Of what is left beside the tree, a part may take one in this many; the rest is for improvement.
constexpr std::uint64_t kShare = 4;
constexpr std::uint64_t kSmallestPart = std::uint64_t{32} << 20;
/// Facets, their nodes and what is known of the nodes between parts, by cells at the boundary: 94 for a ball,
/// 135 for a box of two regions.
constexpr std::uint64_t kSkinBytes = 120;
constexpr double kSurveyed = 0.5, kImproved = 0.6;  // progress

void refuse(bool wrong, const char* option) {
    if (!wrong) return;
    throw Error(ExitCode::kUsage, std::string("a mesh that is made in parts (--memory) cannot have ") +
                                      option + "; leave one of the two out");
}

void check_stream_options(const MeshOptions& options) {
    refuse(options.tetrahedra, "tetrahedra only (--elements tet)");
    refuse(options.second_order, "second order (--order 2)");
    refuse(options.layers.count > 0, "layers (--layers)");
    refuse(options.quality, "a quality report (--quality)");
    refuse(!options.periodic.empty(), "periodic faces (--periodic)");
}

/// The nodes on facets: what features are found from. A mesh of its own, without elements.
struct Skin {
    Mesh mesh;
    std::vector<NodeId> node;  ///< numbers in the whole mesh, ascending
};

class Streamer {
  public:
    Streamer(device::Device& device, Prepared& prepared, const MeshOptions& options, Parts& parts,
             Stages& stages)
        : device_(device), prepared_(prepared), options_(options), parts_(parts), stages_(stages) {}

    void run(const Model& model, MeshSink& sink, MeshReport& out) {
        survey();
        if (parts_.totals().nodes == 0) refuse_empty(model.source);
        find_changes(model.source, out);
        make_skin();
        begin(model.source, sink, out);
        for (std::size_t p = 0; p < parts_.count(); ++p) hand_on(p, sink);
        hand_on_added(sink);
        if (unpaired_ != quality::FaceSum{}) refuse_unpaired(model.source);
        warn_of_empty_regions(prepared_.compiled.region_names, present_, model.source, out);
    }

  private:
    /// Makes all parts once: their numbers, all facets, and where poor elements are.
    void survey() {
        if (options_.improve)
            scope_.emplace(prepared_.bound, prepared_.tree.poles, prepared_.tree.level,
                           improvement_options(prepared_, options_).goal, options_.threads);
        for (std::size_t p = 0; p < parts_.count(); ++p) {
            const double done =
                kSurveyed * (0.6 + 0.4 * static_cast<double>(p) / static_cast<double>(parts_.count()));
            const Part part = parts_.make(p, done, done);
            const FacetBlock& facets = part.mesh.facets;
            std::vector<NodeId> on_facets = facets.nodes;
            sort_unique(on_facets);
            for (const NodeId local : on_facets) {
                const double* point = part.mesh.points.data() + 3 * std::size_t{local};
                outer_.push_back({part.number(local), {point[0], point[1], point[2]}});
            }
            for (const NodeId local : facets.nodes) facets_.nodes.push_back(part.number(local));
            append(facets_.surface, facets.surface);
            append(facets_.inside, facets.inside);
            append(facets_.outside, facets.outside);
            if (!scope_) continue;
            stages_.begin("judge", done);
            scope_->add_poor(part.mesh);
            stages_.end(part.mesh.element_count());
        }
        malloc_trim(0);
    }

    void find_changes(const std::string& source, MeshReport& out) {
        changes_ = scope_ ? improve_parts(device_, parts_, *scope_, std::move(facets_), prepared_, options_,
                                          source, stages_, out)
                          : no_changes(parts_, std::move(facets_));
        scope_.reset();
        malloc_trim(0);
    }

    void make_skin() {
        skin_.node = changes_.facets.nodes;
        sort_unique(skin_.node);
        std::sort(outer_.begin(), outer_.end());
        auto outer = outer_.begin();
        auto placed = changes_.placed.begin();
        for (const NodeId node : skin_.node) {
            while (outer != outer_.end() && outer->node < node) ++outer;
            placed = std::lower_bound(placed, changes_.placed.end(), node);
            const double* point =
                outer != outer_.end() && outer->node == node ? outer->point.data() : nullptr;
            if (placed != changes_.placed.end() && *placed == node)
                point = changes_.added.points.data() + 3 * (placed - changes_.placed.begin());
            if (point == nullptr)
                throw Error(ExitCode::kMeshing, "internal error: a facet's node is missing");
            skin_.mesh.points.insert(skin_.mesh.points.end(), point, point + 3);
        }
        outer_ = {};
        skin_.mesh.facets = changes_.facets;
        for (NodeId& node : skin_.mesh.facets.nodes) {
            node = static_cast<NodeId>(std::lower_bound(skin_.node.begin(), skin_.node.end(), node) -
                                       skin_.node.begin());
        }
        for (NodeId& node : changes_.facets.nodes) node = changes_.final_number(node);
    }

    void begin(const std::string& source, MeshSink& sink, MeshReport& out) {
        stages_.begin("features", kImproved);
        const std::vector<std::uint32_t> facet_surface = skin_.mesh.facets.surface;
        name_surfaces(prepared_.compiled, prepared_.bound, options_.threads, skin_.mesh);
        out.features =
            features::find_features(skin_.mesh, facet_surface, prepared_.bound, prepared_.leaves.level);
        dimension_ = std::move(out.features.model_dimension);
        out.features.model_dimension = {};
        report_hinges(features::find_hinges(skin_.mesh.facets, skin_.mesh.node_count(), options_.threads),
                      skin_.mesh.points, options_, source, out);
        report_small_pieces(prepared_, skin_.mesh.points, skin_.mesh.facets, options_, source, out);
        report_false_facets(prepared_, skin_.mesh.points, skin_.mesh.facets, options_, source, out);
        const auto number = [this](NodeId local) { return changes_.final_number(skin_.node[local]); };
        for (FeatureCurve& curve : out.features.curves) {
            for (NodeId& node : curve.nodes) node = number(node);
        }
        for (FeatureCorner& corner : out.features.corners) corner.node = number(corner.node);
        stages_.end(facet_surface.size());
        Mesh outline;
        outline.facets = std::move(changes_.facets);
        outline.facets.surface = skin_.mesh.facets.surface;
        outline.region_names = prepared_.compiled.region_names;
        outline.surface_names = skin_.mesh.surface_names;
        skin_.mesh = {};
        unpaired_ = quality::sum_of_outer_facets(outline.facets, options_.threads);
        MeshTotals totals = parts_.totals();
        totals.nodes = changes_.final_nodes();
        for (std::size_t t = 0; t < kElementTypes; ++t)
            totals.elements[t] += changes_.added.elements[t].size() - changes_.taken[t].size();
        present_.assign(outline.region_names.size() + 1, false);
        stages_.begin("write", kImproved);
        sink.begin(totals, outline);
        stages_.end(0);
    }

    void hand_on(std::size_t p, MeshSink& sink) {
        const double share = (1 - kImproved) / static_cast<double>(parts_.count());
        const double done = kImproved + share * static_cast<double>(p);
        Part part = parts_.make(p, done, done + 0.5 * share);
        part.mesh.facets = {};
        place_nodes(part);
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            drop_taken(changes_.taken[t], part.first_element[t], static_cast<std::size_t>(kElementNodes[t]),
                       part.mesh.elements[t]);
        }
        const std::vector<float> jacobians = jacobians_of(part.mesh);
        std::vector<NodeId> number(part.mesh.node_count());
        auto gone = std::lower_bound(changes_.gone.begin(), changes_.gone.end(), part.first);
        std::vector<double>& points = part.mesh.points;
        std::size_t kept = 0;
        auto skin = std::lower_bound(skin_.node.begin(), skin_.node.end(), part.first);
        for (NodeId i = 0; i < part.own; ++i) {
            const NodeId node = part.first + i;
            while (gone != changes_.gone.end() && *gone < node) ++gone;
            if (gone != changes_.gone.end() && *gone == node) continue;
            number[i] = node - static_cast<NodeId>(gone - changes_.gone.begin());
            for (std::size_t j = 0; j < 3; ++j) points[3 * kept + j] = points[3 * std::size_t{i} + j];
            ++kept;
            while (skin != skin_.node.end() && *skin < node) ++skin;
            part.mesh.model_dimension.push_back(dimension_at(skin, node));
        }
        for (std::size_t i = part.own; i < number.size(); ++i)
            number[i] = changes_.final_number(part.foreign[i - part.own]);
        points.resize(3 * kept);
        renumber(number, part.mesh);
        send(part.mesh, jacobians, done + 0.5 * share, sink);
    }

    /// The new nodes, and the elements that improvement has made.
    void hand_on_added(MeshSink& sink) {
        Mesh& added = changes_.added;
        if (added.points.empty()) return;
        const std::vector<float> jacobians = jacobians_of(added);
        std::vector<NodeId> number = changes_.placed;
        for (NodeId& node : number) node = changes_.final_number(node);
        const auto first_new = std::lower_bound(changes_.placed.begin(), changes_.placed.end(),
                                                static_cast<NodeId>(changes_.old_nodes));
        added.points.erase(added.points.begin(),
                           added.points.begin() + 3 * (first_new - changes_.placed.begin()));
        auto skin = skin_.node.begin();
        for (auto node = first_new; node != changes_.placed.end(); ++node) {
            skin = std::lower_bound(skin, skin_.node.end(), *node);
            added.model_dimension.push_back(dimension_at(skin, *node));
        }
        renumber(number, added);
        send(added, jacobians, 1, sink);
    }

    std::uint8_t dimension_at(std::vector<NodeId>::const_iterator skin, NodeId node) const {
        constexpr std::uint8_t kRegion = 3;
        if (skin == skin_.node.end() || *skin != node) return kRegion;
        return dimension_[static_cast<std::size_t>(skin - skin_.node.begin())];
    }

    /// Moves the part's nodes to where improvement has left them.
    void place_nodes(Part& part) const {
        const auto& placed = changes_.placed;
        const auto place = [&](std::vector<NodeId>::const_iterator from, std::size_t local) {
            const double* point = changes_.added.points.data() + 3 * (from - placed.begin());
            std::copy(point, point + 3, part.mesh.points.begin() + 3 * static_cast<std::ptrdiff_t>(local));
        };
        auto at = std::lower_bound(placed.begin(), placed.end(), part.first);
        for (; at != placed.end() && *at - part.first < part.own; ++at) place(at, *at - part.first);
        for (std::size_t i = 0; i < part.foreign.size(); ++i) {
            at = std::lower_bound(placed.begin(), placed.end(), part.foreign[i]);
            if (at != placed.end() && *at == part.foreign[i]) place(at, part.own + i);
        }
    }

    static void drop_taken(const std::vector<std::uint32_t>& taken, std::uint64_t first,
                           std::size_t per_element, ElementBlock& block) {
        auto next = std::lower_bound(taken.begin(), taken.end(), first);
        if (next == taken.end() || *next >= first + block.size()) return;
        keep_elements(block, per_element, [&](std::size_t i) {
            const bool is_taken = next != taken.end() && *next == first + i;
            if (is_taken) ++next;
            return !is_taken;
        });
    }

    static void renumber(const std::vector<NodeId>& number, Mesh& mesh) {
        for (ElementBlock& block : mesh.elements) {
            for (NodeId& node : block.nodes) node = number[node];
        }
    }

    std::vector<float> jacobians_of(const Mesh& mesh) {
        stages_.begin("jacobians", kImproved);
        std::vector<float> result = jacobian::scaled_jacobians(
            device_, mesh, method_.value_or(jacobian::usual_method(mesh.element_count())), options_.threads);
        stages_.end(mesh.element_count());
        return result;
    }

    void send(const Mesh& part, const std::vector<float>& jacobians, double progress, MeshSink& sink) {
        for (const ElementBlock& block : part.elements) {
            for (const std::uint16_t region : block.region) present_[region] = true;
        }
        stages_.begin("faces", progress);
        unpaired_ -= quality::sum_of_faces(part, options_.threads);
        stages_.end(part.element_count());
        stages_.begin("write", progress);
        sink.add(part, jacobians);
        stages_.end(part.element_count());
    }

    template <class T>
    static void append(std::vector<T>& to, const std::vector<T>& from) {
        to.insert(to.end(), from.begin(), from.end());
    }

    struct OuterNode {
        NodeId node;
        std::array<double, 3> point;
        bool operator<(const OuterNode& other) const { return node < other.node; }
    };

    device::Device& device_;
    Prepared& prepared_;
    const MeshOptions& options_;
    Parts& parts_;
    Stages& stages_;
    const std::optional<jacobian::Method> method_ = jacobian::wanted_method();
    std::optional<improve::Scope> scope_;
    std::deque<OuterNode> outer_;  ///< nodes on facets before improvement
    FacetBlock facets_;
    Changes changes_;
    Skin skin_;
    std::vector<std::uint8_t> dimension_;  ///< per node of the skin
    std::vector<bool> present_;            ///< by region
    quality::FaceSum unpaired_;            ///< outer facets less the faces of elements (face_pairs.hpp)
};

}  // namespace

void stream(const std::function<device::Device&()>& open_device, const Model& model, const MeshOptions& given,
            MeshSink& sink, MeshReport& out) {
    MeshOptions options = given;
    if (options.memory == 0) options.memory = kUsualMemory;
    check_options(options);
    check_stream_options(options);
    Stages stages(options, out);
    Prepared prepared = prepare(open_device, model, options, stages, out);
    if (!prepared.periodic.empty()) {
        out.warnings.push_back(model.source +
                               ": periodic faces are not made to match in meshes made part by part");
    }
    refuse(prepared.tree.graded, "cells of several sizes");
    const device::KernelsEnd kernels_end(open_device());
    octree::share_memory(open_device(), prepared.tree, prepared.on_device);
    malloc_trim(0);
    const std::uint64_t used = memory_now();
    const std::uint64_t skin = kSkinBytes * prepared.tree.nio.size();
    check_memory(used + skin + kShare * kSmallestPart, kBoundaryCells, options);
    Parts parts(open_device(), options, prepared, stages, (options.memory - used) / kShare,
                options.pieces > 1 ? static_cast<std::size_t>(options.pieces) : 0);
    Streamer(open_device(), prepared, options, parts, stages).run(model, sink, out);
    report_cells(prepared, parts.extracted(), model, options, out);
}

}  // namespace mortise::pipeline
