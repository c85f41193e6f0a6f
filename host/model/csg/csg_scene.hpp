// What a .csg file has become so far: solids, plane shapes, and how its nodes combine them.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/model/outlines/flat_tree.hpp"
#include "host/model/solids/extrusion_pieces.hpp"
#include "host/model/solids/section.hpp"
#include "host/model/solids/solid_bounds.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// The value of a node: a plane shape (a node of CsgScene::flat), a solid (of CsgScene::model) or nothing,
/// which is neither.
struct CsgOperand {
    enum class Kind : std::uint8_t { kNothing, kFlat, kSolid };
    Kind kind = Kind::kNothing;
    std::uint32_t node = 0;
    SourceLocation where{};
};

struct CsgScene {
    CsgScene(const std::string& source_name, Facets curves) : source(source_name), facets(curves) {}

    /// Empty operands: see csg_reader.cpp. Plane shapes among solids count as empty, with one warning a file.
    CsgOperand combined(CsgNode::Op op, std::vector<CsgOperand> operands);
    CsgOperand united(std::vector<CsgOperand> operands) {
        return combined(CsgNode::Op::kUnion, std::move(operands));
    }
    /// The union of the plane operands; `name` is the node that wants them. Solids are left out, with one
    /// warning for each such name, and refused if there is nothing else.
    CsgOperand united_flat(std::vector<CsgOperand> operands, std::string_view name, SourceLocation where);
    /// A plane shape given by its outline: any loops, even-odd. Without area it is nothing.
    CsgOperand outlined(const Contours& loops, SourceLocation where);
    /// Each message is told once a file, with its first place.
    void warn(SourceLocation where, const std::string& message);
    /// Counts an object that is empty: its size is zero, negative or not finite, or a matrix flattens it.
    CsgOperand leave_out(SourceLocation where, const std::string& what);
    /// What was left out, for the end of the file, and where the first is; nothing if nothing was.
    struct LeftOut {
        SourceLocation where;
        std::string message;
    };
    std::optional<LeftOut> left_out() const;
    /// Type and number in the file: cylinder2.
    std::string next_name(std::string_view type);

    const std::string& source;
    Facets facets;
    Model model;
    FlatTree flat;
    KnownExtents extents;  ///< of extrusions
    KnownSweeps sweeps;    ///< of those without a twist, whose sides are planes
    Fragments fragments;   ///< of round solids inside nodes that count in `flat_counts`
    int flat_counts = 0;   ///< open nodes for which a solid without volume counts: hull, minkowski, shadows

  private:
    std::map<std::string, int, std::less<>> counts_;
    std::size_t left_out_ = 0;
    SourceLocation first_left_out_at_{};
    std::string first_left_out_;
    std::set<std::string> told_;
};

/// What a node with children does when its '}' is read.
using CsgFinish = std::function<CsgOperand(CsgScene&, std::vector<CsgOperand>)>;

}  // namespace mortise::model_reader
