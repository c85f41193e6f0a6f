// The poor elements of a mesh, the nodes that may move for their sake, and all elements around these.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/reposition/reposition.hpp"
#include "kernels/shared/reposition.h"

namespace mortise::reposition {

/// Model coordinates ↔ box-local ones on the lattice.
struct Frame {
    std::array<double, 3> origin;
    double cell;   ///< edge of a finest cell, in model units
    double steps;  ///< of the lattice in a model unit
    int level;
    RepositionScale scale;
    double per_unit;  ///< 1 / scale.units, a power of two

    void to_lattice(const Mesh& mesh, NodeId node, double* local) const;
    void to_model(const double* local, double* model) const;
};

Frame make_frame(const tape::BoundModel& model, const Options& options);

struct ElementNumber {
    std::uint32_t type;
    std::uint32_t index;

    std::size_t count() const;  ///< of its nodes
    const NodeId* nodes(const Mesh& mesh) const;
    bool operator<(const ElementNumber& other) const {
        return type != other.type ? type < other.type : index < other.index;
    }
};

bool is_poor(const Mesh& mesh, const Frame& frame, const ElementNumber& element);

/// Poor elements of templates, ascending.
struct PoorElements {
    std::vector<ElementNumber> apart;       ///< without a node of an element of a complex cell
    std::vector<ElementNumber> at_complex;  ///< the others
};

PoorElements find_poor(const Mesh& mesh, const Frame& frame, int threads);

struct Stars {
    std::vector<NodeId> node;    ///< of the mesh, ascending: those of all stars
    std::vector<double> points;  ///< of these, box-local: x, y, z
    std::vector<MovableNode> movable;
    std::vector<StarElement> star;
    std::vector<std::uint32_t> index;       ///< of each of these, among the mesh's of its type, or facets
    std::vector<std::uint32_t> movable_at;  ///< per node, place in `movable`; kNotMovable: none
    std::vector<std::uint8_t>
        is_hopeless;  ///< per movable node: a poor element around it is at a complex one
};

/// Of all nodes that may move of the poor elements that are apart.
Stars gather_stars(const Mesh& mesh, const Frame& frame, const PoorElements& poor, const Options& options);

}  // namespace mortise::reposition
