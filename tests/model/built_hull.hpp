// Hulls and sums of the solids of a text, as the readers make them.
#pragma once

#include <string>
#include <vector>

#include "host/model/solids/hulls.hpp"

namespace mortise::test {

struct Built {
    Model model;
    std::uint32_t node = 0;
    std::string error;
};

/// The hull or sum of the solids of a .csg text.
inline Built build(const std::string& text, bool minkowski = false) {
    Built built;
    built.model = parse_model(text, "csg", "m.csg");
    const CsgNode& root = built.model.nodes[built.model.regions[0].root];
    std::vector<std::uint32_t> children = {built.model.regions[0].root};
    if (root.op == CsgNode::Op::kUnion) children = root.children;
    try {
        built.node = minkowski ? model_reader::add_minkowski(built.model, children, "minkowski1", {3, 4})
                               : model_reader::add_hull(built.model, children, "hull1", {3, 4});
    } catch (const Error& error) {
        built.error = error.what();
    }
    return built;
}

/// A solid, moved.
inline std::string at(double x, double y, double z, const std::string& solid) {
    const auto number = [](double v) { return std::to_string(v); };
    return "multmatrix([[1,0,0," + number(x) + "],[0,1,0," + number(y) + "],[0,0,1," + number(z) +
           "],[0,0,0,1]]) {" + solid + "}";
}

}  // namespace mortise::test
