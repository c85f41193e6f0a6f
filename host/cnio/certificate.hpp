// The certificate: a conforming mesh of any boundary cell, that always ends (docs/design/certificate.md).
//
// 1. Cone: every triangle of the face meshes becomes a tetrahedron to the cell's apex, every quadrilateral a
//    pyramid; where a surface passes between, that has an apex of its own, the cap, and four tetrahedra join
//    the cap to the cell's apex.
// 2. Bisection: for each active surface in turn, every edge inside the cell whose ends lie on different sides
//    is split at the root; new nodes inherit their signs for the surfaces already done.
// 3. Labels: each simplex has one sign per surface, and the pruned tape turns these into its region.
// A cell without surfaces, beside finer leaves, is filled from a table instead (transition.hpp).
// All positions are on the lattice and every simplex is exactly positive. A split that would make one too
// flat is refused and counted; the cell stays valid and conforming.
#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <tuple>
#include <vector>

#include "host/cnio/cell.hpp"
#include "host/cnio/transition.hpp"
#include "mortise/mesh.hpp"

namespace mortise::cnio {

/// Position of a node on the lattice of the whole root box: its identity across cells.
struct NodeKey {
    std::int64_t x, y, z;
    friend bool operator==(const NodeKey& a, const NodeKey& b) {
        return a.x == b.x && a.y == b.y && a.z == b.z;
    }
    friend bool operator<(const NodeKey& a, const NodeKey& b) {
        return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
    }
};

inline constexpr std::uint32_t kNoSurface = 0xffffffffu;

/// A facet between two regions (or a region and the outside) inside one cell, outward from `inside`.
struct InnerFacet {
    std::array<std::uint16_t, 4> node;  ///< codes; a triangle repeats the last
    std::uint32_t surface;
    std::uint16_t inside;
    std::uint16_t outside;
};

/// A facet on a face of the cell, in the order of the face mesh, which both cells share.
struct FaceFacet {
    std::array<std::uint16_t, 4> node;   ///< codes, counter-clockwise in the face's frame
    std::array<std::uint8_t, 4> corner;  ///< which of the patch's corners, in its frame, the node is; 4: none
    std::uint16_t region;                ///< of the element behind it in this cell; 0: none
    std::uint32_t surface;               ///< a surface that holds all its nodes, or kNoSurface
};

/// Meshes of many cells, appended one after another. Node codes: 0–7 corners, 8–19 the single root on that
/// edge, 20 + i the cell's i-th extra node.
struct CellArena {
    std::vector<NodeKey> extras;  ///< per cell in ascending order
    /// Parallel: an element of the cell has the node; else it only may occur in a facet of a finer leaf's.
    std::vector<std::uint8_t> extra_used;
    /// Parallel: where the node goes from there, in lattice units of the finest cells, once corners move.
    std::vector<LatticePoint> extra_moves;
    std::vector<std::int32_t>
        edge_roots;  ///< lattice units from the low end, per used edge in ascending order
    std::array<std::vector<std::uint16_t>, kElementTypes> nodes;
    std::array<std::vector<std::uint16_t>, kElementTypes> regions;
    std::vector<InnerFacet> facets;
    std::vector<FaceFacet> face_facets;
};

/// One cell's part of an arena.
struct CellRecord {
    std::uint32_t arena = 0;
    std::uint32_t used = 0;  ///< mask of kernels/shared/tree.h, bits 0–19
    std::uint32_t first_edge_root = 0;
    std::uint32_t first_extra = 0;
    std::uint32_t extra_count = 0;
    std::array<std::uint32_t, kElementTypes> first_element{};
    std::array<std::uint32_t, kElementTypes> element_count{};
    std::uint32_t first_facet = 0;
    std::uint32_t facet_count = 0;
    /// Patch p (four to a face, Cell::patch): [p] … [p + 1].
    std::array<std::uint32_t, kPatches + 1> first_face_facet{};
    std::uint32_t refused = 0;     ///< as CellCounters, of this cell
    std::uint32_t limited = 0;     ///< the same
    std::uint32_t unresolved = 0;  ///< the same
    bool is_transition = false;    ///< without surfaces, beside finer leaves: filled from a table
    /// Bit c: an element at corner c, which snaps, is not good enough once the cell's corners have moved.
    std::uint8_t unfit = 0;
};

using FaceKey = std::uint64_t;  ///< up to four nodes of a cell

/// Meshes cells one at a time; keeps its scratch memory. One per thread.
class Certificate {
  public:
    Certificate(const tape::BoundModel& model, const octree::Octree& tree)
        : cell_(model, tree), tree_(tree) {}

    /// Meshes one NIO leaf and appends the result to `arena`. The cone's apex is the cell's centre, or a
    /// point strictly inside the cell in a feature that nothing else shows (host/probe); then the cell is
    /// never taken for uniform.
    CellRecord run(const TreeNode& leaf, CellArena& arena, const LatticePoint* apex = nullptr);

    const CellCounters& counters() const { return cell_.counters; }

  private:
    struct Simplex {
        std::array<LocalNode, 4> node;
        bool resolved;  ///< its signs tell its region, and so will those of its parts
    };
    struct Pyramid {
        std::array<LocalNode, 5> node;
    };

    /// An element of a cell in one region.
    struct Whole {
        ElementType type;
        std::array<LocalNode, 8> node;
    };

    bool is_uniform(std::int32_t* region) const;
    bool is_full() const;
    void fill_whole();
    bool hides_surface() const;
    void clear();
    void find_cone();
    void fill_cone(const LatticePoint& at);
    void cone(const LatticePoint& at);
    void add_simplex(const std::array<LocalNode, 4>& node);
    bool is_mixed(const Facet& quad, LocalNode apex) const;
    LocalNode add_cap(const Facet& quad, const LatticePoint& apex);
    void list_edges(std::size_t p, bool different);
    bool can_split(LocalNode a, LocalNode b, const LatticePoint& at);
    bool is_told_by_ends(LocalNode a, LocalNode b, const LatticePoint& at, std::size_t p) const;
    bool is_hidden_by_chord(LocalNode a, LocalNode b, std::size_t p) const;
    bool find_bulge(LocalNode a, LocalNode b, std::size_t p, LatticePoint* at) const;
    void split(LocalNode a, LocalNode b, LocalNode m);
    void show_bulges(const std::vector<std::size_t>& order, std::size_t k, int round);
    bool bisect(const std::vector<std::size_t>& order, std::size_t k, int round);
    bool is_resolved(const Simplex& simplex);
    bool is_of_pyramid(LocalNode a, LocalNode b) const;
    std::int32_t common_region(const LocalNode* node, std::size_t count);
    bool is_filled_by(std::int32_t region, const LocalNode* node, std::size_t count);
    std::int32_t label(const LocalNode* node, std::size_t count, std::int8_t* signs);
    std::uint8_t unfit_corners() const;
    void collect(CellRecord& record, CellArena& arena);
    void collect_face_facets(CellRecord& record, CellArena& arena);
    bool has_one_region() const;
    template <class Visit>
    void for_sides_of(std::size_t owner, const Visit& visit) const;
    void list_sides();
    void collect_inner_facets(CellRecord& record, CellArena& arena);
    std::uint32_t facet_surface(const LocalNode* node, std::size_t count, const std::int8_t* a,
                                const std::int8_t* b) const;
    void assign_codes(CellRecord& record, CellArena& arena);
    void use(LocalNode node) { used_[node] = 1; }

    Cell cell_;
    const octree::Octree& tree_;
    std::vector<Simplex> simplices_;
    std::vector<Pyramid> pyramids_;
    std::vector<std::int32_t> simplex_region_;
    std::vector<std::int32_t> pyramid_region_;
    std::vector<std::int8_t> simplex_signs_;  ///< simplices × surfaces
    std::vector<std::int8_t> pyramid_signs_;
    std::vector<std::uint8_t> used_;
    std::vector<std::uint16_t> code_;
    std::vector<std::pair<LocalNode, LocalNode>> mixed_;
    std::vector<std::vector<std::uint32_t>> incident_;  ///< simplices by node, with stale entries
    std::vector<std::uint32_t> around_;
    std::vector<std::int8_t> signs_;
    std::set<std::tuple<std::uint32_t, LocalNode, LocalNode>> refused_;  ///< (surface, edge): not tried again
    std::int32_t whole_region_ = 0;  ///< of a cell in one region, which `whole_` fills; 0: none
    std::vector<Whole> whole_;
    std::vector<TransitionElement> transition_;
    // Scratch of the facets' collection: faces with the region behind them, by face of the cell, and with the
    // simplex, or pyramid behind the simplices, whose sides they are.
    std::array<std::vector<std::pair<FaceKey, std::int32_t>>, 6> behind_;
    std::vector<std::pair<FaceKey, std::uint32_t>> sides_;
};

}  // namespace mortise::cnio
