// STL, ascii and binary. A binary file may start with the word "solid", too, and some programs append bytes:
// what decides is whether the size fits the count of triangles at byte 80, then whether the start is text.
// Normals are not used: the order of the corners tells the outside.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "host/common/lower_case.hpp"
#include "host/model/triangles/triangle_files.hpp"
#include "host/model/triangles/triangle_text.hpp"

namespace mortise::model_reader {
namespace {

constexpr std::size_t kHeader = 84;
constexpr std::size_t kRecord = 50;  // normal and three corners as floats, and two bytes

std::uint32_t little_endian(const char* bytes) {
    std::uint32_t value = 0;
    for (std::size_t k = 4; k-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[k]);
    return value;
}

bool is_text(const std::string& content) {
    constexpr std::size_t kLooked = 512;
    for (std::size_t i = 0; i < content.size() && i < kLooked; ++i) {
        const char c = content[i];
        if (c >= 0 && c < ' ' && !(c >= '\t' && c <= '\r')) return false;
    }
    return true;
}

bool equal_word(std::string_view found, std::string_view word) {
    return std::equal(found.begin(), found.end(), word.begin(), word.end(),
                      [](char a, char b) { return lower_case(a) == b; });
}

bool take_word(TextCursor& cursor, std::string_view word) {
    TextCursor ahead = cursor;
    if (!equal_word(ahead.take_name(), word)) return false;
    cursor = ahead;
    return true;
}

void expect_word(TextCursor& cursor, std::string_view word) {
    cursor.skip_blanks();
    if (!take_word(cursor, word)) {
        cursor.fail_here("expected '" + std::string(word) + "', found " + cursor.found());
    }
}

[[noreturn]] void fail_at_byte(const std::string& source, std::size_t byte, const std::string& message) {
    throw Error(ExitCode::kInput, source + ": byte " + std::to_string(byte) + ": " + message);
}

TriangleSurface read_binary(const std::string& content, const std::string& source) {
    if (content.size() < kHeader) {
        fail_at_byte(source, content.size(),
                     "the file ends inside its header of 84 bytes; expected an STL file, text or binary");
    }
    const std::size_t count = little_endian(content.data() + 80);
    const std::size_t held = (content.size() - kHeader) / kRecord;
    if (held < count) {
        fail_at_byte(source, content.size(),
                     "the file ends after " + std::to_string(held) + " of " + std::to_string(count) +
                         " triangles; expected a whole STL file, text (starting with 'solid') or binary");
    }
    TriangleSurface surface;
    surface.points.reserve(3 * count);
    surface.triangles.reserve(count);
    for (std::size_t t = 0; t < count; ++t) {
        for (std::size_t corner = 0; corner < 3; ++corner) {
            Vec3 point{};
            for (std::size_t k = 0; k < 3; ++k) {
                const std::size_t byte = kHeader + kRecord * t + 12 * (corner + 1) + 4 * k;
                const std::uint32_t bits = little_endian(content.data() + byte);
                float value = 0;
                std::memcpy(&value, &bits, sizeof value);
                if (!std::isfinite(value)) {
                    fail_at_byte(source, byte,
                                 "a coordinate of triangle " + std::to_string(t + 1) + " is " +
                                     number_text(static_cast<double>(value)) + "; expected a finite number");
                }
                point[k] = static_cast<double>(value);
            }
            surface.points.push_back(point);
        }
        const auto first = static_cast<std::uint32_t>(3 * t);
        surface.triangles.push_back({first, first + 1, first + 2});
    }
    return surface;
}

TriangleSurface read_ascii(const std::string& content, const std::string& source) {
    TextCursor cursor(content, source);
    TriangleSurface surface;
    cursor.skip_blanks();
    if (!take_word(cursor, "solid")) {
        cursor.fail_here("expected 'solid' or a binary STL file, found " + cursor.found());
    }
    cursor.take_line();  // a name
    bool open = true;
    while (true) {
        cursor.skip_blanks();
        if (cursor.at_end()) break;
        if (take_word(cursor, open ? "endsolid" : "solid")) {
            cursor.take_line();
            open = !open;
            continue;
        }
        if (!open) cursor.fail_here("expected 'solid' or the end of file, found " + cursor.found());
        if (!take_word(cursor, "facet")) {
            cursor.fail_here("expected 'facet' or 'endsolid', found " + cursor.found());
        }
        expect_word(cursor, "normal");
        cursor.take_line();  // not a number in files of some programs
        expect_word(cursor, "outer");
        expect_word(cursor, "loop");
        const auto first = static_cast<std::uint32_t>(surface.points.size());
        for (int corner = 0; corner < 3; ++corner) {
            expect_word(cursor, "vertex");
            Vec3 point{};
            for (double& coordinate : point) {
                skip_spaces(cursor);
                coordinate = take_coordinate(cursor);
            }
            surface.points.push_back(point);
        }
        surface.triangles.push_back({first, first + 1, first + 2});
        expect_word(cursor, "endloop");
        expect_word(cursor, "endfacet");
    }
    if (open) cursor.fail_here("expected 'facet' or 'endsolid', found end of file");
    return surface;
}

}  // namespace

TriangleSurface read_stl(const std::string& content, const std::string& source,
                         std::vector<std::string>& warnings) {
    const bool fits = content.size() >= kHeader &&
                      content.size() - kHeader == kRecord * std::size_t{little_endian(content.data() + 80)};
    constexpr std::size_t kMost = 0xffffffffU / 3;
    if (content.size() / kRecord > kMost) {
        throw Error(ExitCode::kInput, source + ": more than " + std::to_string(kMost) + " triangles");
    }
    const bool ascii = !fits && is_text(content);
    return finished_surface(ascii ? read_ascii(content, source) : read_binary(content, source), source,
                            warnings);
}

}  // namespace mortise::model_reader
