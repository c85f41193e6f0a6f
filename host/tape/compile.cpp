#include "host/tape/compile.hpp"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>

#include "host/common/box_faces.hpp"
#include "host/common/constants.hpp"
#include "host/common/coordinate_limits.hpp"
#include "host/formula/expression_parser.hpp"
#include "host/formula/formula_set.hpp"
#include "host/tape/affine_map.hpp"
#include "host/tape/bodies.hpp"
#include "host/tape/hints.hpp"
#include "host/tape/polyhedron.hpp"
#include "host/tape/primitive_shape.hpp"
#include "host/tape/rounded.hpp"
#include "host/tape/sides.hpp"
#include "host/tape/surface_bounds.hpp"
#include "host/tape/tree_size.hpp"

namespace mortise::tape {
namespace {

constexpr std::size_t kMaxTerms = 1u << 24;
constexpr std::uint32_t kNoNode = 0xffffffffu;

/// A monotone formula over signed surfaces; children come before their users.
struct Term {
    enum class Type : std::uint8_t { kFalse, kTrue, kLiteral, kSpatial, kAnd, kOr };
    Type type = Type::kFalse;
    bool negated = false;
    std::uint32_t surface = 0;  ///< kSpatial: index of the polyhedron
    std::vector<std::uint32_t> children;
    std::optional<Box3> hint{};  ///< known to hold the set, in model coordinates
};

class Compiler {
  public:
    Compiler(const Model& model, NodeBounds use) : model_(model), use_(use) {}

    CompiledModel run(const Box3* clip) {
        if (model_.regions.empty()) throw Error(ExitCode::kInput, model_.source + ": the model has no solid");
        if (model_.regions.size() > kMaxRegions) {
            throw Error(ExitCode::kInput, model_.source + ": " + std::to_string(model_.regions.size()) +
                                              " regions, at most " + std::to_string(kMaxRegions) +
                                              " are possible");
        }
        refuse_large_trees(model_, kMaxTerms);
        out_.is_cut = clip != nullptr || model_.clip.has_value();
        std::vector<std::uint32_t> roots;
        for (const Region& region : model_.regions) {
            std::vector<std::uint32_t> parts = {expand(region.root)};
            if (model_.clip) parts.push_back(box_term(*model_.clip));
            if (clip != nullptr) parts.push_back(box_term(*clip));
            roots.push_back(add_operation(Term::Type::kAnd, std::move(parts)));
            out_.region_names.push_back(region.name);
            out_.region_size.push_back(region_size(region));
        }
        find_hints(model_, surface_node_, out_);
        compute_needs();
        compute_bounds(roots);
        // Regions are tried in order: the first is the outermost select, so it is emitted last.
        bool started = false;
        for (std::size_t i = roots.size(); i-- > 0;) {
            const Term& root = terms_[roots[i]];
            if (root.type == Term::Type::kFalse) continue;
            if (root.type == Term::Type::kTrue) {
                throw Error(ExitCode::kInput,
                            model_.source + ": region '" + out_.region_names[i] +
                                "' is unbounded; cut it with --box or with a bounded solid");
            }
            emit(roots[i]);
            const i32 region = static_cast<i32>(i + 1);
            out_.tape.push_back(make_operation(started ? kTapeSelect : kTapeSelectConst, region, 0));
            started = true;
        }
        if (!started) throw Error(ExitCode::kInput, model_.source + ": the solid is empty");
        find_sides(out_);
        return std::move(out_);
    }

  private:
    struct Frame {
        std::uint32_t node;
        Map map;
        bool negate;
        const std::string* name;
        double size;  ///< the smallest wanted on the surfaces below
        std::size_t next = 0;
        std::vector<std::uint32_t> terms;
    };

    std::uint32_t add(Term term) {
        if (terms_.size() >= kMaxTerms) {
            throw Error(ExitCode::kInput, start_of(model_, node_) + "the tree expands to more than " +
                                              std::to_string(kMaxTerms) +
                                              " operations; use parts less often");
        }
        terms_.push_back(std::move(term));
        return static_cast<std::uint32_t>(terms_.size() - 1);
    }

    std::uint32_t add_constant(bool value) {
        return add({value ? Term::Type::kTrue : Term::Type::kFalse, false, 0, {}, {}});
    }

    /// And / or of any number of terms, constants removed.
    std::uint32_t add_operation(Term::Type type, std::vector<std::uint32_t> children) {
        const bool is_and = type == Term::Type::kAnd;
        const Term::Type neutral = is_and ? Term::Type::kTrue : Term::Type::kFalse;
        const Term::Type absorbing = is_and ? Term::Type::kFalse : Term::Type::kTrue;
        std::vector<std::uint32_t> kept;
        for (const std::uint32_t child : children) {
            if (terms_[child].type == absorbing) return child;
            if (terms_[child].type != neutral) kept.push_back(child);
        }
        if (kept.empty()) return add_constant(is_and);
        if (kept.size() == 1) return kept[0];
        return add({type, false, 0, std::move(kept), {}});
    }

    /// The formula of the subtree at `root`, by an explicit stack: any depth of tree.
    std::uint32_t expand(std::uint32_t root) {
        static const std::string kNoName;
        std::vector<Frame> stack;
        stack.push_back({root, Map{}, false, &kNoName, kInfinity, 0, {}});
        for (;;) {
            Frame& frame = stack.back();
            const CsgNode& node = model_.nodes[frame.node];
            if (!node.name.empty()) frame.name = &node.name;
            for (const double size : {node.max_size, node.surface_size}) {
                if (size > 0) frame.size = std::min(frame.size, size);
            }
            if (node.op != CsgNode::Op::kPrimitive && frame.next < node.children.size()) {
                const std::size_t i = frame.next++;
                Frame child{node.children[i], frame.map, frame.negate, frame.name, frame.size, 0, {}};
                if (node.op == CsgNode::Op::kTransform) child.map = compose(frame.map, to_map(node.map));
                if (node.op == CsgNode::Op::kComplement) child.negate = !frame.negate;
                if (node.op == CsgNode::Op::kDifference && i > 0) child.negate = !frame.negate;
                stack.push_back(std::move(child));
                continue;
            }
            std::uint32_t term = finish(frame, node);
            if (node.bounds && !frame.negate) {
                const Box3 box = map_box(*node.bounds, to_affine(frame.map));
                if (use_ == NodeBounds::kCut) term = add_operation(Term::Type::kAnd, {term, box_term(box)});
                std::optional<Box3>& hint = terms_[term].hint;
                if (hint) shrink(*hint, box);
                if (!hint) hint = box;
            }
            stack.pop_back();
            if (stack.empty()) return term;
            stack.back().terms.push_back(term);
        }
    }

    /// The smallest size of the region and of the solids that hold all of it. What a size on a part of the
    /// region asks for inside that part is not told: its surfaces have it.
    double region_size(const Region& region) const {
        double size = region.max_size > 0 ? region.max_size : kInfinity;
        std::vector<std::uint32_t> open = {region.root};
        std::vector<char> seen(model_.nodes.size(), 0);
        while (!open.empty()) {
            const std::uint32_t index = open.back();
            open.pop_back();
            if (seen[index] != 0) continue;
            seen[index] = 1;
            const CsgNode& node = model_.nodes[index];
            if (node.max_size > 0) size = std::min(size, node.max_size);
            if (node.children.empty()) continue;
            const bool one = node.op == CsgNode::Op::kUnion && node.children.size() == 1;
            if (node.op == CsgNode::Op::kIntersection) {
                open.insert(open.end(), node.children.begin(), node.children.end());
            } else if (one || node.op == CsgNode::Op::kDifference || node.op == CsgNode::Op::kTransform) {
                open.push_back(node.children[0]);
            }
        }
        return size;
    }

    std::uint32_t finish(Frame& frame, const CsgNode& node) {
        switch (node.op) {
            case CsgNode::Op::kPrimitive: return primitive(node.primitive, frame);
            case CsgNode::Op::kUnion:
                return add_operation(frame.negate ? Term::Type::kAnd : Term::Type::kOr,
                                     std::move(frame.terms));
            case CsgNode::Op::kIntersection:
                return add_operation(frame.negate ? Term::Type::kOr : Term::Type::kAnd,
                                     std::move(frame.terms));
            case CsgNode::Op::kDifference:
                if (frame.terms.empty()) return add_constant(frame.negate);
                return add_operation(frame.negate ? Term::Type::kOr : Term::Type::kAnd,
                                     std::move(frame.terms));
            case CsgNode::Op::kComplement:
            case CsgNode::Op::kTransform: return frame.terms.at(0);
        }
        return add_constant(false);
    }

    std::uint32_t literal(std::uint32_t surface, bool negated) {
        return add({Term::Type::kLiteral, negated, surface, {}, {}});
    }

    std::uint32_t primitive(const Primitive& p, const Frame& frame) {
        node_ = frame.node;
        const std::string base = base_name(p.kind, frame);
        if (p.kind == Primitive::Kind::kConvex) return convex(p, frame, base);
        if (p.kind == Primitive::Kind::kPolyhedron) return polyhedron(p, frame, base);
        const Inverse inverse(frame);
        Surface s{};
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) s.map[4 * i + j] = inverse.matrix[j][i];
            s.map[4 * i + 3] = inverse.offset[i];
        }
        if (p.kind == Primitive::Kind::kExpression) return formula(p, s, base, frame);
        if (p.kind == Primitive::Kind::kRounded) s = rounded(p, s);
        set_shape(p, s);
        return literal(add_surface(s, base, frame.size), frame.negate);
    }

    /// From model coordinates to those of a primitive.
    struct Inverse {
        explicit Inverse(const Frame& frame)
            : matrix(glm::inverse(frame.map.matrix)), offset(-(matrix * frame.map.offset)) {}
        const glm::dmat3 matrix;
        const glm::dvec3 offset;
    };

    /// The node's own name, or its kind with a number. An unnamed primitive counts once however often its
    /// frame is expanded: names stay short and stable.
    std::string base_name(Primitive::Kind kind, const Frame& frame) {
        if (!frame.name->empty()) return *frame.name;
        static const char* const kNames[] = {"convex", "sphere",  "cylinder",   "cone",   "cone",
                                             "torus",  "formula", "polyhedron", "rounded"};
        static_assert(std::size(kNames) == static_cast<std::size_t>(Primitive::Kind::kRounded) + 1);
        const char* const name = kNames[static_cast<std::size_t>(kind)];
        const auto [ordinal, is_new] = ordinals_.try_emplace(frame.node, 0);
        if (is_new) ordinal->second = ++counts_[name];
        return name + std::to_string(ordinal->second);
    }

    std::uint32_t convex(const Primitive& p, const Frame& frame, const std::string& base) {
        const Inverse inverse(frame);
        std::vector<std::uint32_t> faces;
        for (const Plane& plane : p.planes) {
            // normal·(inverse x + offset) - plane.offset, scaled to a unit normal in model coordinates.
            const glm::dvec3 local(plane.normal[0], plane.normal[1], plane.normal[2]);
            const glm::dvec3 normal = glm::transpose(inverse.matrix) * local;
            const double length = std::sqrt(glm::dot(normal, normal));
            if (!(length > 0) || !std::isfinite(length)) {
                throw Error(ExitCode::kInput,
                            model_.source + ": a half-space of '" + base + "' has no normal");
            }
            Surface s{};
            s.kind = kSurfacePlane;
            for (int j = 0; j < 3; ++j) s.map[j] = normal[j] / length;
            s.map[3] = (glm::dot(local, inverse.offset) - plane.offset) / length;
            const std::string name = plane.name.empty() ? base : base + "_" + plane.name;
            faces.push_back(literal(add_surface(s, name, frame.size), frame.negate));
        }
        return add_operation(frame.negate ? Term::Type::kOr : Term::Type::kAnd, std::move(faces));
    }

    /// Of a surface that has the primitive's map: the data are written once for all its copies.
    Surface rounded(const Primitive& p, const Surface& mapped) {
        const auto [data, is_new] = rounded_.try_emplace(p.rounded.get());
        if (is_new) data->second = write_rounded(*p.rounded, out_.expression_ops);
        Surface surface = data->second;
        std::copy(mapped.map, mapped.map + 12, surface.map);
        return surface;
    }

    /// Its surfaces; their formulas depend on the cell (kernels/shared/spatial.h).
    std::uint32_t polyhedron(const Primitive& p, const Frame& frame, const std::string& base) {
        const auto key = std::make_pair(p.triangles.get(), to_affine(frame.map));
        auto found = polyhedra_.find(key);
        if (found == polyhedra_.end()) {
            const auto& affine = key.second;
            PolyhedronParts parts =
                make_polyhedron(transformed(*p.triangles, affine), p.sharp_angle, out_.expression_ops);
            std::vector<std::uint32_t> place;
            for (std::size_t i = 0; i < parts.surfaces.size(); ++i) {
                place.push_back(add_surface(parts.surfaces[i], base + parts.suffixes[i], frame.size));
            }
            for (std::uint32_t& surface : parts.world.surface) surface = place[surface];
            found = polyhedra_.emplace(key, std::vector<std::uint32_t>()).first;
            for (WorldPolyhedron& body : split_bodies(std::move(parts.world))) {
                found->second.push_back(static_cast<std::uint32_t>(out_.polyhedra.size()));
                out_.polyhedra.push_back(std::move(body));
            }
        }
        std::vector<std::uint32_t> bodies;
        for (const std::uint32_t at : found->second) {
            const WorldPolyhedron& body = out_.polyhedra[at];
            for (const std::uint32_t surface : body.surface)
                out_.surface_size[surface] = std::min(out_.surface_size[surface], frame.size);
            if (body.shape.triangles.empty()) return add_constant(frame.negate);
            Term term;
            term.type = Term::Type::kSpatial;
            term.negated = frame.negate;
            term.surface = at;
            if (!frame.negate) term.hint = bounds_of(body.shape);
            bodies.push_back(add(std::move(term)));
        }
        return add_operation(frame.negate ? Term::Type::kAnd : Term::Type::kOr, std::move(bodies));
    }

    /// min(f, 0) and max(f, 0): what is 0 everywhere is neither inside nor outside.
    void refuse_zero(const formula::Formula::Node& node, std::uint32_t at) const {
        if (node.operation != kExprConstant || node.constant != 0) return;
        throw Error(ExitCode::kInput, start_of(model_, at) +
                                          "formula: an argument of min or max is 0 everywhere, which is "
                                          "neither inside nor outside; write a small number instead");
    }

    std::uint32_t formula(const Primitive& p, const Surface& frame, const std::string& base,
                          const Frame& at) {
        const formula::Formula parsed = formula::with_sharp_edges(
            formula::parse_formula(p.expression, model_.source, model_.nodes[at.node].where));
        const formula::FormulaSet set = formula::formula_set(parsed);
        std::vector<std::uint32_t> terms;
        std::map<std::pair<std::uint32_t, bool>, std::uint32_t> surfaces;  // of a function, or its negative
        for (const formula::FormulaSet::Node& node : set.nodes) {
            if (node.kind != formula::FormulaSet::Kind::kSurface) {
                const bool is_and = (node.kind == formula::FormulaSet::Kind::kIntersection) != at.negate;
                terms.push_back(add_operation(is_and ? Term::Type::kAnd : Term::Type::kOr,
                                              {terms[node.a], terms[node.b]}));
                continue;
            }
            const bool own = node.negated && node.partial;
            const auto [entry, is_new] = surfaces.try_emplace({node.a, own}, 0);
            if (is_new) {
                refuse_zero(parsed.nodes()[node.a], at.node);
                Surface s = frame;
                s.kind = kSurfaceExpression;
                s.first_op = static_cast<std::uint32_t>(out_.expression_ops.size());
                try {
                    s.op_count = formula::emit_formula(parsed, node.a, out_.expression_ops, own);
                } catch (const Error& error) {
                    throw Error(error.code(), model_.source + ": " + error.what());
                }
                entry->second = add_surface(s, base, at.size);
            }
            terms.push_back(literal(entry->second, (node.negated && !own) != at.negate));
        }
        return terms.back();
    }

    std::uint32_t add_surface(const Surface& surface, const std::string& name, double size) {
        const auto [entry, is_new] =
            name_index_.try_emplace(name, static_cast<std::uint32_t>(out_.surface_names.size()));
        if (is_new) out_.surface_names.push_back(name);
        out_.surfaces.push_back({surface, entry->second});
        out_.surface_size.push_back(size);
        surface_node_.push_back(node_);
        for (int i = 0; i < 12; ++i) {
            if (!std::isfinite(surface.map[i])) {
                throw Error(ExitCode::kInput,
                            model_.source + ": the map of '" + name + "' is singular or not finite");
            }
            if (std::fabs(surface.map[i]) > kLargestCoordinate) {
                throw Error(ExitCode::kInput,
                            model_.source + ": '" + name +
                                "' is too small or too far away to be meshed; choose other units");
            }
        }
        return static_cast<std::uint32_t>(out_.surfaces.size() - 1);
    }

    std::uint32_t box_term(const Box3& box) {
        node_ = kNoNode;
        std::vector<std::uint32_t> faces;
        for (int face = 0; face < 6; ++face) {
            const int axis = face / 2;
            const double sign = face % 2 == 0 ? -1 : 1;
            Surface s{};
            s.kind = kSurfacePlane;
            s.map[axis] = sign;
            s.map[3] = -sign * (face % 2 == 0 ? box.min : box.max)[static_cast<std::size_t>(axis)];
            faces.push_back(
                literal(add_surface(s, kBoxFaceNames[static_cast<std::size_t>(face)], kInfinity), false));
        }
        return add_operation(Term::Type::kAnd, std::move(faces));
    }

    /// Stack entries that a term needs when its neediest child comes first (Sethi and Ullman).
    void compute_needs() {
        needs_.assign(terms_.size(), 1);
        for (std::size_t i = 0; i < terms_.size(); ++i) {
            auto& children = terms_[i].children;
            if (terms_[i].type == Term::Type::kSpatial) needs_[i] = kSpatialStack;
            if (children.empty()) continue;
            std::stable_sort(children.begin(), children.end(),
                             [this](std::uint32_t a, std::uint32_t b) { return needs_[a] > needs_[b]; });
            needs_[i] = std::max(needs_[children[0]], 1 + needs_[children[1]]);
        }
    }

    void emit(std::uint32_t root) {
        std::vector<std::pair<std::uint32_t, std::size_t>> stack = {{root, 0}};
        while (!stack.empty()) {
            auto& [index, next] = stack.back();
            const Term& term = terms_[index];
            if (term.type == Term::Type::kLiteral) {
                out_.tape.push_back(make_literal(term.surface, term.negated ? 1 : 0));
                stack.pop_back();
                continue;
            }
            if (term.type == Term::Type::kSpatial) {
                out_.tape.push_back(make_spatial(term.surface, term.negated ? 1 : 0));
                stack.pop_back();
                continue;
            }
            if (next >= 2) {
                out_.tape.push_back(make_operation(term.type == Term::Type::kAnd ? kTapeAnd : kTapeOr, 0, 0));
            }
            if (next < term.children.size()) {
                const std::uint32_t child = term.children[next++];
                stack.push_back({child, 0});
            } else {
                stack.pop_back();
            }
        }
    }

    void compute_bounds(const std::vector<std::uint32_t>& roots) {
        std::vector<Box3> boxes(terms_.size(), kNothing);
        for (std::size_t i = 0; i < terms_.size(); ++i) {
            const Term& term = terms_[i];
            if (term.type == Term::Type::kFalse) continue;
            if (term.type == Term::Type::kLiteral || term.type == Term::Type::kSpatial) {
                boxes[i] = term.type == Term::Type::kLiteral
                               ? half_bounds(out_.surfaces[term.surface].surface, term.negated)
                               : kEverything;
                if (term.hint) shrink(boxes[i], *term.hint);
                continue;
            }
            const bool is_or = term.type == Term::Type::kOr;
            if (!is_or) boxes[i] = kEverything;
            for (const std::uint32_t child : term.children) {
                (is_or ? grow : shrink)(boxes[i], boxes[child]);
                if (!is_or && (boxes[i].min[0] >= boxes[i].max[0] || boxes[i].min[1] >= boxes[i].max[1] ||
                               boxes[i].min[2] >= boxes[i].max[2])) {
                    boxes[i] = kNothing;
                    break;
                }
            }
            if (term.hint) shrink(boxes[i], *term.hint);
        }
        out_.bounds = kNothing;
        for (const std::uint32_t root : roots) grow(out_.bounds, boxes[root]);
        out_.scale = 0;
        for (const WorldSurface& world : out_.surfaces)
            out_.scale = std::max(out_.scale, reach(world.surface));
        if (!(out_.scale > 0)) out_.scale = 1;
        if (!(out_.scale < kLargestCoordinate)) {
            throw Error(ExitCode::kInput, model_.source + ": the model is larger than " +
                                              kLargestCoordinateText + " in its units; choose other units");
        }
    }

    const Model& model_;
    NodeBounds use_;
    CompiledModel out_;
    std::uint32_t node_ = kNoNode;             ///< whose surfaces are made
    std::vector<std::uint32_t> surface_node_;  ///< per surface, kNoNode for those of boxes
    std::vector<Term> terms_;
    std::vector<int> needs_;
    std::map<std::string, std::uint32_t> name_index_;
    std::map<std::string, int> counts_;
    std::map<std::uint32_t, int> ordinals_;
    /// By shape and place: its bodies.
    std::map<std::pair<const TriangleSurface*, Affine>, std::vector<std::uint32_t>> polyhedra_;
    std::map<const RoundedSolid*, Surface> rounded_;
};

}  // namespace

CompiledModel compile(const Model& model, const Box3* clip, NodeBounds use) {
    return Compiler(model, use).run(clip);
}

}  // namespace mortise::tape
