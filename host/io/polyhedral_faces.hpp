// Faces of a mesh as finite volumes want them: each once, between an owner and a neighbour.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/common/edge_middles.hpp"
#include "mortise/mesh.hpp"

namespace mortise::io {

/// Cells are numbered as Mesh::elements lists them, type after type. A face with hanging nodes in its edges
/// has these as corners, too; one with a hanging node in its middle is four.
class PolyhedralFaces {
  public:
    /// A face is local face `local` of element `cell`, or the reverse of it.
    struct Face {
        std::uint32_t owner;      ///< the face's normal points away from it
        std::uint32_t neighbour;  ///< kOutside: none
        std::uint32_t cell;
        std::uint8_t local;
        bool reversed;
        std::uint8_t start = 0;  ///< its corners begin with this one of the local face's
    };
    static constexpr std::uint32_t kOutside = 0xffffffffu;
    static constexpr std::size_t kMostCorners = 8;

    /// Throws Error(kMeshing) if an outer face is missing from the mesh's facets, or what hanging_faces
    /// throws.
    PolyhedralFaces(const Mesh& mesh, int threads);

    /// Inner faces by owner and neighbour, ascending and owner < neighbour; then the outer ones, surface by
    /// surface, by owner.
    const std::vector<Face>& faces() const { return faces_; }
    std::size_t inner_count() const { return inner_count_; }
    std::size_t cell_count() const { return first_[kElementTypes]; }

    /// Outer faces of a surface of the mesh; none: none. If all of them are periodic, `partner` is the index
    /// of the patch with their images, in the same order, which begin with the same corner and run the other
    /// way.
    struct Patch {
        std::uint32_t surface;
        std::size_t first;  ///< among faces()
        std::size_t count;
        std::size_t partner = kNoPatch;
    };
    static constexpr std::size_t kNoPatch = static_cast<std::size_t>(-1);
    const std::vector<Patch>& patches() const { return patches_; }

    /// Writes the nodes of a face, counter-clockwise seen from the neighbour, to `corners`; returns how many.
    std::size_t corners(const Face& face, std::array<NodeId, kMostCorners>& corners) const;

  private:
    struct Entry;
    void match(std::vector<Entry>& entries);
    void add_outer(const std::vector<Entry>& unmatched);
    void pair_patches();
    std::vector<Face> images(const Patch& original, const Patch& copy,
                             const std::vector<NodeId>& original_of) const;
    std::vector<Entry> add_hanging(const std::vector<Entry>& unmatched);
    std::size_t local_nodes(std::uint32_t cell, std::uint8_t local, NodeId* nodes) const;

    const Mesh& mesh_;
    std::array<std::size_t, kElementTypes + 1> first_{};  ///< number of the first cell of each type
    std::vector<Face> faces_;
    std::size_t inner_count_ = 0;
    std::vector<Patch> patches_;
    std::vector<std::uint8_t> is_end_;  ///< per node: of an edge with a hanging node; empty: there is none
    EdgeMiddles middles_;
};

}  // namespace mortise::io
