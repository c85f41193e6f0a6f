// Rounded solids taken apart into what their surface consists of (kernels/shared/rounded.h).
#pragma once

#include <cstddef>
#include <vector>

#include "mortise/model.hpp"

namespace mortise {

/// What the surface of the hull of balls consists of. Directions are unit vectors.
struct RoundedParts {
    struct Facet {
        Vec3 normal;
        double support;
    };
    /// Directions along * axis + across * w, where w is a unit vector across the axis and w·middle >= cosine.
    struct Arc {
        std::size_t ball;
        std::size_t other;  ///< the ball at the other end; of discs in a plane none: `ball`
        Vec3 axis;
        double along;
        double across;
        Vec3 middle;
        double cosine;
    };
    /// Directions n with n·axes[k] <= along[k].
    struct Cap {
        std::size_t ball;
        std::vector<Vec3> axes;
        std::vector<double> along;
    };
    std::vector<Ball> balls;  ///< without those inside others
    std::vector<Facet> facets;
    std::vector<Arc> arcs;
    std::vector<Cap> caps;
    double reach = 0;  ///< no point is farther from the origin
};

/// The parts of a solid; of plates and revolutions those of their discs, in the plane of these.
RoundedParts rounded_parts(const RoundedSolid& solid);

}  // namespace mortise
