// A mesh in parts: pieces of the Morton order whose nodes have the numbers of the whole mesh, and all their
// positions. Uniform trees only: there a piece names nodes of earlier pieces, never of later ones.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <vector>

#include "host/assembly/assembly.hpp"
#include "host/pipeline/prepare.hpp"

namespace mortise::pipeline {

/// One part. Its mesh has first its own nodes, with numbers from `first` on, then those of other parts.
struct Part {
    Mesh mesh;
    NodeId first = 0;
    std::size_t own = 0;
    std::vector<NodeId> foreign;          ///< numbers in the whole mesh of nodes `own`, `own` + 1, …
    std::vector<std::uint8_t> is_shared;  ///< per own node: other parts may name it
    std::array<std::uint64_t, kElementTypes> first_element{};  ///< numbers of its first elements

    NodeId number(NodeId local) const { return local < own ? first + local : foreign[local - own]; }
};

/// Cuts a mesh into parts and makes them, any number of times.
class Parts {
  public:
    /// As many parts as keep each within `bytes`, or `count` if that is not 0.
    Parts(device::Device& device, const MeshOptions& options, Prepared& prepared, Stages& stages,
          std::uint64_t bytes, std::size_t count);

    std::size_t count() const { return ranges_.size(); }
    const assembly::MortonRange& range(std::size_t p) const { return ranges_[p]; }

    /// Makes part p. Parts must be made once in order before any of them is made again. `progress` and
    /// `next`: what the run has done before and after.
    Part make(std::size_t p, double progress, double next);

    /// Of the parts made so far.
    const MeshTotals& totals() const { return totals_; }
    /// What the first making of each part counted.
    const Extracted& extracted() const { return extracted_; }

    /// Node numbers that part p, made before, has of its own: [first, second).
    std::pair<NodeId, NodeId> own_nodes(std::size_t p) const { return {known_[p].first, known_[p].end}; }
    /// Numbers of other parts' nodes that part p uses.
    const std::vector<NodeId>& foreign_nodes(std::size_t p) const { return known_[p].foreign; }

  private:
    struct Known {
        NodeId first, end;
        std::array<std::uint64_t, kElementTypes> first_element;
        std::vector<NodeId> foreign;
    };
    using Point = std::array<double, 3>;
    template <class Name>
    struct Shared {
        Name name;
        NodeId number;
        friend bool operator<(const Shared& a, const Name& b) { return a.name < b; }
    };

    void cut(std::uint64_t bytes, std::size_t count);
    void learn(std::size_t p, const assembly::Piece& piece);
    template <class Name>
    static void resolve(const std::vector<Name>& names, const std::deque<Shared<Name>>& shared, Part& part);
    void add_foreign_points(const assembly::Piece& piece, Part& part) const;
    /// Where a vertex of the grid lies if it has not been moved; of other nodes the owner's corner.
    Point grid_point(std::uint64_t name) const;

    device::Device& device_;
    const MeshOptions& options_;
    Prepared& prepared_;
    Stages& stages_;
    octree::InRegions in_regions_;
    std::vector<assembly::MortonRange> ranges_;
    std::vector<Known> known_;
    // Nodes that later parts may name, ascending, since parts and their leaves are in Morton order. Grid
    // vertices are most of what is kept of a large mesh, so only those that have moved keep their points.
    // Deques: a vector that grows needs three times its memory.
    std::deque<Shared<std::uint64_t>> grid_;
    std::deque<std::pair<std::uint64_t, Point>> moved_;
    std::deque<Shared<assembly::ExtraName>> extras_;
    std::deque<Point> extra_points_;  ///< parallel to extras_
    MeshTotals totals_;
    Extracted extracted_;
};

}  // namespace mortise::pipeline
