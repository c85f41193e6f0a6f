// Solids built in code, part by part.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mortise/model.hpp"

namespace mortise {

/// A solid: a value that is cheap to copy and never changes. Operations make new ones, which share their
/// parts; whatever is used several times is stored once.
///
///     const Solid plate = box({0, 0, 0}, {60, 40, 5});
///     const Solid hole = cylinder(3, 5).named("hole");
///     const Solid part = plate - hole.translated({10, 10, 0}) - hole.translated({50, 10, 0});
///     generate_mesh(make_model(part));
///
/// Sets are regularised: what has no volume is gone. Numbers that make no solid throw Error(kInput).
class Solid {
  public:
    /// The empty set.
    Solid();
    /// A primitive (model.hpp: box, sphere, torus, half_space, …).
    Solid(Primitive primitive);  // NOLINT: box(…) - sphere(…) is meant to work

    /// The name of all surfaces of its primitives that have none yet; planes of boxes and caps of cylinders
    /// have a suffix: "plate_xmin".
    Solid named(std::string name) const;
    /// Cells of at most `size` on its surfaces and inside, or on its surfaces alone; model units. These are
    /// the model's sizes: not with MeshOptions::model_sizes off.
    Solid sized(double size) const;
    Solid surface_sized(double size) const;

    Solid translated(const Vec3& by) const;
    /// Degrees, counter-clockwise seen from the tip of the axis, which goes through the origin.
    Solid rotated(double degrees, const Vec3& axis = {0, 0, 1}) const;
    Solid scaled(const Vec3& factors) const;
    /// In the plane through the origin with this normal.
    Solid mirrored(const Vec3& normal) const;
    Solid transformed(const Affine& map) const;

    friend Solid unite(const std::vector<Solid>& parts);
    friend Solid intersect(const std::vector<Solid>& parts);
    friend Solid operator-(const Solid& a, const Solid& b);
    friend Solid operator~(const Solid& a);
    friend class SolidWriter;  ///< make_model
    friend class SolidReader;  ///< solids_of

  private:
    struct Node;
    explicit Solid(std::shared_ptr<Node> node);
    static Solid combine(CsgNode::Op op, const std::vector<Solid>& parts);
    std::shared_ptr<Node> node_;
};

/// Union and intersection of any number of solids: of none the empty set, and all of space. For thousands of
/// parts faster than one after the other.
Solid unite(const std::vector<Solid>& parts);
Solid intersect(const std::vector<Solid>& parts);
Solid operator|(const Solid& a, const Solid& b);
Solid operator&(const Solid& a, const Solid& b);
Solid operator-(const Solid& a, const Solid& b);
/// The complement.
Solid operator~(const Solid& a);

/// Around the z axis, 0 <= z <= height.
Solid cylinder(double radius, double height);
/// The same with radii at both ends; one of them may be 0.
Solid frustum(double bottom, double top, double height);
/// The hull of a ball around each of two points: a rod with round ends, which may be tapered.
Solid rod(const Vec3& a, const Vec3& b, double radius);
Solid rod(const Vec3& a, const Vec3& b, double radius_at_a, double radius_at_b);
/// Rods along edges, pairs of indices into `points`: a lattice of struts, round at its nodes. Of one radius,
/// or of one for each edge.
Solid lattice(const std::vector<Vec3>& points, const std::vector<std::array<std::uint32_t, 2>>& edges,
              double radius);
Solid lattice(const std::vector<Vec3>& points, const std::vector<std::array<std::uint32_t, 2>>& edges,
              const std::vector<double>& radii);
/// Where a formula in x, y, z (docs/formulas.md) is not positive; within bounds if there are any, whose faces
/// then belong to it. Throws Error(kInput), with the column, for a formula that is not understood.
Solid implicit(const std::string& formula, const std::optional<Box3>& bounds = {});

/// The model of one region.
Model make_model(const Solid& solid, const std::string& region = "solid");
/// Several regions; where they overlap a point belongs to the first.
Model make_model(const std::vector<std::pair<std::string, Solid>>& regions);

/// The regions of a model as solids, to build on what was read from a file; the model's own box cuts them.
/// Hints for sizes, periodic pairs and warnings are not theirs.
std::vector<std::pair<std::string, Solid>> solids_of(const Model& model);

}  // namespace mortise
