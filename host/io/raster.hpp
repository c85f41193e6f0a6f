// A small software rasteriser: convex polygons with flat colour, depth test and dark outlines.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace mortise::io {

struct Colour {
    float red = 1, green = 1, blue = 1;
};

/// A corner on the picture: pixels right and down from the top left corner, depth growing away from the eye.
struct ScreenPoint {
    double x = 0, y = 0, depth = 0;
};

class Raster {
  public:
    /// White, `samples` × `samples` points per pixel.
    Raster(int width, int height, int samples);

    /// Draws a triangle or (count 4) a quadrilateral as two triangles, with its outline but no diagonal.
    void draw(const ScreenPoint* corners, int count, const Colour& colour);

    /// The picture, averaged over the samples: rows from the top, 8-bit red, green, blue.
    std::vector<std::uint8_t> pixels() const;

  private:
    /// `outline[i]` says whether the side from corner i to the next is drawn.
    void draw_triangle(const std::array<ScreenPoint, 3>& corners, const std::array<bool, 3>& outline,
                       double strength, const Colour& colour);

    struct Sample {
        float depth;
        std::uint8_t colour[3];
    };
    int width_, height_, samples_;
    std::vector<Sample> buffer_;
};

}  // namespace mortise::io
