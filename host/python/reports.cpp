#include "host/python/reports.hpp"

#include <string>

#include <pybind11/stl.h>

#include "host/python/arrays.hpp"
#include "host/python/numbers.hpp"
#include "mortise/check.hpp"
#include "mortise/mesher.hpp"

namespace mortise::python {
namespace {

void bind_features(py::module_& module) {
    py::class_<FeatureCurve>(module, "FeatureCurve", "A crease of the model as the mesh has it.")
        .def_readonly("name", &FeatureCurve::name)
        .def_readonly("surfaces", &FeatureCurve::surfaces)
        .def_property_readonly(
            "nodes",
            [](const py::object& self) { return view(py::cast<const FeatureCurve&>(self).nodes, 0, self); })
        .def_readonly("closed", &FeatureCurve::closed)
        .def_readonly("length", &FeatureCurve::length)
        .def_readonly("model_angle", &FeatureCurve::model_angle);
    py::class_<FeatureCorner>(module, "FeatureCorner", "A corner of the model as the mesh has it.")
        .def_readonly("node", &FeatureCorner::node)
        .def_readonly("surfaces", &FeatureCorner::surfaces)
        .def_readonly("model_angle", &FeatureCorner::model_angle);
    py::class_<Features>(module, "Features", "Creases and corners.")
        .def_readonly("curves", &Features::curves)
        .def_readonly("corners", &Features::corners);
}

void bind_quality(py::module_& module) {
    py::class_<ElementShape>(module, "ElementShape", "Scaled Jacobians of the elements of one type.")
        .def_readonly("count", &ElementShape::count)
        .def_readonly("minimum", &ElementShape::minimum)
        .def_readonly("percentile", &ElementShape::percentile)
        .def_readonly("mean", &ElementShape::mean)
        .def_readonly("not_positive", &ElementShape::not_positive)
        .def_readonly("histogram", &ElementShape::histogram);
    py::class_<AngleFigures>(module, "AngleFigures", "Dihedral angles, degrees.")
        .def_readonly("count", &AngleFigures::count)
        .def_readonly("minimum", &AngleFigures::minimum)
        .def_readonly("maximum", &AngleFigures::maximum)
        .def_readonly("low_percentile", &AngleFigures::low_percentile)
        .def_readonly("high_percentile", &AngleFigures::high_percentile)
        .def_readonly("histogram", &AngleFigures::histogram);
    py::class_<WorstElement>(module, "WorstElement")
        .def_property_readonly("type", [](const WorstElement& worst) { return static_cast<int>(worst.type); })
        .def_readonly("index", &WorstElement::index)
        .def_readonly("scaled_jacobian", &WorstElement::scaled_jacobian)
        .def_readonly("min_dihedral", &WorstElement::min_dihedral)
        .def_readonly("max_dihedral", &WorstElement::max_dihedral)
        .def_readonly("place", &WorstElement::place)
        .def_property_readonly("kind", [](const WorstElement& worst) { return static_cast<int>(worst.kind); })
        .def_readonly("cause", &WorstElement::cause);
    py::class_<DistanceFigures>(module, "DistanceFigures", "Distances, model units.")
        .def_readonly("samples", &DistanceFigures::samples)
        .def_readonly("unmeasured", &DistanceFigures::unmeasured)
        .def_readonly("maximum", &DistanceFigures::maximum)
        .def_readonly("mean", &DistanceFigures::mean)
        .def_readonly("place", &DistanceFigures::place);
    py::class_<ModelCorner>(module, "ModelCorner", "A corner of the model, found without the mesh.")
        .def_readonly("place", &ModelCorner::place)
        .def_readonly("surfaces", &ModelCorner::surfaces)
        .def_readonly("nearest", &ModelCorner::nearest);
    py::class_<SurfaceFigures>(module, "SurfaceFigures")
        .def_readonly("name", &SurfaceFigures::name)
        .def_readonly("facets", &SurfaceFigures::facets)
        .def_readonly("components", &SurfaceFigures::components)
        .def_readonly("area", &SurfaceFigures::area);
    py::class_<QualityReport>(module, "QualityReport", "What the option `quality` asks for.")
        .def_readonly("has_model", &QualityReport::has_model)
        .def_readonly("cell_size", &QualityReport::cell_size)
        .def_readonly("shapes", &QualityReport::shapes)
        .def_readonly("angles", &QualityReport::angles)
        .def_readonly("worst", &QualityReport::worst)
        .def_readonly("mesh_to_model", &QualityReport::mesh_to_model)
        .def_readonly("model_to_mesh", &QualityReport::model_to_mesh)
        .def_readonly("max_normal_angle", &QualityReport::max_normal_angle)
        .def_readonly("mean_normal_angle", &QualityReport::mean_normal_angle)
        .def_readonly("max_normal_place", &QualityReport::max_normal_place)
        .def_readonly("corners_expected", &QualityReport::corners_expected)
        .def_readonly("corners_found", &QualityReport::corners_found)
        .def_readonly("corners_extra", &QualityReport::corners_extra)
        .def_readonly("missing", &QualityReport::missing)
        .def_readonly("crease_length", &QualityReport::crease_length)
        .def_readonly("surfaces", &QualityReport::surfaces);
}

void bind_report(py::module_& module) {
    py::class_<StageTime>(module, "StageTime")
        .def_readonly("stage", &StageTime::stage)
        .def_readonly("wall_seconds", &StageTime::wall_seconds)
        .def_readonly("cpu_seconds", &StageTime::cpu_seconds)
        .def_readonly("items", &StageTime::items);
    py::class_<MissedFeature>(module, "MissedFeature")
        .def_readonly("position", &MissedFeature::position)
        .def_readonly("size", &MissedFeature::size)
        .def_readonly("thickness", &MissedFeature::thickness)
        .def_readonly("material", &MissedFeature::material)
        .def_readonly("kept", &MissedFeature::kept);
    py::class_<LayerFigures>(module, "LayerFigures")
        .def_readonly("facets", &LayerFigures::facets)
        .def_readonly("lower", &LayerFigures::lower)
        .def_readonly("bare", &LayerFigures::bare)
        .def_readonly("elements", &LayerFigures::elements)
        .def_readonly("thickness", &LayerFigures::thickness)
        .def_readonly("first_bare", &LayerFigures::first_bare)
        .def_readonly("asked", &LayerFigures::asked)
        .def_readonly("edge", &LayerFigures::edge)
        .def_readonly("surfaces", &LayerFigures::surfaces)
        .def_readonly("unused", &LayerFigures::unused);
    py::class_<MeshReport>(module, "MeshReport", "What happened besides the mesh.")
        .def_readonly("device", &MeshReport::device)
        .def_readonly("level", &MeshReport::level)
        .def_readonly("finest_level", &MeshReport::finest_level)
        .def_readonly("cell_size", &MeshReport::cell_size)
        .def_readonly("leaves", &MeshReport::leaves)
        .def_property_readonly(
            "root", [](const MeshReport& report) { return std::pair(report.root.min, report.root.max); },
            "Lowest and highest corner of the root cube.")
        .def_readonly("cells_evaluated", &MeshReport::cells_evaluated)
        .def_readonly("in_cells", &MeshReport::in_cells)
        .def_readonly("nio_cells", &MeshReport::nio_cells)
        .def_readonly("snio_cells", &MeshReport::snio_cells)
        .def_readonly("cnio_cells", &MeshReport::cnio_cells)
        .def_readonly("transition_cells", &MeshReport::transition_cells)
        .def_readonly("hanging_cells", &MeshReport::hanging_cells)
        .def_readonly("middle_nodes", &MeshReport::middle_nodes)
        .def_readonly("curved_edges", &MeshReport::curved_edges)
        .def_readonly("relaxed_edges", &MeshReport::relaxed_edges)
        .def_readonly("refused_splits", &MeshReport::refused_splits)
        .def_readonly("unresolved", &MeshReport::unresolved)
        .def_readonly("crumbs", &MeshReport::crumbs)
        .def_readonly("loose_pieces", &MeshReport::loose_pieces)
        .def_readonly("closed_hollows", &MeshReport::closed_hollows)
        .def_readonly("dropped_features", &MeshReport::dropped_features)
        .def_readonly("first_dropped", &MeshReport::first_dropped)
        .def_readonly("warnings", &MeshReport::warnings)
        .def_readonly("stages", &MeshReport::stages)
        .def_readonly("missed", &MeshReport::missed)
        .def_readonly("layers", &MeshReport::layers)
        .def_readonly("merged_nodes", &MeshReport::merged_nodes)
        .def_readonly("loosened_nodes", &MeshReport::loosened_nodes)
        .def_readonly("below_min_angle", &MeshReport::below_min_angle)
        .def_readonly("hinge_edges", &MeshReport::hinge_edges)
        .def_readonly("hinge_nodes", &MeshReport::hinge_nodes)
        .def_readonly("features", &MeshReport::features)
        .def_readonly("quality", &MeshReport::quality)
        .def_property_readonly(
            "scaled_jacobians",
            [](const py::object& self) {
                return view(py::cast<const MeshReport&>(self).scaled_jacobians, 0, self);
            },
            "One per element, in the order of hexahedra, wedges, pyramids, tetrahedra.");
}

void bind_check(py::module_& module) {
    py::class_<Defect>(module, "Defect")
        .def_readonly("what", &Defect::what)
        .def_readonly("count", &Defect::count)
        .def_readonly("first", &Defect::first)
        .def("__repr__", [](const Defect& defect) { return defect.what + ": " + defect.first; });
    py::class_<CheckReport>(module, "CheckReport", "Figures of a mesh, and what is wrong with it.")
        .def_property_readonly("valid", &CheckReport::valid)
        .def_readonly("defects", &CheckReport::defects)
        .def_readonly("elements", &CheckReport::elements)
        .def_readonly("nodes", &CheckReport::nodes)
        .def_readonly("middle_nodes", &CheckReport::middle_nodes)
        .def_readonly("boundary_facets", &CheckReport::boundary_facets)
        .def_readonly("interface_facets", &CheckReport::interface_facets)
        .def_readonly("nonmanifold_edges", &CheckReport::nonmanifold_edges)
        .def_readonly("nonmanifold_nodes", &CheckReport::nonmanifold_nodes)
        .def_readonly("euler_characteristic", &CheckReport::euler_characteristic)
        .def_readonly("components", &CheckReport::components)
        .def_readonly("parts", &CheckReport::parts)
        .def_readonly("volume", &CheckReport::volume)
        .def_readonly("boundary_area", &CheckReport::boundary_area)
        .def_readonly("region_volume", &CheckReport::region_volume)
        .def_readonly("min_scaled_jacobian", &CheckReport::min_scaled_jacobian)
        .def_readonly("min_dihedral", &CheckReport::min_dihedral)
        .def_readonly("max_dihedral", &CheckReport::max_dihedral)
        .def("__repr__", [](const CheckReport& report) {
            if (!report.valid())
                return "<mortise.CheckReport: not valid, " + report.defects.front().what + ">";
            return "<mortise.CheckReport: valid, volume " + rounded_text(report.volume) + ", area " +
                   rounded_text(report.boundary_area) + ", Euler characteristic " +
                   std::to_string(report.euler_characteristic) + ", components " +
                   std::to_string(report.components) + ">";
        });
}

}  // namespace

void bind_reports(py::module_& module) {
    bind_features(module);
    bind_quality(module);
    bind_report(module);
    bind_check(module);
}

}  // namespace mortise::python
