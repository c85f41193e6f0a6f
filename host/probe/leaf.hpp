// What the samples of one NIO leaf miss of the solid in it.
//
// A surface is hidden in a leaf if it has one sign at all of the leaf's samples (corners, face centres,
// centre): templates and certificate then take that sign for the whole leaf. Where the surface passes through
// the leaf all the same, the solid may differ from the mesh. The leaf is subdivided by interval bounds down
// to kSide pieces per edge, and the pieces that differ are gathered into components.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/octree/octree.hpp"
#include "host/tape/compile.hpp"
#include "host/tape/local_tape.hpp"
#include "host/tape/reference.hpp"
#include "host/tape/surface_batch.hpp"

namespace mortise::probe {

inline constexpr int kDepth = 4;  ///< subdivisions of a leaf
/// Pieces per edge; a ball of radius √3/2 of one is found for certain.
inline constexpr int kSide = 1 << kDepth;
inline constexpr std::uint32_t kPieces = kSide * kSide * kSide;  ///< in a leaf
/// Pieces of one depth; with more, the depth before is final.
inline constexpr std::size_t kMostPieces = 4096;

/// Pieces of one leaf, joined by faces, that lie in `region` and are meshed as another one.
struct Component {
    std::uint32_t leaf = 0;    ///< index into Octree::nio
    std::uint16_t region = 0;  ///< 0: outside
    bool attached = false;     ///< touches pieces of its region that are meshed as such, in this leaf
    bool torn = false;         ///< sections through faces of the leaf that these do not see
    bool usable = false;       ///< its leaf may have the point below as the apex of its cone
    std::vector<std::uint16_t> pieces;  ///< x + kSide·y + kSide²·z, ascending
    std::vector<std::uint16_t> open;    ///< those of them that touch such meshed pieces
    Vec3 point{};                       ///< well inside, box-local
    int depth = 0;                      ///< layers of pieces around it
    double thickness = 0;               ///< shortest chord through it, within the leaf, box-local
};

/// Probes leaves one at a time; keeps its scratch memory. One per thread.
class LeafProbe {
  public:
    LeafProbe(const tape::BoundModel& model, const octree::Octree& tree)
        : model_(model), tree_(tree), batch_(model) {}

    /// Looks at leaves from `begin` to `end` together, before run() is asked for each of them: faster.
    void prepare_batch(std::uint32_t begin, std::uint32_t end);

    /// Appends the leaf's components, ordered by their first pieces.
    void run(std::uint32_t leaf, std::vector<Component>& out);

    /// Leaves so far that were subdivided.
    std::uint64_t probed() const { return probed_; }
    /// Whether a formula of the leaf is 0 at its centre and around it.
    bool is_flat(const TreeNode& leaf) const;
    /// Of the leaf of the last run: whether a curved surface turns by 90 degrees or more in it.
    bool folds() const { return folds_; }

  private:
    struct Piece {
        tape::GridPlace place;  ///< of 2^depth per edge
        bool decided;           ///< no hidden surface is undecided in it
    };
    struct Found {
        std::int32_t region = -1;  ///< -1: nothing missed here
        Vec3 point{};
        double value = 0;  ///< |f| of the hidden surface there
    };

    // sections.cpp
    int sign_at(std::uint32_t surface, const Vec3& x) const;
    Vec3 on_face(int f, double u, double v) const;
    Vec3 on_edge(int e, double t) const;
    bool passes_through(int f, const Vec3& x) const;
    bool surrounds(int e, const Vec3& x) const;
    bool is_cap_across_edge(int f, double u, double v) const;
    int steps_to_end(const Vec3& x, const Vec3& step) const;
    std::array<int, 8> steps_around(const Vec3& x, std::size_t axis) const;
    bool is_tip_at_edge(int e, const Vec3& x) const;
    bool is_tip_in_face(int f, const Vec3& x) const;
    void find_section(int f);
    void find_bridge(int e);
    void note_section(const Found& found);
    void find_sections(std::uint32_t leaf, std::vector<Component>& out);
    // pieces.cpp
    tape::Grid grid(int depth) const;
    void subdivide();
    void halve(int depth);
    void decide(int depth);
    void sample(int depth);
    void keep_away(std::size_t hidden, int depth);
    void find_missed(const std::vector<std::size_t>& pieces, const std::vector<Vec3>& points,
                     std::size_t sampled);
    void approach(std::size_t hidden, int depth);
    void step_beyond(std::vector<std::size_t>& pieces, std::vector<Vec3>& points, int depth);
    // leaf.cpp
    struct Curved {
        std::uint32_t count = 0;
        std::uint32_t last = 0;
    };
    Curved curved_surfaces(const TreeNode& leaf) const;
    Vec3 middle_of(const TreeNode& leaf) const;
    bool is_steady(std::uint32_t index, std::uint32_t surface, const tape::Cell& whole) const;
    bool load(std::uint32_t index);
    void load_tape(const TreeNode& leaf);
    std::int8_t sample_sign(std::uint32_t surface) const;
    bool differs_here(const Vec3& x, Found& found);
    bool is_missed(const Vec3& x, Found& found);
    void find_missed_at(const std::vector<Vec3>& points);
    void gather(std::uint32_t leaf, std::vector<Component>& out);
    void finish(Component& component);
    bool sees_all(const Component& component);
    std::vector<double> reaches(const Component& component, const std::vector<Vec3>& directions);
    void measure(Component& component);
    bool needs_centre() const;
    void take_signs(const Vec3& x);
    Vec3 centre(std::uint32_t piece) const;
    tape::Cell cell(const std::uint8_t* at, int depth) const;

    /// Planes hide nothing.
    bool cannot_hide(std::uint32_t surface) const { return model_.surfaces[surface].kind == kSurfacePlane; }

    const tape::BoundModel& model_;
    const octree::Octree& tree_;
    std::uint64_t probed_ = 0;
    double low_[3] = {};
    double edge_ = 0;  ///< of the leaf
    bool folds_ = false;
    std::uint32_t first_seen_ = 0;  ///< by prepare_batch()
    std::vector<std::int8_t>
        steady_;  ///< by leaf from there on: has_small_variation of its one surface; -1: not known
    std::vector<std::uint32_t> surfaces_;  ///< of the leaf's tape, ascending
    tape::LocalTape local_tape_;
    std::vector<std::uint32_t> hidden_;     ///< indices into surfaces_
    std::vector<std::int8_t> hidden_sign_;  ///< at the samples
    std::vector<std::uint32_t> winding_;    ///< seen by some sample, and turning by 90 degrees or more
    tape::SurfaceBatch batch_;
    std::vector<Piece> pieces_, next_;
    std::vector<tape::GridPlace> places_;  ///< scratch for pieces
    std::vector<std::int8_t> piece_signs_, contrary_, decided_;
    std::vector<double> values_, widths_;
    std::vector<SurfaceSample> samples_;
    std::vector<std::vector<SurfaceSample>> middles_;  ///< of pieces_, by hidden surface
    std::vector<std::vector<double>> slopes_;          ///< of pieces of kGradientDepth, by hidden surface
    bool has_slopes_ = true;         ///< most pieces of kGradientDepth of each hidden formula
    std::vector<std::size_t> open_;  ///< undecided among places_, with open_places_
    std::vector<tape::GridPlace> open_places_;
    std::vector<Found> missed_;  ///< by index into pieces_
    std::vector<Found> found_;   ///< by piece of the last depth, or empty
    std::vector<std::int8_t> signs_, assumed_;
    std::vector<double> values_here_;             ///< of surfaces_, where signs_ are
    std::vector<std::vector<double>> values_at_;  ///< of surfaces_, at many points
    std::vector<Found> found_at_;
    std::vector<std::uint8_t> layer_;
};

}  // namespace mortise::probe
