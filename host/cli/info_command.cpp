// `mortise info MODEL`: what a model file holds, without meshing it.
#include <array>

#include "host/cli/commands.hpp"
#include "host/cli/documents.hpp"
#include "host/cli/files.hpp"
#include "host/cli/progress.hpp"
#include "host/cli/text.hpp"

namespace mortise::cli {
namespace {

/// By Primitive::Kind.
constexpr std::array<const char*, 9> kPrimitiveNames = {
    "convex", "sphere", "cylinder", "cone", "double_cone", "torus", "expression", "polyhedron", "rounded"};
static_assert(kPrimitiveNames.size() == static_cast<std::size_t>(Primitive::Kind::kRounded) + 1);

/// Bounds and surfaces; the text names the first of many.
void add_summary(const ModelSummary& summary, Json& document, std::string& text) {
    constexpr std::size_t kMostNames = 12;
    document["bounds"] = nullptr;
    if (summary.bounds) {
        document["bounds"] = {{"min", summary.bounds->min}, {"max", summary.bounds->max}};
        text += "  bounds     " + place_text(summary.bounds->min) + " to " + place_text(summary.bounds->max) +
                ", roughly\n";
    } else {
        document["unbounded"] = summary.unbounded;
        text += "  bounds     none: " + one_line(summary.unbounded) + "\n";
    }
    document["surfaces"] = Json::array();
    text += "  surfaces   " + std::to_string(summary.surfaces.size());
    for (std::size_t i = 0; i < summary.surfaces.size(); ++i) {
        const double size = summary.surface_size[i];
        document["surfaces"].push_back(
            {{"name", summary.surfaces[i]}, {"max_size", size > 0 ? Json(size) : Json(nullptr)}});
        if (i == kMostNames) text += ", ...";
        if (i >= kMostNames) continue;
        text += (i == 0 ? ": " : ", ") + summary.surfaces[i] +
                (size > 0 ? " (element size " + rounded_text(size, 4) + ")" : "");
    }
    text += "\n";
}

}  // namespace

ExitCode info_command(const Arguments& arguments) {
    const Model model = read_model(arguments.file, arguments.read);
    std::array<std::uint64_t, kPrimitiveNames.size()> primitives{};
    for (const CsgNode& node : model.nodes) {
        if (node.op == CsgNode::Op::kPrimitive) ++primitives[static_cast<std::size_t>(node.primitive.kind)];
    }
    Json document;
    document["file"] = arguments.file;
    std::string text = arguments.file + ": " + counted(model.nodes.size(), "node") + "\n";
    document["nodes"] = model.nodes.size();
    document["regions"] = Json::array();
    for (const Region& region : model.regions) {
        document["regions"].push_back(
            {{"name", region.name},
             {"max_size", region.max_size > 0 ? Json(region.max_size) : Json(nullptr)},
             {"metadata", region.metadata}});
        text += "  region     " + region.name +
                (region.max_size > 0 ? ", element size " + rounded_text(region.max_size, 4) : "") +
                (region.metadata.empty() ? "" : ", " + one_line(region.metadata)) + "\n";
    }
    document["primitives"] = Json::object();
    for (std::size_t k = 0; k < primitives.size(); ++k) {
        document["primitives"][kPrimitiveNames[k]] = primitives[k];
        if (primitives[k] == 0) continue;
        text +=
            "  primitive  " + std::string(kPrimitiveNames[k]) + ": " + std::to_string(primitives[k]) + "\n";
    }
    document["box"] = nullptr;
    if (model.clip) {
        document["box"] = {{"min", model.clip->min}, {"max", model.clip->max}};
        text += "  box        " + place_text(model.clip->min) + " to " + place_text(model.clip->max) + "\n";
    }
    document["size_hints"] = model.hints.size();
    if (!model.hints.empty())
        text +=
            "  hints      " + std::to_string(model.hints.size()) + " places where small cells are wanted\n";
    document["periodic"] = Json::array();
    for (const PeriodicPair& pair : model.periodic) {
        document["periodic"].push_back(pair.name);
        text += "  periodic   " + pair.name + "\n";
    }
    add_summary(summarize(model), document, text);
    document["warnings"] = model.warnings;
    print(arguments.json ? to_text(document) : text);
    Progress progress(true);
    for (const std::string& warning : model.warnings) progress.warn(warning);
    return ExitCode::kOk;
}

}  // namespace mortise::cli
