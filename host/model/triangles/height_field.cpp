// surface() of .csg: see height_field.hpp.
#include "host/model/triangles/height_field.hpp"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "host/model/outlines/polygon_triangles.hpp"
#include "host/model/triangles/triangle_text.hpp"

namespace mortise::model_reader {
namespace {

constexpr std::size_t kMostHeights = 100000000;

bool is_png(const std::string& content) { return content.compare(0, 4, "\x89PNG") == 0; }

}  // namespace

HeightField read_heights_text(const std::string& content, const std::string& source) {
    TextCursor cursor(content, source);
    HeightField field;
    for (cursor.skip_blanks(); !cursor.at_end(); cursor.skip_blanks()) {
        if (cursor.peek() == '#') {
            cursor.take_line();
            continue;
        }
        const SourceLocation where = cursor.where();
        const std::size_t before = field.heights.size();
        while (!at_line_end(cursor)) {
            field.heights.push_back(take_coordinate(cursor));
            skip_spaces(cursor);
        }
        const std::size_t count = field.heights.size() - before;
        if (field.columns == 0) field.columns = count;
        if (count != field.columns) {
            fail(source, where,
                 "this row has " + std::to_string(count) + " heights; expected " +
                     std::to_string(field.columns) + " as in the first row");
        }
    }
    return field;
}

HeightField read_heights_png(const std::string& content, const std::string& source, bool invert) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    const auto refuse = [&] {
        const std::string cause = image.message;
        png_image_free(&image);
        throw Error(ExitCode::kInput, source + ": the PNG picture cannot be read: " + cause);
    };
    if (png_image_begin_read_from_memory(&image, content.data(), content.size()) == 0) refuse();
    image.format = PNG_FORMAT_RGBA;
    if (std::size_t{image.width} * image.height > kMostHeights) {
        png_image_free(&image);
        throw Error(ExitCode::kInput, source + ": the picture has more than " + std::to_string(kMostHeights) +
                                          " pixels; reduce it");
    }
    std::vector<png_byte> pixels(PNG_IMAGE_SIZE(image));
    if (png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr) == 0) refuse();
    HeightField field;
    field.columns = image.width;
    field.heights.resize(std::size_t{image.width} * image.height);
    for (std::size_t y = 0; y < image.height; ++y) {
        for (std::size_t x = 0; x < image.width; ++x) {
            const png_byte* rgb = &pixels[4 * (y * image.width + x)];
            // Luminance by ITU-R BT.709, as OpenSCAD weighs the colours.
            const double brightness = (0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]) / 255;
            field.heights[(image.height - 1 - y) * image.width + x] =
                100 * (invert ? 1 - brightness : brightness);
        }
    }
    return field;
}

TriangleSurface height_surface(const HeightField& field, bool center, const std::string& source) {
    const std::size_t columns = field.columns;
    const std::size_t rows = field.rows();
    if (columns < 2 || rows < 2) {
        throw Error(ExitCode::kInput, source + ": " + std::to_string(rows) + " rows of " +
                                          std::to_string(columns) +
                                          " heights; expected at least two rows and two columns");
    }
    if (field.heights.size() > kMostHeights) {
        throw Error(ExitCode::kInput, source + ": more than " + std::to_string(kMostHeights) + " heights");
    }
    TriangleSurface surface;
    const double dx = center ? static_cast<double>(columns - 1) / 2 : 0;
    const double dy = center ? static_cast<double>(rows - 1) / 2 : 0;
    const auto add_point = [&](double x, double y, double z) {
        surface.points.push_back({x - dx, y - dy, z});
        return static_cast<std::uint32_t>(surface.points.size() - 1);
    };
    const auto at = [&](std::size_t row, std::size_t column) {
        return static_cast<std::uint32_t>(row * columns + column);
    };
    double base = 0;
    for (std::size_t row = 0; row < rows; ++row) {
        for (std::size_t column = 0; column < columns; ++column) {
            const double z = field.heights[row * columns + column];
            base = std::min(base, z - 1);
            add_point(static_cast<double>(column), static_cast<double>(row), z);
        }
    }
    for (std::size_t row = 0; row + 1 < rows; ++row) {
        for (std::size_t column = 0; column + 1 < columns; ++column) {
            const std::array<std::uint32_t, 4> corners = {at(row, column), at(row, column + 1),
                                                          at(row + 1, column + 1), at(row + 1, column)};
            double z = 0;
            for (const std::uint32_t corner : corners) z += surface.points[corner][2] / 4;
            const std::uint32_t middle =
                add_point(static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5, z);
            for (std::size_t k = 0; k < 4; ++k) {
                surface.triangles.push_back({corners[k], corners[(k + 1) % 4], middle});
            }
        }
    }
    // The base is a rectangle, each wall one polygon between two of its corners and the heights above.
    const double right = static_cast<double>(columns - 1);
    const double back = static_cast<double>(rows - 1);
    const std::array<std::uint32_t, 4> low = {add_point(0, 0, base), add_point(right, 0, base),
                                              add_point(right, back, base), add_point(0, back, base)};
    surface.triangles.push_back({low[0], low[2], low[1]});
    surface.triangles.push_back({low[0], low[3], low[2]});
    std::array<std::vector<std::uint32_t>, 4> walls;
    for (std::size_t side = 0; side < 4; ++side) walls[side] = {low[side], low[(side + 1) % 4]};
    for (std::size_t column = columns; column-- > 0;) {
        walls[0].push_back(at(0, column));
        walls[2].push_back(at(rows - 1, columns - 1 - column));
    }
    for (std::size_t row = rows; row-- > 0;) {
        walls[1].push_back(at(row, columns - 1));
        walls[3].push_back(at(rows - 1 - row, 0));
    }
    for (const auto& wall : walls) triangulate_polygon(surface.points, wall, surface.triangles);
    return surface;
}

TriangleSurface read_height_surface(const std::string& content, const std::string& source, bool center,
                                    bool invert) {
    return height_surface(
        is_png(content) ? read_heights_png(content, source, invert) : read_heights_text(content, source),
        center, source);
}

}  // namespace mortise::model_reader
