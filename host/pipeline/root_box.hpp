// The root cube: where the octree lies in model space.
#pragma once

#include "host/pipeline/periodic.hpp"
#include "host/tape/compile.hpp"
#include "mortise/mesher.hpp"

namespace mortise::pipeline {

struct Root {
    Vec3 origin{};
    double side = 1;
    int level = 6;

    double cell() const;
};

/// A cube about the bounds with at least one cell of margin on each side, of the level and cell size that the
/// options ask for (Saxena & Perucchio 1992, §6.1: size and offset of the enclosing box). By `level`, the
/// faces of the longest extent fall on grid planes. Along the other axes the cube is shifted so that as many
/// as possible of the model's planes across them lie on grid planes, or so far from these that vertices do
/// not move onto them, and no two between the same planes of the grid: creases have poor elements elsewhere,
/// and improvement is most of the time that a mesh of many creases takes. A plane with primitives on both
/// sides counts most on the grid.
///
/// With MeshOptions::box_fit cells may be up to a quarter larger than those of `level`, and planes count on
/// grid planes only, where cells stay whole.
///
/// Planes of `periodic` pairs lie on grid planes, whatever the options say of the box: cells get larger for
/// that, by less than a factor of two, or smaller with MeshOptions::size. If no such grid is found, a warning
/// tells.
Root choose_root(const tape::CompiledModel& compiled, const Box3& bounds, const MeshOptions& options,
                 const std::vector<PeriodicAxis>& periodic, std::vector<std::string>& warnings);

}  // namespace mortise::pipeline
