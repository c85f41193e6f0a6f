#include "host/python/solids.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include "host/python/formulas.hpp"
#include "host/python/numbers.hpp"
#include "mortise/solid.hpp"

namespace mortise::python {
namespace {

namespace py = pybind11;

/// 3 × 3, 3 × 4 or 4 × 4, the last with a row 0 0 0 1.
Affine affine_of(const py::array_t<double, py::array::c_style | py::array::forcecast>& matrix) {
    const auto rows = matrix.ndim() == 2 ? matrix.shape(0) : 0;
    const auto columns = matrix.ndim() == 2 ? matrix.shape(1) : 0;
    if (!((rows == 3 && (columns == 3 || columns == 4)) || (rows == 4 && columns == 4)))
        throw py::value_error("expected a matrix of 3 x 3, 3 x 4 or 4 x 4 numbers");
    if (rows == 4 &&
        (matrix.at(3, 0) != 0 || matrix.at(3, 1) != 0 || matrix.at(3, 2) != 0 || matrix.at(3, 3) != 1))
        throw py::value_error("expected a matrix whose last row is 0, 0, 0, 1");
    Affine map = kIdentity;
    for (py::ssize_t i = 0; i < 3; ++i) {
        for (py::ssize_t j = 0; j < columns; ++j) map[static_cast<std::size_t>(4 * i + j)] = matrix.at(i, j);
    }
    return map;
}

using Outline = std::vector<std::array<double, 2>>;

std::string polygon_text(const Outline& outline) {
    if (outline.size() < 3)
        throw py::value_error("an outline of " + std::to_string(outline.size()) +
                              " points has no area; expected three at least");
    std::string points;
    for (const auto& [x, y] : outline)
        points += (points.empty() ? "[" : ", [") + number_text(x) + ", " + number_text(y) + "]";
    return "polygon(points = [" + points + "]);";
}

/// An outline less the holes, as OpenSCAD's.
std::string outline_text(const Outline& outline, const std::vector<Outline>& holes) {
    if (holes.empty()) return polygon_text(outline);
    std::string text = "difference() { " + polygon_text(outline);
    for (const Outline& hole : holes) text += " " + polygon_text(hole);
    return text + " }";
}

/// The one solid of a model; what its reader warned of is a warning of Python's.
Solid solid_of(const Model& model) {
    for (const std::string& warning : model.warnings) {
        if (PyErr_WarnEx(PyExc_UserWarning, warning.c_str(), 1) != 0) throw py::error_already_set();
    }
    return solids_of(model).front().second;
}

Model parse_text(const std::string& text, const char* format, const std::string& source) {
    const py::gil_scoped_release release;
    return parse_model(text, format, source);
}

/// What a sweep of OpenSCAD makes of an outline with holes, whose surfaces' names begin with `name`.
Solid swept(const std::string& kind, const std::string& arguments, const Outline& outline,
            const std::vector<Outline>& holes, const std::string& name) {
    Model model = parse_text(kind + "(" + arguments + ") " + outline_text(outline, holes), "csg", name);
    const std::string old = kind + "1";  // as the reader calls the first of its kind
    for (CsgNode& node : model.nodes) {
        if (node.name.compare(0, old.size(), old) == 0) node.name = name + node.name.substr(old.size());
    }
    return solid_of(model);
}

Solid extrude(const Outline& outline, double height, const std::vector<Outline>& holes, double twist,
              const std::variant<double, std::array<double, 2>>& scale, const std::string& name) {
    std::string arguments = "height = " + number_text(height);
    if (twist != 0) arguments += ", twist = " + number_text(twist);
    const auto* const both = std::get_if<double>(&scale);
    const std::array<double, 2> top =
        both != nullptr ? std::array<double, 2>{*both, *both} : std::get<std::array<double, 2>>(scale);
    if (top != std::array<double, 2>{1, 1})
        arguments += ", scale = [" + number_text(top[0]) + ", " + number_text(top[1]) + "]";
    return swept("linear_extrude", arguments, outline, holes, name);
}

Solid revolve(const Outline& outline, double angle, const std::vector<Outline>& holes,
              const std::string& name) {
    return swept("rotate_extrude", "angle = " + number_text(angle), outline, holes, name);
}

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Whether it is count x `columns` numbers.
bool is_table(const py::array& array, py::ssize_t columns) {
    return array.ndim() == 2 && array.shape(1) == columns;
}

bool has_whole_numbers(const py::array& array) {
    const char kind = array.dtype().kind();
    return kind == 'i' || kind == 'u';
}

/// Rods along edges, of one radius or of one each.
Solid lattice_of(const Numbers& points, const py::object& given, const Numbers& radius) {
    const py::array edges = py::array::ensure(given);
    if (!edges) throw py::error_already_set();
    if (!is_table(points, 3) || !is_table(edges, 2) || !has_whole_numbers(edges))
        throw py::value_error("expected arrays of count x 3 points and count x 2 whole numbers, the edges");
    if (radius.ndim() > 1 || (radius.ndim() == 1 && radius.shape(0) != edges.shape(0)))
        throw py::value_error("expected one radius, or one for each of the " +
                              std::to_string(edges.shape(0)) + " edges");
    const auto ends = py::cast<py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>>(edges);
    std::vector<Vec3> places;
    for (py::ssize_t i = 0; i < points.shape(0); ++i)
        places.push_back({points.at(i, 0), points.at(i, 1), points.at(i, 2)});
    std::vector<std::array<std::uint32_t, 2>> pairs;
    std::vector<double> radii;
    for (py::ssize_t i = 0; i < ends.shape(0); ++i) {
        pairs.emplace_back();
        for (py::ssize_t k = 0; k < 2; ++k) {
            const std::int64_t end = ends.at(i, k);
            if (end < 0 || end > std::numeric_limits<std::uint32_t>::max())
                throw py::value_error("edge " + std::to_string(i) + " ends at point " + std::to_string(end) +
                                      "; expected numbers of points, from 0");
            pairs.back()[static_cast<std::size_t>(k)] = static_cast<std::uint32_t>(end);
        }
        radii.push_back(radius.ndim() == 1 ? radius.at(i) : *radius.data());
    }
    return lattice(places, pairs, radii);
}

/// By way of the reader of .off files, which closes, turns and joins what can be, and refuses the rest.
Solid polyhedron_of(const Numbers& points, const py::object& given, double sharp_angle) {
    const py::array triangles = py::array::ensure(given);
    if (!triangles) throw py::error_already_set();
    if (!is_table(points, 3) || !is_table(triangles, 3) || !has_whole_numbers(triangles))
        throw py::value_error(
            "expected arrays of count x 3 points and count x 3 whole numbers, the triangles");
    const auto corners =
        py::cast<py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>>(triangles);
    std::string text =
        "OFF\n" + std::to_string(points.shape(0)) + " " + std::to_string(corners.shape(0)) + " 0\n";
    for (py::ssize_t i = 0; i < points.shape(0); ++i) {
        for (py::ssize_t j = 0; j < 3; ++j) text += number_text(points.at(i, j)) + (j < 2 ? " " : "\n");
    }
    for (py::ssize_t i = 0; i < corners.shape(0); ++i) {
        text += "3";
        for (py::ssize_t k = 0; k < 3; ++k) {
            const std::int64_t corner = corners.at(i, k);
            if (corner < 0 || corner >= points.shape(0))
                throw py::value_error("triangle " + std::to_string(i) + " has corner " +
                                      std::to_string(corner) + "; there are " +
                                      std::to_string(points.shape(0)) + " points");
            text += " " + std::to_string(corner);
        }
        text += "\n";
    }
    Model model = parse_text(text, "off", "polyhedron");
    for (CsgNode& node : model.nodes) {
        if (node.primitive.kind != Primitive::Kind::kPolyhedron) continue;
        node.primitive = polyhedron(*node.primitive.triangles, sharp_angle);
        node.name.clear();  // for Solid::named
    }
    return solid_of(model);
}

std::optional<Box3> bounds_of(const std::optional<std::pair<Vec3, Vec3>>& corners) {
    if (!corners) return std::nullopt;
    return Box3{corners->first, corners->second};
}

/// A dict of names and solids, in its order.
Model model_of_regions(const py::dict& regions) {
    if (regions.empty())
        throw py::type_error("expected a dict of regions' names and their solids, not an empty one");
    std::vector<std::pair<std::string, Solid>> solids;
    for (const auto& [name, solid] : regions) {
        if (!py::isinstance<py::str>(name) || !py::isinstance<Solid>(solid))
            throw py::type_error("expected a dict of regions' names and their solids, not " +
                                 std::string(py::repr(regions)));
        solids.emplace_back(py::cast<std::string>(name), py::cast<Solid>(solid));
    }
    return make_model(solids);
}

void bind_class(py::module_& module) {
    py::class_<Solid>(module, "Solid", "A solid; a value: operations make new ones.")
        .def(py::init<>(), "The empty set.")
        .def(
            "__or__", [](const Solid& a, const Solid& b) { return a | b; }, py::is_operator())
        .def(
            "__add__", [](const Solid& a, const Solid& b) { return a | b; }, py::is_operator())
        .def(
            "__and__", [](const Solid& a, const Solid& b) { return a & b; }, py::is_operator())
        .def(
            "__sub__", [](const Solid& a, const Solid& b) { return a - b; }, py::is_operator())
        .def("__invert__", [](const Solid& a) { return ~a; })
        .def("__radd__",  // sum() begins with 0
             [](const Solid& a, const py::object& zero) -> py::object {
                 if (!py::isinstance<py::int_>(zero) || !zero.equal(py::int_(0)))
                     return py::reinterpret_borrow<py::object>(Py_NotImplemented);
                 return py::cast(a);
             })
        .def("__copy__", [](const Solid& self) { return self; })
        .def("__deepcopy__", [](const Solid& self, const py::dict&) { return self; })
        .def("named", &Solid::named, "Names its surfaces that have no name yet.", py::arg("name"))
        .def(
            "sized",
            [](const Solid& self, double size, bool surface_only) {
                return surface_only ? self.surface_sized(size) : self.sized(size);
            },
            "Cells of at most `size` on its surfaces, and inside.", py::arg("size"),
            py::arg("surface_only") = false)
        .def("translate", &Solid::translated, py::arg("by"))
        .def("rotate", &Solid::rotated, "Around an axis through the origin, counter-clockwise from its tip.",
             py::arg("degrees"), py::arg("axis") = Vec3{0, 0, 1})
        .def(
            "scale",
            [](const Solid& self, double factor) {
                return self.scaled({factor, factor, factor});
            },
            py::arg("factor"))
        .def("scale", &Solid::scaled, py::arg("factors"))
        .def("mirror", &Solid::mirrored, "In the plane through the origin with this normal.",
             py::arg("normal"))
        .def(
            "transform",
            [](const Solid& self,
               const py::array_t<double, py::array::c_style | py::array::forcecast>& matrix) {
                return self.transformed(affine_of(matrix));
            },
            "By a matrix of 3 x 3, 3 x 4 or 4 x 4 numbers.", py::arg("matrix"));
}

void bind_makers(py::module_& module) {
    module.def(
        "box", [](const Vec3& low, const Vec3& high) { return Solid(box(low, high)); },
        "Between two corners; its surfaces are NAME_xmin, …", py::arg("low"), py::arg("high"));
    module.def(
        "sphere", [](double radius, const Vec3& center) { return Solid(sphere(radius)).translated(center); },
        py::arg("radius"), py::arg("center") = Vec3{});
    module.def("cylinder", &cylinder, "Around z, from z = 0.", py::arg("radius"), py::arg("height"));
    module.def("frustum", &frustum, "A cylinder with a radius at each end; one may be 0.", py::arg("bottom"),
               py::arg("top"), py::arg("height"));
    module.def(
        "rod",
        [](const Vec3& a, const Vec3& b, double radius, const std::optional<double>& end_radius) {
            return rod(a, b, radius, end_radius.value_or(radius));
        },
        "From a to b, with round ends; tapered if it has another radius at b.", py::arg("a"), py::arg("b"),
        py::arg("radius"), py::arg("end_radius") = py::none());
    module.def("lattice", &lattice_of,
               "Rods along edges, pairs of indices into points; one radius, or one for each edge.",
               py::arg("points"), py::arg("edges"), py::arg("radius"));
    module.def(
        "torus", [](double major, double minor) { return Solid(torus(major, minor)); }, "Around z.",
        py::arg("major"), py::arg("minor"));
    module.def(
        "half_space", [](const Vec3& point, const Vec3& normal) { return Solid(half_space(point, normal)); },
        "All that lies behind a plane.", py::arg("point"), py::arg("normal"));
    module.def(
        "polyhedron", &polyhedron_of,
        "Closed triangles, counter-clockwise seen from outside; edges are creases where the surface turns by "
        "more than `sharp_angle` degrees.",
        py::arg("points"), py::arg("triangles"), py::arg("sharp_angle") = 40.0);
    module.def(
        "implicit",
        [](const py::object& formula, const std::optional<std::pair<Vec3, Vec3>>& bounds) {
            return implicit(formula_text(formula), bounds_of(bounds));
        },
        "Where a formula is not positive: a text, a Formula, or a function of x, y, z.", py::arg("formula"),
        py::arg("bounds") = py::none());
    module.def(
        "extrude", &extrude,
        "An outline in x and y, from z = 0; twist in degrees, scale of the top, or (along x, along y).",
        py::arg("outline"), py::arg("height"), py::kw_only(), py::arg("holes") = std::vector<Outline>(),
        py::arg("twist") = 0.0, py::arg("scale") = std::variant<double, std::array<double, 2>>(1.0),
        py::arg("name") = "extrusion");
    module.def("revolve", &revolve, "An outline in (distance from the axis, height), turned around z.",
               py::arg("outline"), py::arg("angle") = 360.0, py::kw_only(),
               py::arg("holes") = std::vector<Outline>(), py::arg("name") = "revolution");
    module.def(
        "csg", [](const std::string& text) { return solid_of(parse_text(text, "csg", "csg")); },
        "The solid of OpenSCAD's .csg: csg('hull() { sphere(1); translate([3, 0, 0]) sphere(2); }').",
        py::arg("text"));
    const auto all_of = [](const py::iterable& solids) {
        std::vector<Solid> all;
        for (const py::handle solid : solids) all.push_back(py::cast<Solid>(solid));
        return all;
    };
    module.def(
        "unite", [all_of](const py::iterable& solids) { return unite(all_of(solids)); }, "The union of many.",
        py::arg("solids"));
    module.def(
        "intersect", [all_of](const py::iterable& solids) { return intersect(all_of(solids)); },
        "What is in all of many.", py::arg("solids"));
}

}  // namespace

void bind_solids(py::module_& module, py::class_<Model>& model) {
    bind_class(module);
    bind_makers(module);
    model
        .def(
            py::init([](const Solid& solid, const std::string& region) { return make_model(solid, region); }),
            "The model of one region.", py::arg("solid"), py::arg("region") = "solid")
        .def(py::init(&model_of_regions),
             "Several regions, a dict of names and solids; the first has what overlaps.", py::arg("regions"))
        .def_property_readonly(
            "solids",
            [](const Model& self) {
                py::dict solids;
                for (const auto& [name, solid] : solids_of(self)) solids[py::str(name)] = solid;
                return solids;
            },
            "Its regions as solids, by name, to build on.");
}

Model model_of(const py::object& given) {
    if (py::isinstance<Model>(given)) return py::cast<Model>(given);
    if (py::isinstance<Solid>(given)) return make_model(py::cast<Solid>(given));
    if (py::isinstance<py::dict>(given)) return model_of_regions(py::cast<py::dict>(given));
    throw py::type_error("expected a Model, a Solid or a dict of regions' names and their solids, not " +
                         std::string(py::repr(given)));
}

}  // namespace mortise::python
