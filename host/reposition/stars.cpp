#include "host/reposition/stars.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "host/common/good_elements.hpp"
#include "host/common/index_set.hpp"
#include "host/common/large_array.hpp"
#include "host/common/lattice_rounding.hpp"
#include "host/common/parallel.hpp"
#include "host/common/parallel_sort.hpp"
#include "host/reposition/near_cubes.hpp"

namespace mortise::reposition {
namespace {

constexpr std::size_t kStarChunk = 4096;
constexpr std::uint32_t kStays = kFreeNode - 1;  ///< instead of a surface: the node may not move
/// Quality, squared, below which an element is poor. Improvement computes it in another way: what is poor
/// here must be so there, since a part of a mesh holds what is around the elements that are poor there.
constexpr double kCertainlyPoor = 1 - 1e-9;

bool is_kind(const Mesh& mesh, const ElementNumber& e, ElementKind kind) {
    return mesh.elements[e.type].kind[e.index] == static_cast<std::uint8_t>(kind);
}

/// What look(list, type, begin, end) adds to lists for runs of all elements, in their order.
template <class Item, class Look>
std::vector<Item> collect_runs(const Mesh& mesh, int threads, const Look& look) {
    std::vector<Item> all;
    for (std::uint32_t t = 0; t < kElementTypes; ++t) {
        const std::size_t count = mesh.elements[t].size();
        std::vector<std::vector<Item>> found(chunk_count(count, kStarChunk));
        parallel_chunks(count, kStarChunk, threads, [&](std::size_t begin, std::size_t end, int) {
            look(found[begin / kStarChunk], t, begin, end);
        });
        append_lists(found, threads, all);
    }
    return all;
}

/// What look(list, element) adds to lists for all elements, in their order.
template <class Item, class Look>
std::vector<Item> collect(const Mesh& mesh, int threads, const Look& look) {
    return collect_runs<Item>(mesh, threads,
                              [&](auto& list, std::uint32_t type, std::size_t begin, std::size_t end) {
                                  for (std::size_t i = begin; i < end; ++i)
                                      look(list, ElementNumber{type, static_cast<std::uint32_t>(i)});
                              });
}

/// Visits elements of one kind, which may be few, among those of a type from `begin` to `end`.
template <class Visit>
void for_kind(const Mesh& mesh, std::uint32_t type, ElementKind kind, std::size_t begin, std::size_t end,
              const Visit& visit) {
    const std::uint8_t* const kinds = mesh.elements[type].kind.data();
    for (std::size_t i = begin; i < end; ++i) {
        const void* const next = std::memchr(kinds + i, static_cast<int>(kind), end - i);
        if (next == nullptr) return;
        i = static_cast<std::size_t>(static_cast<const std::uint8_t*>(next) - kinds);
        visit(i);
    }
}

/// What look(list, element) adds for these.
template <class Item, class Look>
std::vector<Item> collect(const Mesh& mesh, ElementKind kind, int threads, const Look& look) {
    return collect_runs<Item>(mesh, threads,
                              [&](auto& list, std::uint32_t type, std::size_t begin, std::size_t end) {
                                  for_kind(mesh, type, kind, begin, end, [&](std::size_t i) {
                                      look(list, ElementNumber{type, static_cast<std::uint32_t>(i)});
                                  });
                              });
}

/// An element or a facet at a movable node, both by their places.
struct Incidence {
    std::uint32_t node;
    std::uint32_t type;  ///< of a StarElement
    std::uint32_t index;
    bool operator<(const Incidence& other) const {
        if (node != other.node) return node < other.node;
        return type != other.type ? type < other.type : index < other.index;
    }
};

IndexSet nodes_of(const Mesh& mesh, const std::vector<ElementNumber>& elements) {
    IndexSet nodes(mesh.node_count());
    for (const ElementNumber& e : elements) {
        for (std::size_t k = 0; k < e.count(); ++k) nodes.insert(e.nodes(mesh)[k]);
    }
    nodes.number();
    return nodes;
}

class Gatherer {
  public:
    Gatherer(const Mesh& mesh, const Frame& frame, const Options& options, const PoorElements& poor)
        : mesh_(mesh),
          frame_(frame),
          options_(options),
          poor_(poor),
          movable_(nodes_of(mesh, poor.apart)),
          surface_(movable_.size(), kFreeNode),
          used_(mesh.node_count()) {}

    Stars gather() {
        add_facets();
        add_elements();
        parallel_sort(incidences_, options_.threads);
        choose();
        number();
        return std::move(stars_);
    }

  private:
    std::uint32_t place(NodeId node) const { return static_cast<std::uint32_t>(movable_.place(node)); }

    void add_facets() {
        const FacetBlock& facets = mesh_.facets;
        for (std::size_t i = 0; i < facets.size(); ++i) {
            const FacetNodes nodes = facets.facet(i);
            for (const NodeId node : nodes) {
                if (!movable_.holds(node)) continue;
                std::uint32_t& surface = surface_[place(node)];
                const bool is_held = options_.held != nullptr && (*options_.held)[facets.surface[i]] != 0;
                surface = !is_held && (surface == kFreeNode || surface == facets.surface[i])
                              ? facets.surface[i]
                              : kStays;
                incidences_.push_back({place(node), nodes.size() == 3 ? kStarTriangle : kStarQuadrilateral,
                                       static_cast<std::uint32_t>(i)});
            }
        }
    }

    void add_elements() {
        const NearCubes near(mesh_, frame_, movable_, options_);
        const std::vector<Incidence> found = collect_runs<Incidence>(
            mesh_, options_.threads, [&](auto& list, std::uint32_t type, std::size_t begin, std::size_t end) {
                const auto count = static_cast<std::size_t>(kElementNodes[type]);
                const NodeId* const nodes = mesh_.elements[type].nodes.data();
                const auto look_at = [&](std::size_t i) {
                    const NodeId* const node = nodes + i * count;
                    for (std::size_t k = 0; k < count; ++k) {
                        if (movable_.holds(node[k]))
                            list.push_back({place(node[k]), type, static_cast<std::uint32_t>(i)});
                    }
                };
                if (type == 0) {
                    near.for_near(begin, end, look_at);
                } else {
                    for (std::size_t i = begin; i < end; ++i) look_at(i);
                }
            });
        for (const Incidence& i : found) {
            if (is_kind(mesh_, {i.type, i.index}, ElementKind::kTransition)) surface_[i.node] = kStays;
        }
        incidences_.insert(incidences_.end(), found.begin(), found.end());
    }

    /// Leaves those out that may not move.
    void choose() {
        const std::vector<std::uint32_t> node = movable_.members();
        for (std::size_t begin = 0, end = 0; begin < incidences_.size(); begin = end) {
            const std::uint32_t at = incidences_[begin].node;
            MovableNode movable{};
            while (end < incidences_.size() && incidences_[end].node == at)
                ++(incidences_[end++].type >= kStarTriangle ? movable.facets : movable.elements);
            if (surface_[at] == kStays || movable.elements > kMostStarElements) continue;
            movable.node = node[at];
            movable.first = static_cast<std::uint32_t>(stars_.star.size());
            movable.surface = surface_[at];
            stars_.movable.push_back(movable);
            stars_.is_hopeless.push_back(0);
            for (std::size_t i = begin; i < end; ++i) add_to_star(incidences_[i]);
        }
    }

    void add_to_star(const Incidence& i) {
        StarElement e{};
        e.type = i.type;
        const auto& hopeless = poor_.at_complex;
        if (std::binary_search(hopeless.begin(), hopeless.end(), ElementNumber{i.type, i.index}))
            stars_.is_hopeless.back() = 1;
        const NodeId* const node = i.type >= kStarTriangle
                                       ? mesh_.facets.nodes.data() + 4 * std::size_t{i.index}
                                       : ElementNumber{i.type, i.index}.nodes(mesh_);
        for (u32 k = 0; k < kStarNodes[e.type]; ++k) {
            e.node[k] = node[k];
            used_.insert(node[k]);
        }
        stars_.star.push_back(e);
        stars_.index.push_back(i.index);
    }

    /// From nodes of the mesh to places in the stars' own list.
    void number() {
        used_.number();
        stars_.node = used_.members();
        stars_.points.resize(3 * stars_.node.size());
        for (std::size_t i = 0; i < stars_.node.size(); ++i)
            frame_.to_lattice(mesh_, stars_.node[i], stars_.points.data() + 3 * i);
        stars_.movable_at.assign(stars_.node.size(), kNotMovable);
        const auto local = [this](u32 n) { return static_cast<std::uint32_t>(used_.place(n)); };
        for (StarElement& e : stars_.star) {
            for (u32 k = 0; k < kStarNodes[e.type]; ++k) e.node[k] = local(e.node[k]);
        }
        for (std::size_t i = 0; i < stars_.movable.size(); ++i) {
            stars_.movable[i].node = local(stars_.movable[i].node);
            stars_.movable_at[stars_.movable[i].node] = static_cast<std::uint32_t>(i);
        }
    }

    const Mesh& mesh_;
    const Frame& frame_;
    const Options& options_;
    const PoorElements& poor_;
    const IndexSet movable_;
    std::vector<std::uint32_t> surface_;  ///< per movable node: of its facets, kFreeNode or kStays
    IndexSet used_;                       ///< nodes of stars
    std::vector<Incidence> incidences_;
    Stars stars_;
};

}  // namespace

std::size_t ElementNumber::count() const { return static_cast<std::size_t>(kElementNodes[type]); }

const NodeId* ElementNumber::nodes(const Mesh& mesh) const {
    return mesh.elements[type].nodes.data() + std::size_t{index} * count();
}

void Frame::to_lattice(const Mesh& mesh, NodeId node, double* local) const {
    const double* const point = mesh.points.data() + 3 * std::size_t{node};
    for (std::size_t j = 0; j < 3; ++j) local[j] = round_to_whole((point[j] - origin[j]) * steps) * per_unit;
}

void Frame::to_model(const double* local, double* model) const {
    for (std::size_t j = 0; j < 3; ++j) model[j] = origin[j] + cell * std::ldexp(local[j], level);
}

Frame make_frame(const tape::BoundModel& model, const Options& options) {
    Frame frame{};
    frame.origin = {model.origin[0], model.origin[1], model.origin[2]};
    frame.cell = std::ldexp(model.side, -options.level);
    frame.level = options.level;
    frame.steps = kCellUnits / frame.cell;
    frame.scale.cell = std::ldexp(1.0, -options.level);
    const double shortest = kRepositionShortestEdge * frame.scale.cell;
    frame.scale.shortest = options.is_uniform() ? shortest * shortest : 0;
    frame.scale.units = std::ldexp(1.0, kCellUnitBits + options.level);
    frame.per_unit = 1 / frame.scale.units;
    return frame;
}

bool is_poor(const Mesh& mesh, const Frame& frame, const ElementNumber& e) {
    double p[8][3];
    for (std::size_t k = 0; k < e.count(); ++k) frame.to_lattice(mesh, e.nodes(mesh)[k], p[k]);
    return repositioned_quality(e.type, -1, p, kRepositionJacobianScale, frame.scale.shortest,
                                kCertainlyPoor) < kCertainlyPoor;
}

PoorElements find_poor(const Mesh& mesh, const Frame& frame, int threads) {
    PoorElements result;
    GoodElementsFrame quick;
    quick.origin = frame.origin;
    quick.per_cell = 1 / frame.cell;
    quick.on_lattice = true;
    if (frame.scale.shortest > 0) quick.shortest = kRepositionShortestEdge;
    std::vector<ElementNumber> poor = collect_runs<ElementNumber>(
        mesh, threads, [&](auto& list, std::uint32_t type, std::size_t begin, std::size_t end) {
            const auto visit = [&](std::size_t i) {
                const ElementNumber e{type, static_cast<std::uint32_t>(i)};
                if (is_poor(mesh, frame, e)) list.push_back(e);
            };
            GoodElementsFilter filter(mesh, static_cast<ElementType>(type), quick, visit);
            for_kind(mesh, type, ElementKind::kSnio, begin, end, [&](std::size_t i) { filter.look_at(i); });
            filter.finish();
        });
    if (poor.empty()) return result;
    const IndexSet around = nodes_of(mesh, poor);
    std::vector<std::uint8_t> is_complex(around.size(), 0);
    const auto complex_nodes =
        collect<NodeId>(mesh, ElementKind::kCnio, threads, [&](auto& list, const ElementNumber& e) {
            for (std::size_t k = 0; k < e.count(); ++k) {
                if (around.holds(e.nodes(mesh)[k])) list.push_back(e.nodes(mesh)[k]);
            }
        });
    for (const NodeId node : complex_nodes) {
        is_complex[around.place(node)] = 1;
    }
    for (const ElementNumber& e : poor) {
        const NodeId* const node = e.nodes(mesh);
        const bool is_at_complex =
            std::any_of(node, node + e.count(), [&](NodeId n) { return is_complex[around.place(n)] != 0; });
        (is_at_complex ? result.at_complex : result.apart).push_back(e);
    }
    return result;
}

Stars gather_stars(const Mesh& mesh, const Frame& frame, const PoorElements& poor, const Options& options) {
    return Gatherer(mesh, frame, options, poor).gather();
}

}  // namespace mortise::reposition
