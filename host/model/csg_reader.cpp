// Reader of OpenSCAD's .csg files: the evaluated tree that `openscad -o model.csg model.scad` writes.
//
// Grammar: file = { node }; node = { "#" | "%" | "*" | "!" } name "(" arguments ")" ( ";" | "{" { node } "}"
// ). Groups, colours and the file itself are unions. An empty child is neutral in a union, empties an
// intersection, and as first child empties a difference. % and * remove a node; ! makes it the whole model.
// Anything that is not a three-dimensional solid we can represent is an error that names it.
//
// An explicit stack replaces recursion, so nesting depth is limited by memory only.
#include <array>
#include <utility>

#include "host/model/csg_primitives.hpp"
#include "host/model/readers.hpp"
#include "host/model/text.hpp"

namespace mortise::model_reader {
namespace {

enum class Role { kCube, kSphere, kCylinder, kUnion, kDifference, kIntersection, kMatrix, kUnknown };

constexpr std::array<std::pair<std::string_view, Role>, 10> kRoles = {{{"multmatrix", Role::kMatrix},
                                                                       {"cube", Role::kCube},
                                                                       {"group", Role::kUnion},
                                                                       {"cylinder", Role::kCylinder},
                                                                       {"union", Role::kUnion},
                                                                       {"difference", Role::kDifference},
                                                                       {"sphere", Role::kSphere},
                                                                       {"color", Role::kUnion},
                                                                       {"intersection", Role::kIntersection},
                                                                       {"render", Role::kUnion}}};

constexpr const char* kSupported =
    "supported are cube, sphere, cylinder, multmatrix, group, union, difference, intersection, color and "
    "render";

/// OpenSCAD's other node types, to tell a gap in this reader from a typing error.
constexpr std::array<std::string_view, 17> kNotYet = {
    "polyhedron",     "square",     "circle", "polygon", "text",        "linear_extrude",
    "rotate_extrude", "projection", "offset", "roof",    "surface",     "import",
    "hull",           "minkowski",  "fill",   "resize",  "path_extrude"};

Role role_of(std::string_view name) {
    for (const auto& [known, role] : kRoles) {
        if (known == name) return role;
    }
    return Role::kUnknown;
}

bool is_primitive(Role role) {
    return role == Role::kCube || role == Role::kSphere || role == Role::kCylinder;
}

/// A node whose '{' is open.
struct Frame {
    Role role = Role::kUnion;
    bool active = true;             ///< false: read for its grammar only
    bool removed = false;           ///< it or a node around it carries % or *
    SourceLocation where;           ///< of the name
    SourceLocation brace;           ///< of the '{'
    std::size_t first_operand = 0;  ///< its children's nodes start here in CsgReader::operands_
    Affine map = kIdentity;         ///< kMatrix
};

constexpr std::size_t kNoRoot = static_cast<std::size_t>(-1);

class CsgReader {
  public:
    CsgReader(const std::string& text, const std::string& source) : text_(text), source_(source) {}

    Model read(const std::string& region) {
        model_.source = source_;
        if (text_.find('!') != std::string::npos) {
            // First pass: grammar only, to find a root modifier.
            only_look_for_root_ = true;
            read_nodes();
            only_look_for_root_ = false;
        }
        Region result;
        result.name = region;
        result.root = read_nodes();
        model_.regions.push_back(std::move(result));
        return std::move(model_);
    }

  private:
    std::uint32_t read_nodes() {
        TextCursor cursor(text_, source_);
        frames_.assign(1, Frame{});
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
        return combine(Role::kUnion, 0);
    }

    void read_node(TextCursor& cursor) {
        bool removed = frames_.back().removed;
        bool marked_as_root = false;
        const std::size_t offset = cursor.offset();
        for (char c = cursor.peek(); c == '!' || c == '%' || c == '*' || c == '#'; c = cursor.peek()) {
            if (c == '!') marked_as_root = true;
            if (c == '%' || c == '*') removed = true;
            cursor.advance();
            skip_csg_blanks(cursor);
        }
        const SourceLocation where = cursor.where();
        if (!is_name_start(cursor.peek())) {
            cursor.fail_here("expected a node such as cube, union or multmatrix, found " + cursor.found());
        }
        const std::string_view name = cursor.take_name();
        skip_csg_blanks(cursor);
        if (cursor.peek() != '(') {
            cursor.fail_here("expected '(' after '" + std::string(name) + "', found " + cursor.found());
        }
        if (marked_as_root && !removed && only_look_for_root_) note_root(offset, where);
        const bool active = !only_look_for_root_ && !removed && (frames_.back().active || offset == root_);
        const Role role = role_of(name);
        if (active && role == Role::kUnknown) refuse_name(name, where);
        arguments_.read(cursor);
        Affine map = kIdentity;
        if (active && role == Role::kMatrix) map = csg_matrix({name, arguments_, source_, where, {}});
        if (active && is_primitive(role)) add_primitive(name, role, where);

        skip_csg_blanks(cursor);
        const bool opens = cursor.peek() == '{';
        if (!opens && cursor.peek() != ';') {
            cursor.fail_here("expected ';' or '{' after '" + std::string(name) + "(...)', found " +
                             cursor.found());
        }
        if (opens && active && is_primitive(role)) {
            cursor.fail_here("'" + std::string(name) + "' takes no children; expected ';'");
        }
        const SourceLocation brace = cursor.where();
        cursor.advance();
        if (opens) {
            frames_.push_back({role, active, removed, where, brace, operands_.size(), map});
        } else if (active && !is_primitive(role)) {
            operands_.push_back(combine(role, operands_.size()));
        }
    }

    /// The first node with a root modifier counts.
    void note_root(std::size_t offset, SourceLocation where) {
        if (root_ == kNoRoot) {
            root_ = offset;
        } else if (!warned_of_roots_) {
            warned_of_roots_ = true;
            model_.warnings.push_back(place_text(source_, where) +
                                      "a second '!' modifier; only the first one counts");
        }
    }

    void add_primitive(std::string_view name, Role role, SourceLocation where) {
        // Surfaces are called after the node's type and its number in the file: cylinder2, cylinder2_zmin.
        const std::string surface = std::string(name) + std::to_string(++primitives_[static_cast<int>(role)]);
        const CsgNodeText node = {name, arguments_, source_, where, surface};
        switch (role) {
            case Role::kCube: operands_.push_back(add_csg_cube(model_, node)); break;
            case Role::kSphere: operands_.push_back(add_csg_sphere(model_, node)); break;
            default: operands_.push_back(add_csg_cylinder(model_, node)); break;
        }
    }

    [[noreturn]] void refuse_name(std::string_view name, SourceLocation where) const {
        const std::string quoted = "'" + std::string(name) + "'";
        for (const std::string_view known : kNotYet) {
            if (known == name) {
                fail(source_, where,
                     quoted + " is not supported yet; " + kSupported +
                         "; disable the node with '*' to leave it out");
            }
        }
        fail(source_, where, "unknown node " + quoted + "; " + kSupported);
    }

    void close_frame() {
        const Frame frame = frames_.back();
        frames_.pop_back();
        if (!frame.active) return;
        std::uint32_t node = combine(frame.role, frame.first_operand);
        if (frame.role == Role::kMatrix && frame.map != kIdentity && !is_empty(node)) {
            node = model_.add_transform(frame.map, node);
            model_.nodes[node].where = frame.where;
        }
        operands_.push_back(node);
    }

    bool is_empty(std::uint32_t node) const {
        const CsgNode& n = model_.nodes[node];
        return n.op == CsgNode::Op::kUnion && n.children.empty();
    }

    /// Replaces the operands from `first` on by one node, which is returned and not pushed.
    std::uint32_t combine(Role role, std::size_t first) {
        if (operands_.size() == first + 1) {
            const std::uint32_t only = operands_.back();
            operands_.pop_back();
            return only;
        }
        std::vector<std::uint32_t> children(operands_.begin() + static_cast<std::ptrdiff_t>(first),
                                            operands_.end());
        operands_.resize(first);
        CsgNode::Op op = CsgNode::Op::kUnion;
        if (role == Role::kDifference) op = CsgNode::Op::kDifference;
        if (role == Role::kIntersection) op = CsgNode::Op::kIntersection;

        // Empty children: see the head of this file.
        bool all_empty = children.empty() || (op == CsgNode::Op::kDifference && is_empty(children[0]));
        std::size_t kept = 0;
        for (const std::uint32_t child : children) {
            if (!is_empty(child)) {
                children[kept++] = child;
            } else if (op == CsgNode::Op::kIntersection) {
                all_empty = true;
            }
        }
        children.resize(kept);
        if (all_empty || children.empty()) return model_.add_operation(CsgNode::Op::kUnion, {});
        if (children.size() == 1) return children[0];
        return model_.add_operation(op, std::move(children));
    }

    const std::string& text_;
    const std::string& source_;
    Model model_;
    CsgArguments arguments_;
    std::vector<Frame> frames_;
    std::vector<std::uint32_t> operands_;
    std::array<std::uint32_t, 3> primitives_{};  ///< how many cubes, spheres, cylinders so far
    bool only_look_for_root_ = false;
    bool warned_of_roots_ = false;
    std::size_t root_ = kNoRoot;  ///< where the node with the root modifier starts
};

}  // namespace

Model read_csg(const std::string& text, const std::string& source, const std::string& region) {
    return CsgReader(text, source).read(region);
}

}  // namespace mortise::model_reader
