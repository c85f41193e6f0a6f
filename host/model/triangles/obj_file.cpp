// Wavefront OBJ: lines "v x y z ..." and "f i/.../... ...", indices from 1, negative ones back from the last
// point so far; a line that ends with '\' goes on. Lines that concern looks and names change nothing; one
// warning tells of all others, such as free-form surfaces.
#include <algorithm>
#include <array>

#include "host/common/message_text.hpp"
#include "host/model/triangles/triangle_files.hpp"
#include "host/model/triangles/triangle_text.hpp"

namespace mortise::model_reader {
namespace {

void skip_within_line(TextCursor& cursor) {
    while (true) {
        skip_spaces(cursor);
        if (cursor.peek() != '\\' || (cursor.peek_next() != '\n' && cursor.peek_next() != '\r')) return;
        cursor.advance();
        if (cursor.peek() == '\r') cursor.advance();
        if (cursor.peek() == '\n') cursor.advance();
    }
}

void skip_line(TextCursor& cursor) {
    while (true) {
        const std::string_view line = cursor.take_line();
        if (line.empty() || line.back() != '\\' || cursor.at_end()) return;
        if (cursor.peek() == '\r') cursor.advance();
        if (cursor.peek() == '\n') cursor.advance();
    }
}

constexpr std::array<std::string_view, 20> kOfLooks = {
    "vn",     "vt",  "vp",    "g",        "o",        "s",          "l",         "p",      "mtllib", "usemtl",
    "maplib", "lod", "bevel", "c_interp", "d_interp", "shadow_obj", "trace_obj", "usemap", "mg",     "call"};

void read_face(TextCursor& cursor, Polygons& polygons) {
    while (!at_line_end(cursor) && cursor.peek() != '#') {
        const SourceLocation where = cursor.where();
        std::int64_t index = take_integer(cursor, "the number of a point");
        if (index == 0) fail(cursor.source(), where, "point 0 does not exist; points are counted from 1");
        index += index > 0 ? -1 : static_cast<std::int64_t>(polygons.points.size());
        polygons.add_corner(index, where);
        while (cursor.peek() == '/') {
            cursor.advance();
            if (cursor.peek() == '-' || is_digit(cursor.peek())) take_integer(cursor, "a number");
        }
        skip_within_line(cursor);
    }
}

}  // namespace

TriangleSurface read_obj(const std::string& content, const std::string& source,
                         std::vector<std::string>& warnings) {
    TextCursor cursor(content, source);
    Polygons polygons;
    std::size_t faces = 0;
    std::size_t unknown = 0;
    SourceLocation first_unknown;
    std::string first_statement;
    for (cursor.skip_blanks(); !cursor.at_end(); cursor.skip_blanks()) {
        const SourceLocation where = cursor.where();
        const char kind = cursor.peek();
        const char after = cursor.peek_next();
        if ((kind == 'v' || kind == 'f') && (after == ' ' || after == '\t')) {
            cursor.advance();
            skip_within_line(cursor);
            if (kind == 'v') {
                Vec3 point{};
                for (double& coordinate : point) {
                    coordinate = take_coordinate(cursor);
                    skip_within_line(cursor);
                }
                polygons.points.push_back(point);
            } else {
                read_face(cursor, polygons);
                polygons.end_face(source, where);
                ++faces;
            }
        } else if (kind != '#') {
            TextCursor ahead = cursor;
            const std::string_view statement = ahead.take_word();
            // Neither text in ASCII nor in another encoding starts a line like that.
            if (statement.empty() && kind >= 0)
                cursor.fail_here("expected a Wavefront OBJ file, found " + cursor.found());
            const bool is_of_looks = std::find(kOfLooks.begin(), kOfLooks.end(), statement) != kOfLooks.end();
            if (!is_of_looks && unknown++ == 0) {
                first_unknown = where;
                first_statement = excerpt(statement);
            }
        }
        skip_line(cursor);
    }
    if (faces == 0) {
        throw Error(ExitCode::kInput,
                    source +
                        ": there are no faces (lines such as f 1 2 3); expected a Wavefront OBJ "
                        "file of a closed surface");
    }
    if (unknown != 0) {
        warnings.push_back(place_text(source, first_unknown) + counted(unknown, "line is", "lines are") +
                           " not known and not read, first '" + first_statement + "'");
    }
    return finished_surface(polygons.triangulate(source, 1), source, warnings);
}

}  // namespace mortise::model_reader
