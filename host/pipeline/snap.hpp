// Snapping of vertices beside complex leaves: between the two halves of classification.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "host/pipeline/prepare.hpp"

namespace mortise::pipeline {

/// Which vertices of complex leaves snap, and what follows for the leaves around them.
///
/// All that snapping::find_snapped finds do at first. Then the leaves around are meshed, or tried, each for
/// its own corners; a vertex where one of them would have elements that are not positive, or lose a feature,
/// stays where it is, and the leaves around it are tried again. Each round takes back what the last one has
/// found, so their order does not matter, and in the end all leaves bear what is left.
class Snapping {
  public:
    /// All arguments outlive it. `keep`: cells that the certificate has meshed are kept.
    Snapping(snio::Classifier& classifier, Prepared& prepared, bool keep, int threads);

    /// Fills tree.crowded and tree.snapped; returns how many vertices snap. `strict`: leaves none of whose
    /// vertices do, indices into Octree::nio.
    std::size_t find(std::vector<std::uint32_t> strict);

    /// Ends the classification.
    void classify();

    /// Meshes the complex leaves that no snapped vertex touches, too, if cells are kept.
    void extract();

  private:
    /// A leaf with corners that snap, or did.
    struct Touched {
        TreeNode leaf;  ///< of an IN leaf: without a tape
        bool is_in;
        bool is_complex;        ///< from the start; of an IN leaf: it will be a misfit (snio/misfits.cl)
        bool is_split = false;  ///< a face is (octree::odd_corner)
        snio::Keeps keeps = snio::Keeps::kTemplate;
        SnappedLeaf corners{};
        std::array<std::uint32_t, 8> vertex{};  ///< of corners.snapped: its place in vertices_

        bool needs_certificate() const {
            return is_complex || is_split || (!is_in && keeps != snio::Keeps::kTemplate);
        }
    };

    /// Corners that a leaf does not bear together.
    struct Blame {
        std::uint32_t leaf;  ///< its place in touched_
        u32 corners;
        bool needs_all;  ///< all of them are to stay where they were
    };

    std::vector<std::uint32_t> find_complex();
    void list_touched();
    bool is_misfit(std::uint64_t code) const;
    void update(Touched& touched) const;
    void judge_simple(const std::vector<std::uint32_t>& simple);
    std::vector<std::uint32_t> find_unfit(const std::vector<std::uint32_t>& dirty);
    std::vector<std::uint32_t> choose(const std::vector<Blame>& blames) const;
    const SnioCandidate* simple_beyond(const Touched& touched, int f) const;
    bool has_face_on_other(const Touched& touched) const;
    bool find_surface(Touched& touched) const;
    std::vector<std::uint32_t> take_back(const std::vector<std::uint32_t>& unfit);

    snio::Classifier& classifier_;
    Prepared& prepared_;
    octree::Octree& tree_;
    bool keep_;
    int threads_;
    std::vector<octree::SnappedVertex> vertices_;  ///< all that were found
    std::vector<std::uint8_t> snaps_;              ///< which of them do
    std::vector<Touched> touched_;                 ///< by code
    cnio::Extraction extraction_;                  ///< records parallel to touched_, of what was meshed
};

}  // namespace mortise::pipeline
