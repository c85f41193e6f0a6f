// Names of the model's faces where equal surfaces of several solids are one.
#pragma once

#include <cstdint>
#include <vector>

#include "host/tape/compile.hpp"

namespace mortise::tape {

/// Both models must live as long.
class FaceNames {
  public:
    FaceNames(const CompiledModel& compiled, const BoundModel& model);

    /// Of a face that bounds a region, at a point of it in model units: the name of the first solid that has
    /// a face there, of the region's own solids if one of these has the surface. Index into
    /// CompiledModel::surface_names. `surface`: of the bound model.
    std::uint32_t name(std::uint32_t surface, std::int32_t region, const Vec3& point) const;

  private:
    bool is_face_of(std::uint32_t compiled, const Vec3& point) const;
    bool is_inside(std::uint32_t compiled, bool is_flipped, const Vec3& point) const;

    const CompiledModel& compiled_;
    const BoundModel& model_;
    std::vector<Box3> box_;  ///< per compiled surface: of its polyhedron; empty if there are none
};

}  // namespace mortise::tape
