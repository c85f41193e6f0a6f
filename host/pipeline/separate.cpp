#include <algorithm>

#include "host/pipeline/glue.hpp"

namespace mortise::pipeline {
namespace {

/// Of `numbers`, marks in `gone` those whose places the trace does not hold any more.
void mark_gone(const std::vector<std::uint32_t>& numbers, const std::vector<std::uint32_t>& trace,
               std::vector<std::uint8_t>& gone) {
    std::vector<std::uint8_t> is_there(numbers.size(), 0);
    for (const std::uint32_t slot : trace) {
        if (slot != improve::kNone) is_there[slot] = 1;
    }
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (is_there[i] == 0 && numbers[i] != kNoNode) gone[numbers[i]] = 1;
    }
}

template <class T>
void remove_marked(std::vector<T>& values, const std::vector<std::uint8_t>& gone, std::size_t stride) {
    std::size_t to = 0;
    for (std::size_t i = 0; i < gone.size(); ++i) {
        for (std::size_t k = 0; k < stride && gone[i] == 0; ++k) values[to++] = values[i * stride + k];
    }
    values.resize(to);
}

void remove_unused_nodes(Mesh& mesh) {
    std::vector<NodeId> number(mesh.node_count(), 0);
    for (const ElementBlock& block : mesh.elements) {
        for (const NodeId n : block.nodes) number[n] = 1;
    }
    std::vector<std::uint8_t> gone(number.size(), 0);
    NodeId next = 0;
    for (std::size_t n = 0; n < number.size(); ++n) {
        gone[n] = number[n] == 0 ? 1 : 0;
        number[n] = number[n] != 0 ? next++ : kNoNode;
    }
    remove_marked(mesh.points, gone, 3);
    for (ElementBlock& block : mesh.elements) {
        for (NodeId& n : block.nodes) n = number[n];
    }
    for (NodeId& n : mesh.facets.nodes) n = number[n];
}

class Separator {
  public:
    Separator(const Gluing& gluing, const GluedModel& model, const GluedMesh& glued, const Mesh& improved,
              const improve::Trace& trace)
        : gluing_(gluing), model_(model), glued_(glued), improved_(improved), trace_(trace) {}

    bool put_into(Mesh& mesh) {
        find_uses();
        number_.resize(gluing_.sides());
        for (std::size_t side = 0; side < gluing_.sides(); ++side) place_nodes(side, mesh);
        for (std::size_t t = 0; t < kElementTypes; ++t) put_elements(t, mesh.elements[t]);
        std::vector<std::uint8_t> gone(mesh.facets.size(), 0);
        for (const std::vector<std::uint32_t>& numbers : glued_.facet) mark_gone(numbers, trace_.facet, gone);
        remove_marked(mesh.facets.nodes, gone, 4);
        remove_marked(mesh.facets.surface, gone, 1);
        remove_marked(mesh.facets.inside, gone, 1);
        remove_marked(mesh.facets.outside, gone, 1);
        for (std::size_t f = 0; f < improved_.facets.size(); ++f) {
            if (trace_.facet[f] == improve::kNone && !put_facet(f, mesh.facets)) return false;
        }
        remove_unused_nodes(mesh);
        return true;
    }

  private:
    /// The sides whose elements use a node, as bits.
    void find_uses() {
        uses_.assign(improved_.node_count(), 0);
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            const ElementBlock& block = improved_.elements[t];
            const auto count = static_cast<std::size_t>(kElementNodes[t]);
            for (std::size_t i = 0; i < block.size(); ++i) {
                const auto bit = static_cast<std::uint8_t>(1u << gluing_.side_of(block.region[i]));
                for (std::size_t k = 0; k < count; ++k) uses_[block.nodes[i * count + k]] |= bit;
            }
        }
    }

    /// Whether sides at both planes of a pair use a node.
    bool is_on_plane(std::size_t node, std::size_t pair) const {
        unsigned seen = 0;
        for (std::size_t side = 0; side < gluing_.sides(); ++side) {
            if ((uses_[node] >> side & 1) != 0) seen |= 1u << Gluing::bit(side, pair);
        }
        return seen == 3;
    }

    void place_nodes(std::size_t side, Mesh& mesh) {
        std::vector<NodeId>& number = number_[side];
        number.assign(improved_.node_count(), kNoNode);
        for (std::size_t n = 0; n < number.size(); ++n) {
            if ((uses_[n] >> side & 1) == 0) continue;
            const std::uint32_t slot = trace_.node[n];
            if (slot != improve::kNone) number[n] = glued_.node[side][slot];
            const double* point = improved_.points.data() + 3 * n;
            if (number[n] == kNoNode) {
                number[n] = static_cast<NodeId>(mesh.node_count());
                mesh.points.resize(mesh.points.size() + 3);
            } else if (std::equal(point, point + 3, glued_.mesh.points.data() + 3 * std::size_t{slot})) {
                continue;
            }
            double* to = mesh.points.data() + 3 * std::size_t{number[n]};
            std::copy_n(point, 3, to);
            for (std::size_t j = 0; j < gluing_.pairs.size(); ++j) {
                const GluedPair& pair = gluing_.pairs[j];
                const std::size_t which = Gluing::bit(side, j);
                to[pair.axis] = is_on_plane(n, j)
                                    ? pair.at[which]
                                    : to[pair.axis] - static_cast<double>(pair.shift[which]) * gluing_.edge;
            }
        }
    }

    std::uint16_t own_region(std::uint16_t region) const {
        return region == 0 ? region
                           : static_cast<std::uint16_t>(region - gluing_.side_of(region) * gluing_.regions);
    }

    void put_elements(std::size_t t, ElementBlock& to) const {
        const ElementBlock& from = improved_.elements[t];
        const auto count = static_cast<std::size_t>(kElementNodes[t]);
        std::vector<std::uint8_t> gone(to.size(), 0);
        mark_gone(glued_.element[t], trace_.element[t], gone);
        remove_marked(to.nodes, gone, count);
        remove_marked(to.region, gone, 1);
        remove_marked(to.kind, gone, 1);
        for (std::size_t i = 0; i < from.size(); ++i) {
            if (trace_.element[t][i] != improve::kNone) continue;
            const std::vector<NodeId>& number = number_[gluing_.side_of(from.region[i])];
            for (std::size_t k = 0; k < count; ++k) to.nodes.push_back(number[from.nodes[i * count + k]]);
            to.region.push_back(own_region(from.region[i]));
            to.kind.push_back(from.kind[i]);
        }
    }

    bool put_facet(std::size_t f, FacetBlock& to) const {
        const FacetBlock& from = improved_.facets;
        const std::uint16_t inside = from.inside[f], outside = from.outside[f];
        const std::size_t side = gluing_.side_of(inside);
        const std::size_t other = outside == 0 ? side : gluing_.side_of(outside);
        const std::size_t j = gluing_.pair_of(from.surface[f]);
        const NodeId* node = from.nodes.data() + 4 * f;
        if (j == gluing_.pairs.size()) {
            const std::uint32_t surface = model_.source[side][from.surface[f]];
            if (side != other || surface == kNoNode) return false;
            add_facet({node[0], node[1], node[2], node[3]}, side, surface, inside, outside, to);
            return true;
        }
        if ((side ^ other) != std::size_t{1} << j) return false;
        const GluedPair& pair = gluing_.pairs[j];
        add_facet({node[0], node[1], node[2], node[3]}, side, pair.plane[Gluing::bit(side, j)], inside, 0,
                  to);
        const bool is_triangle = corner_count(node) == 3;
        add_facet({node[is_triangle ? 1 : 3], node[is_triangle ? 0 : 2], node[is_triangle ? 2 : 1],
                   node[is_triangle ? 2 : 0]},
                  other, pair.plane[Gluing::bit(other, j)], outside, 0, to);
        return true;
    }

    void add_facet(const std::array<NodeId, 4>& node, std::size_t side, std::uint32_t surface,
                   std::uint16_t inside, std::uint16_t outside, FacetBlock& to) const {
        for (const NodeId n : node) to.nodes.push_back(number_[side][n]);
        to.surface.push_back(surface);
        to.inside.push_back(own_region(inside));
        to.outside.push_back(own_region(outside));
    }

    const Gluing& gluing_;
    const GluedModel& model_;
    const GluedMesh& glued_;
    const Mesh& improved_;
    const improve::Trace& trace_;
    std::vector<std::uint8_t> uses_;           ///< per node of the improved mesh
    std::vector<std::vector<NodeId>> number_;  ///< per side and node of the improved mesh
};

}  // namespace

bool separate(const Gluing& gluing, const GluedModel& model, const GluedMesh& glued, const Mesh& improved,
              const improve::Trace& trace, Mesh& mesh) {
    return Separator(gluing, model, glued, improved, trace).put_into(mesh);
}

}  // namespace mortise::pipeline
