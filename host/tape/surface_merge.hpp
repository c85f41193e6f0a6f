// Which surfaces of a compiled model are one: equal ones, and those so close that no cell tells them apart.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "host/tape/compile.hpp"

namespace mortise::tape {

/// Compiled surfaces as those that are left. Lengths are in edges of the root cube.
class SurfaceMerge {
  public:
    SurfaceMerge(const CompiledModel& compiled, const Vec3& origin, double side);

    /// Takes equal surfaces for one, and those within `distance`; returns how many of the latter.
    std::uint64_t merge_equal(const std::vector<ExpressionOp>& ops, double distance);

    /// Takes surfaces within `distance` for one if they only bound one region, the same, from the same side:
    /// then nothing can lie between them. Returns how many. After merge_equal.
    std::uint64_t merge_alike(const CompiledModel& compiled, double distance);

    /// A surface in box-local coordinates.
    const Surface& local(std::size_t i) const { return local_[i]; }

    std::vector<std::uint32_t> target;   ///< per surface: the one that stands for it
    std::vector<std::uint32_t> flipped;  ///< per surface: 1 if with the other sign

  private:
    template <class Visit>
    void for_near(std::size_t i, double distance, const Visit& visit) const;
    /// Whether what tells the surface from others is where its data begin.
    bool has_start(std::size_t i) const;
    std::vector<std::int64_t> find_uses(const CompiledModel& compiled) const;

    std::vector<Surface> local_;
    std::vector<std::array<double, 16>> signatures_;
    /// Surfaces that stand for others, by the size of one coefficient, whose sign may be flipped: equal ones
    /// are neighbours.
    std::multimap<double, std::size_t> by_offset_;
    std::multimap<double, std::size_t> by_start_;  ///< the same of those that has_start()
};

}  // namespace mortise::tape
