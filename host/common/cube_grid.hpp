// A cube some of whose faces and edges are split at their middles: its 27 vertices in halves, its patterns of
// splits, its symmetries.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <utility>
#include <vector>

namespace mortise {

/// Vertex x + 3 y + 9 z of the cube in halves, coordinates 0 … 2.
inline constexpr int kGridVertices = 27;
inline constexpr std::uint8_t kGridCentre = 13;
using GridPoint = std::array<int, 3>;
constexpr GridPoint grid_point(int vertex) { return {vertex % 3, vertex / 3 % 3, vertex / 9}; }
constexpr std::uint8_t grid_vertex(const GridPoint& p) {
    return static_cast<std::uint8_t>(p[0] + 3 * p[1] + 9 * p[2]);
}

/// Bit e: edge e is split at its middle; bit 12 + f: face f is split into quarters, its edges too. Edges and
/// faces as in kernels/shared/lattice.h.
using SplitPattern = std::uint32_t;
inline constexpr int kSplitBits = 18;

/// Middle of edge e = 4 axis + a + 2 b, a and b being its place along the other axes in ascending order.
constexpr std::uint8_t edge_middle(int e) {
    const int axis = e / 4;
    GridPoint p{};
    p[static_cast<std::size_t>(axis)] = 1;
    p[axis == 0 ? 1 : 0] = 2 * (e & 1);
    p[axis == 2 ? 1 : 2] = 2 * ((e >> 1) & 1);
    return grid_vertex(p);
}
constexpr std::uint8_t face_centre(int f) {
    GridPoint p{1, 1, 1};
    p[static_cast<std::size_t>(f / 2)] = 2 * (f & 1);
    return grid_vertex(p);
}
/// The vertex that is there if the bit is set.
constexpr std::uint8_t split_vertex(int bit) { return bit < 12 ? edge_middle(bit) : face_centre(bit - 12); }

/// Whether all edges of split faces are split.
constexpr bool is_split_pattern(SplitPattern pattern) {
    for (int f = 0; f < 6; ++f) {
        if (((pattern >> (12 + f)) & 1) == 0) continue;
        for (int e = 0; e < 12; ++e) {
            const int at = grid_point(edge_middle(e))[static_cast<std::size_t>(f / 2)];
            if (at == 2 * (f & 1) && ((pattern >> e) & 1) == 0) return false;
        }
    }
    return true;
}

/// A facet of a whole face some of whose sides are split. Places 0–3 are the face's corners in order, 4 + i
/// the middle of the side from corner i on.
struct SplitFacet {
    std::array<std::uint8_t, 4> place{};
    std::uint8_t count = 0;  ///< 3 or 4
};

/// The face rule: no new node; a triangle cut off at each corner between two middles, and what is left
/// divided through the middles. Bit i of `sides`: side i is split.
inline std::vector<SplitFacet> split_face(unsigned sides) {
    std::vector<SplitFacet> facets;
    const auto has = [sides](unsigned i) { return ((sides >> (i % 4)) & 1) != 0; };
    const auto add = [&facets](std::initializer_list<unsigned> places) {
        SplitFacet facet;
        for (const unsigned place : places) facet.place[facet.count++] = static_cast<std::uint8_t>(place);
        facets.push_back(facet);
    };
    const unsigned count = unsigned{has(0)} + unsigned{has(1)} + unsigned{has(2)} + unsigned{has(3)};
    for (unsigned i = 0; i < 4; ++i) {
        if (has(i) && has(i + 3)) add({i, 4 + i, 4 + (i + 3) % 4});
    }
    if (count == 0) add({0, 1, 2, 3});
    if (count == 4) add({4, 5, 6, 7});
    if (count == 0 || count == 4) return facets;
    // From the first side that is split while the one before it is not.
    unsigned first = 0;
    while (!has(first) || has(first + 3)) ++first;
    const auto c = [first](unsigned i) { return (first + i) % 4; };
    const auto m = [first](unsigned i) { return 4 + (first + i) % 4; };
    if (count == 1) {
        add({c(0), m(0), c(3)});
        add({m(0), c(2), c(3)});
        add({m(0), c(1), c(2)});
    } else if (count == 3) {
        add({m(0), m(1), m(2)});
        add({c(0), m(0), m(2), c(3)});
    } else if (has(first + 1)) {
        add({c(0), m(0), c(3)});
        add({m(0), m(1), c(3)});
        add({m(1), c(2), c(3)});
    } else {
        add({c(0), m(0), m(2), c(3)});
        add({m(0), c(1), c(2), m(2)});
    }
    return facets;
}

struct CubeSymmetry {
    std::array<std::uint8_t, kGridVertices> vertex{};  ///< where each vertex goes
    std::array<std::uint8_t, kSplitBits> bit{};        ///< where each bit of a pattern goes
    bool mirrored = false;
};

constexpr SplitPattern transform(const CubeSymmetry& symmetry, SplitPattern pattern) {
    SplitPattern result = 0;
    for (std::size_t b = 0; b < kSplitBits; ++b) {
        if (((pattern >> b) & 1) != 0) result |= SplitPattern{1} << symmetry.bit[b];
    }
    return result;
}

/// The 48 symmetries of the cube; the first is the identity.
inline const std::array<CubeSymmetry, 48>& cube_symmetries() {
    static const std::array<CubeSymmetry, 48> all = [] {
        constexpr int kOrders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
        std::array<int, kGridVertices> bit_at{};
        for (int b = 0; b < kSplitBits; ++b) bit_at[split_vertex(b)] = b;
        std::array<CubeSymmetry, 48> result;
        for (std::size_t s = 0; s < 48; ++s) {
            const std::size_t order = s / 8;
            const unsigned flips = s % 8;
            result[s].mirrored = (order >= 3) != (((flips ^ (flips >> 1) ^ (flips >> 2)) & 1) != 0);
            for (int v = 0; v < kGridVertices; ++v) {
                const GridPoint p = grid_point(v);
                GridPoint q{};
                for (std::size_t j = 0; j < 3; ++j) {
                    q[j] = p[static_cast<std::size_t>(kOrders[order][j])];
                    if (((flips >> j) & 1) != 0) q[j] = 2 - q[j];
                }
                result[s].vertex[static_cast<std::size_t>(v)] = grid_vertex(q);
            }
            for (int b = 0; b < kSplitBits; ++b) {
                result[s].bit[static_cast<std::size_t>(b)] =
                    static_cast<std::uint8_t>(bit_at[result[s].vertex[split_vertex(b)]]);
            }
        }
        return result;
    }();
    return all;
}

/// Makes the mirror image of an element right-handed again; by its number of nodes, in mesh.hpp's order.
template <class Node>
void turn_over(Node* node, int count) {
    if (count == 4) {
        std::swap(node[0], node[1]);
    } else if (count == 6) {
        std::swap(node[1], node[2]);
        std::swap(node[4], node[5]);
    } else {  // a pyramid, or a hexahedron
        std::swap(node[1], node[3]);
        if (count == 8) std::swap(node[5], node[7]);
    }
}

}  // namespace mortise
