// Names of surfaces in a .geo model.
//
// Netgen gives a surface the first boundary condition (-bc, -bcname) of the solids that use it. A copy made
// by translate or rotate has surfaces of its own. Surfaces without a condition are called after their solid.
#pragma once

#include <string>
#include <vector>

#include "mortise/model.hpp"

namespace mortise::model_reader {

class GeoSurfaces {
  public:
    explicit GeoSurfaces(Model& model) : model_(model) {}

    /// Names every surface below `root` that has no condition yet.
    void set_condition(std::uint32_t root, const std::string& name);

    /// Names the faces of a polyhedron, unless it has a condition: `face_of` each triangle, `names` of faces.
    /// Surfaces are called PREFIX_name; without a prefix, after the solid and the name.
    void set_face_conditions(std::uint32_t polyhedron, const std::vector<std::uint32_t>& face_of,
                             const std::vector<std::string>& names, const std::string& prefix);

    /// The same for surfaces of `root` that bound `region` (a node) and nothing else, conditions or not.
    /// False, and nothing done, if one of them also bounds a node of `other_regions`.
    bool override_condition(std::uint32_t root, std::uint32_t region,
                            const std::vector<std::uint32_t>& other_regions, const std::string& name);

    /// Asks for elements of that size on the surfaces of `root` that bound `region` (a node); they may bound
    /// other regions, too. False if there is none.
    bool set_size(std::uint32_t root, std::uint32_t region, double size);

    /// Primitives below a node, ascending.
    std::vector<std::uint32_t> primitives(std::uint32_t root) const;
    /// Primitives below both nodes, ascending.
    std::vector<std::uint32_t> common_primitives(std::uint32_t root, std::uint32_t region) const;

    /// Calls the surfaces of nodes [first, end) that have neither condition nor name after their solid.
    void set_solid(std::uint32_t first, const std::string& solid);

    /// A node with the same solid as `node` whose surfaces can be named on their own: a copy of all that
    /// comes from before node `first` and can still get a condition.
    std::uint32_t copy(std::uint32_t node, std::uint32_t first);

  private:
    void set_primitive(std::uint32_t node, const std::string& name);
    /// Nodes reachable from `root`, ascending. With `open_only`, not below a settled node.
    std::vector<std::uint32_t> reachable(std::uint32_t root, bool open_only) const;
    void grow() { settled_.resize(model_.nodes.size(), 0); }

    Model& model_;
    /// Per node: 1 if all surfaces below have a condition.
    std::vector<char> settled_;
};

}  // namespace mortise::model_reader
