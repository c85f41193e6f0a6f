#include "host/model/csg/csg_scene.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/common/coordinate_limits.hpp"
#include "host/model/csg/csg_checks.hpp"

namespace mortise::model_reader {
namespace {

using Kind = CsgOperand::Kind;

FlatNode::Op flat_operation(CsgNode::Op op) {
    switch (op) {
        case CsgNode::Op::kDifference: return FlatNode::Op::kDifference;
        case CsgNode::Op::kIntersection: return FlatNode::Op::kIntersection;
        default: return FlatNode::Op::kUnion;
    }
}

}  // namespace

CsgOperand CsgScene::combined(CsgNode::Op op, std::vector<CsgOperand> operands) {
    if (operands.size() == 1) return operands[0];
    const bool solid = std::any_of(operands.begin(), operands.end(),
                                   [](const CsgOperand& operand) { return operand.kind == Kind::kSolid; });
    const Kind kind = solid ? Kind::kSolid : Kind::kFlat;
    std::vector<std::uint32_t> children;
    SourceLocation where{};  // of the first operand that is something
    for (std::size_t i = 0; i < operands.size(); ++i) {
        CsgOperand& operand = operands[i];
        if (solid && operand.kind == Kind::kFlat) {
            warn(operand.where, "a 2D shape among solids is left out; extrude it to make it a solid");
            operand.kind = Kind::kNothing;
        }
        if (operand.kind != Kind::kNothing) {
            if (children.empty()) where = operand.where;
            children.push_back(operand.node);
        } else if (op == CsgNode::Op::kIntersection || (op == CsgNode::Op::kDifference && i == 0)) {
            return {};
        }
    }
    if (children.empty()) return {};
    if (children.size() == 1) return {kind, children[0], where};
    return {kind,
            solid ? model.add_operation(op, std::move(children))
                  : flat.add_operation(flat_operation(op), std::move(children)),
            where};
}

CsgOperand CsgScene::united_flat(std::vector<CsgOperand> operands, std::string_view name,
                                 SourceLocation where) {
    const auto is_solid = [](const CsgOperand& operand) { return operand.kind == Kind::kSolid; };
    const auto found = std::find_if(operands.begin(), operands.end(), is_solid);
    if (found != operands.end()) {
        if (std::none_of(operands.begin(), operands.end(),
                         [](const CsgOperand& operand) { return operand.kind == Kind::kFlat; })) {
            fail(source, where,
                 in_quotes(name) + " wants 2D shapes such as square or polygon; its children are solids");
        }
        warn(found->where, "a solid among the 2D shapes of " + in_quotes(name) + " is left out");
        operands.erase(std::remove_if(operands.begin(), operands.end(), is_solid), operands.end());
    }
    return united(std::move(operands));
}

CsgOperand CsgScene::outlined(const Contours& loops, SourceLocation where) {
    for (const auto& loop : loops) {
        for (const Vec2& point : loop) {
            if (std::max(std::fabs(point[0]), std::fabs(point[1])) < kLargestCoordinate) continue;
            fail(source, where,
                 std::string("this 2D shape is larger than ") + kLargestCoordinateText +
                     " in its units; choose other units");
        }
    }
    const std::uint32_t node = flat.add_contours(loops);
    if (flat.nodes[node].contours.empty()) return {};
    return {Kind::kFlat, node, where};
}

void CsgScene::warn(SourceLocation where, const std::string& message) {
    if (told_.insert(message).second) model.warnings.push_back(place_text(source, where) + message);
}

CsgOperand CsgScene::leave_out(SourceLocation where, const std::string& what) {
    if (left_out_++ == 0) {
        first_left_out_at_ = where;
        first_left_out_ = what;
    }
    return {};
}

std::optional<CsgScene::LeftOut> CsgScene::left_out() const {
    if (left_out_ == 0) return {};
    const std::string kind = " of size 0, negative, infinite or flattened by a matrix ";
    return LeftOut{first_left_out_at_, left_out_ == 1 ? "an object" + kind + "is left out: " + first_left_out_
                                                      : std::to_string(left_out_) + " objects" + kind +
                                                            "are left out, the first: " + first_left_out_};
}

std::string CsgScene::next_name(std::string_view type) {
    auto found = counts_.find(type);
    if (found == counts_.end()) found = counts_.emplace(std::string(type), 0).first;
    return found->first + std::to_string(++found->second);
}

}  // namespace mortise::model_reader
