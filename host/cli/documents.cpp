#include "host/cli/documents.hpp"

#include <algorithm>

#include "host/cli/text.hpp"

namespace mortise::cli {
namespace {

Json by_type(const std::array<std::uint64_t, kElementTypes>& values) {
    Json json = Json::object();
    for (std::size_t t = 0; t < kElementTypes; ++t) json[kElementNames[t]] = values[t];
    return json;
}

/// Types without elements have no worst element: null.
Json worst_by_type(const std::array<std::uint64_t, kElementTypes>& elements,
                   const std::array<double, kElementTypes>& values) {
    Json json = Json::object();
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        json[kElementNames[t]] = elements[t] > 0 ? Json(values[t]) : Json(nullptr);
    }
    return json;
}

Json names_with_counts(const std::vector<std::string>& names, const std::vector<std::uint64_t>& counts,
                       const char* what) {
    Json list = Json::array();
    for (std::size_t i = 0; i < names.size(); ++i) list.push_back({{"name", names[i]}, {what, counts[i]}});
    return list;
}

/// The largest of them by name, all of them by count.
Json missed_document(const std::vector<MissedFeature>& missed) {
    constexpr std::size_t kListed = 100;
    Json json;
    json["count"] = missed.size();
    json["lost"] =
        std::count_if(missed.begin(), missed.end(), [](const MissedFeature& f) { return !f.kept; });
    json["largest"] = Json::array();
    for (std::size_t i = 0; i < std::min(missed.size(), kListed); ++i) {
        json["largest"].push_back({{"position", missed[i].position},
                                   {"size", missed[i].size},
                                   {"thickness", missed[i].thickness},
                                   {"kind", missed[i].material ? "material" : "hole"},
                                   {"kept", missed[i].kept}});
    }
    return json;
}

/// What only some options make.
void add_optional_members(const MeshReport& report, Json& json) {
    if (!report.leaves.empty()) {
        json["cells_by_level"] = report.leaves;
        json["transition_cells"] = report.transition_cells;
        json["hanging_cells"] = report.hanging_cells;
    }
    if (report.middle_nodes > 0)
        json["second_order"] = {{"middle_nodes", report.middle_nodes},
                                {"curved_edges", report.curved_edges},
                                {"relaxed_edges", report.relaxed_edges}};
    if (report.layers.facets > 0)
        json["layers"] = {
            {"facets", report.layers.facets},
            {"lower", report.layers.lower},
            {"bare", report.layers.bare},
            {"elements", report.layers.elements},
            {"thickness", report.layers.thickness},
            {"asked", report.layers.asked},
            {"first_bare", report.layers.first_bare ? Json(*report.layers.first_bare) : Json(nullptr)}};
}

Json features_document(const Features& features) {
    double crease_length = 0;
    for (const FeatureCurve& curve : features.curves) crease_length += curve.length;
    return {{"creases", features.curves.size()},
            {"crease_length", crease_length},
            {"corners", features.corners.size()}};
}

Json periodic_document(const std::vector<MeshFigures::Periodic>& pairs) {
    Json json = Json::array();
    for (const MeshFigures::Periodic& pair : pairs)
        json.push_back({{"shift", pair.shift}, {"nodes", pair.nodes}});
    return json;
}

Json stages_document(const std::vector<StageTime>& stages) {
    Json json = Json::array();
    for (const StageTime& stage : stages) {
        json.push_back({{"stage", stage.stage},
                        {"wall_seconds", stage.wall_seconds},
                        {"cpu_seconds", stage.cpu_seconds},
                        {"items", stage.items}});
    }
    return json;
}

}  // namespace

Json mesh_document(const MeshReport& report, const MeshFigures& figures) {
    Json json;
    json["version"] = MORTISE_VERSION;
    json["device"] = report.device;
    json["level"] = report.level;
    json["finest_level"] = report.finest_level;
    add_optional_members(report, json);
    json["cell_size"] = report.cell_size;
    json["root_box"] = {{"min", report.root.min}, {"max", report.root.max}};
    json["nodes"] = figures.nodes;
    json["elements"] = by_type(figures.elements);
    json["elements_by_kind"] = {{"in", figures.kinds[0]},
                                {"snio", figures.kinds[1]},
                                {"cnio", figures.kinds[2]},
                                {"transition", figures.kinds[3]},
                                {"layer", figures.kinds[4]}};
    json["min_scaled_jacobian"] = worst_by_type(figures.elements, figures.min_scaled_jacobian);
    json["worst_place"] = figures.worst_place ? Json(*figures.worst_place) : Json(nullptr);
    json["regions"] = names_with_counts(figures.regions, figures.in_region, "elements");
    json["surfaces"] = names_with_counts(figures.surfaces, figures.on_surface, "facets");
    json["periodic"] = periodic_document(figures.periodic);
    json["features"] = features_document(report.features);
    json["cells"] = {{"evaluated", report.cells_evaluated},
                     {"in", report.in_cells},
                     {"nio", report.nio_cells},
                     {"snio", report.snio_cells},
                     {"cnio", report.cnio_cells}};
    json["refused_splits"] = report.refused_splits;
    json["unresolved"] = report.unresolved;
    json["merged_nodes"] = report.merged_nodes;
    json["loosened_nodes"] = report.loosened_nodes;
    json["below_min_angle"] = report.below_min_angle;
    json["crumbs"] = report.crumbs;
    json["hinge_edges"] = report.hinge_edges;
    json["hinge_nodes"] = report.hinge_nodes;
    json["loose_pieces"] = report.loose_pieces;
    json["closed_hollows"] = report.closed_hollows;
    json["dropped_features"] = report.dropped_features;
    json["first_dropped_feature"] = report.first_dropped ? Json(*report.first_dropped) : Json(nullptr);
    json["missed_features"] = missed_document(report.missed);
    json["stages"] = stages_document(report.stages);
    json["warnings"] = report.warnings;
    return json;
}

Json check_document(const CheckReport& report) {
    Json json;
    json["valid"] = report.valid();
    json["defects"] = Json::array();
    for (const Defect& defect : report.defects) {
        json["defects"].push_back({{"what", defect.what}, {"count", defect.count}, {"first", defect.first}});
    }
    json["nodes"] = report.nodes;
    json["middle_nodes"] = report.middle_nodes;
    json["elements"] = by_type(report.elements);
    json["min_scaled_jacobian"] = worst_by_type(report.elements, report.min_scaled_jacobian);
    json["min_dihedral"] = report.min_dihedral;
    json["max_dihedral"] = report.max_dihedral;
    json["volume"] = report.volume;
    json["region_volume"] = report.region_volume;
    json["boundary_area"] = report.boundary_area;
    json["boundary_facets"] = report.boundary_facets;
    json["interface_facets"] = report.interface_facets;
    json["nonmanifold_edges"] = report.nonmanifold_edges;
    json["nonmanifold_nodes"] = report.nonmanifold_nodes;
    json["euler_characteristic"] = report.euler_characteristic;
    json["components"] = report.components;
    json["parts"] = report.parts;
    return json;
}

std::string to_line(const Json& document) {
    return document.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string to_text(const Json& document) {
    return document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace mortise::cli
