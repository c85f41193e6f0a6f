// Improvement of the tetrahedra of one block of the lattice.
//
// A block's elements are those of the zone with their centroid in it, of one or two sizes. Nodes all of whose
// elements are in the block are free: they move along their stratum, and edges collapse and flip where only
// they are concerned. Everything else stays, so blocks do not know each other and may be done at once
// (docs/design/improvement.md).
//
// Every change is accepted only if the worst element that it touches gets better, and all stay positive.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "host/improve/block_mesh.hpp"
#include "host/improve/facet_grid.hpp"
#include "host/improve/loose_start.hpp"
#include "host/improve/star_views.hpp"

namespace mortise::improve {

/// A change must lift the worst quality by at least this factor, so that rounding never makes a loop.
inline constexpr double kLeastGain = 1.002;

/// A facet on a curved surface may lie this far from it, in edges of the smallest leaf there, or as far as
/// what it replaces: nodes on the surface and a bounded angle do not keep it near.
inline constexpr double kMostSag = 0.15;

/// Elements at least this good do not justify that a feature is lost: scaled Jacobian 0.065, 5.7 degrees.
inline constexpr double kMergeBelow = 0.1;

/// Elements at least this good do not justify that nodes lie beside the model: 15 degrees, 159 degrees, a
/// scaled Jacobian of 0.167.
inline constexpr double kLoosenBelow = 0.259;

/// Where smaller elements reach this nothing need be merged: scaled Jacobian 0.13.
inline constexpr double kRelieved = 0.2;

/// Cosine between a facet that a change makes or moves and its surface; less only if it was less before.
inline constexpr double kLeastAlignment = 0.75;

/// With more poor elements than one of so many the model itself must be the reason: further work would not
/// help enough.
inline constexpr std::size_t kTetrahedraPerPoor = 16;

/// Nodes that a block has added are numbered from here until the zone has numbered them.
inline constexpr ZoneNode kNewNode = 0x80000000u;

struct BlockOptions {
    bool reposition = true;        ///< move nodes (besides their projection onto the model)
    bool change_boundary = true;   ///< false: facets stay as they are
    bool move_boundary = true;     ///< false: their nodes do, too
    bool keeps_loose = false;      ///< nodes beside their surfaces are not put there
    bool look_ahead = true;        ///< changes of several steps
    bool is_first = true;          ///< nothing has been improved yet
    double raised_from = 0;        ///< if positive: what is at least this good gets better still
    bool watch_facets = false;     ///< no change may make facets cross,
    std::vector<Bounds> watched;   ///< in these places; if there are none, anywhere
    bool spares_shared = false;    ///< no change at nodes that other blocks have, too
    double target = kGoodQuality;  ///< elements at least this good are left alone
    double merge_distance = 0;     ///< features closer than this, in cells, may be merged; 0: none
    int rounds = 6;
};

/// What was done.
struct BlockCounters {
    std::uint64_t collapsed = 0;
    std::uint64_t merged = 0;   ///< of these, nodes of one feature with those of another
    std::uint64_t swapped = 0;  ///< edges and faces removed
    std::uint64_t moved = 0;
    std::uint64_t split = 0;     ///< edges
    std::uint64_t compound = 0;  ///< changes of several steps (lookahead.cpp)
    std::uint64_t tried = 0;     ///< elements for which changes were sought
    std::uint64_t repeated = 0;  ///< blocks that were done again with facets, or their nodes, left alone
    std::uint64_t given_up = 0;  ///< blocks that were left as they were

    void add(const BlockCounters& other);
};

class Block : private BlockMesh {
  public:
    explicit Block(const Surfaces& surfaces) : BlockMesh(surfaces) {}

    /// Loads the elements with these indices of the zone; `place` is scratch of one number per node of the
    /// zone, all kNone, and is left so. free[i]: node i of the zone may move.
    void load(const Zone& zone, const std::vector<std::uint32_t>& tetrahedra,
              const std::vector<std::uint32_t>& pyramids, const std::vector<std::uint8_t>& free,
              std::vector<std::uint32_t>& place);

    void run(const BlockOptions& options);

    /// After run(): whether there is what merging is for.
    bool has_slivers() const;

    /// After run(), where nothing else has helped: merges features closer than this, in cells. False if there
    /// are none.
    bool merge_slivers(double merge_distance);

    /// After run(): whether refine() is to be tried.
    bool may_refine() const;

    /// Makes elements smaller where they are poor, if that helps. False if nothing was done.
    bool refine();

    /// Instead of run(): lets nodes of slivers leave their surfaces. False if nothing was done.
    bool loosen(const BlockOptions& options, const LooseStart& start);

    /// Whether the block still is a mesh with the same outside: every face has its partner, or is a facet, or
    /// lies on the block's border as before; nodes do not coincide.
    bool verify() const;

    /// Whether facets of the outer boundary cross.
    bool has_crossed();

    /// After has_crossed(): around facets that cross each other, if those are few and most else has become
    /// good; otherwise none.
    std::vector<Bounds> crossed_places() const;

    /// Nodes of the zone with their strata.
    using Strata = std::vector<std::pair<ZoneNode, std::vector<std::uint32_t>>>;

    struct NewNode {
        Point at;
        double size;  ///< edge of the smallest leaf there, in finest cells
        std::vector<std::uint32_t> stratum;
    };

    /// What is left, in the zone's numbers.
    struct Result {
        std::vector<Tetrahedron> tetrahedra;
        std::vector<NewNode> added;                      ///< node kNewNode + i is the i-th
        std::vector<std::pair<ZoneNode, Point>> points;  ///< where free nodes are now
        Strata strata;                                   ///< those that merging has changed
        std::vector<LooseStart::Way> ways;               ///< of nodes merged while loose
        std::size_t slivers = 0;                         ///< elements that merging is for
        std::size_t poor = 0;                            ///< elements below kRelieved
        BlockCounters counters;
    };
    Result result() const;

    /// Whether there are creases closer to each other than half of `merge_distance` (in cells) for some way.
    bool has_creases_side_by_side(double merge_distance) const;

    BlockCounters counters;

  private:
    /// A change of connectivity that has been examined but not made.
    struct Change {
        std::vector<std::uint32_t> removed;
        std::vector<Tetrahedron> added;
        struct Retag {
            std::uint32_t tetrahedron;
            std::uint32_t face;
            FaceTag tag;
        };
        std::vector<Retag> retagged;
        double before = 0;  ///< quality of the worst that is removed
        double after = 0;   ///< of the worst that is added
        double needed = 0;  ///< `after` must be above this
        bool collapse = false;
        bool merge = false;  ///< strata change
        Local gone = kNone;  ///< of a collapse
        Local kept = kNone;

        void clear();
    };

    /// The facet on a face, for tetrahedra that are to be added.
    struct FaceEntry {
        std::array<Local, 3> node;  ///< ascending
        std::uint16_t region;
        FaceTag tag;
    };

    /// A node of the link of a node that a collapse removes.
    struct LinkNode {
        Local node;
        std::uint32_t outer = 0;     ///< facets of the outer boundary at the edge from the removed node
        bool at_edge = false;        ///< shares a tetrahedron with both ends of the collapsed edge
        bool facet = false;          ///< a facet holds it and the removed node
        bool facet_at_edge = false;  ///< one that has the collapsed edge
    };

    // room.cpp
    /// The volume of some elements of a region, and their share of what was there first.
    struct Room {
        std::uint16_t region;
        double volume;
        double share;
    };
    double volume(const Tetrahedron& t) const;
    static void add_share(std::uint16_t region, double volume, double share, std::vector<Room>& rooms);
    void add_room(const Tetrahedron& t, std::vector<Room>& rooms) const;
    bool is_curved(const std::vector<std::uint32_t>& stratum) const;
    void gather_room(Local node, std::vector<Room>& rooms) const;
    static bool has_swollen(const std::vector<Room>& before, const std::vector<Room>& after, double most);
    bool have_swollen(const std::vector<std::uint32_t>& changed);
    bool swells(const Change& change);
    bool star_swells(Local node);
    void hand_on_shares(Change& change);
    void divide_shares(Local node);
    double share_of(const Tetrahedron& t, const std::vector<Room>& rooms) const;

    // crossing.cpp
    std::array<Point, 3> triangle(const std::array<Local, 3>& node) const;
    bool stab_each_other(const std::array<Local, 3>& a, const std::array<Local, 3>& b) const;
    bool cross_each_other(const std::array<Local, 3>& a, const std::array<Local, 3>& b) const;
    bool is_watched(const Bounds& facet) const;
    void list_facets(std::uint32_t tetrahedron);
    void list_watched_facets();
    template <class Listed>
    void list_facets_if(const Listed& listed);
    void note_crossing(const std::array<Local, 3>& a, const std::array<Local, 3>& b);
    void drop_unwatched(std::vector<std::array<Local, 3>>& facets) const;
    template <class Stays>
    bool any_crosses(const std::vector<std::array<Local, 3>>& facets, const Stays& stays);
    bool crosses(const Change& change);
    bool facets_cross(Local node);

    // block.cpp
    bool is_for_later(const Change& change) const;
    void apply(Change& change);
    void tag_added(Change& change, const std::vector<FaceEntry>& entries) const;
    bool improve(std::uint32_t tetrahedron);
    void look_now_and_then();
    bool is_barren(double quality) const;
    void lower_target();
    void sweep();
    void limit_search(std::uint64_t tetrahedra);
    void mend(std::uint64_t tetrahedra);
    void mend_further();
    bool is_spent() const { return counters.tried >= most_tried_ || evaluated_ > most_evaluated_; }
    bool has_changed(std::uint32_t tetrahedron) const;
    void touch(Local node);
    void collapse_short_edges();

    // refine.cpp
    Local add_node(const Point& at, double size, std::vector<std::uint32_t> stratum);
    Local split_edge(Local a, Local b);
    struct Seed;
    struct Cluster;
    std::vector<Cluster> find_clusters() const;
    std::vector<Seed> find_seeds(const std::vector<std::uint32_t>& members, double edge_per_height) const;
    std::size_t split_long_edges(const std::vector<std::uint32_t>& members, double edge_per_height);
    bool relieve(const Cluster& cluster, const std::vector<std::uint32_t>& members);
    static double asked_length(const std::vector<Seed>& seeds, const Point& at, double most);
    struct Relief {
        bool is_enough = false;
        bool is_near = false;  ///< changes of several steps may make it one
    };
    Relief find_relief(const Block& before, const Cluster& cluster) const;

    // lookahead.cpp
    struct Candidate;
    std::size_t count_poor() const { return count_below(options_.target); }
    /// Whether so much is poor that the model must be the reason: it has no room for good elements.
    bool is_hopeless() const;
    bool has_much_poor() const;
    bool look_ahead_all();
    bool look_ahead(std::uint32_t tetrahedron);
    void gather_candidates(std::uint32_t tetrahedron, std::vector<Candidate>& candidates);
    bool examine(const Candidate& candidate, std::uint32_t tetrahedron, Change& change);
    bool finish_trial();
    void begin_trial();
    void undo_trial();
    bool trial_stays_close() const;
    void note_tetrahedron(std::uint32_t tetrahedron);
    void note_move(Local node);

    // collapse.cpp
    struct CachedViews;
    bool examine_collapse(Local gone, Local kept, bool good_will_do, double better_than, Change& change);
    bool list_collapse(Local gone, Local kept, const CachedViews& seen, Change& change);
    bool crease_stays_close(Local gone, Local kept) const;
    bool facets_stay_aligned(Local gone, Local kept, bool any_narrow) const;
    bool examine_ear(Local gone, Change& change);
    bool ear_leaves_crease(std::uint32_t ear, std::size_t gone, std::size_t single, bool& merges) const;
    bool is_narrow(const std::array<Local, 3>& face) const;
    bool chord_is_close(Local gone, Local a, Local b) const;
    std::size_t count_feature_edges(Local node);
    bool links_allow(Local gone, Local kept);
    bool is_joined_link_whole(Local gone, Local kept) const;
    bool is_link_whole(std::size_t outer, Local gone) const;
    bool is_link_shared(Local gone, Local kept) const;
    bool sheets_would_meet(Local kept) const;

    // verify.cpp
    bool verify_faces() const;

    // merge.cpp
    void merge_close_nodes();
    bool merge(const std::array<Local, 4>& node);
    bool may_merge(Local gone, Local kept);
    struct Facing {
        Point normal;
        Point away;
    };
    Facing facing(Local node, std::uint32_t surface) const;
    bool makes_blade(Local gone, Local kept) const;
    void renew_strata(const Change& merge);

    // loosen.cpp
    double way_to(Local node, const Point& at) const;
    bool is_within_reach(Local node, const Point& at) const;
    void note_way(Local gone, Local kept);
    bool is_at_sharp_edge(const std::array<Local, 4>& node) const;
    std::vector<std::uint32_t> list_loosable() const;

    // swap.cpp
    /// The tagged faces at an edge, as places in its ring: face k lies between tetrahedra k - 1 and k.
    struct RingCuts {
        std::size_t at[2] = {0, 0};
        std::size_t count = 0;
        std::uint32_t surface = 0;
        bool on_interface = false;
    };
    bool read_ring(Local a, Local b, Change& change, RingCuts& cuts);
    bool is_new_on_surface(Local p, Local q, bool peels, const Change& change) const;
    bool flip_fits(std::uint32_t surface, Local a, Local b, Local p, Local q) const;
    bool peel(std::uint32_t tetrahedron, Local a, Local b, Local p, Local q, FaceTag tag,
              Change& change) const;
    bool examine_edge_removal(Local a, Local b, double better_than, Change& change);
    bool examine_face_removal(std::uint32_t tetrahedron, std::size_t face, double better_than,
                              Change& change);
    static constexpr std::size_t kLongestPolygon = 9;
    using PolygonMiddles = std::array<std::array<std::size_t, kLongestPolygon>, kLongestPolygon>;
    bool triangulate(const std::vector<Local>& polygon, Local a, Local b, double needed,
                     PolygonMiddles& middle);
    void add_over_triangles(const std::vector<Local>& polygon, const PolygonMiddles& middle, Local a, Local b,
                            std::uint16_t region, Change& change);
    bool diagonals_are_new(const std::vector<Local>& polygon, const Change& change, std::size_t first) const;
    bool fill_polygon(const std::vector<Local>& polygon, Local a, Local b, std::uint16_t region,
                      Change& change);

    // smooth.cpp
    bool project_nodes(Local first = 0);
    /// What the place of a node is to do for the elements around it.
    enum class Wish {
        kWorstBetter,  ///< the worst of them improves
        kAllBetter,  ///< together they come closer to the target; none falls below raised_from, or the worst
    };
    bool may_smooth(Local node, Wish wish);
    bool smooth(Local node, Wish wish = Wish::kWorstBetter);
    struct Goal;
    class PlaceSearch;
    struct StarSize {
        Point mean{};     ///< of the neighbours, each as often as there are elements with both
        Point away{};     ///< of length 1, from the face opposite the node in its worst element
        double edge = 0;  ///< mean length of the node's edges
        double shortest = 0;
    };
    StarSize measure_star(Local node) const;
    struct Directions {
        std::array<Point, 9> at{};
        std::size_t count = 0;
    };
    bool find_directions(Local node, const Point& away, Directions& found) const;
    double shortfall(const StarViews& seen) const;
    void relax();
    /// The star of a node, as long as nothing changes.
    struct CachedViews {
        Local node = kNone;
        std::uint64_t version = 0;
        double worst = 0;          ///< quality of its tetrahedra
        double squared_reach = 0;  ///< to the farthest node
        StarViews views;
    };
    CachedViews& views(Local node);
    double quality_at(StarViews& views, const Point& p, double enough, Local except = StarViews::kNobody);

    BlockOptions options_;
    std::vector<ZoneNode> zone_node_;
    Local loaded_ = 0;                  ///< nodes of the zone; the others are new
    double most_sag_ = kMostSag;        ///< of a facet that a change makes
    std::vector<std::uint8_t> shared_;  ///< per node: other blocks have it, too
    std::vector<std::uint8_t> joined_;
    std::vector<std::uint8_t> tip_;  ///< 0, or 1 + place in tips_
    std::vector<Point> tips_;
    std::vector<Local> renewed_;  ///< nodes whose strata have changed
    bool may_merge_ = false;
    bool is_loose_ = false;  ///< nodes may leave their surfaces
    const LooseStart* loose_start_ = nullptr;
    std::vector<double> used_;           ///< per node, while they are loose: as LooseStart::used
    std::vector<Tetrahedron> original_;  ///< as they were loaded
    std::vector<Point> original_points_;
    std::uint32_t clock_ = 0;             ///< counts changes
    std::vector<std::uint32_t> changed_;  ///< per node: when its star changed last
    std::vector<std::uint32_t> rested_;   ///< per node: when it was last found in its best place, plus 1
    std::vector<std::uint32_t> tried_;    ///< per tetrahedron: when it was last tried in vain
    FacetGrid grid_;                      ///< of the outer boundary's
    std::size_t most_listed_ = 0;         ///< entries of it
    // Scratch of swells.
    std::vector<Room> room_before_, room_after_;
    std::vector<Room> start_room_;             ///< of the elements of a node that is to move
    std::vector<std::uint64_t> counted_;       ///< per tetrahedron: when its room was last counted
    std::vector<std::uint64_t> counted_node_;  ///< per node: the same of its tetrahedra
    std::uint64_t count_ = 0;
    std::vector<Bounds> crossed_;  ///< places that has_crossed() has found
    // Scratch of crosses.
    std::vector<std::array<Local, 3>> facets_;
    std::vector<std::array<Local, 3>> faces_before_;
    std::vector<std::uint32_t> removed_;
    std::vector<Bounds> boxes_;
    Change trial_;
    Change best_;
    Ring ring_;
    std::vector<FaceEntry> entries_;
    std::vector<LinkNode> link_;
    std::vector<std::uint32_t> seen_at_;  ///< scratch of links_allow, one per node
    std::vector<std::pair<Local, std::uint32_t>>
        spokes_;                        ///< neighbour, surface of a facet at the edge to it
    std::array<CachedViews, 4> views_;  ///< asked last
    std::size_t next_views_ = 0;
    std::uint64_t version_ = 0;          ///< counts changes, also those of the past that are undone
    std::uint64_t most_evaluated_ = 0;   ///< until they are these,
    std::uint64_t last_evaluation_ = 0;  ///< which are no more than these
    std::uint64_t most_tried_ = 0;       ///< or so many searches are made, the block is worked on
    unsigned looks_ = 0;                 ///< of look_now_and_then

    /// A change must lift the worst quality by this factor: kLeastGain, but for the first step of a trial.
    double least_gain_ = kLeastGain;

    /// Changes that are undone unless the worst element that they touch gets better.
    struct Trial {
        struct Step {
            std::vector<std::uint32_t> removed;
            std::size_t first_added;
            std::vector<Change::Retag> tags;  ///< as they were
            Local moved = kNone;
            Point from{};
        };
        bool on = false;
        double before = 0;                   ///< worst quality of what has been touched, as it was
        double sag = 0;                      ///< largest distance of its facets from curved surfaces
        std::vector<std::uint32_t> touched;  ///< elements that were there and have been touched
        std::vector<std::uint32_t> pyramids;
        std::vector<Step> steps;
        std::size_t tetrahedra = 0;  ///< how many there were
        std::uint32_t clock = 0;
        std::vector<std::uint32_t> changed, rested, tried;
        BlockCounters counters;
    };
    Trial running_;
    std::uint64_t trials_left_ = 0;
    std::vector<std::uint32_t> looked_;  ///< per tetrahedron: when looking ahead from it was last in vain
    std::uint32_t looks_since_ = 0;      ///< looking ahead is only from what has changed since then
};

}  // namespace mortise::improve
