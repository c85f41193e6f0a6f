// The rasteriser: coverage, depth order, outlines.
#include <doctest/doctest.h>

#include "host/io/raster.hpp"

using namespace mortise::io;

namespace {

constexpr Colour kRed{1, 0, 0}, kBlue{0, 0, 1};

struct Pixel {
    int red, green, blue;
};

Pixel pixel(const Raster& raster, int width, int x, int y) {
    const std::vector<std::uint8_t> pixels = raster.pixels();
    const std::size_t at = 3 * static_cast<std::size_t>(y * width + x);
    return {pixels[at], pixels[at + 1], pixels[at + 2]};
}

}  // namespace

TEST_CASE("a quadrilateral covers exactly its pixels, in either orientation") {
    for (const bool reversed : {false, true}) {
        // 2 to 18 across and 3 to 17 down; narrow enough to leave outlines nearly out.
        ScreenPoint corners[4] = {{2, 3, 0.5}, {18, 3, 0.5}, {18, 17, 0.5}, {2, 17, 0.5}};
        if (reversed) std::swap(corners[1], corners[3]);
        Raster raster(20, 20, 2);
        raster.draw(corners, 4, kRed);
        for (int y = 0; y < 20; ++y) {
            for (int x = 0; x < 20; ++x) {
                const bool inside = x >= 2 && x < 18 && y >= 3 && y < 17;
                CHECK((pixel(raster, 20, x, y).green < 100) == inside);
            }
        }
        // No diagonal line: plain red in the middle; dark at the rim.
        CHECK(pixel(raster, 20, 10, 10).red == 255);
        CHECK(pixel(raster, 20, 2, 10).red < 200);
    }
}

TEST_CASE("the nearer facet wins, whatever the order; depth varies along a facet") {
    const ScreenPoint tilted[3] = {{0, 0, 0.0}, {20, 0, 1.0}, {0, 20, 0.0}};
    const ScreenPoint level[3] = {{0, 0, 0.5}, {20, 0, 0.5}, {0, 20, 0.5}};
    for (const bool tilted_first : {true, false}) {
        Raster raster(20, 20, 1);
        if (tilted_first) raster.draw(tilted, 3, kRed);
        raster.draw(level, 3, kBlue);
        if (!tilted_first) raster.draw(tilted, 3, kRed);
        CHECK(pixel(raster, 20, 4, 4).red > 200);
        CHECK(pixel(raster, 20, 13, 3).blue > 200);
    }
}

TEST_CASE("facets beyond the picture and without area do no harm") {
    Raster raster(8, 8, 2);
    const ScreenPoint outside[3] = {{-50, -50, 0}, {-40, -50, 0}, {-40, -20, 0}};
    const ScreenPoint line[3] = {{1, 1, 0}, {4, 4, 0}, {6, 6, 0}};
    const ScreenPoint around[4] = {{-1e6, -1e6, 0.5}, {1e6, -1e6, 0.5}, {1e6, 1e6, 0.5}, {-1e6, 1e6, 0.5}};
    raster.draw(outside, 3, kRed);
    raster.draw(line, 3, kRed);
    CHECK(pixel(raster, 8, 3, 3).green == 255);
    raster.draw(around, 4, kRed);
    CHECK(pixel(raster, 8, 7, 7).green == 0);
}
