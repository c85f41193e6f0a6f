// One complex cell while it is meshed: its surfaces, its nodes with their signs, its six face meshes.
//
// Everything on a face or an edge is computed from data of that face or edge alone: the surfaces that are
// active in all leaves around it, signs that are pure functions of position, and a fixed frame
// (kernels/shared/lattice.h). So two cells that share a face make the same mesh of it, without talking to
// each other (algorithms.md §2).
#pragma once

#include <cstdint>
#include <vector>

#include "host/cnio/exact.hpp"
#include "host/octree/octree.hpp"
#include "host/tape/compile.hpp"
#include "host/tape/local_tape.hpp"

namespace mortise::cnio {

using LocalNode = std::uint16_t;  ///< index into CellNodes

inline constexpr std::uint16_t kNoCap = 0xffff;

/// Rounds of bisection. One is enough unless a simplex is mixed along an edge of a face where the surface is
/// not active: cutting it by another surface then makes new mixed edges, which the next round splits.
inline constexpr int kBisectionRounds = 6;

/// How a node is told to the outside: a corner, the single root of an edge, or a node with a key of its own.
inline constexpr std::uint16_t kExtraCode = 20;

struct Node {
    LatticePoint point{};
    std::uint8_t faces = 0;           ///< bit f: lies on face f of the cell
    std::uint16_t code = kExtraCode;  ///< 0–7 corner, 8–19 single root of edge code - 8, else kExtraCode
    std::uint16_t cap = kNoCap;       ///< index of the quad whose pyramid this node is the apex of
};

/// A triangle or quadrilateral of a face mesh, counter-clockwise in the face's frame.
struct Facet {
    LocalNode node[4];
    std::uint8_t count;
};

enum class FaceMode : std::uint8_t { kWhole, kCut, kFan };  ///< F0, F1, F2 of algorithms.md §2

/// What did not go as planned, for the report.
struct CellCounters {
    std::uint64_t snapped =
        0;  ///< nodes that count as on a surface because a split so close to them was refused
    std::uint64_t refused = 0;      ///< splits that would have made a flat simplex
    std::uint64_t unresolved = 0;   ///< tetrahedra labelled by their centroid
    std::uint64_t forced_caps = 0;  ///< caps whose signs were assigned
};

class Cell {
  public:
    Cell(const tape::BoundModel& model, const octree::Octree& tree) : model_(model), tree_(tree) {}

    /// Loads an NIO leaf: surfaces, active sets, corners, edge roots, face meshes.
    void load(const TreeNode& leaf);

    const std::vector<std::uint32_t>& surfaces() const { return surfaces_; }
    std::size_t surface_count() const { return surfaces_.size(); }
    const std::vector<Node>& nodes() const { return nodes_; }
    std::int8_t sign(std::size_t node, std::size_t surface) const {
        return signs_[node * surfaces_.size() + surface];
    }
    void set_sign(std::size_t node, std::size_t surface, int sign) {
        signs_[node * surfaces_.size() + surface] = static_cast<std::int8_t>(sign);
    }
    const std::vector<Facet>& face(int f) const { return faces_[static_cast<std::size_t>(f)]; }
    FaceMode mode(int f) const { return modes_[static_cast<std::size_t>(f)]; }
    const TreeNode& leaf() const { return leaf_; }
    const tape::LocalTape& local_tape() const { return local_tape_; }
    std::uint32_t coordinate(int axis) const { return xyz_[axis]; }

    /// Signs by evaluation at a point, tolerance and all: the pure function.
    int pure_sign(std::size_t surface, const LatticePoint& p) const;
    void position(const LatticePoint& p, double* x) const;
    /// Sign of the value alone, never zero: for the inside of a simplex all of whose nodes are on the
    /// surface.
    int value_sign(std::size_t surface, const LatticePoint& p) const;

    /// Appends a node with pure signs for every surface.
    LocalNode add_node(const LatticePoint& p, std::uint8_t faces, std::uint16_t code = kExtraCode);
    void remove_last_node() {
        nodes_.pop_back();
        signs_.resize(nodes_.size() * surfaces_.size());
    }
    void set_cap(LocalNode node, std::uint16_t quad) { nodes_[node].cap = quad; }

    /// The root of a surface between two nodes, on the lattice.
    LatticePoint root(std::size_t surface, LocalNode a, LocalNode b) const;

    /// Adds the node that splits edge ab at surface p. Its signs for the surfaces done before (those before p
    /// in the first round, all in later ones) are inherited from the edge; `active`, if given, restricts
    /// them.
    LocalNode split_node(std::size_t p, LocalNode a, LocalNode b, const LatticePoint& at, int round,
                         const std::uint8_t* active);

    /// In place of a split of edge ab at p: gives the end within `reach` of the root, if there is one, the
    /// sign 0. A node on an edge of the cell keeps its sign while faces are meshed, since other faces depend
    /// on it.
    bool snap_end(std::size_t p, LocalNode a, LocalNode b, const LatticePoint& at, double reach,
                  bool inner_only);

    CellCounters counters;

  private:
    void load_active_sets();
    void load_edges();
    void partition_face(int f);
    FaceMode face_mode(const std::vector<LocalNode>& loop, int f);
    void cut_face(const std::vector<LocalNode>& loop, int f);
    void fan_face(const std::vector<LocalNode>& loop, int f);
    bool split_face(int f, std::size_t p, int round);
    void load_other_tape(const TreeNode& other);
    bool is_resolved(const std::array<std::uint16_t, 3>& triangle, const std::uint8_t* active);
    void add_polygon(const std::vector<LocalNode>& polygon, int f);
    bool flat(LocalNode a, LocalNode b, LocalNode c) const;

    const tape::BoundModel& model_;
    const octree::Octree& tree_;
    TreeNode leaf_{};
    std::uint32_t xyz_[3] = {};
    std::vector<std::uint32_t> surfaces_;  ///< active set, ascending
    tape::LocalTape local_tape_;
    std::vector<std::uint8_t> neighbour_active_;  ///< 27 × surfaces: active in that neighbour
    std::vector<std::uint8_t> edge_active_;       ///< 12 × surfaces
    std::vector<Node> nodes_;
    std::vector<std::int8_t> signs_;         ///< nodes × surfaces
    std::vector<LocalNode> edge_nodes_[12];  ///< from the low end to the high end
    std::vector<Facet> faces_[6];
    FaceMode modes_[6] = {};
    std::size_t crossing_ = 0;  ///< the surface that cuts the face at hand (F1)
    // Scratch of one face; numbers in `fan_` index `fan_nodes_`, whose order depends on the face alone.
    std::vector<LocalNode> fan_nodes_;
    std::vector<std::array<std::uint16_t, 3>> fan_;
    std::vector<std::pair<std::uint16_t, std::uint16_t>> mixed_;
    std::vector<std::int8_t> triangle_signs_;
    tape::LocalTape other_tape_;                 ///< of the cell beyond
    std::vector<std::uint32_t> other_surfaces_;  ///< its active set, ascending
    std::vector<std::size_t> other_to_own_;      ///< places in surfaces_, or the number of them: not there
    std::vector<std::int8_t> other_signs_;
};

}  // namespace mortise::cnio
