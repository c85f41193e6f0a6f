// The part of the model that a node belongs to, and projection onto it.
//
// A node's stratum is the set of surfaces that its boundary and interface facets lie on: none (inside a
// region), one (a model face), two (a crease), three or more (a corner). A node leaves its stratum in the
// last resort only (loosen.cpp).
#pragma once

#include <cstdint>
#include <vector>

#include "host/improve/quality.hpp"
#include "host/tape/compile.hpp"
#include "host/tape/pole.hpp"

namespace mortise::improve {

/// A corner of the model that has less than three surfaces: a singular point of one, a pole of two.
struct Tip {
    std::vector<std::uint32_t> surfaces;  ///< ascending
    Point point;                          ///< in finest cells
    const tape::Pole* pole = nullptr;     ///< null: no pole
};

/// The apexes of cones at which the solid really ends, in order of their surfaces, then the poles, which must
/// live as long as the tips.
std::vector<Tip> find_tips(const tape::BoundModel& model, const std::vector<tape::Pole>& poles, int level);

/// Surfaces in units of finest cells, from the root box's minimum corner.
class Surfaces {
  public:
    Surfaces(const tape::BoundModel& model, int level);

    struct Sample {
        double value;
        Point gradient;  ///< not zero; otherwise `valid` is false
        bool valid;
    };
    Sample sample(std::uint32_t surface, const Point& x) const;

    bool is_plane(std::uint32_t surface) const;

    /// The surface at which the solid ends beside a point near a pole, by the signs of all that pass through
    /// the pole, along its normal; kNoTurn if it ends there at several, or not at all.
    std::uint32_t turn_at(const tape::Pole& pole, const Point& x) const;
    static constexpr std::uint32_t kNoTurn = 0xffffffffu;

    /// Moves x onto all of the given surfaces by Newton's method, minimum norm; false if that does not
    /// converge within a quarter of `size`, the edge of the cell there, or if the surfaces are tangent. One,
    /// two or three surfaces.
    bool project(const std::uint32_t* surfaces, std::size_t count, double size, Point* x) const;

  private:
    const tape::BoundModel& model_;
    double cell_;      ///< a finest cell's edge in box-local coordinates: a power of two
    double rounding_;  ///< of a position, in finest cells
};

}  // namespace mortise::improve
