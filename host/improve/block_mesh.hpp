// The elements of a block, and what can be asked about them.
//
// Nodes and elements have numbers of the block's own. Elements that a change removes stay in their place,
// dead; what it adds comes at the end.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "host/improve/quality.hpp"
#include "host/improve/stratum.hpp"
#include "host/improve/zone.hpp"

namespace mortise::improve {

/// Edges shorter than this, in edges of the smallest leaf at their ends, are collapsed where that makes
/// nothing worse.
inline constexpr double kShortEdge = 0.35;

inline constexpr std::size_t kMostSurfaces = 8;  ///< that may have a crease in common

class BlockMesh {
  protected:
    using Local = std::uint32_t;  ///< a node

    /// Tetrahedra around an edge in order, and the nodes opposite.
    struct Ring {
        std::vector<std::uint32_t> tetrahedra;
        std::vector<Local> nodes;  ///< tetrahedron i has nodes i and i + 1 (cyclic if closed)
        bool closed = false;
    };

    /// How a facet lies on its surface, at the facet's middle: cosine between both, and distance in finest
    /// cells.
    struct Fit {
        double alignment = 0;
        double sag = 0;
    };

    explicit BlockMesh(const Surfaces& surfaces) : surfaces_(&surfaces) {}

    bool is_plane(std::uint32_t surface) const { return surfaces_->is_plane(surface); }

    // Elements.
    std::size_t count_alive() const;
    std::size_t count_below(double quality) const;
    /// Whether all nodes are free.
    bool is_inside(const std::array<Local, 4>& node) const;
    double quality(const std::array<Local, 4>& node) const;
    std::array<Point, 5> corners(const std::array<Local, 5>& pyramid) const;
    /// The tetrahedron beyond a face, or kNone.
    std::uint32_t across(std::uint32_t tetrahedron, std::size_t face) const;
    /// Of the face with these nodes.
    FaceTag tag_of(std::uint32_t tetrahedron, Local a, Local b, Local c) const;

    // Edges.
    bool is_short_edge(Local a, Local b) const {
        const double shortest = kShortEdge * std::min(size_[a], size_[b]);
        return squared_length(points_[a] - points_[b]) < shortest * shortest;
    }
    bool share_tetrahedron(Local a, Local b) const;
    /// The tetrahedra around an edge; false if they are none, more than `longest` (16 at most), or in more
    /// than one piece.
    bool gather_ring(Local a, Local b, std::size_t longest, Ring& ring) const;
    bool edge_is_on_stratum(Local gone, Local kept) const;

    // Nodes.
    std::vector<Local> neighbours(Local node) const;
    std::vector<Point> crease_neighbours(Local node) const;
    /// The worst quality of a node's elements, or one not above `enough`.
    double star_quality(Local node, double enough) const;
    double known_star_quality(Local node) const;

    // Facets.
    Fit fit(std::uint32_t surface, const Point& a, const Point& b, const Point& c) const;
    double alignment(std::uint32_t surface, const Point& a, const Point& b, const Point& c) const {
        return fit(surface, a, b, c).alignment;
    }
    Fit worst_fit(Local node) const;
    double worst_sag(std::uint32_t tetrahedron) const;

    const Surfaces* surfaces_;
    std::vector<Point> points_;
    std::vector<double> size_;  ///< per node: edge of the smallest leaf around it, in finest cells
    double unit_ = 1;           ///< Zone::unit
    double rounding_ = kVolumeRounding;
    std::vector<std::uint8_t> free_;  ///< per node: it may move, and all its elements are in the block
    std::vector<std::vector<std::uint32_t>> strata_;  ///< per node: its surfaces, ascending
    std::vector<Tetrahedron> tetrahedra_;
    std::vector<std::uint8_t> alive_;
    std::vector<std::array<Local, 5>> pyramids_;
    std::vector<std::vector<std::uint32_t>> star_;          ///< per node: its tetrahedra
    std::vector<std::vector<std::uint32_t>> pyramid_star_;  ///< per node: its pyramids
    mutable std::uint64_t evaluated_ = 0;                   ///< qualities computed
};

}  // namespace mortise::improve
