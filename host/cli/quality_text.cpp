// See quality_text.hpp.
#include "host/cli/quality_text.hpp"

#include <algorithm>
#include <cstdio>

#include "host/cli/text.hpp"

namespace mortise::cli {
namespace {

constexpr std::array<const char*, kElementTypes> kElementName = {"hexahedron", "wedge", "pyramid",
                                                                 "tetrahedron"};
constexpr std::array<const char*, 3> kKindName = {"in", "snio", "cnio"};
constexpr std::size_t kMostMissingLines = 5;

/// snprintf into a string.
template <class... Values>
std::string format(const char* pattern, Values... values) {
    char text[256];
    std::snprintf(text, sizeof text, pattern, values...);
    return text;
}

const char* kind_name(ElementKind kind) {
    const auto i = static_cast<std::size_t>(kind);
    return i < kKindName.size() ? kKindName[i] : "other";
}

std::string shapes_text(const QualityReport& report) {
    std::string text =
        "  shape           count       min      1 %     mean   scaled Jacobian, % from 0 to 1 by 0.2\n";
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const ElementShape& shape = report.shapes[t];
        if (shape.count == 0) continue;
        text +=
            format("    %-11s %9llu %9.4g %8.4g %8.4g  ", kElementNames[t],
                   static_cast<unsigned long long>(shape.count), shape.minimum, shape.percentile, shape.mean);
        for (std::size_t bin = 0; bin < shape.histogram.size(); bin += 4) {
            std::uint64_t sum = 0;
            for (std::size_t i = bin; i < bin + 4; ++i) sum += shape.histogram[i];
            text += format(" %5.1f", 100 * static_cast<double>(sum) / static_cast<double>(shape.count));
        }
        if (shape.not_positive > 0) {
            text += format(", %llu not positive", static_cast<unsigned long long>(shape.not_positive));
        }
        text += "\n";
    }
    const AngleFigures& angles = report.angles;
    text += format("  angles        %.4g to %.4g degrees; 1 %% below %.4g, 1 %% above %.4g\n", angles.minimum,
                   angles.maximum, angles.low_percentile, angles.high_percentile);
    text += "    % by 15 deg";
    for (std::size_t bin = 0; bin < angles.histogram.size(); bin += 3) {
        std::uint64_t sum = 0;
        for (std::size_t i = bin; i < bin + 3; ++i) sum += angles.histogram[i];
        const double count = static_cast<double>(std::max<std::uint64_t>(angles.count, 1));
        text += format(" %.1f", 100 * static_cast<double>(sum) / count);
    }
    return text + "\n";
}

std::string distance_text(const char* name, const DistanceFigures& distance, double cell) {
    const std::string others =
        distance.unmeasured == 0 ? ""
                                 : format("; %llu samples not measured: a formula shows no surface near them",
                                          static_cast<unsigned long long>(distance.unmeasured));
    if (distance.samples == 0) return format("  %-13s no samples", name) + others + "\n";
    return format("  %-13s max %.3g (%.3g cells), mean %.3g (%.3g cells), ", name, distance.maximum,
                  distance.maximum / cell, distance.mean, distance.mean / cell) +
           "worst at " + place_text(distance.place) + others + "\n";
}

std::string corner_names(const ModelCorner& corner) {
    std::string text;
    for (const std::string& name : corner.surfaces) text += (text.empty() ? "" : ", ") + name;
    return text;
}

std::string model_text(const QualityReport& report, const Features* features) {
    std::string text = distance_text("mesh to model", report.mesh_to_model, report.cell_size);
    text += distance_text("model to mesh", report.model_to_mesh, report.cell_size);
    text += format("  normals       max %.3g degrees, mean %.3g; worst at ", report.max_normal_angle,
                   report.mean_normal_angle) +
            place_text(report.max_normal_place) + "\n";
    text += format("  corners       %llu expected, %llu found, %llu others in the mesh\n",
                   static_cast<unsigned long long>(report.corners_expected),
                   static_cast<unsigned long long>(report.corners_found),
                   static_cast<unsigned long long>(report.corners_extra));
    for (std::size_t i = 0; i < std::min(report.missing.size(), kMostMissingLines); ++i) {
        const ModelCorner& corner = report.missing[i];
        text += "    missing     " + place_text(corner.place) + " of " + corner_names(corner);
        text += corner.nearest < 0 ? "\n"
                                   : format("; nearest corner of the mesh at %.3g cells\n",
                                            corner.nearest / report.cell_size);
    }
    if (features != nullptr) {
        text += format("  creases       %zu, length %.6g\n", features->curves.size(), report.crease_length);
    }
    std::uint64_t faces = 0;
    for (const SurfaceFigures& surface : report.surfaces) faces += surface.components;
    return text + format("  surfaces      %zu, %llu faces\n", report.surfaces.size(),
                         static_cast<unsigned long long>(faces));
}

Json distance_document(const DistanceFigures& distance, double cell) {
    Json json = {{"samples", distance.samples}};
    if (distance.unmeasured > 0) json["unmeasured"] = distance.unmeasured;
    if (distance.samples == 0) return json;
    json.update({{"max", distance.maximum},
                 {"max_cells", distance.maximum / cell},
                 {"mean", distance.mean},
                 {"mean_cells", distance.mean / cell},
                 {"place", distance.place}});
    return json;
}

void add_model(const QualityReport& report, const Features* features, Json& json) {
    json["cell_size"] = report.cell_size;
    json["mesh_to_model"] = distance_document(report.mesh_to_model, report.cell_size);
    json["model_to_mesh"] = distance_document(report.model_to_mesh, report.cell_size);
    json["normal_angle"] = {{"max", report.max_normal_angle},
                            {"mean", report.mean_normal_angle},
                            {"place", report.max_normal_place}};
    json["corners"] = {{"expected", report.corners_expected},
                       {"found", report.corners_found},
                       {"extra", report.corners_extra},
                       {"missing", Json::array()}};
    for (const ModelCorner& corner : report.missing) {
        Json item = {{"place", corner.place}, {"surfaces", corner.surfaces}};
        item["nearest"] = corner.nearest < 0 ? Json(nullptr) : Json(corner.nearest);
        json["corners"]["missing"].push_back(item);
    }
    json["crease_length"] = report.crease_length;
    json["surfaces"] = Json::array();
    for (const SurfaceFigures& surface : report.surfaces) {
        json["surfaces"].push_back({{"name", surface.name},
                                    {"facets", surface.facets},
                                    {"faces", surface.components},
                                    {"area", surface.area}});
    }
    if (features == nullptr) return;
    json["creases"] = Json::array();
    for (const FeatureCurve& curve : features->curves) {
        json["creases"].push_back({{"name", curve.name},
                                   {"length", curve.length},
                                   {"edges", curve.nodes.size() - (curve.closed ? 0 : 1)},
                                   {"closed", curve.closed},
                                   {"model_angle", curve.model_angle}});
    }
}

}  // namespace

std::string describe(const WorstElement& element) {
    return std::string(kElementName[static_cast<std::size_t>(element.type)]) + " " +
           std::to_string(element.index) + " at " + place_text(element.place) + ", scaled Jacobian " +
           rounded_text(element.scaled_jacobian, 4);
}

std::string quality_text(const QualityReport& report, const Features* features) {
    std::string text = shapes_text(report);
    if (!report.worst.empty()) text += "  worst elements\n";
    for (const WorstElement& element : report.worst) {
        const std::string kind = report.has_model ? std::string(" (") + kind_name(element.kind) + ")" : "";
        text += format("    %.3g, angles %.3g to %.3g, %s %llu%s at ", element.scaled_jacobian,
                       element.min_dihedral, element.max_dihedral,
                       kElementName[static_cast<std::size_t>(element.type)],
                       static_cast<unsigned long long>(element.index), kind.c_str()) +
                place_text(element.place) + (element.cause.empty() ? "" : ": " + element.cause) + "\n";
    }
    return report.has_model ? text + model_text(report, features) : text;
}

Json quality_document(const QualityReport& report, const Features* features) {
    Json json;
    json["scaled_jacobian"] = Json::object();
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const ElementShape& shape = report.shapes[t];
        if (shape.count == 0) {
            json["scaled_jacobian"][kElementNames[t]] = nullptr;
            continue;
        }
        json["scaled_jacobian"][kElementNames[t]] = {{"count", shape.count},
                                                     {"min", shape.minimum},
                                                     {"percentile_1", shape.percentile},
                                                     {"mean", shape.mean},
                                                     {"not_positive", shape.not_positive},
                                                     {"histogram", shape.histogram}};
    }
    const AngleFigures& angles = report.angles;
    json["dihedral_angles"] = {{"count", angles.count},
                               {"min", angles.minimum},
                               {"percentile_1", angles.low_percentile},
                               {"percentile_99", angles.high_percentile},
                               {"max", angles.maximum},
                               {"histogram", angles.histogram}};
    json["worst"] = Json::array();
    for (const WorstElement& element : report.worst) {
        Json item = {{"type", kElementName[static_cast<std::size_t>(element.type)]},
                     {"index", element.index},
                     {"scaled_jacobian", element.scaled_jacobian},
                     {"min_dihedral", element.min_dihedral},
                     {"max_dihedral", element.max_dihedral},
                     {"place", element.place}};
        // A mesh of another program has neither.
        if (report.has_model) {
            item["kind"] = kind_name(element.kind);
            item["cause"] = element.cause;
        }
        json["worst"].push_back(item);
    }
    if (report.has_model) add_model(report, features, json);
    return json;
}

}  // namespace mortise::cli
