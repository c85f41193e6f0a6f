#include "host/pipeline/names.hpp"

#include <algorithm>

#include "host/common/facet_middle.hpp"
#include "host/common/parallel.hpp"
#include "host/tape/face_names.hpp"
#include "mortise/error.hpp"

namespace mortise::pipeline {
namespace {

constexpr std::size_t kFacetChunk = 4096;

}  // namespace

void name_surfaces(const tape::CompiledModel& compiled, const tape::BoundModel& model, int threads,
                   Mesh& mesh) {
    std::vector<std::uint32_t>& surface = mesh.facets.surface;
    const tape::FaceNames names(compiled, model);
    parallel_chunks(surface.size(), kFacetChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t f = begin; f < end; ++f) {
            // Only where several solids have a surface does the place tell.
            const Vec3 middle = model.namesakes.empty() ? Vec3{} : facet_middle(mesh, f);
            surface[f] = names.name(surface[f], mesh.facets.inside[f], middle);
        }
    });
    std::vector<std::uint32_t> place(compiled.surface_names.size(), 0xffffffffu);
    for (const std::uint32_t name : surface) place[name] = 0;
    for (std::size_t i = 0; i < place.size(); ++i) {
        if (place[i] != 0) continue;
        place[i] = static_cast<std::uint32_t>(mesh.surface_names.size());
        mesh.surface_names.push_back(compiled.surface_names[i]);
    }
    for (std::uint32_t& name : surface) name = place[name];
}

void refuse_name(const std::string& name, const tape::CompiledModel& compiled) {
    std::string known;
    for (const auto* names : {&compiled.region_names, &compiled.surface_names}) {
        for (const std::string& other : *names) {
            if (known.size() < 200) known += (known.empty() ? "" : ", ") + other;
        }
    }
    throw Error(ExitCode::kUsage, "no region or surface is called '" + name + "'; this model has " + known);
}

void check_names(const std::vector<std::string>& names, const tape::CompiledModel& compiled) {
    for (const std::string& name : names) {
        bool found = false;
        for (const auto* known : {&compiled.region_names, &compiled.surface_names})
            found = found || std::find(known->begin(), known->end(), name) != known->end();
        if (!found) refuse_name(name, compiled);
    }
}

}  // namespace mortise::pipeline
