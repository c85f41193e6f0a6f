#include "host/layers/insert.hpp"

#include <algorithm>
#include <array>

#include "host/common/element_block.hpp"
#include "host/common/large_array.hpp"
#include "host/common/parallel.hpp"
#include "host/layers/cuts.hpp"
#include "host/layers/stack.hpp"

namespace mortise::layers {
namespace {

class Insertion {
  public:
    Insertion(const Walls& walls, const Band& band, const Heights& heights, const Fit& fit, int threads,
              Mesh& mesh, std::vector<std::uint32_t>& facet_surface)
        : walls_(walls),
          band_(band),
          layers_(heights.count),
          fit_(fit),
          threads_(threads),
          mesh_(mesh),
          facet_surface_(facet_surface),
          is_bare_(walls.nodes.size()),
          first_new_(walls.nodes.size()) {}

    void run() {
        number_nodes();
        const std::vector<CutFace> cuts = find_cut_faces(walls_, is_bare_);
        const std::vector<Cut> cut_elements = plan_cuts(cuts);
        move_nodes();
        reattach_elements();
        cut(cut_elements);
        add_stacks();
        cut_facets(cuts);
        reattach_facets();
        add_sides();
    }

  private:
    /// An element to cut, and its parts.
    struct Cut {
        CutElement element;
        std::vector<CutPart> parts;
    };

    std::vector<Cut> plan_cuts(const std::vector<CutFace>& faces) const {
        std::vector<Cut> plan;
        for (const CutElement& element : find_cut_elements(mesh_, faces, threads_)) {
            const NodeId* const node =
                mesh_.block(element.type).nodes.data() + nodes_per(element.type) * element.index;
            plan.push_back({element, cut_element(element.type, node, faces)});
        }
        return plan;
    }

    void number_nodes() {
        std::size_t next = mesh_.node_count();
        for (std::size_t i = 0; i < is_bare_.size(); ++i) {
            is_bare_[i] = fit_.share[i] == 0;
            first_new_[i] = static_cast<NodeId>(next);
            if (is_bare_[i] == 0) next += static_cast<std::size_t>(layers_);
        }
        nodes_ = next;
    }

    /// Of a wall node after some layers.
    NodeId number(std::size_t place, int layer) const {
        if (layer == 0 || is_bare_[place] != 0) return walls_.nodes[place];
        return first_new_[place] + static_cast<NodeId>(layer - 1);
    }
    /// What elements behind the layers have instead of a node.
    NodeId inner(NodeId node) const {
        const std::uint32_t place = walls_.place[node];
        return place == kNoWallNode ? node : number(place, layers_);
    }

    void set_point(NodeId node, const Vec3& at) {
        std::copy(at.begin(), at.end(), mesh_.points.begin() + 3 * static_cast<std::ptrdiff_t>(node));
    }

    void move_nodes() {
        resize_large(mesh_.points, 3 * nodes_, threads_);
        const std::size_t levels = static_cast<std::size_t>(layers_) - 1;
        parallel_chunks(
            band_.node.size(), kElementChunk, threads_, [&](std::size_t begin, std::size_t end, int) {
                for (std::size_t s = begin; s < end; ++s) {
                    if (s >= is_bare_.size()) {
                        set_point(band_.node[s], fit_.inner[s]);
                        continue;
                    }
                    if (is_bare_[s] != 0) continue;
                    for (std::size_t k = 0; k < levels; ++k)
                        set_point(first_new_[s] + static_cast<NodeId>(k), fit_.between[levels * s + k]);
                    set_point(first_new_[s] + static_cast<NodeId>(levels), fit_.inner[s]);
                }
            });
    }

    void reattach_elements() {
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            const std::vector<std::uint32_t>& list = band_.elements[t];
            const std::size_t count = nodes_per(static_cast<ElementType>(t));
            NodeId* const nodes = mesh_.elements[t].nodes.data();
            parallel_chunks(
                list.size(), kElementChunk, threads_, [&](std::size_t begin, std::size_t end, int) {
                    for (std::size_t e = begin; e < end; ++e) {
                        NodeId* const node = nodes + count * list[e];
                        std::transform(node, node + count, node, [this](NodeId n) { return inner(n); });
                    }
                });
        }
    }

    void add_element(ElementType type, const NodeId* nodes, std::uint16_t region, std::uint8_t kind) {
        ElementBlock& block = mesh_.block(type);
        block.nodes.insert(block.nodes.end(), nodes, nodes + nodes_per(type));
        block.region.push_back(region);
        block.kind.push_back(kind);
    }

    void cut(const std::vector<Cut>& plan) {
        std::array<std::vector<std::uint32_t>, kElementTypes> gone;
        for (const auto& [element, parts] : plan) {
            const ElementBlock& block = mesh_.block(element.type);
            const std::size_t count = nodes_per(element.type);
            std::array<NodeId, 8> node{};
            std::copy_n(block.nodes.data() + count * element.index, count, node.begin());
            const auto centre = static_cast<NodeId>(mesh_.node_count());
            if (element.type != ElementType::kPyramid) add_centre(node.data(), count);
            const std::uint16_t region = block.region[element.index];
            const std::uint8_t kind = block.kind[element.index];
            for (const CutPart& part : parts) {
                std::array<NodeId, 5> nodes{};
                for (std::size_t k = 0; k < 5; ++k)
                    nodes[k] =
                        part.node[k] == kCentre ? centre : node[static_cast<std::size_t>(part.node[k])];
                add_element(part.type, nodes.data(), region, kind);
            }
            gone[static_cast<std::size_t>(element.type)].push_back(element.index);
        }
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            if (gone[t].empty()) continue;
            keep_elements(mesh_.elements[t], nodes_per(static_cast<ElementType>(t)), [&](std::size_t i) {
                return !std::binary_search(gone[t].begin(), gone[t].end(), i);
            });
        }
    }

    void add_centre(const NodeId* node, std::size_t count) {
        Vec3 middle{};
        for (std::size_t k = 0; k < count; ++k) {
            for (std::size_t j = 0; j < 3; ++j)
                middle[j] += mesh_.points[3 * std::size_t{node[k]} + j] / static_cast<double>(count);
        }
        mesh_.points.insert(mesh_.points.end(), middle.begin(), middle.end());
    }

    void add_stacks() {
        for (const WallFacet& facet : walls_.facets) {
            for_stack(facet, bare_corners(facet, walls_.place, is_bare_), layers_,
                      [&](ElementType type, const StackNodes& nodes) {
                          std::array<NodeId, 8> node{};
                          for (std::size_t k = 0; k < nodes_per(type); ++k)
                              node[k] = number(walls_.place[facet.node[nodes[k].corner]], nodes[k].layer);
                          add_element(type, node.data(), facet.region,
                                      static_cast<std::uint8_t>(ElementKind::kLayer));
                      });
        }
    }

    void add_facet(const std::array<NodeId, 4>& node, std::size_t like) {
        FacetBlock& facets = mesh_.facets;
        facets.nodes.insert(facets.nodes.end(), node.begin(), node.end());
        facets.surface.push_back(facets.surface[like]);
        facets.inside.push_back(facets.inside[like]);
        facets.outside.push_back(facets.outside[like]);
        facet_surface_.push_back(facet_surface_[like]);
    }

    /// A cut quadrilateral becomes a triangle, and gets another.
    void cut_facets(const std::vector<CutFace>& cuts) {
        for (const CutFace& face : cuts) {
            const std::size_t facet = walls_.facets[face.wall].facet;
            NodeId* const node = mesh_.facets.nodes.data() + 4 * facet;
            while (node[0] != face.diagonal[0]) std::rotate(node, node + 1, node + 4);
            const std::array<NodeId, 4> other = {node[0], node[2], node[3], node[3]};
            node[3] = node[2];
            add_facet(other, facet);
        }
    }

    void reattach_facets() {
        const std::size_t count = walls_.role.size();
        for (std::size_t f = 0; f < count; ++f) {
            if (walls_.role[f] != FacetRole::kOpen && walls_.role[f] != FacetRole::kInner) continue;
            for (std::size_t k = 0; k < 4; ++k) {
                NodeId& node = mesh_.facets.nodes[4 * f + k];
                node = inner(node);
            }
        }
    }

    void add_sides() {
        for (const Rim& rim : walls_.rims) {
            const std::size_t a = walls_.place[rim.a], b = walls_.place[rim.b];
            if (is_bare_[a] != 0 && is_bare_[b] != 0) continue;
            for (int out = 0; out < layers_; ++out) {
                const NodeId a_out = number(a, out), b_out = number(b, out);
                const NodeId a_in = number(a, out + 1), b_in = number(b, out + 1);
                if (is_bare_[a] != 0)
                    add_facet({a_out, b_out, b_in, b_in}, rim.facet);
                else if (is_bare_[b] != 0)
                    add_facet({a_out, b_out, a_in, a_in}, rim.facet);
                else
                    add_facet({a_out, b_out, b_in, a_in}, rim.facet);
            }
        }
    }

    const Walls& walls_;
    const Band& band_;
    const int layers_;
    const Fit& fit_;
    const int threads_;
    Mesh& mesh_;
    std::vector<std::uint32_t>& facet_surface_;
    std::vector<std::uint8_t> is_bare_;  ///< by place of the wall node
    std::vector<NodeId> first_new_;      ///< likewise: the node after the first layer
    std::size_t nodes_ = 0;              ///< those of the mesh, and of the layers
};

}  // namespace

void insert_layers(const Walls& walls, const Band& band, const Heights& heights, const Fit& fit, int threads,
                   Mesh& mesh, std::vector<std::uint32_t>& facet_surface) {
    Insertion(walls, band, heights, fit, threads, mesh, facet_surface).run();
}

}  // namespace mortise::layers
