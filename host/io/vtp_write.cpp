// write_features: VTK XML PolyData of crease curves (poly-lines) and corners (vertices), as vtu_write.cpp.
//
// Points: the nodes on features, with the point array `node` (index in the mesh). Cells: corners first, then
// curves. Cell arrays: model_dimension (UInt8; 0 corner, 1 crease), curve (Int32; index into the field array
// curve_names, -1 for a corner), surface_a and surface_b (Int32; indices into surface_names; a corner's first
// two), length and model_angle (Float64; 0 and its sharpest crease's for a corner). A closed curve repeats
// its first point. FieldData: curve_names, surface_names, and corner_surfaces, those of all corners one after
// the other, with corner_surface_ends.
#include <algorithm>
#include <string>
#include <vector>

#include "host/common/sort_unique.hpp"
#include "host/io/coordinates.hpp"
#include "host/io/vtk_xml.hpp"
#include "mortise/error.hpp"
#include "mortise/io.hpp"

namespace mortise {
namespace {

/// The arrays of the file.
struct FeatureArrays {
    std::vector<std::int64_t> node;
    std::vector<double> points;
    std::vector<std::int64_t> corner_points, corner_ends, curve_points, curve_ends;
    std::vector<std::uint8_t> dimension;
    std::vector<std::int32_t> curve, surface_a, surface_b;
    std::vector<double> length, model_angle;
    std::vector<std::string> curve_names;
    std::vector<std::int32_t> corner_surfaces;
    std::vector<std::int64_t> corner_surface_ends;
};

void add_points(const Mesh& mesh, const Features& features, double scale, FeatureArrays& out) {
    for (const FeatureCorner& corner : features.corners) out.node.push_back(corner.node);
    for (const FeatureCurve& curve : features.curves) {
        out.node.insert(out.node.end(), curve.nodes.begin(), curve.nodes.end());
    }
    sort_unique(out.node);
    const io::Coordinates points(mesh.points, scale);
    for (const std::int64_t node : out.node) {
        for (std::size_t j = 0; j < 3; ++j)
            out.points.push_back(points[3 * static_cast<std::size_t>(node) + j]);
    }
}

FeatureArrays arrays_of(const Mesh& mesh, const Features& features, double scale) {
    FeatureArrays out;
    add_points(mesh, features, scale, out);
    const auto place = [&out](NodeId node) {
        return std::lower_bound(out.node.begin(), out.node.end(), std::int64_t{node}) - out.node.begin();
    };
    for (const FeatureCorner& corner : features.corners) {
        out.corner_points.push_back(place(corner.node));
        out.corner_ends.push_back(static_cast<std::int64_t>(out.corner_points.size()));
        out.dimension.push_back(0);
        out.curve.push_back(-1);
        const auto surface = [&corner](std::size_t i) {
            return i < corner.surfaces.size() ? static_cast<std::int32_t>(corner.surfaces[i]) : -1;
        };
        out.surface_a.push_back(surface(0));
        out.surface_b.push_back(surface(1));
        out.length.push_back(0);
        out.model_angle.push_back(corner.model_angle);
        for (const std::uint32_t s : corner.surfaces) {
            out.corner_surfaces.push_back(static_cast<std::int32_t>(s));
        }
        out.corner_surface_ends.push_back(static_cast<std::int64_t>(out.corner_surfaces.size()));
    }
    for (const FeatureCurve& curve : features.curves) {
        for (const NodeId node : curve.nodes) out.curve_points.push_back(place(node));
        if (curve.closed) out.curve_points.push_back(place(curve.nodes.front()));
        out.curve_ends.push_back(static_cast<std::int64_t>(out.curve_points.size()));
        out.dimension.push_back(1);
        out.curve.push_back(static_cast<std::int32_t>(out.curve_names.size()));
        out.surface_a.push_back(static_cast<std::int32_t>(curve.surfaces[0]));
        out.surface_b.push_back(static_cast<std::int32_t>(curve.surfaces[1]));
        out.length.push_back(curve.length * scale);
        out.model_angle.push_back(curve.model_angle);
        out.curve_names.push_back(curve.name);
    }
    return out;
}

template <class Value>
void add_array(const char* type, const char* name, const std::vector<Value>& values,
               io::VtkXmlWriter& writer) {
    writer.array(type, name, "", values.size() * sizeof(Value), io::memory_source(values.data()));
}

void add_cells(const char* name, const std::vector<std::int64_t>& points,
               const std::vector<std::int64_t>& ends, io::VtkXmlWriter& writer) {
    writer.text("<" + std::string(name) + ">");
    add_array("Int64", "connectivity", points, writer);
    add_array("Int64", "offsets", ends, writer);
    writer.text("</" + std::string(name) + ">");
}

/// What does not fit the mesh; empty: nothing.
std::string find_range_error(const Mesh& mesh, const Features& features) {
    const auto is_node = [&mesh](NodeId node) { return node < mesh.node_count(); };
    const auto is_surface = [&mesh](std::uint32_t surface) { return surface < mesh.surface_names.size(); };
    for (const FeatureCorner& corner : features.corners) {
        if (!is_node(corner.node)) return "corner with a node index out of range";
        if (!std::all_of(corner.surfaces.begin(), corner.surfaces.end(), is_surface))
            return "corner with a surface out of range";
    }
    for (const FeatureCurve& curve : features.curves) {
        if (curve.nodes.empty()) return "curve without nodes";
        if (!std::all_of(curve.nodes.begin(), curve.nodes.end(), is_node))
            return "curve with a node index out of range";
        if (!std::all_of(curve.surfaces.begin(), curve.surfaces.end(), is_surface))
            return "curve with a surface out of range";
    }
    return {};
}

}  // namespace

void write_features(const Mesh& mesh, const Features& features, const std::string& path,
                    const MeshFileOptions& options) {
    io::check_scale(options.scale, path);
    const std::string error = find_range_error(mesh, features);
    if (!error.empty())
        throw Error(ExitCode::kMeshing, "cannot write '" + path + "': features of another mesh: " + error);
    const FeatureArrays arrays = arrays_of(mesh, features, options.scale);
    io::TemporaryFile file(path);
    io::VtkXmlWriter writer(file, "PolyData", io::Packing{});
    writer.text("<PolyData>");
    writer.text("<FieldData>");
    writer.names("surface_names", mesh.surface_names);
    writer.names("curve_names", arrays.curve_names);
    writer.field("Int32", "corner_surfaces", 1, arrays.corner_surfaces);
    writer.field("Int64", "corner_surface_ends", 1, arrays.corner_surface_ends);
    writer.text("</FieldData>");
    writer.text("<Piece NumberOfPoints=\"" + std::to_string(arrays.node.size()) + "\" NumberOfVerts=\"" +
                std::to_string(arrays.corner_ends.size()) + "\" NumberOfLines=\"" +
                std::to_string(arrays.curve_ends.size()) + "\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">");
    writer.text("<Points>");
    writer.array("Float64", "Points", " NumberOfComponents=\"3\"", arrays.points.size() * sizeof(double),
                 io::memory_source(arrays.points.data()));
    writer.text("</Points>");
    writer.text("<PointData>");
    add_array("Int64", "node", arrays.node, writer);
    writer.text("</PointData>");
    add_cells("Verts", arrays.corner_points, arrays.corner_ends, writer);
    add_cells("Lines", arrays.curve_points, arrays.curve_ends, writer);
    writer.text("<CellData>");
    add_array("UInt8", "model_dimension", arrays.dimension, writer);
    add_array("Int32", "curve", arrays.curve, writer);
    add_array("Int32", "surface_a", arrays.surface_a, writer);
    add_array("Int32", "surface_b", arrays.surface_b, writer);
    add_array("Float64", "length", arrays.length, writer);
    add_array("Float64", "model_angle", arrays.model_angle, writer);
    writer.text("</CellData>");
    writer.text("</Piece>");
    writer.text("</PolyData>");
    writer.finish();
    file.commit();
}

}  // namespace mortise
