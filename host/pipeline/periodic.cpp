#include "host/pipeline/periodic.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "host/common/face_key.hpp"
#include "host/common/facet_middle.hpp"
#include "host/common/message_text.hpp"
#include "host/common/sort_unique.hpp"
#include "host/tape/reference.hpp"

namespace mortise::pipeline {
namespace {

/// Two roots of the same edge differ by the rounding of positions: two steps of the lattice, in cells.
constexpr double kSamePlace = 3.1e-8;
constexpr double kAcross = 1e-12;
constexpr double kInset = 1e-3;  ///< cells: how far from a plane its region is asked

std::string start_of(const Model& model, const PeriodicPair& pair) {
    if (pair.where.line == 0) return model.source + ": periodic faces across " + pair.name + ": ";
    return model.source + ":" + std::to_string(pair.where.line) + ":" + std::to_string(pair.where.column) +
           ": identify periodic " + pair.name + ": ";
}

/// The axis across which a plane lies, and its place there; 3: none.
std::size_t axis_of(const Surface& plane, double& at) {
    for (std::size_t j = 0; j < 3; ++j) {
        const double across = std::fabs(plane.map[j]);
        const double off = std::max(std::fabs(plane.map[(j + 1) % 3]), std::fabs(plane.map[(j + 2) % 3]));
        if (!(off <= kAcross * across)) continue;
        at = -plane.map[3] / plane.map[j];
        return j;
    }
    return 3;
}

/// Matches the facets of two planes.
class Matcher {
  public:
    /// `facet_surface`: by facet, the surface of `bound`.
    Matcher(const PeriodicAxis& pair, const tape::BoundModel& bound, double cell,
            const std::vector<std::uint32_t>& facet_surface, Mesh& mesh)
        : pair_(pair), bound_(bound), cell_(cell), mesh_(mesh) {
        facets_[0] = facets_on(facet_surface, bound.periodic[pair.pair].first);
        facets_[1] = facets_on(facet_surface, bound.periodic[pair.pair].second);
    }

    /// Gives nodes of the second plane the places of those of the first; copy_of[n] of each is its original.
    void place_nodes(std::vector<NodeId>& copy_of) {
        const std::size_t u = (pair_.axis + 1) % 3, v = (pair_.axis + 2) % 3;
        std::vector<NodeId> originals = nodes_of(facets_[0]);
        std::vector<NodeId> copies = nodes_of(facets_[1]);
        const auto less = [&](NodeId a, NodeId b) { return at(a, u) < at(b, u); };
        std::sort(originals.begin(), originals.end(), less);
        partner_.assign(mesh_.node_count(), kNoNode);
        const double reach = kSamePlace * cell_;
        for (const NodeId node : copies) {
            auto candidate = std::lower_bound(originals.begin(), originals.end(), at(node, u) - reach,
                                              [&](NodeId n, double x) { return at(n, u) < x; });
            for (; candidate != originals.end() && at(*candidate, u) <= at(node, u) + reach; ++candidate) {
                if (std::fabs(at(*candidate, v) - at(node, v)) <= reach) partner_[node] = *candidate;
            }
        }
        for (const NodeId n : originals) at(n, pair_.axis) = pair_.first;
        for (const NodeId n : copies) {
            at(n, pair_.axis) = pair_.second;
            if (partner_[n] == kNoNode) continue;
            at(n, u) = at(partner_[n], u);
            at(n, v) = at(partner_[n], v);
            copy_of[n] = copy_of[partner_[n]];
        }
    }

    struct Unmatched {
        std::uint32_t facet;
        std::size_t side;  ///< 0: of the first plane
    };

    /// The facets of each plane without their image on the other.
    std::vector<Unmatched> unmatched() const {
        std::array<std::vector<Key>, 2> keys;
        for (std::size_t side = 0; side < 2; ++side) {
            for (const std::uint32_t f : facets_[side]) keys[side].push_back(key_of(f, side == 1));
            std::sort(keys[side].begin(), keys[side].end());
        }
        std::vector<Unmatched> found;
        for (std::size_t side = 0; side < 2; ++side) {
            const std::vector<Key>& others = keys[1 - side];
            for (const std::uint32_t f : facets_[side]) {
                if (!std::binary_search(others.begin(), others.end(), key_of(f, side == 1)))
                    found.push_back({f, side});
            }
        }
        return found;
    }

    const std::vector<NodeId>& partners() const { return partner_; }

    /// Neither plane has facets.
    bool is_empty() const { return facets_[0].empty() && facets_[1].empty(); }

    /// Region at the inner side of a plane at this place.
    std::int32_t region_inside(Vec3 x, std::size_t side) const {
        x[pair_.axis] = side == 0 ? pair_.first : pair_.second;
        const double inward = (pair_.second > pair_.first) == (side == 0) ? 1 : -1;
        x[pair_.axis] += inward * kInset * cell_;
        for (std::size_t j = 0; j < 3; ++j) x[j] = (x[j] - bound_.origin[j]) / bound_.side;
        return tape::region_at(bound_, x[0], x[1], x[2]);
    }

  private:
    struct Key {
        FaceKey node;  ///< of originals
        std::uint16_t inside;
        bool operator<(const Key& other) const {
            return node != other.node ? node < other.node : inside < other.inside;
        }
    };

    double& at(NodeId node, std::size_t axis) { return mesh_.points[3 * std::size_t{node} + axis]; }

    static std::vector<std::uint32_t> facets_on(const std::vector<std::uint32_t>& facet_surface,
                                                std::uint32_t surface) {
        std::vector<std::uint32_t> found;
        for (std::uint32_t f = 0; f < facet_surface.size(); ++f) {
            if (facet_surface[f] == surface) found.push_back(f);
        }
        return found;
    }

    std::vector<NodeId> nodes_of(const std::vector<std::uint32_t>& facets) const {
        std::vector<NodeId> nodes;
        for (const std::uint32_t f : facets) {
            const auto first = mesh_.facets.nodes.begin() + 4 * static_cast<std::ptrdiff_t>(f);
            nodes.insert(nodes.end(), first, first + 4);
        }
        sort_unique(nodes);
        return nodes;
    }

    Key key_of(std::uint32_t facet, bool is_copy) const {
        Key key{};
        key.inside = mesh_.facets.inside[facet];
        for (std::size_t k = 0; k < 4; ++k) {
            const NodeId node = mesh_.facets.nodes[4 * std::size_t{facet} + k];
            key.node[k] = is_copy ? partner_[node] : node;
        }
        key.node = facet_key(key.node);
        return key;
    }

    const PeriodicAxis& pair_;
    const tape::BoundModel& bound_;
    double cell_;
    Mesh& mesh_;
    std::array<std::vector<std::uint32_t>, 2> facets_;
    std::vector<NodeId> partner_;  ///< per node of the second plane, else kNoNode
};

}  // namespace

std::vector<PeriodicAxis> periodic_axes(const tape::CompiledModel& compiled, const Model& model,
                                        std::vector<std::string>* why) {
    std::vector<PeriodicAxis> result;
    for (std::size_t i = 0; i < compiled.periodic.size(); ++i) {
        const tape::PeriodicSurfaces& pair = compiled.periodic[i];
        const auto refuse = [&](const std::string& reason) {
            if (why != nullptr) why->push_back(start_of(model, model.periodic[i]) + reason);
        };
        if (std::max(pair.first, pair.second) == tape::PeriodicSurfaces::kNoSurface) {
            refuse("one of the two bounds no region; there are no faces to match");
            continue;
        }
        PeriodicAxis axis;
        axis.pair = i;
        const Surface& first = compiled.surfaces[pair.first].surface;
        const Surface& second = compiled.surfaces[pair.second].surface;
        axis.axis = first.kind == kSurfacePlane ? axis_of(first, axis.first) : 3;
        const std::size_t other = second.kind == kSurfacePlane ? axis_of(second, axis.second) : 3;
        if (axis.axis == 3 || other != axis.axis || axis.first == axis.second) {
            refuse("expected two planes across the same axis; these faces are not made to match");
            continue;
        }
        result.push_back(axis);
    }
    return result;
}

void split_images(const tape::BoundModel& bound, const std::vector<PeriodicAxis>& axes,
                  const std::vector<TreeNode>& nodes, int level, std::vector<std::uint8_t>& which) {
    if (axes.empty()) return;
    std::vector<std::uint32_t> order(nodes.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::uint32_t>(i);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return nodes[a].morton < nodes[b].morton; });
    const double cells = std::ldexp(1.0, level);
    const auto grid_plane = [&](std::size_t axis, double at) {
        return std::llround((at - bound.origin[axis]) / bound.side * cells);
    };
    // Images of images at edges and corners: once for each pair.
    for (std::size_t round = 0; round < axes.size(); ++round) {
        for (const PeriodicAxis& pair : axes) {
            const std::int64_t planes[2] = {grid_plane(pair.axis, pair.first),
                                            grid_plane(pair.axis, pair.second)};
            for (std::size_t i = 0; i < nodes.size(); ++i) {
                if (which[i] == 0) continue;
                const u64 code = nodes[i].morton;
                std::array<std::int64_t, 3> at = {gather_bits(code), gather_bits(code >> 1),
                                                  gather_bits(code >> 2)};
                for (int side = 0; side < 2; ++side) {
                    const std::int64_t beside = at[pair.axis] - planes[side];
                    if (beside != 0 && beside != -1) continue;
                    std::array<std::int64_t, 3> image = at;
                    image[pair.axis] = planes[1 - side] + beside;
                    if (image[pair.axis] < 0 || image[pair.axis] >= std::int64_t{1} << level) continue;
                    const u64 wanted = morton_encode(static_cast<u32>(image[0]), static_cast<u32>(image[1]),
                                                     static_cast<u32>(image[2]));
                    const auto found = std::lower_bound(
                        order.begin(), order.end(), wanted,
                        [&](std::uint32_t n, u64 morton) { return nodes[n].morton < morton; });
                    if (found != order.end() && nodes[*found].morton == wanted) which[*found] = 1;
                }
            }
        }
    }
}

std::vector<std::uint8_t> held_surfaces(const tape::BoundModel& bound,
                                        const std::vector<PeriodicAxis>& axes) {
    std::vector<std::uint8_t> held(axes.empty() ? 0 : bound.surfaces.size(), 0);
    for (const PeriodicAxis& axis : axes) {
        held[bound.periodic[axis.pair].first] = 1;
        held[bound.periodic[axis.pair].second] = 1;
    }
    return held;
}

std::vector<NodeId> match_plane(const PeriodicAxis& axis, const tape::BoundModel& bound, double cell,
                                Mesh& mesh) {
    std::vector<NodeId> copy_of(mesh.node_count());
    Matcher matcher(axis, bound, cell, mesh.facets.surface, mesh);
    matcher.place_nodes(copy_of);
    return matcher.unmatched().empty() ? matcher.partners() : std::vector<NodeId>{};
}

std::vector<NodeId> match_planes(const std::vector<PeriodicAxis>& axes, const Model& model,
                                 const tape::BoundModel& bound, double cell, Mesh& mesh,
                                 std::vector<std::string>& warnings) {
    std::vector<NodeId> copy_of(mesh.node_count());
    for (std::size_t n = 0; n < copy_of.size(); ++n) copy_of[n] = static_cast<NodeId>(n);
    for (const PeriodicAxis& axis : axes) {
        Matcher matcher(axis, bound, cell, mesh.facets.surface, mesh);
        matcher.place_nodes(copy_of);
        if (matcher.is_empty())
            warnings.push_back(start_of(model, model.periodic[axis.pair]) +
                               "the solid does not reach these faces");
        const std::vector<Matcher::Unmatched> unmatched = matcher.unmatched();
        if (unmatched.empty()) continue;
        const auto name = [&](std::int32_t region) {
            return region > 0 ? "'" + model.regions[static_cast<std::size_t>(region) - 1].name + "'"
                              : std::string("no region");
        };
        const std::string text = start_of(model, model.periodic[axis.pair]) +
                                 std::to_string(unmatched.size()) +
                                 " facets have no image on the other plane";
        std::string reason =
            "; the first is at " + place_text(facet_middle(mesh, unmatched[0].facet)) +
            ", where rounding may decide, or the balance of cells of several sizes; cells of one size, other "
            "cells (--level) or planes may match";
        for (const Matcher::Unmatched& u : unmatched) {
            const Vec3 x = facet_middle(mesh, u.facet);
            const std::int32_t here = matcher.region_inside(x, u.side);
            const std::int32_t there = matcher.region_inside(x, 1 - u.side);
            if (here == there) continue;
            reason = ": the model differs, at " + place_text(x) + " is " + name(here) + ", at its image " +
                     name(there);
            break;
        }
        warnings.push_back(text + reason);
    }
    return copy_of;
}

std::vector<PeriodicNodes> pair_nodes(const std::vector<PeriodicAxis>& axes, const tape::BoundModel& bound,
                                      double cell, const std::vector<std::uint32_t>& facet_surface,
                                      Mesh& mesh) {
    std::vector<PeriodicNodes> result;
    std::vector<NodeId> copy_of(mesh.node_count());
    for (const PeriodicAxis& axis : axes) {
        Matcher matcher(axis, bound, cell, facet_surface, mesh);
        matcher.place_nodes(copy_of);
        if (matcher.is_empty() || !matcher.unmatched().empty()) continue;
        PeriodicNodes nodes;
        nodes.shift[axis.axis] = axis.second - axis.first;
        for (std::size_t n = 0; n < mesh.node_count(); ++n) {
            if (matcher.partners()[n] == kNoNode) continue;
            nodes.node.push_back(static_cast<NodeId>(n));
            nodes.original.push_back(matcher.partners()[n]);
        }
        result.push_back(std::move(nodes));
    }
    return result;
}

}  // namespace mortise::pipeline
