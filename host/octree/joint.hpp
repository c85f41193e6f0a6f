// Where one surface goes on smoothly from another (tangent.hpp).
#pragma once

#include <cstdint>
#include <vector>

namespace mortise::octree {

/// Surfaces of the model: on one side of `chooser` the solid ends at one of them, beyond it at the other.
struct Joint {
    std::uint32_t chooser;
    std::uint32_t inside;   ///< the surface where `chooser` is negative
    std::uint32_t outside;  ///< the surface elsewhere
    bool negated;           ///< the two have opposite insides

    friend bool operator==(const Joint& a, const Joint& b) {
        return a.chooser == b.chooser && a.inside == b.inside && a.outside == b.outside &&
               a.negated == b.negated;
    }
};

/// Stands for both surfaces of a joint in a leaf's tape, with the inside of the first.
inline constexpr std::uint32_t kJointSurface = 0x0ffffffe;

/// A leaf that a joint passes through, and the leaf's tape over kJointSurface in the place of the three
/// surfaces.
struct LeafJoint {
    std::uint64_t morton = 0;
    Joint joint{};
    std::vector<std::uint32_t> tape;
};

}  // namespace mortise::octree
