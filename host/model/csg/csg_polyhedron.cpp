// polyhedron() of .csg: see csg_polyhedron.hpp.
#include "host/model/csg/csg_polyhedron.hpp"

#include <cmath>
#include <utility>

#include "host/model/triangles/triangle_text.hpp"

namespace mortise::model_reader {

TriangleSurface polyhedron_surface(std::vector<Vec3> points, const NumberLists& faces,
                                   const std::string& source, SourceLocation where,
                                   std::vector<std::string>& warnings) {
    constexpr const char* kName = "'polyhedron': ";
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (const double coordinate : points[i]) {
            if (std::isfinite(coordinate)) continue;
            fail(source, where,
                 kName + ("point " + std::to_string(i)) + " has the coordinate " + number_text(coordinate) +
                     "; expected finite numbers");
        }
    }
    if (faces.count < 4) {
        fail(source, where,
             kName + std::to_string(faces.count) + " faces; a closed surface needs at least four");
    }
    Polygons polygons;
    const std::size_t count = points.size();
    polygons.points = std::move(points);
    const auto refuse = [&](std::size_t face, const std::string& message) {
        fail(source, where, kName + ("face " + std::to_string(face)) + " " + message);
    };
    std::size_t first = 0;
    for (std::size_t f = 0; f < faces.count; ++f) {
        const std::size_t end = faces.ends[f];
        if (end - first < 3) {
            refuse(f, "has " + std::to_string(end - first) + " corners; expected at least three");
        }
        for (std::size_t k = end; k-- > first;) {
            const double index = faces.numbers[k];
            if (!(index >= 0 && index < static_cast<double>(count)) || index != std::floor(index)) {
                refuse(f, "uses point " + number_text(index) + ", which does not exist; there are " +
                              std::to_string(count) + ", counted from 0");
            }
            polygons.add_corner(static_cast<std::int64_t>(index), where);
        }
        polygons.end_face(source, where);
        first = end;
    }
    std::string place = place_text(source, where) + "'polyhedron'";
    return finished_surface(polygons.triangulate(source, 0), place, warnings);
}

}  // namespace mortise::model_reader
