// Results of the certificate: elements, facets and node codes of one cell.
#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "host/cnio/certificate.hpp"

namespace mortise::cnio {
namespace {

/// The nodes of a triangle or quadrilateral in ascending order, as one number; kNoNode is the last of a
/// triangle.
FaceKey key_of(std::array<LocalNode, 4> node) {
    static_assert(4 * sizeof(LocalNode) == sizeof(FaceKey));
    const auto order = [&](std::size_t a, std::size_t b) {
        if (node[b] < node[a]) std::swap(node[a], node[b]);
    };
    order(0, 1);
    order(2, 3);
    order(0, 2);
    order(1, 3);
    order(1, 2);
    FaceKey key = 0;
    for (const LocalNode n : node) key = key << 16 | n;
    return key;
}

}  // namespace

std::uint32_t Certificate::facet_surface(const LocalNode* node, std::size_t count, const std::int8_t* a,
                                         const std::int8_t* b) const {
    std::uint32_t found = kNoSurface;
    LatticePoint middle{};
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t j = 0; j < 3; ++j)
            middle[j] += cell_.nodes()[node[i]].point[j] / static_cast<std::int32_t>(count);
    }
    for (std::size_t s = 0; s < cell_.surface_count(); ++s) {
        bool on = cell_.is_named(s);
        for (std::size_t i = 0; i < count; ++i) on = on && cell_.sign(node[i], s) == 0;
        if (!on) continue;
        // The surface that parts the two sides, if one of several is known to.
        if (a != nullptr && b != nullptr && a[s] * b[s] < 0) return cell_.model_surface(s, middle);
        if (found == kNoSurface) found = cell_.model_surface(s, middle);
    }
    if (found == kNoSurface && a != nullptr && b != nullptr) {
        for (std::size_t s = 0; s < cell_.surface_count(); ++s) {
            if (cell_.is_named(s) && a[s] != b[s]) return cell_.model_surface(s, middle);
        }
    }
    return found;
}

void Certificate::collect(CellRecord& record, CellArena& arena) {
    used_.assign(cell_.nodes().size(), 0);
    for (const Whole& whole : whole_) {
        const auto size = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(whole.type)]);
        for (std::size_t i = 0; i < size; ++i) use(whole.node[i]);
    }
    for (std::size_t i = 0; i < simplices_.size(); ++i) {
        if (simplex_region_[i] <= 0) continue;
        for (const LocalNode node : simplices_[i].node) use(node);
    }
    for (std::size_t i = 0; i < pyramids_.size(); ++i) {
        if (pyramid_region_[i] <= 0) continue;
        for (const LocalNode node : pyramids_[i].node) use(node);
    }
    assign_codes(record, arena);
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        record.first_element[t] = static_cast<std::uint32_t>(arena.regions[t].size());
    }
    const auto add = [&](ElementType type, const LocalNode* node, std::int32_t region) {
        const auto t = static_cast<std::size_t>(type);
        for (int i = 0; i < kElementNodes[t]; ++i) arena.nodes[t].push_back(code_[node[i]]);
        arena.regions[t].push_back(static_cast<std::uint16_t>(region));
    };
    for (const Whole& whole : whole_) add(whole.type, whole.node.data(), whole_region_);
    for (std::size_t i = 0; i < pyramids_.size(); ++i) {
        if (pyramid_region_[i] > 0) add(ElementType::kPyramid, pyramids_[i].node.data(), pyramid_region_[i]);
    }
    for (std::size_t i = 0; i < simplices_.size(); ++i) {
        if (simplex_region_[i] > 0)
            add(ElementType::kTetrahedron, simplices_[i].node.data(), simplex_region_[i]);
    }
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        record.element_count[t] =
            static_cast<std::uint32_t>(arena.regions[t].size()) - record.first_element[t];
    }
    collect_face_facets(record, arena);
    collect_inner_facets(record, arena);
}

void Certificate::assign_codes(CellRecord& record, CellArena& arena) {
    const auto& nodes = cell_.nodes();
    code_.assign(nodes.size(), 0xffff);
    std::vector<std::pair<NodeKey, LocalNode>> extras;
    record.first_edge_root = static_cast<std::uint32_t>(arena.edge_roots.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        if (nodes[i].code < kExtraCode) {
            // Corners and edges have codes even if only a neighbour uses them. Nodes are in the order of
            // edges.
            code_[i] = nodes[i].code;
            if (used_[i] == 0) continue;
            record.used |= 1u << nodes[i].code;
            if (nodes[i].code >= 8) {
                const std::int32_t root = nodes[i].point[static_cast<std::size_t>((nodes[i].code - 8) / 4)];
                arena.edge_roots.push_back(root / (cell_.units() / kCellUnits));
            }
            continue;
        }
        // Nodes beside finer leaves may be these leaves' own.
        const bool beside_finer = nodes[i].faces != 0 && cell_.units() != kCellUnits;
        if (used_[i] == 0 && !beside_finer) continue;
        std::array<std::int64_t, 3> at{};
        for (std::size_t j = 0; j < 3; ++j) {
            at[j] = cell_.key(static_cast<int>(j), nodes[i].point[j]);
        }
        extras.push_back({{at[0], at[1], at[2]}, static_cast<LocalNode>(i)});
    }
    std::sort(extras.begin(), extras.end());
    record.first_extra = static_cast<std::uint32_t>(arena.extras.size());
    record.extra_count = static_cast<std::uint32_t>(extras.size());
    for (std::size_t i = 0; i < extras.size(); ++i) {
        code_[extras[i].second] = static_cast<std::uint16_t>(kExtraCode + i);
        arena.extras.push_back(extras[i].first);
        arena.extra_used.push_back(used_[extras[i].second]);
        const Node& node = nodes[extras[i].second];
        LatticePoint move{};
        for (std::size_t j = 0; j < 3; ++j) move[j] = (node.target[j] - node.point[j]) * cell_.key_step();
        arena.extra_moves.push_back(move);
    }
}

void Certificate::collect_face_facets(CellRecord& record, CellArena& arena) {
    const auto& nodes = cell_.nodes();
    // Region behind each facet: the simplex or pyramid whose side it is.
    for (auto& list : behind_) list.clear();
    const auto face_of = [&](const LocalNode* v, std::size_t count) {
        std::uint8_t common = 0x3f;
        for (std::size_t i = 0; i < count; ++i) common &= nodes[v[i]].faces;
        return common;
    };
    for (std::size_t i = 0; i < simplices_.size(); ++i) {
        for (std::size_t skip = 0; skip < 4; ++skip) {
            std::array<LocalNode, 4> node{};
            std::size_t at = 0;
            for (std::size_t k = 0; k < 4; ++k) {
                if (k != skip) node[at++] = simplices_[i].node[k];
            }
            const std::uint8_t common = face_of(node.data(), 3);
            if (common == 0) continue;
            node[3] = kNoNode;
            behind_[static_cast<std::size_t>(__builtin_ctz(common))].push_back(
                {key_of(node), simplex_region_[i]});
        }
    }
    for (std::size_t i = 0; i < pyramids_.size(); ++i) {
        const std::array<LocalNode, 4> node = {pyramids_[i].node[0], pyramids_[i].node[1],
                                               pyramids_[i].node[2], pyramids_[i].node[3]};
        const std::uint8_t common = face_of(node.data(), 4);
        behind_[static_cast<std::size_t>(__builtin_ctz(common))].push_back(
            {key_of(node), pyramid_region_[i]});
    }
    for (int p = 0; p < kPatches; ++p) {
        auto& behind = behind_[static_cast<std::size_t>(p / 4)];
        record.first_face_facet[static_cast<std::size_t>(p)] =
            static_cast<std::uint32_t>(arena.face_facets.size());
        if (p % 4 == 0) std::sort(behind.begin(), behind.end());
        for (const Facet& facet : cell_.patch(p)) {
            FaceFacet out{};
            const FaceKey key = key_of(
                {facet.node[0], facet.node[1], facet.node[2], facet.count == 4 ? facet.node[3] : kNoNode});
            const auto found = std::lower_bound(
                behind.begin(), behind.end(), std::make_pair(key, std::numeric_limits<std::int32_t>::min()));
            std::int32_t region = whole_region_;
            if (found != behind.end() && found->first == key) region = found->second;
            out.region = static_cast<std::uint16_t>(region);
            for (std::size_t i = 0; i < 4; ++i) {
                out.node[i] = code_[facet.node[i]];
                out.corner[i] = static_cast<std::uint8_t>(cell_.patch_corner(p, facet.node[i]));
            }
            out.surface = facet_surface(facet.node, facet.count, nullptr, nullptr);
            arena.face_facets.push_back(out);
        }
    }
    record.first_face_facet[kPatches] = static_cast<std::uint32_t>(arena.face_facets.size());
}

bool Certificate::has_one_region() const {
    std::int32_t low = 0x7fffffff;
    std::int32_t high = -1;
    for (const auto* regions : {&simplex_region_, &pyramid_region_}) {
        for (const std::int32_t region : *regions) {
            low = std::min(low, region);
            high = std::max(high, region);
        }
    }
    return low >= high;
}

/// Calls visit(a, b, c) for the triangles of an owner: a simplex, or behind these a pyramid.
template <class Visit>
void Certificate::for_sides_of(std::size_t owner, const Visit& visit) const {
    const bool is_simplex = owner < simplices_.size();
    const LocalNode* const v =
        is_simplex ? simplices_[owner].node.data() : pyramids_[owner - simplices_.size()].node.data();
    const LocalFaces faces = is_simplex ? local_faces(ElementType::kTetrahedron)
                                        : LocalFaces{kPyramidFaces.data() + 1, 4};  // the base lies in a face
    for (int f = 0; f < faces.count; ++f) {
        const LocalFace& face = faces.faces[f];
        visit(v[face[0]], v[face[1]], v[face[2]]);
    }
}

/// Fills sides_ with the triangles inside the cell, equal ones side by side.
void Certificate::list_sides() {
    const auto& nodes = cell_.nodes();
    sides_.clear();
    for (std::size_t owner = 0; owner < simplices_.size() + pyramids_.size(); ++owner) {
        for_sides_of(owner, [&](LocalNode a, LocalNode b, LocalNode c) {
            if ((nodes[a].faces & nodes[b].faces & nodes[c].faces) == 0)  // else on a face of the cell
                sides_.push_back({key_of({a, b, c, kNoNode}), static_cast<std::uint32_t>(owner)});
        });
    }
    std::sort(sides_.begin(), sides_.end());
}

void Certificate::collect_inner_facets(CellRecord& record, CellArena& arena) {
    record.first_facet = static_cast<std::uint32_t>(arena.facets.size());
    if (has_one_region()) return;
    list_sides();
    const std::size_t n = cell_.surface_count();
    const auto region_of = [&](std::size_t owner) {
        return owner < simplices_.size() ? simplex_region_[owner]
                                         : pyramid_region_[owner - simplices_.size()];
    };
    const auto signs_of = [&](std::size_t owner) {
        return owner < simplices_.size() ? simplex_signs_.data() + owner * n
                                         : pyramid_signs_.data() + (owner - simplices_.size()) * n;
    };
    for (std::size_t i = 0; i + 1 < sides_.size(); ++i) {
        if (sides_[i].first != sides_[i + 1].first) continue;
        std::size_t inner = sides_[i].second;
        std::size_t outer = sides_[i + 1].second;
        if (region_of(inner) == region_of(outer)) continue;
        // The outward side is that of the region listed as `inside`: the one that exists, or the lower
        // number.
        const std::int32_t a = region_of(inner);
        const std::int32_t b = region_of(outer);
        if (a == 0 || (b != 0 && b < a)) std::swap(inner, outer);
        std::array<LocalNode, 3> outward{};
        for_sides_of(inner, [&](LocalNode p, LocalNode q, LocalNode r) {
            if (key_of({p, q, r, kNoNode}) == sides_[i].first) outward = {p, q, r};
        });
        InnerFacet facet{};
        for (std::size_t k = 0; k < 4; ++k) facet.node[k] = code_[outward[std::min<std::size_t>(k, 2)]];
        facet.surface = facet_surface(outward.data(), 3, signs_of(inner), signs_of(outer));
        facet.inside = static_cast<std::uint16_t>(region_of(inner));
        facet.outside = static_cast<std::uint16_t>(region_of(outer));
        arena.facets.push_back(facet);
    }
    record.facet_count = static_cast<std::uint32_t>(arena.facets.size()) - record.first_facet;
}

}  // namespace mortise::cnio
