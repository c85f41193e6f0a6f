// Combinatorics of one boundary cell; see pattern.hpp for the numbering.
#include "host/templates/pattern.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace mortise::templates {
namespace {

constexpr NodeCode kNoNode = 31;

/// The four corners of a face, counter-clockwise seen from outside the cell.
std::array<int, 4> face_corners(int face) {
    const int axis = face / 2;
    const int side = face % 2;
    const int b = 1 << (axis + 1) % 3;
    const int c = 1 << (axis + 2) % 3;
    const int base = side << axis;
    if (side == 1) return {base, base + b, base + b + c, base + c};
    return {base, base + c, base + b + c, base + b};
}

bool inside(Pattern pattern, int corner) { return (pattern >> corner & 1) != 0; }

bool is_ambiguous(Pattern pattern, int face) {
    const auto corners = face_corners(face);
    const bool first = inside(pattern, corners[0]);
    return inside(pattern, corners[2]) == first && inside(pattern, corners[1]) != first &&
           inside(pattern, corners[3]) != first;
}

bool is_connected(Pattern corners) {
    if (corners == 0) return false;
    std::uint32_t reached = corners & (~corners + 1U);
    for (;;) {
        std::uint32_t grown = reached;
        for (int c = 0; c < kCorners; ++c) {
            if ((reached >> c & 1U) != 0) grown |= (1U << (c ^ 1)) | (1U << (c ^ 2)) | (1U << (c ^ 4));
        }
        grown &= corners;
        if (grown == reached) return reached == corners;
        reached = grown;
    }
}

}  // namespace

int bits(std::uint32_t mask) {
    int count = 0;
    for (; mask != 0; mask &= mask - 1) ++count;
    return count;
}

std::array<int, 2> edge_corners(int edge) {
    const int axis = edge / 4;
    const int k = edge % 4;
    const int first = axis == 0 ? 2 : 1;
    const int second = axis == 2 ? 2 : 4;
    const int low = (k & 1) * first + (k >> 1) * second;
    return {low, low + (1 << axis)};
}

int edge_between(int corner_a, int corner_b) {
    for (int e = 0; e < kEdges; ++e) {
        const auto ends = edge_corners(e);
        if (ends[0] == std::min(corner_a, corner_b) && ends[1] == std::max(corner_a, corner_b)) return e;
    }
    return -1;
}

bool on_face(NodeCode node, int face) {
    const int axis = face / 2;
    const int side = face % 2;
    if (node < kFirstCut) return (node >> axis & 1) == side;
    if (node >= kInteriorNode) return false;
    const auto ends = edge_corners(node - kFirstCut);
    return (ends[0] >> axis & 1) == side && (ends[1] >> axis & 1) == side;
}

NodeSet face_nodes(int face) {
    NodeSet nodes = 0;
    for (NodeCode node = 0; node < kInteriorNode; ++node) {
        if (on_face(node, face)) nodes |= 1U << node;
    }
    return nodes;
}

Facet triangle(NodeCode a, NodeCode b, NodeCode c) { return {{a, b, c, kNoNode}, 3}; }
Facet quad(NodeCode a, NodeCode b, NodeCode c, NodeCode d) { return {{a, b, c, d}, 4}; }

Facet reversed(const Facet& facet) {
    Facet result = facet;
    std::reverse(result.nodes.begin(), result.nodes.begin() + facet.size);
    return result;
}

std::uint32_t facet_key(const Facet& facet) {
    const auto begin = facet.nodes.begin();
    const auto start = std::min_element(begin, begin + facet.size) - begin;
    std::uint32_t key = 0;
    for (int i = 0; i < 4; ++i) {
        const auto at = static_cast<std::size_t>((start + i) % facet.size);
        key = key << 5 | (i < facet.size ? facet.nodes[at] : kNoNode);
    }
    return key;
}

NodeSet node_set(const Facet& facet) {
    NodeSet nodes = 0;
    for (int i = 0; i < facet.size; ++i) nodes |= 1U << facet.nodes[static_cast<std::size_t>(i)];
    return nodes;
}

std::vector<NodeCode> node_list(NodeSet nodes) {
    std::vector<NodeCode> list;
    for (NodeCode i = 0; i < kNodeCodes; ++i) {
        if ((nodes >> i & 1U) != 0) list.push_back(i);
    }
    return list;
}

std::vector<Facet> element_facets(const Element& element) {
    const LocalFaces local = local_faces(element.type);
    std::vector<Facet> facets;
    for (int f = 0; f < local.count; ++f) {
        const LocalFace& face = local.faces[f];
        const auto node = [&](int i) {
            return element.nodes[static_cast<std::size_t>(face[static_cast<std::size_t>(i)])];
        };
        facets.push_back(face[3] < 0 ? triangle(node(0), node(1), node(2))
                                     : quad(node(0), node(1), node(2), node(3)));
    }
    return facets;
}

const std::vector<Symmetry>& symmetries() {
    static const std::vector<Symmetry> all = [] {
        std::vector<Symmetry> list;
        std::array<int, 3> axes = {0, 1, 2};
        do {
            const bool odd = (axes[0] > axes[1]) ^ (axes[0] > axes[2]) ^ (axes[1] > axes[2]);
            for (int flip = 0; flip < 8; ++flip) {
                Symmetry symmetry;
                symmetry.mirror = odd ^ (bits(static_cast<std::uint32_t>(flip)) % 2 == 1);
                for (int c = 0; c < kCorners; ++c) {
                    int image = 0;
                    for (std::size_t a = 0; a < 3; ++a) image |= (c >> a & 1) << axes[a];
                    symmetry.image[static_cast<std::size_t>(c)] = static_cast<NodeCode>(image ^ flip);
                }
                for (int e = 0; e < kEdges; ++e) {
                    const auto ends = edge_corners(e);
                    const int image = edge_between(symmetry.image[static_cast<std::size_t>(ends[0])],
                                                   symmetry.image[static_cast<std::size_t>(ends[1])]);
                    symmetry.image[static_cast<std::size_t>(kFirstCut + e)] =
                        static_cast<NodeCode>(kFirstCut + image);
                }
                symmetry.image[kInteriorNode] = kInteriorNode;
                list.push_back(symmetry);
            }
        } while (std::next_permutation(axes.begin(), axes.end()));
        return list;
    }();
    return all;
}

NodeSet mapped(NodeSet nodes, const Symmetry& symmetry) {
    NodeSet image = 0;
    for (std::size_t i = 0; i < kNodeCodes; ++i) {
        if ((nodes >> i & 1U) != 0) image |= 1U << symmetry.image[i];
    }
    return image;
}

Pattern mapped(Pattern pattern, const Symmetry& symmetry) {
    return static_cast<Pattern>(mapped(static_cast<NodeSet>(pattern), symmetry));
}

Facet mapped(const Facet& facet, const Symmetry& symmetry) {
    Facet image = facet;
    for (std::size_t i = 0; i < static_cast<std::size_t>(facet.size); ++i) {
        image.nodes[i] = symmetry.image[facet.nodes[i]];
    }
    return symmetry.mirror ? reversed(image) : image;
}

Element mapped(const Element& element, const Symmetry& symmetry) {
    Element image = element;
    const auto count = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(element.type)]);
    for (std::size_t i = 0; i < count; ++i) image.nodes[i] = symmetry.image[element.nodes[i]];
    if (!symmetry.mirror) return image;
    auto& n = image.nodes;
    switch (element.type) {
        case ElementType::kHexahedron: std::rotate(n.begin(), n.begin() + 4, n.end()); break;
        case ElementType::kWedge: std::rotate(n.begin(), n.begin() + 3, n.begin() + 6); break;
        case ElementType::kPyramid: std::swap(n[1], n[3]); break;
        default: std::swap(n[1], n[2]); break;
    }
    return image;
}

bool is_simple(Pattern pattern) {
    for (int f = 0; f < kFaces; ++f) {
        if (is_ambiguous(pattern, f)) return false;
    }
    return is_connected(pattern) && is_connected(static_cast<Pattern>(~pattern));
}

std::vector<NodeCode> face_polygon(Pattern pattern, int face) {
    const auto corners = face_corners(face);
    std::vector<NodeCode> polygon;
    for (std::size_t i = 0; i < 4; ++i) {
        const int here = corners[i];
        const int next = corners[(i + 1) % 4];
        if (inside(pattern, here)) polygon.push_back(static_cast<NodeCode>(here));
        if (inside(pattern, here) != inside(pattern, next)) {
            polygon.push_back(static_cast<NodeCode>(kFirstCut + edge_between(here, next)));
        }
    }
    return polygon;
}

std::vector<Facet> face_mesh(Pattern pattern, int face) {
    std::vector<NodeCode> polygon = face_polygon(pattern, face);
    if (polygon.empty()) return {};
    if (polygon.size() == 3) return {triangle(polygon[0], polygon[1], polygon[2])};
    if (polygon.size() == 4) return {quad(polygon[0], polygon[1], polygon[2], polygon[3])};
    // Rotate to A, B, C, cut, cut; B is the corner opposite the outside one.
    while (polygon[3] < kFirstCut || polygon[4] < kFirstCut) {
        std::rotate(polygon.begin(), polygon.begin() + 1, polygon.end());
    }
    return {triangle(polygon[1], polygon[2], polygon[3]), triangle(polygon[1], polygon[3], polygon[4]),
            triangle(polygon[1], polygon[4], polygon[0])};
}

std::vector<NodeCode> surface_loop(Pattern pattern) {
    std::map<NodeCode, NodeCode> next;
    for (int f = 0; f < kFaces; ++f) {
        const std::vector<NodeCode> polygon = face_polygon(pattern, f);
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const NodeCode a = polygon[i];
            const NodeCode b = polygon[(i + 1) % polygon.size()];
            if (a >= kFirstCut && b >= kFirstCut) next[b] = a;
        }
    }
    std::vector<NodeCode> loop;
    if (next.empty()) return loop;
    const NodeCode start = next.begin()->first;
    for (NodeCode at = start;;) {
        loop.push_back(at);
        at = next.at(at);
        if (at == start) return loop;
    }
}

std::vector<std::vector<Facet>> dissections(const std::vector<NodeCode>& polygon) {
    if (polygon.size() < 3) return {{}};
    const std::size_t last = polygon.size() - 1;
    std::vector<std::vector<Facet>> result;
    // The facet on edge (last, 0), then what is left between its neighbouring nodes.
    const auto add = [&](const Facet& facet, const std::vector<std::vector<NodeCode>>& parts) {
        std::vector<std::vector<Facet>> partial = {{facet}};
        for (const auto& part : parts) {
            std::vector<std::vector<Facet>> extended;
            for (const auto& left : partial) {
                for (const auto& right : dissections(part)) {
                    extended.push_back(left);
                    extended.back().insert(extended.back().end(), right.begin(), right.end());
                }
            }
            partial = std::move(extended);
        }
        result.insert(result.end(), partial.begin(), partial.end());
    };
    const auto range = [&](std::size_t from, std::size_t to) {
        return std::vector<NodeCode>(polygon.begin() + static_cast<std::ptrdiff_t>(from),
                                     polygon.begin() + static_cast<std::ptrdiff_t>(to) + 1);
    };
    for (std::size_t i = 1; i < last; ++i) {
        add(triangle(polygon[0], polygon[i], polygon[last]), {range(0, i), range(i, last)});
        for (std::size_t j = i + 1; j < last; ++j) {
            add(quad(polygon[0], polygon[i], polygon[j], polygon[last]),
                {range(0, i), range(i, j), range(j, last)});
        }
    }
    return result;
}

NodeSet pattern_nodes(Pattern pattern) {
    NodeSet nodes = pattern;
    for (int e = 0; e < kEdges; ++e) {
        const auto ends = edge_corners(e);
        if (inside(pattern, ends[0]) != inside(pattern, ends[1])) nodes |= 1U << (kFirstCut + e);
    }
    return nodes;
}

}  // namespace mortise::templates
