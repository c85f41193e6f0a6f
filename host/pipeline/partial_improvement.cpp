#include "host/pipeline/partial_improvement.hpp"

#include <algorithm>
#include <string>

#include "host/common/parallel.hpp"
#include "host/common/sort_unique.hpp"
#include "host/pipeline/findings.hpp"
#include "host/pipeline/memory_limit.hpp"

namespace mortise::pipeline {
namespace {

/// How far around poor elements, in cells, the scope reaches: zones seldom grow by more than a few cells. If
/// they do, it is made wider.
constexpr int kFirstReach = 4;
constexpr int kLastReach = 64;
/// Bytes that improvement takes for each element of the scope, measured.
constexpr std::uint64_t kBytesPerElement = 150;
constexpr std::size_t kChunk = 65536;
constexpr std::uint8_t kInScope = 1, kBeyond = 2;

struct Selection {
    Mesh mesh;                 ///< with its own node numbers
    std::vector<NodeId> node;  ///< their numbers in the whole mesh, ascending
    improve::ElementNumbers element;
    std::vector<std::uint32_t> facet;
    std::vector<std::uint8_t> is_open;  ///< per node: elements around it are not in the selection
};

struct Place {
    NodeId node;
    std::array<double, 3> point;
    bool operator<(const Place& other) const { return node < other.node; }
};

class Selector {
  public:
    Selector(Parts& parts, const improve::Scope& scope, const MeshOptions& options, Stages& stages)
        : parts_(parts), scope_(scope), options_(options), stages_(stages) {}

    Selection select(const FacetBlock& facets) {
        for (std::size_t p = 0; p < parts_.count(); ++p) {
            const assembly::MortonRange& range = parts_.range(p);
            if (scope_.touches(range.begin, range.end)) {
                take(parts_.make(p, kProgress, kProgress));
            } else {
                skip(p);
            }
        }
        stages_.begin("select", kProgress);
        number_nodes();
        take_facets(facets);
        stages_.end(0);
        return std::move(result_);
    }

  private:
    static constexpr double kProgress = 0.5;

    void take(const Part& part) {
        stages_.begin("select", kProgress);
        const improve::ElementNumbers chosen = scope_.select(part.mesh);
        std::vector<std::uint8_t> use(part.mesh.node_count(), 0);
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            const auto per_element = static_cast<std::size_t>(kElementNodes[t]);
            const ElementBlock& from = part.mesh.elements[t];
            ElementBlock& to = result_.mesh.elements[t];
            auto next = chosen[t].begin();
            for (std::size_t i = 0; i < from.size(); ++i) {
                const bool is_chosen = next != chosen[t].end() && *next == i;
                const NodeId* node = from.nodes.data() + i * per_element;
                for (std::size_t k = 0; k < per_element; ++k) use[node[k]] |= is_chosen ? kInScope : kBeyond;
                if (!is_chosen) continue;
                ++next;
                for (std::size_t k = 0; k < per_element; ++k) to.nodes.push_back(part.number(node[k]));
                to.region.push_back(from.region[i]);
                to.kind.push_back(from.kind[i]);
                result_.element[t].push_back(static_cast<std::uint32_t>(part.first_element[t] + i));
            }
        }
        for (NodeId i = 0; i < use.size(); ++i) {
            if ((use[i] & kInScope) != 0) {
                const double* point = part.mesh.points.data() + 3 * std::size_t{i};
                places_.push_back({part.number(i), {point[0], point[1], point[2]}});
            }
            const bool is_shared = i >= part.own || part.is_shared[i] != 0;
            if ((use[i] & kBeyond) != 0 && (is_shared || (use[i] & kInScope) != 0))
                open_.push_back(part.number(i));
        }
        sort_unique(open_);
        check_memory(memory_now() + kBytesPerElement * result_.mesh.element_count(),
                     "the elements around poor ones", options_);
        stages_.end(part.mesh.element_count());
    }

    /// No element of this part is in the scope: all its nodes are open.
    void skip(std::size_t p) {
        skipped_.push_back(parts_.own_nodes(p));
        const std::vector<NodeId>& foreign = parts_.foreign_nodes(p);
        open_.insert(open_.end(), foreign.begin(), foreign.end());
        sort_unique(open_);
    }

    void number_nodes() {
        std::sort(places_.begin(), places_.end());
        for (const Place& place : places_) {
            if (!result_.node.empty() && result_.node.back() == place.node) continue;
            result_.node.push_back(place.node);
            result_.mesh.points.insert(result_.mesh.points.end(), place.point.begin(), place.point.end());
        }
        places_ = {};
        for (ElementBlock& block : result_.mesh.elements) {
            parallel_chunks(block.nodes.size(), kChunk, options_.threads,
                            [&](std::size_t begin, std::size_t end, int) {
                                for (std::size_t i = begin; i < end; ++i)
                                    block.nodes[i] = find(block.nodes[i]);
                            });
        }
        result_.is_open.resize(result_.node.size());
        for (std::size_t i = 0; i < result_.node.size(); ++i) {
            const NodeId node = result_.node[i];
            result_.is_open[i] = std::binary_search(open_.begin(), open_.end(), node) ||
                                 std::any_of(skipped_.begin(), skipped_.end(), [node](const auto& range) {
                                     return node >= range.first && node < range.second;
                                 });
        }
        open_ = {};
    }

    /// Place of a node in the selection; its size: it is not there.
    NodeId find(NodeId node) const {
        const auto found = std::lower_bound(result_.node.begin(), result_.node.end(), node);
        if (found == result_.node.end() || *found != node) return static_cast<NodeId>(result_.node.size());
        return static_cast<NodeId>(found - result_.node.begin());
    }

    void take_facets(const FacetBlock& facets) {
        FacetBlock& to = result_.mesh.facets;
        for (std::size_t f = 0; f < facets.size(); ++f) {
            std::array<NodeId, 4> node;
            bool is_there = true;
            for (std::size_t k = 0; k < 4 && is_there; ++k) {
                node[k] = find(facets.nodes[4 * f + k]);
                is_there = node[k] < result_.node.size();
            }
            if (!is_there) continue;
            to.nodes.insert(to.nodes.end(), node.begin(), node.end());
            to.surface.push_back(facets.surface[f]);
            to.inside.push_back(facets.inside[f]);
            to.outside.push_back(facets.outside[f]);
            result_.facet.push_back(static_cast<std::uint32_t>(f));
        }
    }

    Parts& parts_;
    const improve::Scope& scope_;
    const MeshOptions& options_;
    Stages& stages_;
    Selection result_;
    std::vector<Place> places_;
    std::vector<NodeId> open_;                        ///< ascending
    std::vector<std::pair<NodeId, NodeId>> skipped_;  ///< ranges of nodes, all open
};

/// Of `numbers`, those that the trace does not hold any more.
std::vector<std::uint32_t> missing(const std::vector<std::uint32_t>& numbers,
                                   const std::vector<std::uint32_t>& trace) {
    std::vector<std::uint32_t> result;
    std::size_t next = 0;
    for (std::uint32_t i = 0; i < numbers.size(); ++i) {
        if (next < trace.size() && trace[next] == i) {
            ++next;
        } else {
            result.push_back(numbers[i]);
        }
    }
    return result;
}

std::size_t first_new(const std::vector<std::uint32_t>& trace) {
    return static_cast<std::size_t>(std::find(trace.begin(), trace.end(), improve::kNone) - trace.begin());
}

/// Facets that stay, then those of the improved selection that are new.
FacetBlock join_facets(const FacetBlock& old, const std::vector<std::uint32_t>& gone,
                       const FacetBlock& improved, std::size_t first, const std::vector<NodeId>& number) {
    FacetBlock result;
    const auto add = [&result](const FacetBlock& from, std::size_t f) {
        result.surface.push_back(from.surface[f]);
        result.inside.push_back(from.inside[f]);
        result.outside.push_back(from.outside[f]);
    };
    auto next = gone.begin();
    for (std::size_t f = 0; f < old.size(); ++f) {
        if (next != gone.end() && *next == f) {
            ++next;
            continue;
        }
        for (std::size_t k = 0; k < 4; ++k) result.nodes.push_back(old.nodes[4 * f + k]);
        add(old, f);
    }
    for (std::size_t f = first; f < improved.size(); ++f) {
        for (std::size_t k = 0; k < 4; ++k) result.nodes.push_back(number[improved.nodes[4 * f + k]]);
        add(improved, f);
    }
    return result;
}

Changes describe(const Selection& selection, Mesh improved, const improve::Trace& trace, Changes changes) {
    std::vector<std::uint32_t> kept;
    auto next = static_cast<NodeId>(changes.old_nodes);
    for (const std::uint32_t slot : trace.node) {
        changes.placed.push_back(slot == improve::kNone ? next++ : selection.node[slot]);
        if (slot != improve::kNone) kept.push_back(slot);
    }
    changes.gone = missing(selection.node, kept);
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        changes.taken[t] = missing(selection.element[t], trace.element[t]);
        ElementBlock& block = improved.elements[t];
        const auto first = static_cast<std::ptrdiff_t>(first_new(trace.element[t]));
        block.nodes.erase(block.nodes.begin(), block.nodes.begin() + first * kElementNodes[t]);
        block.region.erase(block.region.begin(), block.region.begin() + first);
        block.kind.erase(block.kind.begin(), block.kind.begin() + first);
        block.nodes.shrink_to_fit();
    }
    changes.facets = join_facets(changes.facets, missing(selection.facet, trace.facet), improved.facets,
                                 first_new(trace.facet), changes.placed);
    improved.facets = {};
    changes.added = std::move(improved);
    return changes;
}

}  // namespace

Changes no_changes(const Parts& parts, FacetBlock facets) {
    Changes changes;
    changes.old_nodes = parts.totals().nodes;
    changes.facets = std::move(facets);
    return changes;
}

Changes improve_parts(device::Device& device, Parts& parts, improve::Scope& scope, FacetBlock facets,
                      const Prepared& prepared, const MeshOptions& options, const std::string& source,
                      Stages& stages, MeshReport& out) {
    Changes changes = no_changes(parts, std::move(facets));
    for (int reach = kFirstReach; !scope.is_empty(); reach *= 2) {
        scope.spread(reach);
        Selection selection = Selector(parts, scope, options, stages).select(changes.facets);
        improve::Options improve_options = improvement_options(prepared, options);
        reposition_nodes(device, prepared, options, improve_options.held, stages, selection.mesh);
        stages.begin("improve", 0.55);
        improve_options.is_open = &selection.is_open;
        improve::Counters counters;
        improve::Trace trace;
        Mesh improved =
            improve::improve(std::move(selection.mesh), prepared.bound, improve_options, &counters, &trace);
        if (!counters.reached_open && improve_options.goal > improve::kGoodQuality) {
            improved = improve::raise(std::move(improved), prepared.bound, improve_options, counters, &trace);
        }
        stages.end(counters.zone_elements);
        if (!counters.reached_open) {
            report_improvement(counters, options, source, out);
            return describe(selection, std::move(improved), trace, std::move(changes));
        }
        if (reach >= kLastReach) {
            throw Error(ExitCode::kMeshing,
                        "poor elements reach too far to be improved in parts; leave --memory out, or give "
                        "--no-improve");
        }
    }
    return changes;
}

}  // namespace mortise::pipeline
