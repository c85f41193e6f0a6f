// What the readers of STL, OBJ and OFF share.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/model/text.hpp"
#include "mortise/model.hpp"

namespace mortise::model_reader {

/// Repairs the surface, adds what was found to the warnings; throws if it encloses nothing.
TriangleSurface finished_surface(TriangleSurface surface, const std::string& source,
                                 std::vector<std::string>& warnings);

/// A signed, finite number.
double take_coordinate(TextCursor& cursor);
/// A signed whole number; `what` is expected.
std::int64_t take_integer(TextCursor& cursor, const char* what);

void skip_spaces(TextCursor& cursor);
bool at_line_end(const TextCursor& cursor);

/// Points and faces by their numbers, which may be used before the point is known.
class Polygons {
  public:
    std::vector<Vec3> points;

    /// A corner of the current face; `index` counts from 0.
    void add_corner(std::int64_t index, SourceLocation where) { corners_.push_back({index, where}); }
    void end_face(const std::string& source, SourceLocation where);
    /// Takes the points. `base` is the first number in the file, for messages.
    TriangleSurface triangulate(const std::string& source, std::int64_t base);

  private:
    struct Corner {
        std::int64_t index;
        SourceLocation where;
    };
    std::vector<Corner> corners_;
    std::vector<std::size_t> ends_;
};

}  // namespace mortise::model_reader
