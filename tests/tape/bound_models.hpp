// Models bound to a root cube as the mesher does it, and a tape interpreter of our own, for tests of stages.
#pragma once

#include <cstdint>
#include <vector>

#include "host/tape/compile.hpp"
#include "mortise/model.hpp"

namespace mortise::test {

/// Compiled and bound to a cube about its bounds with one cell of margin at `level`.
tape::BoundModel bind_model(const Model& model, int level);

/// Value of a tape where inside[s] tells whether the point is in surface s's half. Depth in `deepest`.
std::int32_t run_tape(const std::uint32_t* words, std::size_t length, const std::vector<bool>& inside,
                      std::size_t* deepest = nullptr);

/// Halves that hold a box-local point: value <= 0.
std::vector<bool> halves_at(const tape::BoundModel& model, const Vec3& local);

/// Box-local to model coordinates.
Vec3 to_model(const tape::BoundModel& model, const Vec3& local);

/// One box, and one with a cylinder or ball taken out or added, at odd angles: what meshes without trouble.
Model rotated_box();
Model ball();
Model crossing_cylinders();

/// A convex polyhedron of `planes` random planes about the origin.
Model random_polytope(std::uint64_t seed, int planes);

/// Unions, differences and intersections of random boxes and wedges, two regions in some.
Model random_polyhedron(std::uint64_t seed);

/// One formula as the whole model, cut by the cube of half edge `half`.
Model formula_model(const std::string& formula, double half);

}  // namespace mortise::test
