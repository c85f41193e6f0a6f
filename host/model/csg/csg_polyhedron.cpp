// polyhedron() of .csg: see csg_polyhedron.hpp.
#include "host/model/csg/csg_polyhedron.hpp"

#include <cmath>
#include <utility>

#include "host/model/triangles/triangle_text.hpp"

namespace mortise::model_reader {

TriangleSurface polyhedron_surface(std::vector<Vec3> points, const std::vector<std::vector<double>>& faces,
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
    if (faces.size() < 4) {
        fail(source, where,
             kName + std::to_string(faces.size()) + " faces; a closed surface needs at least four");
    }
    Polygons polygons;
    const std::size_t count = points.size();
    polygons.points = std::move(points);
    for (std::size_t f = 0; f < faces.size(); ++f) {
        const std::string face = kName + ("face " + std::to_string(f)) + " ";
        if (faces[f].size() < 3) {
            fail(source, where,
                 face + "has " + std::to_string(faces[f].size()) + " corners; expected at least three");
        }
        for (std::size_t k = faces[f].size(); k-- > 0;) {
            const double index = faces[f][k];
            if (!(index >= 0 && index < static_cast<double>(count)) || index != std::floor(index)) {
                fail(source, where,
                     face + "uses point " + number_text(index) + ", which does not exist; there are " +
                         std::to_string(count) + ", counted from 0");
            }
            polygons.add_corner(static_cast<std::int64_t>(index), where);
        }
        polygons.end_face(source, where);
    }
    std::string place = place_text(source, where) + "'polyhedron'";
    return finished_surface(polygons.triangulate(source, 0), place, warnings);
}

}  // namespace mortise::model_reader
