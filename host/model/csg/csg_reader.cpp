// Reader of OpenSCAD's .csg files: the evaluated tree that `openscad -o model.csg model.scad` writes.
//
// Grammar: file = { node }; node = { "#" | "%" | "*" | "!" } name "(" arguments ")" ( ";" | node | "{" { node
// }
// "}" ). OpenSCAD itself always writes braces. Groups, colours and the file itself are unions. An empty child
// is neutral in a union, empties an intersection, and as first child empties a difference. % and * remove a
// node; ! makes it the whole model. Anything that we cannot represent is an error that names it. Plane shapes
// become solids by extrusion; among solids they count as empty.
//
// An explicit stack replaces recursion, so nesting depth is limited by memory only.
#include <algorithm>
#include <iterator>
#include <utility>

#include "host/model/csg/csg_nodes.hpp"
#include "host/model/readers.hpp"
#include "host/model/solids/box_unions.hpp"
#include "host/model/solids/rod_unions.hpp"

namespace mortise::model_reader {
namespace {

/// A node whose children are being read.
struct Frame {
    CsgNode::Op operation = CsgNode::Op::kUnion;
    CsgFinish finish{};             ///< instead of an operation
    bool active = true;             ///< false: read for its grammar only
    bool removed = false;           ///< it or a node around it carries % or *
    bool is_single = false;         ///< one child, without braces
    SourceLocation brace{};         ///< of the '{'
    std::size_t first_operand = 0;  ///< its children's values start here in CsgReader::operands_
};

/// Behind what is found.
constexpr const char* kOnlyInScad =
    "; this looks like OpenSCAD's source, which belongs into a file named .scad";

/// What the language has and its evaluated trees do not.
bool is_scad_word(std::string_view name) {
    constexpr std::string_view kWords[] = {"module", "function",         "use", "include", "for",
                                           "if",     "intersection_for", "let", "echo",    "assert"};
    return std::find(std::begin(kWords), std::end(kWords), name) != std::end(kWords);
}

constexpr std::size_t kNoRoot = static_cast<std::size_t>(-1);

class CsgReader {
  public:
    CsgReader(const std::string& text, const std::string& source, Facets facets)
        : text_(text), source_(source), scene_(source, facets) {}

    Model read(const std::string& region) {
        scene_.model.source = source_;
        // Most nodes of the text become one or two of the model; growing would move them all again and again.
        const auto nodes = static_cast<std::size_t>(std::count(text_.begin(), text_.end(), '('));
        scene_.model.nodes.reserve(std::min(nodes + nodes / 2 + nodes / 8, text_.size() / 32) + 64);
        if (text_.find('!') != std::string::npos) {
            // First pass: grammar only, to find a root modifier.
            only_look_for_root_ = true;
            read_nodes();
            only_look_for_root_ = false;
        }
        const CsgOperand all = read_nodes();
        if (all.kind == CsgOperand::Kind::kFlat) {
            fail(source_, all.where,
                 "the file holds 2D shapes only; expected a solid: put them into linear_extrude or "
                 "rotate_extrude");
        }
        if (const auto left_out = scene_.left_out()) {
            if (all.kind == CsgOperand::Kind::kNothing)
                fail(source_, left_out->where, "the file holds no solid: " + left_out->message);
            scene_.warn(left_out->where, left_out->message);
        }
        Region result;
        result.name = region;
        result.root = all.kind == CsgOperand::Kind::kSolid
                          ? all.node
                          : scene_.model.add_operation(CsgNode::Op::kUnion, {});
        scene_.model.regions.push_back(std::move(result));
        merge_boxes(scene_.model);
        join_rods(scene_.model);
        return std::move(scene_.model);
    }

  private:
    CsgOperand read_nodes() {
        TextCursor cursor(text_, source_);
        frames_.clear();
        frames_.emplace_back();
        frames_[0].active = !only_look_for_root_ && root_ == kNoRoot;
        operands_.clear();
        bool any = false;
        while (true) {
            skip_csg_blanks(cursor);
            if (cursor.at_end()) break;
            if (cursor.peek() == ';') {
                cursor.advance();  // an empty statement
            } else if (cursor.peek() == '}') {
                if (frames_.size() == 1) cursor.fail_here("unexpected '}': no '{' is open here");
                cursor.advance();
                close_frame();
                close_single_frames();
            } else {
                read_node(cursor);
                any = true;
            }
        }
        if (frames_.size() > 1) {
            cursor.fail_here("expected '}' before the end of file: the '{' at line " +
                             std::to_string(frames_.back().brace.line) + ", column " +
                             std::to_string(frames_.back().brace.column) + " is never closed");
        }
        if (!any)
            cursor.fail_here("the file holds no solid; expected a node such as cube(size = [1, 1, 1]);");
        // With a root modifier its node is the one operand.
        return scene_.united(take_operands(0));
    }

    struct Modifiers {
        bool root = false;
        bool removed = false;
    };
    static Modifiers take_modifiers(TextCursor& cursor) {
        Modifiers found;
        for (char c = cursor.peek(); is_modifier(c); c = cursor.peek()) {
            if (c == '!') found.root = true;
            if (c == '%' || c == '*') found.removed = true;
            cursor.advance();
            skip_csg_blanks(cursor);
        }
        return found;
    }

    /// The name of a node, up to the '(' that must follow.
    std::string_view take_node_name(TextCursor& cursor) const {
        const SourceLocation where = cursor.where();
        if (!is_name_start(cursor.peek())) {
            cursor.fail_here("expected a node such as cube, union or multmatrix, found " + cursor.found() +
                             (cursor.peek() == '$' ? kOnlyInScad : ""));
        }
        const std::string_view name = cursor.take_name();
        if (is_scad_word(name))
            fail(source_, where,
                 "expected a node such as cube, union or multmatrix, found '" + std::string(name) + "'" +
                     kOnlyInScad);
        skip_csg_blanks(cursor);
        if (cursor.peek() != '(') {
            cursor.fail_here("expected '(' after " + in_quotes(name) + ", found " + cursor.found() +
                             (cursor.peek() == '=' ? kOnlyInScad : ""));
        }
        return name;
    }

    /// What a node that counts makes of its arguments, which have been read. Returns whether it is a leaf,
    /// whose operand is there now.
    bool start_node(std::string_view name, SourceLocation where, Frame& frame) {
        const CsgNodeType& type = csg_node_type(name, source_, where);
        const bool is_leaf = type.leaf != nullptr;
        frame.operation = type.operation;
        if (type.operation != CsgNode::Op::kPrimitive) return is_leaf;
        const CsgNodeText node = {name, arguments_, source_, where, type_name(type), scene_.facets};
        try {
            if (is_leaf) operands_.push_back(type.leaf(scene_, node));
            if (!is_leaf) frame.finish = type.branch(scene_, node);
        } catch (const NoExtent& empty) {
            const CsgOperand nothing = scene_.leave_out(empty.where, empty.what);
            if (is_leaf) operands_.push_back(nothing);
            if (!is_leaf) frame.finish = [](CsgScene&, auto&&) { return CsgOperand{}; };
        }
        return is_leaf;
    }

    /// What comes after the arguments of a node: ';', '{' or the only child.
    void refuse_wrong_end(const TextCursor& cursor, std::string_view name, bool is_leaf) const {
        const char c = cursor.peek();
        if (c == '{' && is_leaf)
            cursor.fail_here("'" + std::string(name) + "' takes no children; expected ';'");
        if (c == '{' || c == ';' || (!is_leaf && starts_node(c))) return;
        cursor.fail_here("expected " + std::string(is_leaf ? "';'" : "';', '{' or a node") + " after '" +
                         std::string(name) + "(...)', found " + cursor.found());
    }

    void read_node(TextCursor& cursor) {
        const std::size_t offset = cursor.offset();
        const Modifiers modifiers = take_modifiers(cursor);
        const bool removed = frames_.back().removed || modifiers.removed;
        const SourceLocation where = cursor.where();
        const std::string_view name = take_node_name(cursor);
        if (modifiers.root && !removed && only_look_for_root_) note_root(offset, where);
        arguments_.read(cursor);
        Frame frame;
        frame.active = !only_look_for_root_ && !removed && (frames_.back().active || offset == root_);
        frame.removed = removed;
        const bool is_leaf = frame.active && start_node(name, where, frame);
        skip_csg_blanks(cursor);
        refuse_wrong_end(cursor, name, is_leaf);
        frame.is_single = !is_leaf && starts_node(cursor.peek());
        frame.brace = cursor.where();
        frame.first_operand = operands_.size();
        const bool has_children = frame.is_single || cursor.peek() == '{';
        if (!frame.is_single) cursor.advance();
        if (has_children) {
            frames_.push_back(std::move(frame));
            return;
        }
        if (frame.active && !is_leaf) operands_.push_back(value_of(frame));
        close_single_frames();
    }

    static bool is_modifier(char c) { return c == '!' || c == '%' || c == '*' || c == '#'; }
    static bool starts_node(char c) { return is_name_start(c) || is_modifier(c); }

    /// Surfaces are called after the node's type and its number in the file.
    std::string type_name(const CsgNodeType& type) {
        return type.name == "multmatrix" ? std::string() : scene_.next_name(type.name);
    }

    /// The first node with a root modifier counts.
    void note_root(std::size_t offset, SourceLocation where) {
        if (root_ == kNoRoot) {
            root_ = offset;
        } else {
            scene_.warn(where, "a second '!' modifier; only the first one counts");
        }
    }

    void close_frame() {
        const Frame frame = std::move(frames_.back());
        frames_.pop_back();
        if (frame.active) operands_.push_back(value_of(frame));
    }

    /// After a node is complete: ends the nodes whose only child it is.
    void close_single_frames() {
        while (frames_.back().is_single) close_frame();
    }

    CsgOperand value_of(const Frame& frame) {
        std::vector<CsgOperand> children = take_operands(frame.first_operand);
        if (frame.finish) return frame.finish(scene_, std::move(children));
        return scene_.combined(frame.operation, std::move(children));
    }

    std::vector<CsgOperand> take_operands(std::size_t first) {
        const auto begin = operands_.begin() + static_cast<std::ptrdiff_t>(first);
        std::vector<CsgOperand> taken(begin, operands_.end());
        operands_.erase(begin, operands_.end());
        return taken;
    }

    const std::string& text_;
    const std::string& source_;
    CsgScene scene_;
    CsgArguments arguments_;
    std::vector<Frame> frames_;
    std::vector<CsgOperand> operands_;
    bool only_look_for_root_ = false;
    std::size_t root_ = kNoRoot;  ///< where the node with the root modifier starts
};

}  // namespace

Model read_csg(const std::string& text, const std::string& source, const std::string& region, Facets facets) {
    return CsgReader(text, source, facets).read(region);
}

}  // namespace mortise::model_reader
