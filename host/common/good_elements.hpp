// A quick look that tells most good elements, many at a time, so that few are looked at closely.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "mortise/mesh.hpp"

namespace mortise {

/// Where the lattice of positions lies, and how short an edge may be.
struct GoodElementsFrame {
    std::array<double, 3> origin{};
    double per_cell = 1;      ///< finest cells in a model unit
    bool on_lattice = false;  ///< nodes lie on the lattice of positions (kernels/shared/lattice.h), but for
                              ///< the rounding of model coordinates
    double shortest = 0;      ///< edge of a hexahedron, wedge or pyramid that is good, in cells; 0: any
};

inline constexpr std::size_t kLookedAtOnce = 8;

/// Bit i: the i-th of eight elements of one type, given by their nodes, is certainly good: its dihedral
/// angles are between 18 and 155 degrees, its scaled Jacobians at least 0.2, its edges long enough, all by a
/// millionth, so that other formulas for the same agree. Other bits say nothing: none is set where the
/// compiler has no lanes.
unsigned certainly_good(ElementType type, const double* points,
                        const std::array<const NodeId*, kLookedAtOnce>& elements,
                        const GoodElementsFrame& frame);

/// Passes elements of one type on in their order, without those that are certainly good.
template <class Visit>
class GoodElementsFilter {
  public:
    /// `visit(i)`: element i of the mesh's block is not certainly good.
    GoodElementsFilter(const Mesh& mesh, ElementType type, const GoodElementsFrame& frame, const Visit& visit)
        : nodes_(mesh.block(type).nodes.data()),
          points_(mesh.points.data()),
          type_(type),
          frame_(frame),
          visit_(visit) {}

    void look_at(std::size_t i) {
        index_[count_++] = i;
        if (count_ == kLookedAtOnce) finish();
    }

    /// After the last element.
    void finish() {
        if (count_ == 0) return;
        const auto size = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(type_)]);
        std::array<const NodeId*, kLookedAtOnce> elements;
        for (std::size_t k = 0; k < kLookedAtOnce; ++k)
            elements[k] = nodes_ + size * index_[k < count_ ? k : 0];
        const unsigned good = certainly_good(type_, points_, elements, frame_);
        for (std::size_t k = 0; k < count_; ++k) {
            if (((good >> k) & 1) == 0) visit_(index_[k]);
        }
        count_ = 0;
    }

  private:
    const NodeId* nodes_;
    const double* points_;
    ElementType type_;
    const GoodElementsFrame& frame_;
    const Visit& visit_;
    std::array<std::size_t, kLookedAtOnce> index_{};
    std::size_t count_ = 0;
};

}  // namespace mortise
