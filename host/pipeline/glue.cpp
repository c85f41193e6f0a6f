#include "host/pipeline/glue.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "host/tape/singular_point.hpp"

namespace mortise::pipeline {
namespace {

constexpr double kBehind = 0.01;  ///< cells
/// Two surfaces are one if no number of theirs differs by more.
constexpr double kSameSurface = 1e-10;

/// Whether two surfaces are the same function, up to rounding.
bool is_same(const Surface& a, const Surface& b, const std::vector<ExpressionOp>& ops) {
    if (a.kind != b.kind || a.op_count != b.op_count) return false;
    if (a.first_op != b.first_op &&
        (a.kind != kSurfaceExpression ||
         std::memcmp(&ops[a.first_op], &ops[b.first_op], a.op_count * sizeof(ExpressionOp)) != 0))
        return false;
    const auto differs = [](double x, double y, double scale) {
        return !(std::fabs(x - y) <= kSameSurface * std::max(1.0, scale));
    };
    for (std::size_t i = 0; i < 4; ++i) {
        if (differs(a.form[i], b.form[i], std::fabs(a.form[i]))) return false;
    }
    for (std::size_t i = 0; i < (a.kind == kSurfacePlane ? 1u : 3u); ++i) {
        // Along the axis of a cylinder nothing changes.
        if (a.kind == kSurfaceQuadric && a.form[i] == 0) continue;
        double scale = 0;
        for (std::size_t j = 0; j < 4; ++j) scale = std::max(scale, std::fabs(a.map[4 * i + j]));
        for (std::size_t j = 0; j < 4; ++j) {
            if (differs(a.map[4 * i + j], b.map[4 * i + j], scale)) return false;
        }
    }
    return true;
}

class ModelGluer {
  public:
    ModelGluer(const Gluing& gluing, const Prepared& prepared, const improve::Options& options,
               std::int64_t reach, const Mesh& mesh)
        : gluing_(gluing),
          bound_(prepared.bound),
          held_(*options.held),
          poles_(options.poles),
          reach_(static_cast<double>(reach)) {
        used_.assign(gluing.sides(), std::vector<std::uint8_t>(bound_.surfaces.size(), 0));
        for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
            const std::size_t side = gluing.side_of_nodes(mesh, mesh.facets.nodes.data() + 4 * f, 4, reach);
            if (side < gluing.sides()) used_[side][mesh.facets.surface[f]] = 1;
        }
    }

    std::optional<GluedModel> glue() {
        model_.bound = bound_;
        model_.bound.surfaces.clear();
        model_.bound.bounds.clear();
        const auto count = static_cast<std::uint32_t>(bound_.surfaces.size());
        model_.image.assign(gluing_.sides(), std::vector<std::uint32_t>(count, kNoNode));
        model_.source.resize(gluing_.sides());
        // The tape knows surfaces by their numbers.
        for (std::uint32_t s = 0; s < count; ++s) add(0, s);
        for (std::size_t side = 1; side < gluing_.sides(); ++side) {
            for (std::uint32_t s = 0; s < count; ++s) {
                if (used_[side][s] != 0 && !find_or_add(side, s)) return std::nullopt;
            }
        }
        for (const GluedPair& pair : gluing_.pairs) model_.held[pair.plane[0]] = 0;
        for (std::vector<std::uint32_t>& source : model_.source)
            source.resize(model_.bound.surfaces.size(), kNoNode);
        if (poles_ != nullptr) glue_poles();
        return std::move(model_);
    }

  private:
    /// Distance that a side is moved along a pair's axis, box-local.
    double shift(std::size_t side, std::size_t j) const {
        const auto cells = static_cast<double>(gluing_.pairs[j].shift[Gluing::bit(side, j)]);
        return std::ldexp(cells, -gluing_.level);
    }

    Surface moved(std::size_t side, std::uint32_t surface) const {
        Surface s = bound_.surfaces[surface];
        for (std::size_t j = 0; j < gluing_.pairs.size(); ++j) {
            const std::size_t axis = gluing_.pairs[j].axis;
            for (std::size_t i = 0; i < 3; ++i) s.map[4 * i + 3] -= s.map[4 * i + axis] * shift(side, j);
        }
        return s;
    }

    void set(std::size_t side, std::uint32_t surface, std::uint32_t image) {
        model_.image[side][surface] = image;
        if (model_.source[side].size() <= image) model_.source[side].resize(image + 1, kNoNode);
        model_.source[side][image] = surface;
    }

    void add(std::size_t side, std::uint32_t surface) {
        set(side, surface, static_cast<std::uint32_t>(model_.bound.surfaces.size()));
        model_.bound.surfaces.push_back(moved(side, surface));
        model_.bound.bounds.push_back(bound_.bounds[surface]);
        model_.held.push_back(held_[surface]);
    }

    bool find_or_add(std::size_t side, std::uint32_t surface) {
        const std::size_t pair = gluing_.pair_of(surface);
        if (pair < gluing_.pairs.size()) {
            set(side, surface, gluing_.pairs[pair].plane[0]);
            return true;
        }
        const Surface image = moved(side, surface);
        const std::vector<Surface>& known = model_.bound.surfaces;
        for (std::uint32_t s = 0; s < known.size(); ++s) {
            if (!is_same(image, known[s], bound_.expression_ops)) continue;
            set(side, surface, s);
            return true;
        }
        // Only the first side's apexes are known to be some (improve/stratum.hpp).
        double apex[3];
        if (tape::singular_point(bound_.surfaces[surface], apex) && is_near(side, apex)) return false;
        add(side, surface);
        return true;
    }

    /// Whether a box-local point is near all planes of a side.
    bool is_near(std::size_t side, const double* x) const {
        for (std::size_t j = 0; j < gluing_.pairs.size(); ++j) {
            const std::size_t axis = gluing_.pairs[j].axis;
            const double at = gluing_.origin[axis] + bound_.side * x[axis];
            if (!(std::fabs(gluing_.depth(j, Gluing::bit(side, j), at)) < reach_)) return false;
        }
        return true;
    }

    void glue_poles() {
        for (const tape::Pole& pole : *poles_) {
            for (std::size_t side = 0; side < gluing_.sides(); ++side) {
                if (!is_near(side, pole.at.data())) continue;
                tape::Pole image = pole;
                for (std::size_t j = 0; j < gluing_.pairs.size(); ++j)
                    image.at[gluing_.pairs[j].axis] += shift(side, j);
                const auto renumber = [&](std::vector<std::uint32_t>& list) {
                    for (std::uint32_t& s : list) {
                        if (model_.image[side][s] != kNoNode) s = model_.image[side][s];
                    }
                };
                renumber(image.surfaces);
                renumber(image.through);
                std::sort(image.surfaces.begin(), image.surfaces.end());
                model_.poles.push_back(image);
            }
        }
    }

    const Gluing& gluing_;
    const tape::BoundModel& bound_;
    const std::vector<std::uint8_t>& held_;
    const std::vector<tape::Pole>* poles_;
    double reach_;
    std::vector<std::vector<std::uint8_t>> used_;  ///< per side and surface
    GluedModel model_;
};

class MeshGluer {
  public:
    MeshGluer(const Gluing& gluing, const GluedModel& model, std::int64_t reach, const Mesh& mesh)
        : gluing_(gluing), model_(model), reach_(reach), mesh_(mesh) {
        glued_at_.assign(mesh.node_count(), kNoNode);
        is_beyond_.assign(mesh.node_count(), 0);
        glued_.node.resize(gluing.sides());
    }

    GluedMesh glue() {
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            const ElementBlock& block = mesh_.elements[t];
            const auto count = static_cast<std::size_t>(kElementNodes[t]);
            ElementBlock& to = glued_.mesh.elements[t];
            for (const Placed& p : elements_near(t)) {
                for (std::size_t k = 0; k < count; ++k)
                    to.nodes.push_back(add(block.nodes[p.index * count + k], p.side));
                to.region.push_back(on_side(block.region[p.index], p.side));
                to.kind.push_back(block.kind[p.index]);
                glued_.element[t].push_back(p.index);
            }
        }
        for (std::size_t n = 0; n < glued_.mesh.node_count(); ++n) {
            glued_.is_open.push_back(
                std::any_of(glued_.node.begin(), glued_.node.end(), [&](const std::vector<NodeId>& node) {
                    return node[n] != kNoNode && is_beyond_[node[n]] != 0;
                }));
        }
        glue_facets();
        return std::move(glued_);
    }

  private:
    struct Placed {
        std::uint64_t code;  ///< Morton code of the cell where it is moved to
        std::uint32_t index;
        std::uint32_t side;
        bool operator<(const Placed& other) const {
            return code != other.code ? code < other.code : index < other.index;
        }
    };

    std::uint16_t on_side(std::uint16_t region, std::size_t side) const {
        return static_cast<std::uint16_t>(region + side * gluing_.regions);
    }

    /// The elements of a type near the planes, in Morton order, as improvement wants them; marks nodes of all
    /// others.
    std::vector<Placed> elements_near(std::size_t t) {
        const ElementBlock& block = mesh_.elements[t];
        const auto count = static_cast<std::size_t>(kElementNodes[t]);
        std::vector<Placed> found;
        for (std::uint32_t i = 0; i < block.size(); ++i) {
            const NodeId* node = block.nodes.data() + i * count;
            const std::size_t side = gluing_.side_of_nodes(mesh_, node, count, reach_);
            if (side == gluing_.sides()) {
                for (std::size_t k = 0; k < count; ++k) is_beyond_[node[k]] = 1;
                continue;
            }
            found.push_back({cell_of(node, count, side), i, static_cast<std::uint32_t>(side)});
        }
        std::sort(found.begin(), found.end());
        return found;
    }

    std::uint64_t cell_of(const NodeId* node, std::size_t count, std::size_t side) const {
        std::array<double, 3> at{};
        for (std::size_t k = 0; k < count; ++k) {
            for (std::size_t j = 0; j < 3; ++j)
                at[j] += mesh_.points[3 * std::size_t{node[k]} + j] / static_cast<double>(count);
        }
        for (std::size_t j = 0; j < 3; ++j) at[j] = (at[j] - gluing_.origin[j]) / gluing_.edge;
        for (std::size_t j = 0; j < gluing_.pairs.size(); ++j) {
            const GluedPair& pair = gluing_.pairs[j];
            at[pair.axis] += static_cast<double>(pair.shift[Gluing::bit(side, j)]);
        }
        const auto cell = [&](std::size_t j) { return static_cast<u32>(std::max(at[j], 0.0)); };
        return morton_encode(cell(0), cell(1), cell(2));
    }

    /// The glued node of a node on this side.
    NodeId add(NodeId node, std::size_t side) {
        if (glued_at_[node] != kNoNode && glued_.node[side][glued_at_[node]] == node) return glued_at_[node];
        NodeId original = node;
        std::size_t original_side = side;
        for (std::size_t j = 0; j < gluing_.pairs.size(); ++j) {
            const NodeId partner = gluing_.pairs[j].partner[original];
            if (Gluing::bit(side, j) == 0 || partner == kNoNode) continue;
            original = partner;
            original_side &= ~(std::size_t{1} << j);
        }
        NodeId& at = glued_at_[original];
        if (at == kNoNode) {
            at = static_cast<NodeId>(glued_.mesh.node_count());
            std::array<double, 3> x{};
            std::copy_n(mesh_.points.data() + 3 * std::size_t{original}, 3, x.data());
            for (std::size_t j = 0; j < gluing_.pairs.size(); ++j) {
                const GluedPair& pair = gluing_.pairs[j];
                x[pair.axis] += static_cast<double>(pair.shift[Gluing::bit(original_side, j)]) * gluing_.edge;
            }
            glued_.mesh.points.insert(glued_.mesh.points.end(), x.begin(), x.end());
            for (std::vector<NodeId>& numbers : glued_.node) numbers.push_back(kNoNode);
        }
        glued_.node[side][at] = node;
        glued_at_[node] = at;
        return at;
    }

    FaceKey key(std::size_t f) const {
        FaceKey nodes;
        for (std::size_t k = 0; k < 4; ++k) nodes[k] = glued_at_[mesh_.facets.nodes[4 * f + k]];
        return facet_key(nodes);
    }

    void glue_facets() {
        const FacetBlock& from = mesh_.facets;
        struct Near {
            std::uint32_t index;
            std::size_t side;
            std::size_t pair;
        };
        std::vector<Near> near;
        std::vector<std::pair<FaceKey, std::uint32_t>> second;  ///< of second planes
        for (std::uint32_t f = 0; f < from.size(); ++f) {
            const NodeId* node = from.nodes.data() + 4 * std::size_t{f};
            const std::size_t side = gluing_.side_of_nodes(mesh_, node, 4, reach_);
            if (side == gluing_.sides() ||
                std::any_of(node, node + 4, [&](NodeId n) { return glued_at_[n] == kNoNode; }))
                continue;
            const std::size_t pair = gluing_.pair_of(from.surface[f]);
            if (pair < gluing_.pairs.size() && Gluing::bit(side, pair) == 1) {
                second.push_back({key(f), f});
            } else {
                near.push_back({f, side, pair});
            }
        }
        std::sort(second.begin(), second.end());
        FacetBlock& to = glued_.mesh.facets;
        for (const Near& facet : near) {
            const std::uint32_t f = facet.index;
            std::uint32_t image = kNoNode;
            std::uint16_t outside =
                from.outside[f] != 0 ? on_side(from.outside[f], facet.side) : from.outside[f];
            if (facet.pair < gluing_.pairs.size()) {
                const auto found =
                    std::lower_bound(second.begin(), second.end(), std::make_pair(key(f), std::uint32_t{0}));
                if (found == second.end() || found->first != key(f)) continue;
                image = found->second;
                outside = on_side(from.inside[image], facet.side | std::size_t{1} << facet.pair);
            }
            for (std::size_t k = 0; k < 4; ++k)
                to.nodes.push_back(glued_at_[from.nodes[4 * std::size_t{f} + k]]);
            to.surface.push_back(model_.image[facet.side][from.surface[f]]);
            to.inside.push_back(on_side(from.inside[f], facet.side));
            to.outside.push_back(outside);
            glued_.facet[0].push_back(f);
            glued_.facet[1].push_back(image);
        }
    }

    const Gluing& gluing_;
    const GluedModel& model_;
    std::int64_t reach_;
    const Mesh& mesh_;
    std::vector<NodeId> glued_at_;         ///< per node of the mesh
    std::vector<std::uint8_t> is_beyond_;  ///< per node of the mesh: an element around it is not taken
    GluedMesh glued_;
};

}  // namespace

double Gluing::depth(std::size_t pair, std::size_t which, double x) const {
    const GluedPair& p = pairs[pair];
    const double along = (x - origin[p.axis]) / edge - static_cast<double>(p.cell[which]);
    return p.at[which] < p.at[1 - which] ? along : -along;
}

std::size_t Gluing::side_of_nodes(const Mesh& mesh, const NodeId* node, std::size_t count,
                                  std::int64_t reach) const {
    std::size_t side = 0;
    for (std::size_t j = 0; j < pairs.size(); ++j) {
        const auto is_near = [&](std::size_t which) {
            return std::any_of(node, node + count, [&](NodeId n) {
                return depth(j, which, mesh.points[3 * std::size_t{n} + pairs[j].axis]) <
                       static_cast<double>(reach);
            });
        };
        if (is_near(0)) continue;
        if (!is_near(1)) return sides();
        side |= std::size_t{1} << j;
    }
    return side;
}

std::size_t Gluing::pair_of(std::uint32_t surface) const {
    std::size_t j = 0;
    while (j < pairs.size() && surface != pairs[j].plane[0] && surface != pairs[j].plane[1]) ++j;
    return j;
}

std::optional<Gluing> make_gluing(const Prepared& prepared, const std::vector<const PeriodicAxis*>& pairs,
                                  Mesh& mesh) {
    const tape::BoundModel& bound = prepared.bound;
    Gluing gluing;
    gluing.level = prepared.tree.level;
    gluing.origin = {bound.origin[0], bound.origin[1], bound.origin[2]};
    gluing.edge = std::ldexp(bound.side, -gluing.level);
    std::size_t regions = 0;
    for (const ElementBlock& block : mesh.elements) {
        for (const std::uint16_t region : block.region) regions = std::max<std::size_t>(regions, region);
    }
    for (const PeriodicAxis* pair : pairs) {
        GluedPair glued;
        glued.pair = pair;
        glued.axis = pair->axis;
        glued.plane = {bound.periodic[pair->pair].first, bound.periodic[pair->pair].second};
        glued.at = {pair->first, pair->second};
        for (std::size_t which = 0; which < 2; ++which) {
            glued.cell[which] = std::llround((glued.at[which] - gluing.origin[glued.axis]) / gluing.edge);
            glued.shift[which] = (std::int64_t{1} << (gluing.level - 1)) - glued.cell[which];
        }
        glued.partner = match_plane(*pair, bound, prepared.root.cell(), mesh);
        if (glued.partner.empty()) return std::nullopt;
        gluing.pairs.push_back(std::move(glued));
    }
    if (regions * gluing.sides() > 0xffff) return std::nullopt;
    gluing.regions = static_cast<std::uint16_t>(regions);
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        if (mesh.facets.outside[f] != 0 && gluing.pair_of(mesh.facets.surface[f]) < pairs.size())
            return std::nullopt;
    }
    for (std::size_t j = 0; j < pairs.size(); ++j) {
        for (std::size_t n = 0; n < mesh.node_count(); ++n) {
            const double x = mesh.points[3 * n + gluing.pairs[j].axis];
            if (std::min(gluing.depth(j, 0, x), gluing.depth(j, 1, x)) < -kBehind) return std::nullopt;
        }
    }
    return gluing;
}

std::optional<GluedModel> glue_model(const Gluing& gluing, const Prepared& prepared,
                                     const improve::Options& options, std::int64_t reach, const Mesh& mesh) {
    return ModelGluer(gluing, prepared, options, reach, mesh).glue();
}

GluedMesh glue_mesh(const Gluing& gluing, const GluedModel& model, std::int64_t reach, const Mesh& mesh) {
    return MeshGluer(gluing, model, reach, mesh).glue();
}

}  // namespace mortise::pipeline
