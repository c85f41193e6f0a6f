// The Python module: models, meshes as arrays of numpy, files.
#include <sys/types.h>
#include <unistd.h>

#include <array>
#include <memory>
#include <string>
#include <utility>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "host/python/arrays.hpp"
#include "host/python/formulas.hpp"
#include "host/python/options.hpp"
#include "host/python/reports.hpp"
#include "host/python/solids.hpp"
#include "mortise/check.hpp"
#include "mortise/error.hpp"
#include "mortise/io.hpp"
#include "mortise/mesher.hpp"
#include "mortise/model.hpp"

namespace mortise::python {
namespace {

/// A mesh with what is known of its making.
struct ReportedMesh {
    Mesh mesh;
    MeshReport report;
};

constexpr std::array<const char*, kElementTypes> kBlockNames = {"hexahedra", "wedges", "pyramids",
                                                                "tetrahedra"};
/// As VTK and meshio call them; of first order and of second.
constexpr std::array<std::array<const char*, 2>, kElementTypes> kCellNames = {
    {{"hexahedron", "hexahedron20"}, {"wedge", "wedge15"}, {"pyramid", "pyramid13"}, {"tetra", "tetra10"}}};

/// A path as str, bytes or pathlib has it.
std::string path_of(const py::object& path) {
    return py::cast<std::string>(py::module_::import("os").attr("fsencode")(path));
}

/// The elements of one type.
struct Block {
    const ElementBlock* block;
    ElementType type;

    std::size_t nodes_per_element() const {
        return static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(type)]);
    }
};

/// The nodes of one type in VTK's order, as a copy: corners, then those in the middles of edges.
py::array_t<NodeId> cell_array(const ElementBlock& block, ElementType type) {
    const auto corners = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(type)]);
    const LocalEdges edges = local_edges(type);
    const std::size_t middles = block.middles.empty() ? 0 : static_cast<std::size_t>(edges.count);
    py::array_t<NodeId> array(
        {static_cast<py::ssize_t>(block.size()), static_cast<py::ssize_t>(corners + middles)});
    const std::array<int, 8>& order = kVtkNodes[static_cast<std::size_t>(type)];
    std::vector<std::size_t> middle_order;
    for (std::size_t e = 0; e < middles; ++e) {  // VTK's edges have the same numbers, by its own corners
        const auto end = [&](std::size_t k) { return order[static_cast<std::size_t>(edges.edges[e][k])]; };
        middle_order.push_back(static_cast<std::size_t>(local_edge(type, end(0), end(1))));
    }
    NodeId* to = array.mutable_data();
    for (std::size_t i = 0; i < block.size(); ++i) {
        for (std::size_t k = 0; k < corners; ++k)
            *to++ = block.nodes[i * corners + static_cast<std::size_t>(order[k])];
        for (const std::size_t e : middle_order) *to++ = block.middles[i * middles + e];
    }
    return array;
}

py::dict cells(const Mesh& mesh) {
    if (mesh.hanging.size() > 0)
        throw Error(ExitCode::kUsage,
                    "cells() is of elements without hanging nodes; write() has formats for others");
    const std::size_t order = mesh.is_second_order() ? 1 : 0;
    py::dict result;
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        if (mesh.elements[t].size() > 0)
            result[kCellNames[t][order]] = cell_array(mesh.elements[t], static_cast<ElementType>(t));
    }
    return result;
}

/// mortise.Error, with the exit code that the program would end with; Ctrl-C as KeyboardInterrupt.
void bind_errors(py::module_& module) {
    // Of the interpreter's whole life; nothing is left to release it at the end.
    static PyObject* const type = PyErr_NewExceptionWithDoc(
        "mortise.Error", "What went wrong, in one line. exit_code: that of the program mortise.",
        PyExc_RuntimeError, nullptr);
    module.attr("Error") = py::handle(type);
    py::register_local_exception_translator([](std::exception_ptr thrown) {
        try {
            std::rethrow_exception(thrown);
        } catch (const Error& error) {
            const py::object instance = py::handle(type)(error.what());
            instance.attr("exit_code") = static_cast<int>(error.code());
            PyErr_SetObject(type, instance.ptr());
        }
    });
}

void bind_models(py::module_& module) {
    py::class_<Model> bound(module, "Model",
                            "What is meshed: from read_model(), parse_model(), a Solid, or a dict of them.");
    bind_solids(module, bound);
    bound.def_readonly("source", &Model::source)
        .def_readonly("warnings", &Model::warnings)
        .def_property_readonly("regions", [](const Model& model) {
            std::vector<std::string> names;
            for (const Region& region : model.regions) names.push_back(region.name);
            return names;
        });
    const auto options = [](bool exact, double extrude, std::vector<std::string> definitions) {
        ReadOptions read;
        read.facets = exact ? Facets::kExact : Facets::kSmooth;
        read.extrude = extrude;
        read.definitions = std::move(definitions);
        return read;
    };
    module.def(
        "read_model",
        [options](const py::object& path, bool exact, double extrude, std::vector<std::string> definitions) {
            const std::string name = path_of(path);
            const py::gil_scoped_release release;
            return read_model(name, options(exact, extrude, std::move(definitions)));
        },
        "Reads .csg, .scad, .geo, .stl, .obj, .off, .formula, .vm or .frep.", py::arg("path"), py::kw_only(),
        py::arg("exact_facets") = false, py::arg("extrude") = 0.0,
        py::arg("definitions") = std::vector<std::string>());
    module.def(
        "parse_model",
        [options](const std::string& text, const std::string& format, const std::string& source, bool exact,
                  double extrude) {
            const py::gil_scoped_release release;
            return parse_model(text, format, source, options(exact, extrude, {}));
        },
        "The same of a text in memory; format as the extension of a file: 'csg'.", py::arg("text"),
        py::arg("format"), py::arg("source") = "model", py::kw_only(), py::arg("exact_facets") = false,
        py::arg("extrude") = 0.0);
    py::class_<ModelSummary>(module, "ModelSummary")
        .def_property_readonly("bounds",
                               [](const ModelSummary& summary) -> py::object {
                                   if (!summary.bounds) return py::none();
                                   return py::make_tuple(summary.bounds->min, summary.bounds->max);
                               })
        .def_readonly("unbounded", &ModelSummary::unbounded)
        .def_readonly("surfaces", &ModelSummary::surfaces)
        .def_readonly("surface_size", &ModelSummary::surface_size);
    module.def(
        "summarize",
        [](const py::object& given) {
            const Model model = model_of(given);
            const py::gil_scoped_release release;
            return summarize(model);
        },
        "What a mesh of the model would have, without making one.", py::arg("model"));
}

/// Arrays of a member's vectors, as properties of the object that has them.
template <class Class, class Get>
void bind_array(py::class_<Class>& bound, const char* name, const Get& get, const char* text) {
    bound.def_property_readonly(
        name,
        [get](const py::object& self) {
            const auto& object = py::cast<const Class&>(self);
            const auto [values, width] = get(object);
            return view(*values, width, self);
        },
        text);
}

int axis_of(const std::string& name) {
    const std::size_t axis = std::string("xyz").find(name);
    if (name.size() != 1 || axis == std::string::npos)
        throw py::value_error("cut '" + name + "': expected 'x', 'y' or 'z'");
    return static_cast<int>(axis);
}

void bind_elements(py::module_& module) {
    py::class_<Block> block(module, "Elements", "All elements of one type, as arrays.");
    const auto edges = [](const Block& b) {
        return static_cast<std::size_t>(kElementEdges[static_cast<std::size_t>(b.type)]);
    };
    block.def("__len__", [](const Block& b) { return b.block->size(); });
    bind_array(
        block, "nodes", [](const Block& b) { return std::make_pair(&b.block->nodes, b.nodes_per_element()); },
        "(count, nodes of an element): numbers of nodes, in Mortise's order (see Mesh.cells)");
    bind_array(
        block, "region", [](const Block& b) { return std::make_pair(&b.block->region, std::size_t{0}); },
        "(count,): number of the region, from 1");
    bind_array(
        block, "kind", [](const Block& b) { return std::make_pair(&b.block->kind, std::size_t{0}); },
        "(count,): 0 cube inside, 1 template, 2 complex cell, 3 between sizes, 4 layer");
    bind_array(
        block, "middles", [edges](const Block& b) { return std::make_pair(&b.block->middles, edges(b)); },
        "(count, edges of an element): nodes of second order; empty at first order");
}

void bind_facets(py::module_& module) {
    py::class_<FacetBlock> facets(module, "Facets", "Facets of the boundary and between regions, as arrays.");
    facets.def("__len__", &FacetBlock::size);
    bind_array(
        facets, "nodes", [](const FacetBlock& f) { return std::make_pair(&f.nodes, std::size_t{4}); },
        "(count, 4): numbers of nodes, counter-clockwise seen from outside; triangles repeat the last");
    bind_array(
        facets, "surface", [](const FacetBlock& f) { return std::make_pair(&f.surface, std::size_t{0}); },
        "(count,): place in Mesh.surface_names");
    bind_array(
        facets, "inside", [](const FacetBlock& f) { return std::make_pair(&f.inside, std::size_t{0}); },
        "(count,): region behind the facet, from 1");
    bind_array(
        facets, "outside", [](const FacetBlock& f) { return std::make_pair(&f.outside, std::size_t{0}); },
        "(count,): region in front, 0: none");
    bind_array(
        facets, "middles", [](const FacetBlock& f) { return std::make_pair(&f.middles, std::size_t{4}); },
        "(count, 4): nodes of second order; empty at first order");
}

void bind_periodic_nodes(py::module_& module) {
    py::class_<PeriodicNodes> periodic(module, "PeriodicNodes",
                                       "Two planes with the same facets: nodes of one are copies.");
    periodic.def("__len__", &PeriodicNodes::size).def_readonly("shift", &PeriodicNodes::shift);
    bind_array(
        periodic, "nodes", [](const PeriodicNodes& p) { return std::make_pair(&p.node, std::size_t{0}); },
        "(count,): the copies");
    bind_array(
        periodic, "originals",
        [](const PeriodicNodes& p) { return std::make_pair(&p.original, std::size_t{0}); },
        "(count,): what each is a copy of, moved by `shift`");
}

void bind_contents(py::class_<ReportedMesh>& mesh) {
    bind_array(
        mesh, "points", [](const ReportedMesh& m) { return std::make_pair(&m.mesh.points, std::size_t{3}); },
        "(nodes, 3): x, y, z");
    bind_array(
        mesh, "model_dimension",
        [](const ReportedMesh& m) { return std::make_pair(&m.mesh.model_dimension, std::size_t{0}); },
        "(nodes,): 0 corner of the model, 1 crease, 2 face, 3 inside");
    bind_array(
        mesh, "hanging_nodes",
        [](const ReportedMesh& m) { return std::make_pair(&m.mesh.hanging.node, std::size_t{0}); },
        "(hanging,): nodes that hang");
    bind_array(
        mesh, "hanging_masters",
        [](const ReportedMesh& m) { return std::make_pair(&m.mesh.hanging.masters, std::size_t{4}); },
        "(hanging, 4): the nodes whose mean each takes; of an edge's middle both ends twice");
    mesh.def_property_readonly(
        "periodic",
        [](const py::object& self) {
            py::list pairs;
            for (const PeriodicNodes& pair : py::cast<const ReportedMesh&>(self).mesh.periodic)
                pairs.append(py::cast(&pair, py::return_value_policy::reference_internal, self));
            return pairs;
        },
        "Pairs of planes with the same facets.");
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        mesh.def_property_readonly(kBlockNames[t],
                                   py::cpp_function(
                                       [t](const ReportedMesh& m) {
                                           return Block{&m.mesh.elements[t], static_cast<ElementType>(t)};
                                       },
                                       py::keep_alive<0, 1>()));
    }
    mesh.def_property_readonly(
            "facets", [](const ReportedMesh& m) { return &m.mesh.facets; },
            py::return_value_policy::reference_internal)
        .def_property_readonly("region_names", [](const ReportedMesh& m) { return m.mesh.region_names; })
        .def_property_readonly("surface_names", [](const ReportedMesh& m) { return m.mesh.surface_names; })
        .def_property_readonly(
            "report", [](const ReportedMesh& m) { return &m.report; },
            py::return_value_policy::reference_internal);
}

void bind_uses(py::class_<ReportedMesh>& mesh) {
    mesh.def(
            "cells", [](const ReportedMesh& m) { return cells(m.mesh); },
            "Elements by VTK's names, nodes in VTK's order, as copies: meshio.Mesh(mesh.points, "
            "mesh.cells()).")
        .def("__repr__",
             [](const ReportedMesh& m) {
                 return "<mortise.Mesh: " + std::to_string(m.mesh.element_count()) + " elements, " +
                        std::to_string(m.mesh.node_count()) + " nodes>";
             })
        .def(
            "check", [](const ReportedMesh& m, int threads) { return check_mesh(m.mesh, threads); },
            "Validates the mesh.", py::arg("threads") = 0, py::call_guard<py::gil_scoped_release>())
        .def(
            "write",
            [](const ReportedMesh& m, const py::object& path, bool compress, double scale) {
                const std::string name = path_of(path);
                MeshFileOptions options;
                options.compress = compress;
                options.scale = scale;
                options.walls = m.report.layers.surfaces;
                const py::gil_scoped_release release;
                write_mesh(m.mesh, name, m.report.scaled_jacobians, options);
            },
            "Writes .vtu, .msh, .inp, .stl (the surface) or a folder polyMesh; coordinates times `scale`.",
            py::arg("path"), py::arg("compress") = true, py::arg("scale") = 1.0)
        .def(
            "write_features",
            [](const ReportedMesh& m, const py::object& path, double scale) {
                const std::string name = path_of(path);
                if (m.report.features.model_dimension.empty())
                    throw Error(ExitCode::kUsage,
                                "a mesh from a file has no features; only one that was made has");
                MeshFileOptions options;
                options.scale = scale;
                const py::gil_scoped_release release;
                write_features(m.mesh, m.report.features, name, options);
            },
            "Writes creases and corners, .vtp; coordinates times `scale`.", py::arg("path"),
            py::arg("scale") = 1.0)
        .def(
            "write_picture",
            [](const ReportedMesh& m, const py::object& path, int width, int height,
               std::optional<std::string> cut, std::optional<double> at) {
                PictureOptions options;
                options.width = width;
                options.height = height;
                if (cut) options.cut = PictureCut{axis_of(*cut), at};
                const std::string name = path_of(path);
                const py::gil_scoped_release release;
                write_picture(m.mesh, name, options);
            },
            "Draws the mesh, .png; cut: 'x', 'y' or 'z' opens it across that axis, at a place or the middle.",
            py::arg("path"), py::arg("width") = 1200, py::arg("height") = 900, py::arg("cut") = py::none(),
            py::arg("at") = py::none());
}

void bind_meshes(py::module_& module) {
    bind_elements(module);
    bind_facets(module);
    bind_periodic_nodes(module);
    py::class_<ReportedMesh> mesh(module, "Mesh", "A mesh. Arrays are views that cannot be written.");
    bind_contents(mesh);
    bind_uses(mesh);
    module.def(
        "read_mesh",
        [](const py::object& path) {
            const std::string name = path_of(path);
            const py::gil_scoped_release release;
            return std::make_unique<ReportedMesh>(ReportedMesh{read_mesh(name), {}});
        },
        "Reads .vtu or .msh.", py::arg("path"));
}

/// OpenCL does not live on in a process that is forked from one that has used it: a mesher would wait
/// forever.
void refuse_forked() {
    static const pid_t first = getpid();  // of the first mesh
    if (getpid() == first) return;
    throw Error(
        ExitCode::kUsage,
        "this process was forked from one that has meshed, which OpenCL does not survive; start processes "
        "afresh: multiprocessing.get_context('spawn')");
}

std::unique_ptr<ReportedMesh> generate(Mesher& mesher, const Model& model, const MeshOptions& options) {
    refuse_forked();
    auto result = std::make_unique<ReportedMesh>();
    const py::gil_scoped_release release;
    result->mesh = mesher.generate(model, options, &result->report);
    return result;
}

void bind_mesher(py::module_& module) {
    py::class_<MeshEstimate>(module, "MeshEstimate")
        .def_readonly("level", &MeshEstimate::level)
        .def_readonly("finest_level", &MeshEstimate::finest_level)
        .def_readonly("cell_size", &MeshEstimate::cell_size)
        .def_readonly("in_cells", &MeshEstimate::in_cells)
        .def_readonly("nio_cells", &MeshEstimate::nio_cells)
        .def_readonly("elements", &MeshEstimate::elements)
        .def_readonly("nodes", &MeshEstimate::nodes)
        .def_readonly("memory_bytes", &MeshEstimate::memory_bytes)
        .def_readonly("file_bytes", &MeshEstimate::file_bytes)
        .def_readonly("seconds", &MeshEstimate::seconds)
        .def_readonly("is_exact", &MeshEstimate::is_exact)
        .def_readonly("warnings", &MeshEstimate::warnings)
        .def("__repr__", [](const MeshEstimate& estimate) {
            return "<mortise.MeshEstimate: " + std::string(estimate.is_exact ? "" : "about ") +
                   std::to_string(estimate.elements) + " elements, " + std::to_string(estimate.nodes) +
                   " nodes, " + std::to_string(estimate.memory_bytes >> 20) + " MiB>";
        });
    py::class_<Mesher>(module, "Mesher", "Meshes one model after another on one device; kernels stay loaded.")
        .def(py::init<std::string, int>(), py::arg("device") = "", py::arg("work_group_size") = 0)
        .def(
            "generate",
            [](Mesher& mesher, const py::object& model, const py::kwargs& arguments) {
                return generate(mesher, model_of(model), options_of(arguments));
            },
            "Meshes a model. Options are those of the program, by the names of docs/python.md.",
            py::arg("model"))
        .def(
            "estimate",
            [](Mesher& mesher, const py::object& given, const py::kwargs& arguments) {
                refuse_forked();
                const Model model = model_of(given);
                const MeshOptions options = options_of(arguments);
                const py::gil_scoped_release release;
                return mesher.estimate(model, options);
            },
            "What a mesh would have and take, roughly, without making it.", py::arg("model"));
    module.def(
        "generate",
        [](const py::object& model, const std::string& device, const py::kwargs& arguments) {
            Mesher mesher(device);
            return generate(mesher, model_of(model), options_of(arguments));
        },
        "Meshes one model. For many, Mesher().generate is faster: it keeps its kernels.", py::arg("model"),
        py::kw_only(), py::arg("device") = "");
}

}  // namespace
}  // namespace mortise::python

PYBIND11_MODULE(mortise, module) {
    module.doc() = "Volume meshes of CSG solids and implicit functions.";
    module.attr("__version__") = MORTISE_VERSION;
    mortise::python::bind_errors(module);
    mortise::python::bind_formulas(module);
    mortise::python::bind_models(module);
    mortise::python::bind_reports(module);
    mortise::python::bind_meshes(module);
    mortise::python::bind_mesher(module);
}
