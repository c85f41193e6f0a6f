// Geomview's OFF: [ST][C][N]OFF, the numbers of points, faces and edges, the points, and the faces
// "n i1 ... in [colour]", indices from 0. '#' starts a comment.
#include "host/model/triangles/triangle_files.hpp"
#include "host/model/triangles/triangle_text.hpp"

namespace mortise::model_reader {
namespace {

void skip_off_blanks(TextCursor& cursor) {
    while (true) {
        cursor.skip_blanks();
        if (cursor.peek() != '#') return;
        cursor.take_line();
    }
}

/// Reads the first word; returns whether more numbers stand behind the coordinates of a point.
bool read_header(TextCursor& cursor) {
    const TextCursor start = cursor;
    std::string_view name = cursor.take_name();
    bool more = false;
    for (const std::string_view prefix : {"ST", "C", "N"}) {
        if (name.substr(0, prefix.size()) != prefix) continue;
        name.remove_prefix(prefix.size());
        more = true;
    }
    if (name != "OFF") start.fail_here("expected OFF, COFF or NOFF, found " + start.found());
    skip_off_blanks(cursor);
    if (cursor.peek() == 'B') cursor.fail_here("binary OFF files are not read; save it as text");
    return more;
}

}  // namespace

TriangleSurface read_off(const std::string& content, const std::string& source,
                         std::vector<std::string>& warnings) {
    TextCursor cursor(content, source);
    skip_off_blanks(cursor);
    const bool more_per_point = read_header(cursor);
    std::array<std::int64_t, 3> counts{};
    constexpr std::array<const char*, 3> kWhat = {"the number of points", "the number of faces",
                                                  "the number of edges"};
    for (std::size_t k = 0; k < 3; ++k) {
        const TextCursor start = cursor;
        counts[k] = take_integer(cursor, kWhat[k]);
        if (counts[k] < 0) start.fail_here("expected " + std::string(kWhat[k]) + ", found " + start.found());
        skip_off_blanks(cursor);
    }
    const auto expect_more = [&](std::int64_t done, std::size_t k) {
        if (!cursor.at_end()) return;
        cursor.fail_here("the file ends after " + std::to_string(done) + " of " + std::to_string(counts[k]) +
                         (k == 0 ? " points" : " faces"));
    };
    Polygons polygons;
    for (std::int64_t i = 0; i < counts[0]; ++i) {
        Vec3 point{};
        for (std::size_t k = 0; k < 3; ++k) {
            skip_off_blanks(cursor);
            expect_more(i, 0);
            point[k] = take_coordinate(cursor);
        }
        // Colours and normals end with the line.
        if (more_per_point) cursor.take_line();
        polygons.points.push_back(point);
    }
    for (std::int64_t i = 0; i < counts[1]; ++i) {
        skip_off_blanks(cursor);
        expect_more(i, 1);
        const SourceLocation where = cursor.where();
        const std::int64_t corners = take_integer(cursor, "a face's number of corners");
        for (std::int64_t k = 0; k < corners; ++k) {
            skip_off_blanks(cursor);
            expect_more(i, 1);
            const SourceLocation place = cursor.where();
            polygons.add_corner(take_integer(cursor, "the number of a point"), place);
        }
        polygons.end_face(source, where);
        cursor.take_line();  // a colour
    }
    skip_off_blanks(cursor);
    if (!cursor.at_end()) {
        warnings.push_back(place_text(source, cursor.where()) + "what follows the last face is not read");
    }
    return finished_surface(polygons.triangulate(source, 0), source, warnings);
}

}  // namespace mortise::model_reader
