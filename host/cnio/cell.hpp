// One complex cell while it is meshed: its surfaces, its nodes with their signs, its six face meshes.
//
// Everything on a face or an edge is computed from data of that face or edge alone: the surfaces that are
// active in all leaves around it, signs that are pure functions of position, and a fixed frame
// (kernels/shared/lattice.h). So two cells that share a face make the same mesh of it, without talking to
// each other (invariant 1 of ARCHITECTURE.md).
//
// In a graded tree the finest leaf around an entity owns it. Where finer leaves lie in a place beside the
// cell (one of its own size), the cell's edges and faces there are split at their middles: `HalfGrid` says
// which.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "host/cnio/exact.hpp"
#include "host/octree/octree.hpp"
#include "host/tape/compile.hpp"
#include "host/tape/local_tape.hpp"

namespace mortise::cnio {

using LocalNode = std::uint16_t;  ///< index into CellNodes

inline constexpr LocalNode kNoNode = 0xffff;

/// Rounds of bisection. One is enough unless a simplex is mixed along an edge of a face where the surface is
/// not active: cutting it by another surface then makes new mixed edges, which the next round splits.
inline constexpr int kBisectionRounds = 6;

/// Of surfaces that an apex may lie on.
inline constexpr std::size_t kMostApexSurfaces = 3;

/// Nodes other than vertices of the grid are on all surfaces within this many tolerances of signs, 3e-5 of a
/// cell: rods and the balls at their ends meet in one point but for the six figures of their coordinates, and
/// what parts them there would be slivers.
inline constexpr double kTogether = 4;

/// How a node is told to the outside: a corner, the single root of an edge, or a node with a key of its own.
inline constexpr std::uint16_t kExtraCode = 20;

struct Node {
    LatticePoint point{};
    LatticePoint target{};            ///< where it will be moved to, if a corner of the cell snaps
    std::uint8_t faces = 0;           ///< bit f: lies on face f of the cell
    std::uint8_t middles = 0;         ///< bit j: lies on a split face's line across the middle of axis j
    std::uint16_t code = kExtraCode;  ///< 0–7 corner, 8–19 single root of edge code - 8, else kExtraCode
};

/// A triangle or quadrilateral of a face mesh, counter-clockwise in the face's frame.
struct Facet {
    LocalNode node[4];
    std::uint8_t count;
};

/// F0, F1, F2 of docs/design/certificate.md; whole, but with middles of split edges; whole, but for its
/// diagonal.
enum class FaceMode : std::uint8_t { kWhole, kCut, kFan, kHanging, kSplit };

/// What did not go as planned, for the report.
struct CellCounters {
    /// Nodes that count as on a surface because a split so close to them was refused.
    std::uint64_t snapped = 0;
    std::uint64_t refused = 0;      ///< splits that would have made a flat simplex
    std::uint64_t limited = 0;      ///< times that work was cut short: too many surfaces
    std::uint64_t unresolved = 0;   ///< simplices labelled by their centroid, part of which lies elsewhere
    std::uint64_t forced_caps = 0;  ///< caps whose signs were assigned
};

/// The cell and what touches it, in halves of the cell: vertices 0 … 2 along each axis, half-cells -1 … 2
/// along each axis, the cell itself being 0 and 1.
struct HalfGrid {
    /// Bit k: finer leaves lie in place k = (dx + 1) + 3 (dy + 1) + 9 (dz + 1).
    std::uint32_t subdivided = 0;
    /// The NIO leaf in each half-cell, by (x + 1) + 4 (y + 1) + 16 (z + 1), or kNoNio.
    std::array<std::uint32_t, 64> nio{};
    std::array<std::uint8_t, 64> row{};  ///< of the active sets
};
inline constexpr std::uint32_t kNoNio = 0xffffffffu;
inline int half_index(int x, int y, int z) { return (x + 1) + 4 * (y + 1) + 16 * (z + 1); }

/// Step of a lattice in units of the cell's own, and the edge of the cells for which signs are taken.
struct Scale {
    std::int32_t step = 1;
    double size = 0;
};

/// On which sides of a surface some nodes lie.
struct Sides {
    bool negative = false;
    bool positive = false;

    void add(int sign) {
        negative = negative || sign < 0;
        positive = positive || sign > 0;
    }
    bool are_mixed() const { return negative && positive; }
    /// Of all nodes; 0 if they are mixed, or all on the surface.
    std::int8_t sign() const {
        return static_cast<std::int8_t>(static_cast<int>(positive) - static_cast<int>(negative));
    }
};

/// A face of the cell, or a quarter of one that is split: what one leaf beyond shares.
struct Patch {
    int face = 0;
    bool quarter = false;
    std::array<LocalNode, 4> corner{};  ///< as kFaceCorners
    LatticePoint middle{};
    std::uint8_t row = 0;           ///< of the active sets
    std::uint32_t beyond = kNoNio;  ///< the NIO leaf
    Scale scale;
};

inline constexpr int kPatches = 24;  ///< four to a face; the first stands for one that is not split

/// Stands for all surfaces of a crowded leaf: the solid's own.
inline constexpr std::uint32_t kSolidSurface = 0x0ffffffd;

class Cell {
  public:
    Cell(const tape::BoundModel& model, const octree::Octree& tree) : model_(model), tree_(tree) {}

    /// Loads an NIO leaf: surfaces, active sets, corners, edge roots, face meshes.
    void load(const TreeNode& leaf);

    std::size_t surface_count() const { return surfaces_.size(); }
    /// Whether the solid stands for all surfaces of the cell (crowd.cpp).
    bool is_crowded() const { return crowded_; }
    const std::vector<Node>& nodes() const { return nodes_; }
    std::int8_t sign(std::size_t node, std::size_t surface) const {
        return signs_[node * surfaces_.size() + surface];
    }
    /// Of a node, per surface.
    const std::int8_t* signs(std::size_t node) const { return signs_.data() + node * surfaces_.size(); }
    void set_sign(std::size_t node, std::size_t surface, int sign) {
        signs_[node * surfaces_.size() + surface] = static_cast<std::int8_t>(sign);
    }
    const std::vector<Facet>& patch(int p) const { return patches_[static_cast<std::size_t>(p)]; }
    /// Which corner of a patch a node is, in the order of kFaceCorners; 4: none.
    std::size_t patch_corner(int p, LocalNode node) const;
    /// The node at a vertex of the cell in halves (x + 3 y + 9 z), or kNoNode.
    LocalNode vertex(std::size_t v) const { return vertex_[v]; }
    /// Whether the cell's faces are six whole quadrilaterals.
    bool has_whole_faces() const;
    /// Whether a face is split for corners that snap (odd_corner).
    bool has_split_faces() const {
        return std::find(modes_, modes_ + kPatches, FaceMode::kSplit) != modes_ + kPatches;
    }
    /// Whether corners will be moved (Node::target).
    bool snaps() const { return snapped_ != 0; }
    /// Whether corners of a patch will be: what the cells on both sides know.
    bool snaps(const Patch& patch) const {
        return std::any_of(patch.corner.begin(), patch.corner.end(),
                           [this](LocalNode c) { return c < 8 && ((snapped_ >> c) & 1) != 0; });
    }
    /// Gives the nodes from `first` on a target where signs put them on surfaces that do not pass through
    /// them: they lie between nodes that snap. `active`, if given, restricts the surfaces.
    void settle_targets(std::size_t first, const std::uint8_t* active);
    /// Whether such a target was not to be had.
    bool is_misplaced() const { return misplaced_; }
    const TreeNode& leaf() const { return leaf_; }
    const tape::LocalTape& local_tape() const { return local_tape_; }
    LatticePoint centre() const { return {units_ / 2, units_ / 2, units_ / 2}; }
    /// Lattice units to the cell's edge: kCellUnits, or twice as many beside finer leaves, whose lattice it
    /// is.
    std::int32_t units() const { return units_; }
    /// A point on the lattice of the tree's finest cells, along one axis.
    std::int64_t key(int axis, std::int32_t at) const {
        return (static_cast<std::int64_t>(xyz_[axis]) << kCellUnitBits) +
               (static_cast<std::int64_t>(at) << key_shift_);
    }

    /// Of these points to one of the cell's own lattice units.
    std::int32_t key_step() const { return std::int32_t{1} << key_shift_; }

    Sides sides(const LocalNode* nodes, std::size_t count, std::size_t surface) const {
        Sides result;
        for (std::size_t i = 0; i < count; ++i) result.add(sign(nodes[i], surface));
        return result;
    }

    /// Signs by evaluation at a point, tolerance and all: the pure function. `size`: edge of the smallest
    /// cells that share the entity on which the point lies.
    int pure_sign(std::size_t surface, const LatticePoint& p, double size) const;
    double size() const { return size_; }
    void position(const LatticePoint& p, double* x) const;
    /// The model's number of a surface at a point: a joint of two surfaces is one of them.
    std::uint32_t model_surface(std::size_t surface, const LatticePoint& p) const {
        bool negated = false;
        double x[3];
        position(p, x);
        return surface_at(surface, x, &negated);
    }
    /// Whether the cell's tape names a surface: not those that a joint stands for.
    bool is_named(std::size_t surface) const { return local_tape_.names(surface); }
    /// Whether a surface is not known to be a plane; false of those that stand for several.
    bool is_curved(std::size_t surface) const {
        return !(has_stand_in() && surface + 1 == surfaces_.size()) &&
               model_.surfaces[surfaces_[surface]].kind != kSurfacePlane;
    }
    /// Sign of the value alone, never zero: for the inside of a simplex all of whose nodes are on the
    /// surface.
    int value_sign(std::size_t surface, const LatticePoint& p) const;

    /// The cell's centre; where surfaces pass close to it, the point next to it on up to `most` of them: a
    /// cone from a point of a crease needs no cuts inside, and an apex beside a surface would make simplices
    /// as flat as it is close (apex.cpp).
    LatticePoint apex(std::size_t most) const;
    void settle_pole(LocalNode node, int face);

    /// Appends a node with pure signs for every surface, of the entity at hand, and zero for those next to
    /// it.
    LocalNode add_node(const LatticePoint& p, std::uint8_t faces, std::uint16_t code = kExtraCode,
                       std::uint8_t middles = 0);
    void remove_last_node() { keep_nodes(nodes_.size() - 1); }
    void drop_inner_nodes() {
        keep_nodes(border_nodes_);
        misplaced_ = border_misplaced_;
    }

    /// The point at t, 0 to 1, between two points, on the lattice.
    LatticePoint between(const LatticePoint& from, const LatticePoint& to, double t) const;

    /// Where between two points the value of a curved surface turns, by the parabola through three values,
    /// not close to the ends: what bulges through the edge does so there.
    LatticePoint turning_point(std::size_t surface, const LatticePoint& from, const LatticePoint& to) const;

    /// Distance of a point from a surface, to first order, box-local; infinite where the gradient vanishes.
    double distance_to(std::size_t surface, const LatticePoint& p) const {
        double x[3];
        position(p, x);
        return distance_to(surface, x);
    }

    /// The root of a surface between two points of opposite signs, on the lattice.
    LatticePoint root(std::size_t surface, const LatticePoint& from, const LatticePoint& to) const;

    /// The order in which the cell's surfaces cut it: those first that tell most of the others apart from
    /// what they change nothing of. Where two solids meet smoothly on a plane inside both, the plane comes
    /// first, and each side is cut by its own surface alone.
    const std::vector<std::size_t>& cutting_order();

    /// Adds the node that splits edge ab at surface order[k]. Its signs for the surfaces done before (order[0
    /// … k - 1] in the first round, all in later ones) are inherited from the edge; `active`, if given,
    /// restricts them.
    LocalNode split_node(const std::vector<std::size_t>& order, std::size_t k, LocalNode a, LocalNode b,
                         const LatticePoint& at, int round, const std::uint8_t* active);

    /// In place of a split of edge ab at p: gives the end within `reach` of the root, if there is one, the
    /// sign 0. A node on an edge of the cell keeps its sign while faces are meshed, since other faces depend
    /// on it.
    bool snap_end(std::size_t p, LocalNode a, LocalNode b, const LatticePoint& at, double reach,
                  bool inner_only);

    CellCounters counters;

  private:
    /// Place of a surface of the model among the cell's, those that stand for others left aside; their
    /// number: it is none of them.
    std::size_t surface_place(std::uint32_t surface) const {
        const auto found = std::lower_bound(surfaces_.begin(), surfaces_.end(), surface);
        const bool is_own = found != surfaces_.end() && *found == surface;
        return is_own ? static_cast<std::size_t>(found - surfaces_.begin()) : surfaces_.size();
    }
    void keep_nodes(std::size_t count) {
        nodes_.resize(count);
        signs_.resize(count * surfaces_.size());
    }
    // apex.cpp
    double distance_to(std::size_t surface, const double* x) const;
    double cosine(std::size_t a, std::size_t b, const double* x) const;
    struct ApexSearch {
        LatticePoint middle;
        int fixed_axis;  ///< of a face: both cells find the same apex in its plane; 3: none
        Scale scale;     ///< the apex lies on its lattice
    };
    using NearSurfaces = std::vector<std::pair<double, std::size_t>>;  ///< with their distances, ascending
    void leave_distinct(int fixed_axis, const double* middle, NearSurfaces& near) const;
    LatticePoint apex_near(const ApexSearch& search, const std::vector<std::size_t>& surfaces,
                           std::size_t most) const;
    NearSurfaces::const_iterator beside_boundary(const LatticePoint& point, std::size_t count,
                                                 const NearSurfaces& near) const;
    std::vector<std::uint32_t> model_surfaces(const std::vector<std::size_t>& surfaces,
                                              const double* x) const;
    bool apex_on(const ApexSearch& search, const std::vector<std::size_t>& surfaces,
                 LatticePoint& apex) const;
    bool is_joint(std::size_t surface) const { return joint_ != nullptr && surface + 1 == surfaces_.size(); }
    bool pole_at(int face, LatticePoint& at) const;
    LatticePoint fan_centre(const std::vector<LocalNode>& loop, const Patch& patch) const;
    // cell.cpp
    LocalNode append_node(const LatticePoint& p, std::uint8_t faces, std::uint16_t code, std::uint8_t middles,
                          double size);
    void load_surroundings();
    void mark_half_cells(const Tree& tree, const i32* d, std::uint32_t nio);
    void load_tape();
    void load_row(std::size_t row, std::uint32_t nio);
    void load_corners();
    void load_edges();
    void load_edge(int e);
    void load_cross(int f);
    LocalNode grid_vertex(int x, int y, int z);
    void load_segment(LocalNode low, LocalNode high, int axis, const std::uint8_t* active, const Scale& scale,
                      std::uint16_t code, std::vector<LocalNode>& out);
    // snapped.cpp
    void snap_corner(LocalNode corner);
    std::size_t odd_corner(const Patch& patch) const;
    int middle_sign(std::size_t surface, const Patch& patch) const;
    bool is_crowding(const ApexSearch& search, const LatticePoint& apex) const;
    bool only_touches(std::size_t surface, const LocalNode* nodes, std::size_t count) const;
    // joint.cpp
    void load_joint();
    std::uint32_t surface_at(std::size_t surface, const double* x, bool* negated) const;
    double model_value(std::uint32_t surface, const double* x) const;
    double root_between(std::size_t surface, const double* low, const double* high) const;
    void settle_stand_in(std::uint8_t* active) const;
    void sync_joint(LocalNode node);
    void load_patch_tapes(const Patch& patch);
    /// Whether the last surface stands for others of the cell.
    bool has_stand_in() const { return joint_ != nullptr || crowded_; }
    bool is_solid(std::size_t surface) const { return crowded_ && surface + 1 == surfaces_.size(); }
    // crowd.cpp
    void load_crowd();
    int solid_sign(const double* x) const;
    bool holds(const TreeNode& leaf, const double* x) const;
    double solid_root(const double* low, const double* high) const;
    std::uint32_t surface_of_solid(const double* x) const;
    void sync_solid(LocalNode node);
    void sync_solid(LocalNode low, LocalNode high, const LocalNode* nodes, std::size_t count);
    const std::uint8_t* row(std::size_t index) const { return active_.data() + index * surfaces_.size(); }
    bool is_subdivided(int dx, int dy, int dz) const {
        return ((half_.subdivided >> ((dx + 1) + 3 * (dy + 1) + 9 * (dz + 1))) & 1) != 0;
    }
    bool is_vertex_fine(int x, int y, int z) const;
    bool is_face_split(int f) const;
    bool is_grid_vertex(LocalNode node) const;
    Scale whole_scale() const { return {units_ / kCellUnits, size_}; }
    Scale half_scale() const { return {1, 0.5 * size_}; }

    // face.cpp
    void partition_face(int f);
    void partition_quarter(int f, int u, int v);
    void partition_patch(const Patch& patch, const std::vector<LocalNode>& loop, int p);
    FaceMode patch_mode(const std::vector<LocalNode>& loop, const Patch& patch);
    void divide_hanging(const std::vector<LocalNode>& loop, const Patch& patch, std::vector<Facet>& facets);
    void cut_patch(const std::vector<LocalNode>& loop, const Patch& patch, std::vector<Facet>& facets);
    void fan_patch(const std::vector<LocalNode>& loop, const Patch& patch, std::vector<Facet>& facets);
    void order_patch(const std::uint8_t* active);
    bool split_patch(const Patch& patch, std::size_t k, int round);
    void list_mixed_edges(const Patch& patch, std::size_t p);
    bool splits_flat(std::uint16_t a, std::uint16_t b, LocalNode middle) const;
    void split_fan(std::uint16_t a, std::uint16_t b);
    /// Which side of a triangle of the fan an edge is, whichever way round; 3: none.
    static std::size_t side_of(const std::array<std::uint16_t, 3>& triangle, std::uint16_t a,
                               std::uint16_t b) {
        std::size_t i = 0;
        for (; i < 3; ++i) {
            const std::uint16_t u = triangle[i], v = triangle[(i + 1) % 3];
            if ((u == a && v == b) || (u == b && v == a)) break;
        }
        return i;
    }
    void load_certain_signs(const std::uint16_t* corners, std::size_t count, const std::uint8_t* active);
    /// The signs at hand of the face's active surfaces, in the order of both cells' tapes.
    template <class SignOf>
    void load_signs(const std::uint8_t* active, const SignOf& sign_of) {
        certain_signs_.assign(surfaces_.size(), 0);
        for (std::size_t s = 0; s < surfaces_.size(); ++s) {
            if (active[s] != 0) certain_signs_[s] = static_cast<std::int8_t>(sign_of(s));
        }
        other_signs_.assign(other_surfaces_.size(), 0);
        for (std::size_t i = 0; i < other_surfaces_.size(); ++i) {
            if (other_to_own_[i] < surfaces_.size()) other_signs_[i] = certain_signs_[other_to_own_[i]];
        }
    }
    bool ends_crease(std::size_t p, const std::array<std::uint16_t, 2>& edge, const std::uint8_t* active);
    bool matters(std::size_t surface) const;
    bool is_resolved() const;
    void add_polygon(const std::vector<LocalNode>& polygon, const Patch& patch, std::vector<Facet>& facets);
    bool is_flat(LocalNode a, LocalNode b, LocalNode c) const;
    /// Whether an edge of a face mesh lies within the face, not on its border.
    bool is_inner(const Patch& patch, LocalNode a, LocalNode b) const {
        return (nodes_[a].faces & nodes_[b].faces) == 1u << patch.face &&
               (nodes_[a].middles & nodes_[b].middles) == 0;
    }
    // crossing.cpp
    LatticePoint on_shared_curve(const Patch& patch, std::size_t k, const std::array<std::uint16_t, 2>& edge,
                                 const LatticePoint& at, int round);
    bool insert_crossings(const Patch& patch, std::size_t k);
    bool insert_crossing(const Patch& patch, std::size_t p, const std::array<std::uint16_t, 3>& corner);
    bool meets_third(const Patch& patch, std::size_t p, std::size_t q, const LatticePoint& at) const;
    bool matters_at(const Patch& patch, std::size_t surface, const LatticePoint& at);

    const tape::BoundModel& model_;
    const octree::Octree& tree_;
    TreeNode leaf_{};
    int level_ = 0;
    double size_ = 0;            ///< edge of the cell, box-local
    std::uint32_t xyz_[3] = {};  ///< in finest cells
    std::int32_t units_ = kCellUnits;
    int key_shift_ = 0;
    HalfGrid half_;
    Scale scale_;                          ///< of the entity at hand
    std::vector<std::uint32_t> surfaces_;  ///< active set, ascending
    tape::LocalTape local_tape_;
    const octree::LeafPole* pole_ = nullptr;
    const octree::LeafJoint* joint_ = nullptr;            ///< then the last of surfaces_ is kJointSurface
    std::array<std::size_t, 3> joined_{};                 ///< places of its chooser, inside and outside
    bool crowded_ = false;                                ///< then the last of surfaces_ is kSolidSurface
    std::vector<std::uint32_t> crowd_tape_;               ///< over kSolidSurface
    mutable std::vector<std::uint32_t> around_surfaces_;  ///< scratch of holds()
    mutable std::vector<std::int8_t> around_signs_;       ///< the same
    tape::LocalTape plain_tape_;                          ///< without joint or crowd
    std::vector<std::uint8_t> active_;  ///< rows × surfaces: active in a leaf around; row 0: in none
    std::size_t rows_ = 0;
    std::vector<std::uint8_t> segment_active_;  ///< scratch: on one segment
    std::vector<Node> nodes_;
    std::vector<std::int8_t> signs_;         ///< nodes × surfaces
    std::uint8_t snapped_ = 0;               ///< bit c: corner c snaps
    bool misplaced_ = false;                 ///< see is_misplaced
    std::size_t border_nodes_ = 0;           ///< on the cell's faces
    bool border_misplaced_ = false;          ///< misplaced_, of these
    std::array<LocalNode, 27> vertex_{};     ///< by x + 3 y + 9 z in halves, or kNoNode
    std::vector<LocalNode> edge_nodes_[12];  ///< inner nodes from the low end to the high end
    /// Of split faces: inner nodes from the middle of side i (as kFaceEdges) to the centre.
    std::vector<LocalNode> cross_nodes_[6][4];
    std::vector<Facet> patches_[kPatches];
    FaceMode modes_[kPatches] = {};
    std::array<LocalNode, 4> patch_corners_[kPatches] = {};
    std::size_t crossing_ = 0;  ///< the surface that cuts the patch at hand (F1)
    // Scratch of one face; numbers in `fan_` index `fan_nodes_`, whose order depends on the face alone.
    std::vector<LocalNode> fan_nodes_;
    std::vector<std::array<std::uint16_t, 3>> fan_;
    std::vector<std::pair<std::uint16_t, std::uint16_t>> mixed_;
    std::vector<std::size_t> patch_order_;         ///< in which the active surfaces cut the face
    std::vector<std::int8_t> certain_signs_;       ///< of the triangle or edge at hand
    std::vector<std::uint8_t> patch_active_;       ///< per surface of the cell
    const tape::LocalTape* patch_tape_ = nullptr;  ///< of the cell
    tape::LocalTape other_tape_;                   ///< of the cell beyond
    std::vector<std::uint32_t> other_surfaces_;    ///< its active set, ascending
    std::vector<std::size_t> other_to_own_;        ///< places in surfaces_, or the number of them: not there
    std::vector<std::int8_t> other_signs_;         ///< as certain_signs_
    std::vector<std::size_t> order_;
};

}  // namespace mortise::cnio
