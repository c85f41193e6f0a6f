// Points where two surfaces touch and yet cross: two pipes of one radius that meet, a torus and a plane that
// is tangent to its inner rim. The two creases that run through such a pole cross there.
#pragma once

#include <cstdint>
#include <vector>

#include "host/tape/compile.hpp"

namespace mortise::tape {

struct Pole {
    std::vector<std::uint32_t> surfaces;  ///< ascending: the two, and others that bound the solid there
    Vec3 at{};                            ///< box-local, to about 1e-12
    Vec3 normal{};                        ///< unit, of the two
    // Of a pole of the solid; find_pole leaves them empty.
    std::vector<std::uint32_t> through;  ///< all surfaces that its leaf knows to pass there
    std::vector<std::int32_t> region;    ///< by the signs of `through`: bit i of the place is set if positive
    bool is_skin = false;  ///< one region lies below all the surfaces that touch there, another above
};

/// Looks for a pole of two surfaces within `reach` of a point along both tangents; box-local. Both surfaces
/// are heights over a common tangent plane there, and a pole is a saddle of their difference, of height zero.
/// Where surfaces touch along a line (a rounding) the difference is no saddle, and where one lies inside the
/// other it is a minimum: false. Patches and pairs of planes: false.
bool find_pole(const BoundModel& model, std::uint32_t first, std::uint32_t second, const Vec3& near,
               double reach, Pole* pole);

}  // namespace mortise::tape
