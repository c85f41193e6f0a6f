// polyhedron, text, import, surface; hulls and sums of solids: arguments and places of errors. The work is
// done in csg_polyhedron, text_outlines, triangle_files, drawings, height_field and hulls.
#include "host/model/csg/csg_imports.hpp"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "host/model/csg/csg_polyhedron.hpp"
#include "host/model/file_content.hpp"
#include "host/model/outlines/drawings.hpp"
#include "host/model/outlines/text_outlines.hpp"
#include "host/model/solids/hulls.hpp"
#include "host/model/solids/swept_outline.hpp"
#include "host/model/triangles/height_field.hpp"
#include "host/model/triangles/triangle_files.hpp"

namespace mortise::model_reader {
namespace {

using Kind = CsgOperand::Kind;

/// A string argument without its escapes; the fallback where it is missing or undef.
std::string optional_string(const CsgNodeText& node, std::string_view name, int position,
                            const std::string& fallback) {
    const CsgArgument* argument = node.arguments.find(name, position);
    if (argument == nullptr || argument->kind == CsgArgument::Kind::kUndefined) return fallback;
    if (argument->kind != CsgArgument::Kind::kString) {
        fail(node.source, argument->where,
             in_quotes(node.name) + ": " + std::string(name) + " is not a string; expected one in quotes");
    }
    std::string text;
    for (std::size_t i = 0; i < argument->text.size(); ++i) {
        char c = argument->text[i];
        if (c == '\\' && i + 1 < argument->text.size()) {
            c = argument->text[++i];
            if (c == 'n') c = '\n';
            if (c == 't') c = '\t';
            if (c == 'r') c = '\r';
        }
        text += c;
    }
    return text;
}

SourceLocation place_of(const CsgNodeText& node, std::string_view name, int position) {
    const CsgArgument* argument = node.arguments.find(name, position);
    return argument != nullptr ? argument->where : node.where;
}

/// Warnings that have no place get the node's.
void add_warnings(CsgScene& scene, SourceLocation where, const std::vector<std::string>& warnings) {
    for (const std::string& warning : warnings) scene.warn(where, warning);
}

CsgOperand united_pieces(CsgScene& scene, const std::vector<Contours>& pieces, SourceLocation where) {
    std::vector<CsgOperand> operands;
    for (const Contours& piece : pieces) operands.push_back(scene.outlined(piece, where));
    return scene.united(std::move(operands));
}

double fragment_number(const CsgNodeText& node, std::string_view name, double fallback) {
    const double value = optional_number(node, name, -1, fallback);
    return name == "$fn" ? value : std::max(value, 0.01);
}

struct ImportedFile {
    std::string path;
    std::string content;
};

/// The file of an import or surface node. Errors name the node's place, too.
ImportedFile read_imported(const CsgNodeText& node) {
    const std::string name = optional_string(node, "file", 0, "");
    const SourceLocation where = place_of(node, "file", 0);
    if (name.empty()) fail(node.source, where, in_quotes(node.name) + ": there is no file; expected a path");
    if (std::any_of(name.begin(), name.end(), [](char c) { return c >= 0 && c < ' '; })) {
        fail(
            node.source, where,
            in_quotes(node.name) + ": there is no file with control characters in its name; expected a path");
    }
    constexpr std::size_t kLongest = 4096;
    if (name.size() > kLongest) {
        fail(node.source, where,
             in_quotes(node.name) + ": the path '" + excerpt(name) + "' is too long; expected up to " +
                 std::to_string(kLongest) + " bytes");
    }
    ImportedFile file;
    file.path = (std::filesystem::path(node.source).parent_path() / name).string();
    try {
        file.content = read_file(file.path);
    } catch (const Error& error) {
        throw Error(error.code(), place_text(node.source, where) + in_quotes(node.name) + ": " +
                                      with_short_words(error.what()));
    }
    return file;
}

template <typename Read>
auto with_place(const CsgNodeText& node, Read&& read) {
    try {
        return read();
    } catch (const Error& error) {
        throw Error(error.code(), place_text(node.source, node.where) + in_quotes(node.name) + ": " +
                                      with_short_words(error.what()));
    }
}

void center_surface(TriangleSurface& surface) {
    Vec3 low = surface.points[0];
    Vec3 high = low;
    for (const Vec3& point : surface.points) {
        for (std::size_t k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], point[k]);
            high[k] = std::max(high[k], point[k]);
        }
    }
    for (Vec3& point : surface.points) {
        for (std::size_t k = 0; k < 3; ++k) point[k] -= (low[k] + high[k]) / 2;
    }
}

Vec2 optional_pair(const CsgNodeText& node, std::string_view name) {
    const CsgArgument* argument = node.arguments.find(name);
    if (argument == nullptr || argument->kind == CsgArgument::Kind::kUndefined) return {0, 0};
    if (argument->kind != CsgArgument::Kind::kList || !argument->regular || argument->rows != 0 ||
        argument->count != 2 || argument->not_finite.line != 0) {
        fail(node.source, argument->where,
             in_quotes(node.name) + ": " + std::string(name) + " is not a pair of finite numbers");
    }
    const double* numbers = node.arguments.numbers(*argument);
    return {numbers[0], numbers[1]};
}

std::vector<std::uint32_t> solids_of(CsgScene& scene, const std::vector<CsgOperand>& children,
                                     const std::string& what, SourceLocation where) {
    std::vector<std::uint32_t> nodes;
    bool flat = false;
    for (const CsgOperand& child : children) {
        if (child.kind == Kind::kSolid) nodes.push_back(child.node);
        flat = flat || child.kind == Kind::kFlat;
    }
    if (flat) scene.warn(where, "'" + what + "': 2D shapes among solids are left out");
    return nodes;
}

CsgOperand solid_or_nothing(const CsgScene& scene, std::uint32_t node, SourceLocation where) {
    const CsgNode& made = scene.model.nodes[node];
    if (made.op == CsgNode::Op::kUnion && made.children.empty()) return {};
    return {Kind::kSolid, node, where};
}

}  // namespace

CsgOperand read_polyhedron(CsgScene& scene, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {"points", "faces", "triangles", "convexity"}, 3);
    const CsgArgument* points = node.arguments.find("points", 0);
    const CsgArgument* faces = node.arguments.find("faces", 1);
    if (faces == nullptr) faces = node.arguments.find("triangles");
    const auto is_undefined = [](const CsgArgument* argument) {
        return argument == nullptr || argument->kind == CsgArgument::Kind::kUndefined;
    };
    if (is_undefined(points) && is_undefined(faces)) {
        scene.warn(node.where, "a polyhedron without faces is left out");
        return {};
    }
    const auto is_list = [](const CsgArgument* argument) {
        return argument != nullptr && argument->kind == CsgArgument::Kind::kList && argument->numeric &&
               argument->direct == 0;
    };
    if (!is_list(points) || (points->count != 0 && (!points->regular || points->row_length != 3))) {
        fail(node.source, points != nullptr ? points->where : node.where,
             "'polyhedron': points is not a list of triples of numbers");
    }
    if (!is_list(faces)) {
        fail(node.source, faces != nullptr ? faces->where : node.where,
             "'polyhedron': faces is not a list of lists of point numbers");
    }
    if (faces->rows == 0) {
        scene.warn(node.where, "a polyhedron without faces is left out");
        return {};
    }
    std::vector<Vec3> coordinates(points->count == 0 ? 0 : points->rows);
    const double* numbers = node.arguments.numbers(*points);
    for (std::size_t i = 0; i < coordinates.size(); ++i) {
        coordinates[i] = {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
    }
    const NumberLists corners = {node.arguments.numbers(*faces), node.arguments.row_ends(*faces),
                                 faces->rows};
    TriangleSurface surface =
        polyhedron_surface(std::move(coordinates), corners, node.source, node.where, scene.model.warnings);
    const bool has_curves = node.facets == Facets::kSmooth && faces->rows > kMostSharpFaces;
    const std::uint32_t solid = add_polyhedron(
        scene.model, std::move(surface), has_curves ? kSmoothTurn : kPolyhedronSharpAngle, node.surface);
    scene.model.nodes[solid].where = node.where;
    return {Kind::kSolid, solid, node.where};
}

CsgOperand read_text(CsgScene& scene, const CsgNodeText& node) {
    refuse_unknown_arguments(
        node,
        {"text", "size", "font", "halign", "valign", "spacing", "direction", "language", "script", "em"}, 9);
    TextStyle style;
    style.text = optional_string(node, "text", 0, "");
    style.size = optional_number(node, "size", 1, 10);
    if (style.size == 0) throw_no_extent(node, place_of(node, "size", 1), "size", 0);
    if (!(style.size > 0)) {
        fail_size(node, place_of(node, "size", 1), "size", style.size, "a positive number");
    }
    style.font = optional_string(node, "font", 2, "");
    // Newer versions of OpenSCAD write "default" for what is not given.
    style.halign = optional_string(node, "halign", 3, "default");
    style.valign = optional_string(node, "valign", 4, "default");
    if (style.halign == "default") style.halign = "left";
    if (style.valign == "default") style.valign = "baseline";
    style.spacing = optional_number(node, "spacing", 5, 1);
    style.direction = optional_string(node, "direction", 6, "");
    style.language = optional_string(node, "language", 7, "en");
    style.script = optional_string(node, "script", 8, "");
    style.segments = text_segments(style.size, fragment_number(node, "$fn", 0),
                                   fragment_number(node, "$fa", 12), fragment_number(node, "$fs", 2));
    std::vector<std::string> warnings;
    try {
        const std::vector<Contours> pieces = text_outlines(style, warnings);
        add_warnings(scene, node.where, warnings);
        return united_pieces(scene, pieces, node.where);
    } catch (const std::invalid_argument& error) {
        fail(node.source, node.where, in_quotes(node.name) + ": " + with_short_words(error.what()));
    }
}

CsgOperand read_import(CsgScene& scene, const CsgNodeText& node) {
    refuse_unknown_arguments(
        node, {"file", "layer", "convexity", "origin", "scale", "center", "dpi", "id", "timestamp"}, 2);
    const ImportedFile file = read_imported(node);
    const std::string format = format_of(file.path);
    const bool center = optional_boolean(node, "center", -1);
    std::vector<std::string> warnings;
    if (is_triangle_format(format)) {
        TriangleSurface surface =
            with_place(node, [&] { return read_triangles(file.content, format, file.path, warnings); });
        add_warnings(scene, node.where, warnings);
        if (center) center_surface(surface);
        const std::uint32_t solid =
            add_polyhedron(scene.model, std::move(surface), kSharpAngle, node.surface);
        scene.model.nodes[solid].where = node.where;
        return {Kind::kSolid, solid, node.where};
    }
    if (format != "dxf" && format != "svg") {
        fail(node.source, place_of(node, "file", 0),
             "'import': the format '." + format + "' is not read; expected .stl, .obj, .off, .dxf or .svg");
    }
    DrawingOptions options;
    options.layer = optional_string(node, format == "svg" ? "id" : "layer", -1, "");
    if (options.layer.empty()) options.layer = optional_string(node, "layer", -1, "");
    options.origin = optional_pair(node, "origin");
    options.scale = optional_number(node, "scale", -1, 1);
    options.dpi = optional_number(node, "dpi", -1, 72);
    if (!(options.scale > 0))
        fail_size(node, place_of(node, "scale", -1), "scale", options.scale, "a positive number");
    if (!(options.dpi > 0))
        fail_size(node, place_of(node, "dpi", -1), "dpi", options.dpi, "a positive number");
    options.center = center;
    options.fn = fragment_number(node, "$fn", 0);
    options.fa = fragment_number(node, "$fa", 12);
    options.fs = fragment_number(node, "$fs", 2);
    const std::vector<Contours> pieces = with_place(node, [&] {
        return format == "dxf" ? read_dxf(file.content, file.path, options, warnings)
                               : read_svg(file.content, file.path, options, warnings);
    });
    add_warnings(scene, node.where, warnings);
    return united_pieces(scene, pieces, node.where);
}

CsgOperand read_surface(CsgScene& scene, const CsgNodeText& node) {
    refuse_unknown_arguments(node, {"file", "center", "invert", "convexity", "timestamp"}, 3);
    const ImportedFile file = read_imported(node);
    const bool center = optional_boolean(node, "center", 1);
    const bool invert = optional_boolean(node, "invert", 2);
    TriangleSurface surface =
        with_place(node, [&] { return read_height_surface(file.content, file.path, center, invert); });
    const std::uint32_t solid =
        scene.model.add_primitive(polyhedron(std::move(surface), kSharpAngle), node.surface, node.where);
    return {Kind::kSolid, solid, node.where};
}

CsgOperand hull_of_solids(CsgScene& scene, const std::vector<CsgOperand>& children, const std::string& name,
                          SourceLocation where) {
    const std::vector<std::uint32_t> nodes = solids_of(scene, children, "hull", where);
    const SweptShapes swept = {scene.flat, scene.sweeps};
    return solid_or_nothing(scene, add_hull(scene.model, nodes, name, where, &scene.extents, &swept), where);
}

CsgOperand minkowski_of_solids(CsgScene& scene, const std::vector<CsgOperand>& children,
                               const std::string& name, SourceLocation where) {
    const std::vector<std::uint32_t> nodes = solids_of(scene, children, "minkowski", where);
    const SweptShapes swept = {scene.flat, scene.sweeps};
    return solid_or_nothing(scene, add_minkowski(scene.model, nodes, name, where, &swept), where);
}

}  // namespace mortise::model_reader
