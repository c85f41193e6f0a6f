// The node types of .csg files: one table. A new type is one row and one function.
#pragma once

#include "host/model/csg/csg_checks.hpp"
#include "host/model/csg/csg_scene.hpp"

namespace mortise::model_reader {

struct CsgNodeType {
    std::string_view name;
    /// Set operations of the children, whatever the arguments; kPrimitive: none, one of the functions below
    /// is set.
    CsgNode::Op operation = CsgNode::Op::kPrimitive;
    /// A node without children: a solid, or a plane shape (from its outline: CsgScene::outlined).
    CsgOperand (*leaf)(CsgScene&, const CsgNodeText&) = nullptr;
    /// A node with children: reads the arguments, returns what to do with the children.
    CsgFinish (*branch)(CsgScene&, const CsgNodeText&) = nullptr;
};

/// Fails at the place if there is no such type, or none that is supported.
const CsgNodeType& csg_node_type(std::string_view name, const std::string& source, SourceLocation where);

}  // namespace mortise::model_reader
