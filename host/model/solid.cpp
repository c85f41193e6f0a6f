// Solids are trees of shared nodes; a model is the same tree in an arena. No function recurses: trees may be
// as deep as their makers like.
#include "mortise/solid.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <unordered_map>
#include <utility>

#include "host/common/constants.hpp"
#include "host/formula/expression_parser.hpp"
#include "host/model/affine.hpp"
#include "host/model/text.hpp"

namespace mortise {

struct Solid::Node {
    CsgNode content;  ///< without children
    std::vector<std::shared_ptr<Node>> children;

    Node() = default;
    Node(const Node&) = delete;
    Node& operator=(const Node&) = delete;
    /// Children that nobody else has are taken apart here, not by their own destructors.
    ~Node() {
        std::vector<std::shared_ptr<Node>> left = std::move(children);
        while (!left.empty()) {
            const std::shared_ptr<Node> last = std::move(left.back());
            left.pop_back();
            if (last.use_count() != 1) continue;
            std::atomic_thread_fence(std::memory_order_acquire);  // after the others' last use of it
            std::move(last->children.begin(), last->children.end(), std::back_inserter(left));
        }
    }

    /// Nothing but an operation: its children may become those of another one.
    bool is_plain(CsgNode::Op op) const {
        return content.op == op && content.name.empty() && content.max_size == 0 &&
               content.surface_size == 0 && !content.bounds;
    }
};

namespace {

/// a | b | c is one union and a - b - c one difference, of so many parts at most: each step copies the list.
constexpr std::size_t kMostMerged = 4096;

/// Checks what a node says, as entering a model does.
void check_node(const CsgNode& content) { Model().add(content); }

[[noreturn]] void refuse_solid(const std::string& text) { throw Error(ExitCode::kInput, text); }

void require_length(const std::string& what, double value) {
    if (value > 0 && std::isfinite(value)) return;
    refuse_solid(what + " is " + model_reader::number_text(value) + "; expected a positive, finite number");
}

Vec3 direction_of(const char* what, const Vec3& v) {
    const double length = model_reader::length(v);
    if (!(length > 0) || !std::isfinite(length))
        refuse_solid(std::string(what) + " is no direction; expected three finite numbers, not all 0");
    return model_reader::unit(v);
}

/// Sine and cosine, exact for multiples of 90 degrees.
std::pair<double, double> turn_of(double degrees) {
    if (!std::isfinite(degrees)) refuse_solid("rotated: the angle is not finite");
    const double rest = std::remainder(degrees, 360);
    if (rest == 0) return {0, 1};
    if (std::fabs(rest) == 90) return {rest / 90, 0};
    if (std::fabs(rest) == 180) return {0, -1};
    return {std::sin(rest * kPi / 180), std::cos(rest * kPi / 180)};
}

}  // namespace

Solid::Solid(std::shared_ptr<Node> node) : node_(std::move(node)) {}

Solid::Solid() : Solid(combine(CsgNode::Op::kUnion, {})) {}

Solid::Solid(Primitive primitive) : node_(std::make_shared<Node>()) {
    node_->content.primitive = std::move(primitive);
    check_node(node_->content);
}

Solid Solid::combine(CsgNode::Op op, const std::vector<Solid>& parts) {
    auto node = std::make_shared<Node>();
    node->content.op = op;
    node->children.reserve(parts.size());
    for (const Solid& part : parts) node->children.push_back(part.node_);
    return Solid(std::move(node));
}

Solid Solid::named(std::string name) const {
    Solid result = combine(CsgNode::Op::kUnion, {*this});
    result.node_->content.name = std::move(name);
    return result;
}

Solid Solid::sized(double size) const {
    require_length("sized: the size", size);
    Solid result = combine(CsgNode::Op::kUnion, {*this});
    result.node_->content.max_size = size;
    return result;
}

Solid Solid::surface_sized(double size) const {
    require_length("surface_sized: the size", size);
    Solid result = combine(CsgNode::Op::kUnion, {*this});
    result.node_->content.surface_size = size;
    return result;
}

Solid Solid::transformed(const Affine& map) const {
    Model checked;
    const std::uint32_t child = checked.add_operation(CsgNode::Op::kUnion, {});
    checked.add_transform(map, child);
    Solid result = combine(CsgNode::Op::kTransform, {*this});
    result.node_->content.map = map;
    return result;
}

Solid Solid::translated(const Vec3& by) const { return transformed(model_reader::translation(by)); }

Solid Solid::rotated(double degrees, const Vec3& axis) const {
    const Vec3 u = direction_of("rotated: the axis", axis);
    const auto [sine, cosine] = turn_of(degrees);
    Affine map = kIdentity;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j)
            map[4 * i + j] = u[i] * u[j] * (1 - cosine) + (i == j ? cosine : 0);
    }
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t next = (i + 1) % 3, after = (i + 2) % 3;
        map[4 * after + next] += u[i] * sine;
        map[4 * next + after] -= u[i] * sine;
    }
    return transformed(map);
}

Solid Solid::scaled(const Vec3& factors) const {
    return transformed({factors[0], 0, 0, 0, 0, factors[1], 0, 0, 0, 0, factors[2], 0});
}

Solid Solid::mirrored(const Vec3& normal) const {
    const Vec3 u = direction_of("mirrored: the normal", normal);
    Affine map = kIdentity;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) map[4 * i + j] = (i == j ? 1 : 0) - 2 * u[i] * u[j];
    }
    return transformed(map);
}

Solid unite(const std::vector<Solid>& parts) {
    if (parts.size() == 2 && parts[0].node_->is_plain(CsgNode::Op::kUnion) &&
        parts[0].node_->children.size() < kMostMerged) {
        Solid result = Solid::combine(CsgNode::Op::kUnion, {});
        result.node_->children = parts[0].node_->children;
        result.node_->children.push_back(parts[1].node_);
        return result;
    }
    return Solid::combine(CsgNode::Op::kUnion, parts);
}

Solid intersect(const std::vector<Solid>& parts) { return Solid::combine(CsgNode::Op::kIntersection, parts); }

Solid operator|(const Solid& a, const Solid& b) { return unite({a, b}); }
Solid operator&(const Solid& a, const Solid& b) { return intersect({a, b}); }

Solid operator-(const Solid& a, const Solid& b) {
    if (a.node_->is_plain(CsgNode::Op::kDifference) && a.node_->children.size() < kMostMerged) {
        Solid result = Solid::combine(CsgNode::Op::kDifference, {});
        result.node_->children = a.node_->children;
        result.node_->children.push_back(b.node_);
        return result;
    }
    return Solid::combine(CsgNode::Op::kDifference, {a, b});
}

Solid operator~(const Solid& a) { return Solid::combine(CsgNode::Op::kComplement, {a}); }

Solid cylinder(double radius, double height) {
    require_length("cylinder: the radius", radius);
    require_length("cylinder: the height", height);
    Primitive caps;
    caps.planes = {{{0, 0, -1}, 0, "zmin"}, {{0, 0, 1}, height, "zmax"}};
    return intersect({infinite_cylinder(radius), caps});
}

Solid frustum(double bottom, double top, double height) {
    require_length("frustum: the height", height);
    if (bottom != 0 || top == 0) require_length("frustum: the radius at the bottom", bottom);
    if (top != 0) require_length("frustum: the radius at the top", top);
    if (bottom == top) return cylinder(bottom, height);
    Primitive caps;
    if (bottom > 0) caps.planes.push_back({{0, 0, -1}, 0, "zmin"});
    if (top > 0) caps.planes.push_back({{0, 0, 1}, height, "zmax"});
    // A cone's radius at its origin is positive: it stands at the wider end.
    const double slope = (top - bottom) / height;
    const Solid side =
        bottom > top ? Solid(cone(bottom, slope)) : Solid(cone(top, slope)).translated({0, 0, height});
    return intersect({side, caps});
}

Solid rod(const Vec3& a, const Vec3& b, double radius) { return rod(a, b, radius, radius); }

Solid rod(const Vec3& a, const Vec3& b, double radius_at_a, double radius_at_b) {
    require_length("rod: the radius", radius_at_a);
    require_length("rod: the radius at its other end", radius_at_b);
    const double apart = std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
    if (!std::isfinite(apart)) refuse_solid("rod: its ends are not finite");
    const bool is_first = radius_at_a >= radius_at_b;
    if (apart <= std::fabs(radius_at_a - radius_at_b))  // one ball holds the other
        return Solid(sphere(is_first ? radius_at_a : radius_at_b)).translated(is_first ? a : b);
    RoundedSolid solid;
    solid.balls = {{a, radius_at_a}, {b, radius_at_b}};
    return Solid(rounded(std::move(solid)));
}

Solid lattice(const std::vector<Vec3>& points, const std::vector<std::array<std::uint32_t, 2>>& edges,
              double radius) {
    return lattice(points, edges, std::vector<double>(edges.size(), radius));
}

Solid lattice(const std::vector<Vec3>& points, const std::vector<std::array<std::uint32_t, 2>>& edges,
              const std::vector<double>& radii) {
    if (radii.size() != edges.size())
        refuse_solid("lattice: " + std::to_string(radii.size()) + " radii of " +
                     std::to_string(edges.size()) + " edges; expected one for each");
    std::vector<Solid> rods;
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const std::string edge = "lattice: edge " + std::to_string(i);
        for (const std::uint32_t end : edges[i]) {
            if (end >= points.size())
                refuse_solid(edge + " ends at point " + std::to_string(end) + "; there are " +
                             std::to_string(points.size()) + " points");
            for (const double x : points[end]) {
                if (!std::isfinite(x))
                    refuse_solid(edge + " ends at point " + std::to_string(end) + ", which is not finite");
            }
        }
        if (edges[i][0] == edges[i][1])
            refuse_solid(edge + " begins and ends at point " + std::to_string(edges[i][0]));
        require_length(edge + ": the radius", radii[i]);
        rods.push_back(rod(points[edges[i][0]], points[edges[i][1]], radii[i]));
    }
    return unite(rods);
}

Solid implicit(const std::string& formula, const std::optional<Box3>& bounds) {
    Primitive primitive;
    primitive.kind = Primitive::Kind::kExpression;
    primitive.expression = formula;
    const Solid solid(std::move(primitive));
    formula::parse_formula(formula, "implicit");  // what is wrong is told here, not by the mesher
    return bounds ? intersect({solid, box(bounds->min, bounds->max)}) : solid;
}

/// Writes solids into a model, each node once.
class SolidWriter {
  public:
    explicit SolidWriter(Model& model) : model_(model) {}

    std::uint32_t write(const Solid& solid) {
        std::vector<std::pair<const Solid::Node*, std::size_t>> stack = {{solid.node_.get(), 0}};
        while (!stack.empty()) {
            auto& [node, next] = stack.back();
            if (next < node->children.size()) {
                const Solid::Node* const child = node->children[next++].get();
                if (index_.find(child) == index_.end()) stack.push_back({child, 0});
                continue;
            }
            CsgNode content = node->content;
            for (const auto& child : node->children) content.children.push_back(index_.at(child.get()));
            index_[node] = model_.add(std::move(content));
            stack.pop_back();
        }
        return index_.at(solid.node_.get());
    }

  private:
    Model& model_;
    std::unordered_map<const Solid::Node*, std::uint32_t> index_;
};

Model make_model(const Solid& solid, const std::string& region) {
    return make_model(std::vector<std::pair<std::string, Solid>>{{region, solid}});
}

Model make_model(const std::vector<std::pair<std::string, Solid>>& regions) {
    Model model;
    SolidWriter writer(model);
    for (const auto& [name, solid] : regions) {
        Region region;
        region.name = name;
        region.root = writer.write(solid);
        model.regions.push_back(std::move(region));
    }
    return model;
}

/// Reads a model's nodes, each once.
class SolidReader {
  public:
    explicit SolidReader(const Model& model) {
        for (const CsgNode& node : model.nodes) {
            auto made = std::make_shared<Solid::Node>();
            made->content = node;
            made->content.children.clear();
            made->content.where = {};  // of a file that the next model does not know
            for (const std::uint32_t child : node.children) made->children.push_back(nodes_[child]);
            nodes_.push_back(std::move(made));
        }
    }
    Solid solid(std::uint32_t index) const { return Solid(nodes_[index]); }

  private:
    std::vector<std::shared_ptr<Solid::Node>> nodes_;
};

std::vector<std::pair<std::string, Solid>> solids_of(const Model& model) {
    check_model(model);
    const SolidReader reader(model);
    std::vector<std::pair<std::string, Solid>> solids;
    for (const Region& region : model.regions) {
        Solid solid = reader.solid(region.root);
        if (region.max_size > 0) solid = solid.sized(region.max_size);
        if (model.clip) solid = solid & Solid(box(model.clip->min, model.clip->max)).named("box");
        solids.emplace_back(region.name, std::move(solid));
    }
    return solids;
}

}  // namespace mortise
