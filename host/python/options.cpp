#include "host/python/options.hpp"

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/functional.h>
#include <pybind11/stl.h>

#include "host/python/formulas.hpp"

namespace mortise::python {
namespace {

namespace py = pybind11;

/// A value as a type of C++, or TypeError.
template <class T>
T value_of(const py::handle& value, const std::string& name, const char* expected) {
    try {
        return py::cast<T>(value);
    } catch (const py::cast_error&) {
        throw py::type_error("option '" + name + "': expected " + expected + ", not " +
                             std::string(py::repr(value)));
    }
}

Box3 box_of(const py::handle& value, const std::string& name) {
    const auto corners = value_of<std::pair<Vec3, Vec3>>(value, name, "((x0, y0, z0), (x1, y1, z1))");
    return {corners.first, corners.second};
}

std::vector<SizeSource> sizes_of(const py::handle& value, const std::string& name) {
    std::vector<SizeSource> sizes;
    for (const auto& [at, size, grading] : value_of<std::vector<std::tuple<Vec3, double, double>>>(
             value, name, "a list of ((x, y, z), size, grading)"))
        sizes.push_back({at, size, grading});
    return sizes;
}

std::vector<std::pair<std::string, double>> named_sizes_of(const py::handle& value, const std::string& name) {
    const auto sizes = value_of<std::map<std::string, double>>(value, name, "a dict of names and lengths");
    return {sizes.begin(), sizes.end()};
}

LayerOptions layers_of(const py::handle& value, const std::string& name) {
    LayerOptions layers;
    if (!py::isinstance<py::dict>(value)) {
        layers.count = value_of<int>(value, name, "a whole number, or a dict");
        return layers;
    }
    if (!py::cast<py::dict>(value).contains("count"))
        throw py::type_error("option 'layers': expected a member 'count', how many there are to be");
    for (const auto& [key, entry] : py::cast<py::dict>(value)) {
        const auto member = value_of<std::string>(key, "layers", "names of members");
        if (member == "count") {
            layers.count = value_of<int>(entry, "layers: count", "a whole number");
        } else if (member == "first") {
            layers.first = value_of<double>(entry, "layers: first", "a length");
        } else if (member == "growth") {
            layers.growth = value_of<double>(entry, "layers: growth", "a number");
        } else if (member == "on") {
            layers.on = value_of<std::vector<std::string>>(entry, "layers: on", "a list of names");
        } else {
            throw py::type_error("option 'layers' has no member '" + member +
                                 "'; it has count, first, growth, on");
        }
    }
    return layers;
}

/// An option's name, and what puts its value into the options.
struct Option {
    const char* name;
    std::function<void(MeshOptions&, const py::handle&, const std::string&)> set;
};

template <class T>
Option plain(const char* name, T MeshOptions::*member, const char* expected) {
    return {name,
            [member, expected](MeshOptions& options, const py::handle& value, const std::string& called) {
                options.*member = value_of<T>(value, called, expected);
            }};
}
template <class T, class Convert>
Option converted(const char* name, T MeshOptions::*member, Convert convert) {
    return {name, [member, convert](MeshOptions& options, const py::handle& value,
                                    const std::string& called) { options.*member = convert(value, called); }};
}

const std::vector<Option>& all_options() {
    constexpr const char* kWhole = "a whole number";
    constexpr const char* kNumber = "a number";
    constexpr const char* kFlag = "True or False";
    static const std::vector<Option> options = {
        plain("level", &MeshOptions::level, kWhole),
        plain("size", &MeshOptions::size, kNumber),
        plain("refine", &MeshOptions::refine, kWhole),
        plain("curvature_elements", &MeshOptions::curvature_elements, kNumber),
        plain("model_sizes", &MeshOptions::model_sizes, kFlag),
        converted("sizes", &MeshOptions::sizes, sizes_of),
        converted("named_sizes", &MeshOptions::named_sizes, named_sizes_of),
        converted("size_formula", &MeshOptions::size_formula,
                  [](const py::handle& value, const std::string& name) {
                      return formula_text(py::reinterpret_borrow<py::object>(value),
                                          "option '" + name + "': ");
                  }),
        plain("size_max", &MeshOptions::size_max, kNumber),
        plain("size_min", &MeshOptions::size_min, kNumber),
        plain("interior_coarsening", &MeshOptions::interior_coarsening, kWhole),
        plain("box_fit", &MeshOptions::box_fit, kFlag),
        converted("box", &MeshOptions::box, box_of),
        plain("periodic", &MeshOptions::periodic, "letters of 'xyz'"),
        plain("templates", &MeshOptions::templates, kFlag),
        plain("snap", &MeshOptions::snap, kFlag),
        plain("improve", &MeshOptions::improve, kFlag),
        plain("smooth", &MeshOptions::smooth, kWhole),
        plain("min_angle", &MeshOptions::min_angle, kNumber),
        plain("merge_distance", &MeshOptions::merge_distance, kNumber),
        plain("tetrahedra", &MeshOptions::tetrahedra, kFlag),
        plain("hanging", &MeshOptions::hanging, kFlag),
        plain("second_order", &MeshOptions::second_order, kFlag),
        converted("layers", &MeshOptions::layers, layers_of),
        plain("quality", &MeshOptions::quality, kFlag),
        plain("strict", &MeshOptions::strict, kFlag),
        plain("threads", &MeshOptions::threads, kWhole),
    };
    return options;
}

[[noreturn]] void refuse(const std::string& name) {
    std::string known = "progress";
    for (const Option& option : all_options()) known += std::string(", ") + option.name;
    throw py::type_error("there is no option '" + name + "'; there are " + known);
}

}  // namespace

MeshOptions options_of(const py::kwargs& arguments) {
    MeshOptions options;
    py::handle progress = py::none();
    for (const auto& [key, value] : arguments) {
        const auto name = py::cast<std::string>(key);
        if (name == "progress") {
            progress = value;
            if (!progress.is_none() && !PyCallable_Check(progress.ptr()))
                throw py::type_error("option 'progress': expected a function of a stage and a share");
            continue;
        }
        bool found = false;
        for (const Option& option : all_options()) {
            if (name != option.name) continue;
            option.set(options, value, name);
            found = true;
        }
        if (!found) refuse(name);
    }
    // A handle, for the library copies options without Python's lock; the arguments outlive the call.
    options.progress = [progress](const char* stage, double share) {
        const py::gil_scoped_acquire acquire;
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        if (progress.is_none()) return true;
        const py::object goes_on = progress(stage, share);
        return goes_on.is_none() || py::cast<bool>(py::bool_(goes_on));
    };
    return options;
}

}  // namespace mortise::python
