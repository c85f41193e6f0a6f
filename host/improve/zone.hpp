// The part of a mesh that is improved: cells with poor elements and one ring of cells around them, all as
// tetrahedra, but for the pyramids that join them to the elements left alone.
//
// Coordinates are in finest cells, from the root box's minimum corner. Which cell an element belongs to is
// told by its centroid. Lengths that decide are in edges of the smallest leaf around a node.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "host/improve/cell_set.hpp"
#include "host/improve/chunk_bounds.hpp"
#include "host/improve/quality.hpp"
#include "host/improve/stratum.hpp"
#include "host/improve/zone_nodes.hpp"
#include "mortise/mesh.hpp"

namespace mortise::improve {

/// Index of a node of the zone.
using ZoneNode = std::uint32_t;

/// The facet on a face of a tetrahedron: 0 if there is none.
using FaceTag = std::uint32_t;
inline constexpr FaceTag kTagInside = 1;     ///< the facet's region `inside` is that of this tetrahedron
inline constexpr FaceTag kTagInterface = 2;  ///< there is a region on the other side too
/// Held, or an interface to an element outside the zone: stays as it is.
inline constexpr FaceTag kTagBorder = 4;
inline FaceTag make_tag(std::uint32_t surface) { return (surface + 1) << 3; }
inline std::uint32_t tag_surface(FaceTag tag) { return (tag >> 3) - 1; }

struct Tetrahedron {
    std::array<std::uint32_t, 4> node{};  ///< positive, as in mesh.hpp
    std::array<FaceTag, 4> tag{};         ///< of the face opposite each node
    double quality = 0;
    double share = 0;  ///< of the volume when the zone was opened
    std::uint16_t region = 0;
    std::uint8_t kind = 0;
    bool stuck = false;    ///< nothing helped, with all its nodes free, and nothing near it has changed since
    bool refined = false;  ///< smaller elements around it did not help
};

/// Nodes of the face opposite node i of a tetrahedron, outward.
inline constexpr std::array<std::array<std::uint8_t, 3>, 4> kOpposite = {
    {{1, 2, 3}, {2, 0, 3}, {0, 1, 3}, {0, 2, 1}}};

/// The nodes of a tetrahedron's edges.
inline constexpr std::uint8_t kEdgeEnds[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

inline bool has(const std::array<std::uint32_t, 4>& nodes, std::uint32_t node) {
    return nodes[0] == node || nodes[1] == node || nodes[2] == node || nodes[3] == node;
}

/// Sorts three numbers; false if that took an odd number of swaps: a face's orientation beside its nodes.
template <class Number>
bool sort_three(std::array<Number, 3>& n) {
    bool even = true;
    if (n[0] > n[1]) std::swap(n[0], n[1]), even = !even;
    if (n[1] > n[2]) std::swap(n[1], n[2]), even = !even;
    if (n[0] > n[1]) std::swap(n[0], n[1]), even = !even;
    return even;
}

/// A face by its nodes, ascending.
inline std::array<std::uint32_t, 3> sorted_face(std::array<std::uint32_t, 3> nodes) {
    sort_three(nodes);
    return nodes;
}

struct Pyramid {
    std::array<std::uint32_t, 5> node{};
    std::uint16_t region = 0;
    std::uint8_t kind = 0;
};

struct Zone {
    std::vector<Point> points;
    std::vector<std::uint8_t> size_class;  ///< of the smallest leaf around a node: 2^class finest cells
    std::vector<std::uint8_t> frozen;      ///< used by an element outside the zone: never moves
    std::vector<std::uint8_t> joined;      ///< used by a pyramid: never removed
    std::vector<Tetrahedron> tetrahedra;
    std::vector<Pyramid> pyramids;
    /// Surfaces of node i: those of `stratum` from stratum_begin[i] up to stratum_end[i], ascending.
    std::vector<std::uint32_t> stratum;
    std::vector<std::uint32_t> stratum_begin;
    std::vector<std::uint32_t> stratum_end;

    int finest_class = 0;               ///< of the finest leaves of the tree
    double unit = 1;                    ///< their edge
    double rounding = kVolumeRounding;  ///< of volumes: see tetrahedron_quality

    std::vector<std::pair<ZoneNode, Point>> tips;  ///< nodes that belong to a surface's singular point

    std::size_t stratum_size(ZoneNode i) const { return stratum_end[i] - stratum_begin[i]; }
    const std::uint32_t* surfaces(ZoneNode i) const { return stratum.data() + stratum_begin[i]; }
    /// Appends a free node that is not in the mesh yet.
    void add_node(const Point& at, int node_size_class, const std::vector<std::uint32_t>& surfaces_at) {
        points.push_back(at);
        size_class.push_back(static_cast<std::uint8_t>(node_size_class));
        frozen.push_back(0);
        joined.push_back(0);
        mesh_node.push_back(kNone);
        original.push_back(at);
        stratum_begin.push_back(static_cast<std::uint32_t>(stratum.size()));
        stratum.insert(stratum.end(), surfaces_at.begin(), surfaces_at.end());
        stratum_end.push_back(static_cast<std::uint32_t>(stratum.size()));
    }
    void set_strata(const std::vector<std::pair<ZoneNode, std::vector<std::uint32_t>>>& strata) {
        for (const auto& [node, surfaces] : strata) {
            stratum_begin[node] = static_cast<std::uint32_t>(stratum.size());
            stratum.insert(stratum.end(), surfaces.begin(), surfaces.end());
            stratum_end[node] = static_cast<std::uint32_t>(stratum.size());
        }
    }

    // How it goes back into the mesh.
    std::vector<NodeId> mesh_node;  ///< kNone: a new node
    std::vector<Point> original;    ///< points as they were, to tell which nodes moved
    std::array<std::vector<std::uint32_t>, kElementTypes> taken;  ///< the mesh's elements in it, ascending
    std::vector<std::uint32_t> facets_taken;  ///< made anew from tags; each may be there twice
    std::vector<CellId> left_poor;            ///< cells with poor elements that could not be taken
};

/// What zones have replaced: it stays in the mesh's arrays, which may be large, until remove_gone().
struct Gone {
    std::array<std::vector<std::uint8_t>, kElementTypes> element;  ///< per element, not 0
    std::vector<std::uint8_t> facet;                               ///< per facet
    std::vector<NodeId> nodes;                                     ///< in no order

    /// What has been added to the mesh is there.
    void make_room(const Mesh& mesh) {
        for (std::size_t t = 0; t < kElementTypes; ++t) element[t].resize(mesh.elements[t].size(), 0);
        facet.resize(mesh.facets.size(), 0);
    }
};

/// What is known of a mesh whose zone has been closed: elements that were not taken are as they were.
struct Known {
    Gone gone;
    std::array<std::size_t, kElementTypes> old{};   ///< per type: elements from here on are new
    std::vector<CellId> poor;                       ///< cells of old elements that are poor
    std::array<ChunkBounds, kElementTypes> chunks;  ///< of elements but cubes, by their centroids
    ChunkBounds facet_chunks;                       ///< of facets by their nodes
};

/// Where cells lie in model coordinates.
struct CellFrame {
    Point origin;
    double cell;      ///< edge of a finest cell in model units
    double per_cell;  ///< its inverse
    int level;
    const LeafGrid* leaves = nullptr;  ///< null: uniform
    bool on_lattice = true;            ///< no node has been moved off the lattice of positions yet
};

CellFrame make_frame(const tape::BoundModel& model, int level);

/// Where nodes, elements and facets of an improved mesh come from: their numbers in the mesh as it was, or
/// kNone for new ones. Those that are still there keep their order, and come before all new ones, but for new
/// nodes in the place of old ones.
struct Trace {
    std::vector<std::uint32_t> node;
    std::array<std::vector<std::uint32_t>, kElementTypes> element;
    std::vector<std::uint32_t> facet;
};

/// The cells between two planes across an axis, in finest cells.
struct Slab {
    std::size_t axis = 0;
    std::int64_t low = 0;   ///< the first cell's number
    std::int64_t high = 0;  ///< behind the last's
};

struct ZoneOptions {
    const std::vector<std::uint8_t>* held = nullptr;  ///< as Options::held
    const std::vector<Slab>* slabs = nullptr;         ///< as Options::slabs
    double least = kGoodQuality;                      ///< elements of less quality are poor
    bool leaves_cubes = false;                        ///< cubes inside are no part of the ring
    bool is_wide = false;                             ///< two rings instead of one
    bool cuts_quads = false;  ///< all that are left will be cut, from their lowest nodes
    int threads = 0;          ///< host threads; the result does not depend on them
};

/// Collects the zone, whose elements and facets are gone from then on; cells of tips count as poor. Fills in
/// what `known` says of chunks.
Zone open_zone(const Mesh& mesh, const CellFrame& frame, const Surfaces& surfaces,
               const std::vector<Tip>& tips, const ZoneOptions& options, Known& known);

/// Adds the zone's elements and facets, and moves nodes. `trace` may be null; it is brought up to date. Tells
/// in `known` what needs no second look.
Mesh close_zone(Mesh mesh, const CellFrame& frame, const Zone& zone, Trace* trace, Known& known);

/// Instead: nothing of the zone is gone.
void drop_zone(const Zone& zone, Known& known);

/// Takes out what is gone; the rest keeps its order. `trace` may be null.
Mesh remove_gone(Mesh mesh, Gone gone, int threads, Trace* trace);

}  // namespace mortise::improve
