// The section: a walk over the tree with an explicit stack; boolean operations commute with cutting.
#include "host/model/solids/section.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/model/affine.hpp"
#include "host/model/solids/plane_cut.hpp"
#include "host/model/text.hpp"

namespace mortise::model_reader {
namespace {

using Op = CsgNode::Op;
using State = Slice::State;

class Cutter {
  public:
    Cutter(const Model& model, const NodeBoxes& boxes, PlaneCut& cut, const Wanted& wanted)
        : model_(model), boxes_(boxes), cut_(cut), wanted_(wanted) {}

    std::optional<std::uint32_t> run(std::uint32_t root, const Affine& map) {
        const Box3 whole = image_of(map, boxes_.at(root));
        std::vector<Frame> stack;
        stack.push_back({root, map, whole, 0, {}});
        while (true) {
            Frame& frame = stack.back();
            const CsgNode& node = model_.nodes[frame.node];
            // The value counts inside the clip box only.
            const double margin = kSameHeight * cut_.size;
            const bool apart =
                is_empty(frame.clip) || frame.clip.min[2] > margin || frame.clip.max[2] < -margin;
            if (!apart && frame.next < node.children.size()) {
                const std::uint32_t child = node.children[frame.next];
                Frame next{child, frame.map, clip_of(node, frame), 0, {}};
                if (node.op == Op::kTransform) next.map = compose(frame.map, node.map);
                ++frame.next;
                stack.push_back(std::move(next));
                continue;
            }
            Slice value;
            if (!apart) value = node.op == Op::kPrimitive ? primitive(node, frame) : combined(node, frame);
            const Box3 clip = frame.clip;
            stack.pop_back();
            if (stack.empty()) {
                value = to_node(std::move(value), clip);
                if (value.state != State::kNode) return {};
                return value.node;
            }
            // Half-planes go up to the intersection that bounds them.
            const Op above = model_.nodes[stack.back().node].op;
            if (above != Op::kIntersection && above != Op::kTransform)
                value = to_node(std::move(value), clip);
            stack.back().values.push_back(std::move(value));
        }
    }

  private:
    struct Frame {
        std::uint32_t node;
        Affine map;  ///< to the model
        Box3 clip;   ///< in the model's frame
        std::size_t next = 0;
        std::vector<Slice> values;
    };

    Box3 clip_of(const CsgNode& node, const Frame& frame) const {
        Box3 clip = frame.clip;
        const auto add = [&](std::uint32_t child) {
            const Affine map = node.op == Op::kTransform ? compose(frame.map, node.map) : frame.map;
            clip = common_box(clip, image_of(map, boxes_.at(child)));
        };
        if (node.op == Op::kIntersection) {
            for (const std::uint32_t child : node.children) add(child);
        } else {
            if (node.op == Op::kDifference) add(node.children[0]);
            add(node.children[frame.next]);
        }
        return clip;
    }

    [[noreturn]] void refuse(const std::string& what) const {
        fail(wanted_.source, wanted_.where, "'" + wanted_.name + "': " + what);
    }

    Slice primitive(const CsgNode& node, const Frame& frame) const {
        std::optional<Slice> slice = slice_of(node.primitive, frame.map, frame.clip, cut_);
        if (slice) return std::move(*slice);
        switch (node.primitive.kind) {
            case Primitive::Kind::kTorus:
                refuse(
                    "a torus is cut askew, which is not supported; expected a plane across or through its "
                    "axis");
            case Primitive::Kind::kExpression:
                refuse("a formula, or an extrusion with twist, is not supported");
            default: refuse("a solid without end is not supported");
        }
    }

    Slice to_node(Slice slice, const Box3& clip) const {
        if (slice.state == State::kNothing || slice.state == State::kNode) return slice;
        if (!std::isfinite(clip.min[0]) || !std::isfinite(clip.max[0]) || !std::isfinite(clip.min[1]) ||
            !std::isfinite(clip.max[1])) {
            refuse("a solid without end is not supported");
        }
        const std::uint32_t node = cut_.flat.add_contours(cut_rectangle(slice.planes, clip));
        if (cut_.flat.nodes[node].contours.empty()) return {};
        return {State::kNode, {}, node};
    }

    Slice combined(const CsgNode& node, Frame& frame) const {
        std::vector<Slice>& values = frame.values;
        switch (node.op) {
            case Op::kTransform: return std::move(values.at(0));
            case Op::kIntersection: return intersection(values, frame.clip);
            case Op::kComplement:
                if (values.at(0).state == State::kNothing) return {State::kEverything};
                return operation(FlatNode::Op::kDifference,
                                 {to_node({State::kEverything}, frame.clip), values[0]});
            case Op::kDifference:
                if (values.empty() || values[0].state == State::kNothing) return {};
                return operation(FlatNode::Op::kDifference, std::move(values));
            default: return operation(FlatNode::Op::kUnion, std::move(values));
        }
    }

    Slice intersection(std::vector<Slice>& values, const Box3& clip) const {
        Slice flat{State::kPlanes};
        std::vector<Slice> nodes;
        for (Slice& value : values) {
            if (value.state == State::kNothing) return {};
            if (value.state == State::kNode) nodes.push_back(std::move(value));
            flat.planes.insert(flat.planes.end(), value.planes.begin(), value.planes.end());
        }
        if (flat.planes.empty() && nodes.empty()) return {State::kEverything};
        if (nodes.empty()) return flat;
        if (!flat.planes.empty()) nodes.push_back(to_node(std::move(flat), clip));
        if (nodes.back().state == State::kNothing) return {};
        return operation(FlatNode::Op::kIntersection, std::move(nodes));
    }

    /// Of nodes; nothing among them is left out.
    Slice operation(FlatNode::Op op, std::vector<Slice> values) const {
        std::vector<std::uint32_t> children;
        for (const Slice& value : values) {
            if (value.state == State::kNode) children.push_back(value.node);
        }
        if (children.empty()) return {};
        if (children.size() == 1) return {State::kNode, {}, children[0]};
        return {State::kNode, {}, cut_.flat.add_operation(op, std::move(children))};
    }

    const Model& model_;
    const NodeBoxes& boxes_;
    PlaneCut& cut_;
    const Wanted& wanted_;
};

}  // namespace

std::optional<std::uint32_t> section(const Model& model, std::uint32_t node, const Affine& map,
                                     const NodeBoxes& boxes, FlatTree& flat, const Wanted& wanted) {
    PlaneCut cut{flat};
    const Box3 box = image_of(map, boxes.at(node));
    cut.size = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const double extent = box.max[k] - box.min[k];
        if (std::isfinite(extent)) cut.size = std::max(cut.size, extent);
    }
    if (cut.size == 0) cut.size = 1;
    const std::optional<std::uint32_t> above = Cutter(model, boxes, cut, wanted).run(node, map);
    if (!cut.touched) return above;
    // A face in the plane: the solid just below it, too.
    cut.above = false;
    const std::optional<std::uint32_t> below = Cutter(model, boxes, cut, wanted).run(node, map);
    if (!above || !below) return above ? above : below;
    return flat.add_operation(FlatNode::Op::kUnion, {*above, *below});
}

}  // namespace mortise::model_reader
