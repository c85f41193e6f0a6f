// Coordinates of a mesh as its file has them: times MeshFileOptions::scale.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/io/stored_array.hpp"

namespace mortise::io {

class Coordinates {
  public:
    /// `points` must outlive this.
    Coordinates(const std::vector<double>& points, double scale) : points_(points), scale_(scale) {}

    std::size_t size() const { return points_.size(); }
    double operator[](std::size_t i) const { return points_[i] * scale_; }
    /// Bytes of all of them; may outlive this, but not the points.
    ByteSource source() const;
    /// Appends them all.
    void write(TemporaryFile& file) const;

  private:
    const std::vector<double>& points_;
    double scale_;
};

/// Throws Error(kUsage) unless it lies from kLeastScale to kMostScale.
void check_scale(double scale, const std::string& path);

}  // namespace mortise::io
