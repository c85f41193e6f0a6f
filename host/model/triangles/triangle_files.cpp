// What the formats of triangle_files.hpp have in common, and the choice of the reader.
#include "host/model/triangles/triangle_files.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/common/coordinate_limits.hpp"
#include "host/model/affine.hpp"
#include "host/model/outlines/polygon_triangles.hpp"
#include "host/model/triangles/surface_repair.hpp"
#include "host/model/triangles/triangle_text.hpp"

namespace mortise::model_reader {

TriangleSurface finished_surface(TriangleSurface surface, const std::string& source,
                                 std::vector<std::string>& warnings) {
    for (const Vec3& point : surface.points) {
        for (const double coordinate : point) {
            if (std::fabs(coordinate) <= kLargestCoordinate) continue;
            throw Error(ExitCode::kInput, source + ": a coordinate is " + number_text(coordinate) +
                                              "; expected at most " + kLargestCoordinateText +
                                              ", choose other units");
        }
    }
    const SurfaceFindings findings = repair_surface(surface);
    if (surface.triangles.size() < 4) {
        throw Error(ExitCode::kInput, source + ": it has " + std::to_string(surface.triangles.size()) +
                                          " triangles with an area; a closed surface needs at least four");
    }
    // A flat sheet has a volume of rounding errors.
    double area = 0;
    double longest = 0;
    for (const auto& t : surface.triangles) {
        Vec3 u{};
        Vec3 v{};
        for (std::size_t k = 0; k < 3; ++k) {
            u[k] = surface.points[t[1]][k] - surface.points[t[0]][k];
            v[k] = surface.points[t[2]][k] - surface.points[t[0]][k];
        }
        area += length(cross(u, v));
        longest = std::max({longest, length(u), length(v)});
    }
    if (!(six_volumes(surface) > 1e-12 * area * longest)) {
        throw Error(ExitCode::kInput,
                    source + ": its triangles enclose no volume; expected the closed surface of a solid");
    }
    for (std::string& warning : surface_warnings(findings, source)) warnings.push_back(std::move(warning));
    return surface;
}

double take_coordinate(TextCursor& cursor) {
    const bool negative = cursor.peek() == '-';
    if (negative || cursor.peek() == '+') cursor.advance();
    if (!is_digit(cursor.peek()) && cursor.peek() != '.') {
        cursor.fail_here("expected a coordinate (a finite number), found " + cursor.found());
    }
    const double value = cursor.take_number();
    return negative ? -value : value;
}

std::int64_t take_integer(TextCursor& cursor, const char* what) {
    const TextCursor start = cursor;
    const auto refuse = [&] {
        start.fail_here("expected " + std::string(what) + ", found " + start.found());
    };
    const bool negative = cursor.peek() == '-';
    if (negative) cursor.advance();
    if (!is_digit(cursor.peek())) refuse();
    constexpr std::int64_t kMost = std::int64_t{1} << 40;
    std::int64_t value = 0;
    while (is_digit(cursor.peek())) {
        value = 10 * value + (cursor.peek() - '0');
        if (value > kMost) start.fail_here("the number " + start.found() + " is too large");
        cursor.advance();
    }
    if (is_name_part(cursor.peek()) || cursor.peek() == '.') refuse();
    return negative ? -value : value;
}

void skip_spaces(TextCursor& cursor) {
    while (cursor.peek() == ' ' || cursor.peek() == '\t') cursor.advance();
}

bool at_line_end(const TextCursor& cursor) {
    return cursor.at_end() || cursor.peek() == '\n' || cursor.peek() == '\r';
}

void Polygons::end_face(const std::string& source, SourceLocation where) {
    const std::size_t count = corners_.size() - (ends_.empty() ? 0 : ends_.back());
    if (count < 3) {
        fail(source, where, "this face has " + std::to_string(count) + " corners; expected at least three");
    }
    ends_.push_back(corners_.size());
}

TriangleSurface Polygons::triangulate(const std::string& source, std::int64_t base) {
    TriangleSurface surface;
    surface.triangles.reserve(ends_.size());
    std::vector<std::uint32_t> face;
    std::size_t at = 0;
    for (const std::size_t end : ends_) {
        face.clear();
        for (; at < end; ++at) {
            const Corner& corner = corners_[at];
            if (corner.index < 0 || corner.index >= static_cast<std::int64_t>(points.size())) {
                fail(source, corner.where,
                     "point " + std::to_string(corner.index + base) + " does not exist; there are " +
                         std::to_string(points.size()) + " points, counted from " + std::to_string(base));
            }
            face.push_back(static_cast<std::uint32_t>(corner.index));
        }
        triangulate_polygon(points, face, surface.triangles);
    }
    surface.points = std::move(points);
    return surface;
}

bool is_triangle_format(const std::string& format) {
    return format == "stl" || format == "obj" || format == "off";
}

TriangleSurface read_triangles(const std::string& content, const std::string& format,
                               const std::string& source, std::vector<std::string>& warnings) {
    if (format == "stl") return read_stl(content, source, warnings);
    if (format == "obj") return read_obj(content, source, warnings);
    return read_off(content, source, warnings);
}

Model read_triangle_model(const std::string& content, const std::string& format, const std::string& source,
                          const std::string& region) {
    Model model;
    model.source = source;
    TriangleSurface surface = read_triangles(content, format, source, model.warnings);
    Region result;
    result.name = region;
    result.root = model.add_primitive(polyhedron(std::move(surface), kSharpAngle), region);
    model.regions.push_back(std::move(result));
    return model;
}

}  // namespace mortise::model_reader
