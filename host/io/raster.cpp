// Half-space rasterisation: a sample is inside a triangle where its distances from the three sides, counted
// inwards, are not negative. The same distances draw the outline: a sample near an outlined side is darkened.
// Neighbours that share a side darken half of the line each, so lines need no depth offset.
#include "host/io/raster.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mortise::io {
namespace {

constexpr double kLineHalfWidth = 0.55;  // pixels
constexpr Colour kLineColour{0.10f, 0.12f, 0.16f};
constexpr double kLineOpacity = 0.75;
// Outlines of small facets fade, or fine meshes would turn black: none below, full above (pixels).
constexpr double kFadeFrom = 3, kFadeTo = 14;

std::uint8_t to_byte(float value) {
    return static_cast<std::uint8_t>(std::lround(255.0f * std::min(1.0f, std::max(0.0f, value))));
}

/// Distance of a point from the line through a and b: coefficients of x, y and 1.
struct Side {
    double dx = 0, dy = 0, constant = 0;
    double at(double x, double y) const { return dx * x + dy * y + constant; }
};

double twice_area(const ScreenPoint& a, const ScreenPoint& b, const ScreenPoint& c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

}  // namespace

Raster::Raster(int width, int height, int samples) : width_(width), height_(height), samples_(samples) {
    const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                              static_cast<std::size_t>(samples * samples);
    buffer_.assign(count, {std::numeric_limits<float>::infinity(), {255, 255, 255}});
}

void Raster::draw(const ScreenPoint* corners, int count, const Colour& colour) {
    double area = 0, longest = 0;
    for (int i = 0; i < count; ++i) {
        const ScreenPoint& a = corners[i];
        const ScreenPoint& b = corners[(i + 1) % count];
        area += 0.5 * (a.x * b.y - a.y * b.x);
        longest = std::max(longest, std::hypot(b.x - a.x, b.y - a.y));
    }
    // The height of a triangle, about the width of a quadrilateral.
    const double breadth = longest > 0 ? (count == 3 ? 2 : 1) * std::fabs(area) / longest : 0;
    const double strength = std::min(1.0, std::max(0.0, (breadth - kFadeFrom) / (kFadeTo - kFadeFrom)));
    draw_triangle({corners[0], corners[1], corners[2]}, {true, true, count == 3}, strength, colour);
    if (count == 4)
        draw_triangle({corners[0], corners[2], corners[3]}, {false, true, true}, strength, colour);
}

void Raster::draw_triangle(const std::array<ScreenPoint, 3>& corners, const std::array<bool, 3>& outline,
                           double strength, const Colour& colour) {
    const double area = twice_area(corners[0], corners[1], corners[2]);
    if (!(std::fabs(area) > 1e-12)) return;
    const double sign = area > 0 ? 1 : -1;
    std::array<Side, 3> sides;  // side i runs from corner i to the next
    std::array<double, 3> height;
    for (std::size_t i = 0; i < 3; ++i) {
        const ScreenPoint& a = corners[i];
        const ScreenPoint& b = corners[(i + 1) % 3];
        const double length = std::hypot(b.x - a.x, b.y - a.y);
        sides[i].dx = -sign * (b.y - a.y) / length;
        sides[i].dy = sign * (b.x - a.x) / length;
        sides[i].constant = -(sides[i].dx * a.x + sides[i].dy * a.y);
        height[i] = std::fabs(area) / length;
    }
    const auto range = [this](double low, double high, int pixels, int& first, int& last) {
        const double scale = samples_;
        first = static_cast<int>(std::max(0.0, std::ceil(low * scale - 0.5)));
        last = static_cast<int>(std::min(scale * pixels - 1, std::floor(high * scale - 0.5)));
    };
    const auto [left, right] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
    const auto [top, bottom] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
    int x_first, x_last, y_first, y_last;
    range(left, right, width_, x_first, x_last);
    range(top, bottom, height_, y_first, y_last);
    const std::size_t row = static_cast<std::size_t>(width_ * samples_);
    for (int j = y_first; j <= y_last; ++j) {
        for (int i = x_first; i <= x_last; ++i) {
            const double x = (i + 0.5) / samples_, y = (j + 0.5) / samples_;
            const double d[3] = {sides[0].at(x, y), sides[1].at(x, y), sides[2].at(x, y)};
            if (d[0] < 0 || d[1] < 0 || d[2] < 0) continue;
            // Barycentric coordinates are distances over heights; corner i lies across from side i + 1.
            const double depth = d[1] / height[1] * corners[0].depth + d[2] / height[2] * corners[1].depth +
                                 d[0] / height[0] * corners[2].depth;
            Sample& sample = buffer_[static_cast<std::size_t>(j) * row + static_cast<std::size_t>(i)];
            if (!(static_cast<float>(depth) < sample.depth)) continue;
            sample.depth = static_cast<float>(depth);
            double nearest = std::numeric_limits<double>::infinity();
            for (std::size_t k = 0; k < 3; ++k) {
                if (outline[k]) nearest = std::min(nearest, d[k]);
            }
            const float line = nearest < kLineHalfWidth ? static_cast<float>(kLineOpacity * strength) : 0.0f;
            sample.colour[0] = to_byte(colour.red + line * (kLineColour.red - colour.red));
            sample.colour[1] = to_byte(colour.green + line * (kLineColour.green - colour.green));
            sample.colour[2] = to_byte(colour.blue + line * (kLineColour.blue - colour.blue));
        }
    }
}

std::vector<std::uint8_t> Raster::pixels() const {
    const std::size_t width = static_cast<std::size_t>(width_), height = static_cast<std::size_t>(height_);
    const std::size_t samples = static_cast<std::size_t>(samples_);
    std::vector<std::uint8_t> picture(3 * width * height);
    for (std::size_t y = 0; y < height; ++y) {
        for (std::size_t x = 0; x < width; ++x) {
            std::size_t sum[3] = {0, 0, 0};
            for (std::size_t j = 0; j < samples; ++j) {
                for (std::size_t i = 0; i < samples; ++i) {
                    const Sample& sample = buffer_[(y * samples + j) * width * samples + x * samples + i];
                    for (int c = 0; c < 3; ++c) sum[c] += sample.colour[c];
                }
            }
            for (std::size_t c = 0; c < 3; ++c)
                picture[3 * (y * width + x) + c] = static_cast<std::uint8_t>(sum[c] / (samples * samples));
        }
    }
    return picture;
}

}  // namespace mortise::io
