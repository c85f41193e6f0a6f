#include "host/io/facet_groups.hpp"

#include <map>
#include <tuple>

namespace mortise::io {

FacetGroups group_facets(const FacetBlock& facets) {
    std::map<std::tuple<std::uint32_t, std::uint16_t, std::uint16_t>, std::uint32_t> numbers;
    for (std::size_t i = 0; i < facets.size(); ++i)
        numbers[{facets.surface[i], facets.inside[i], facets.outside[i]}] = 0;
    FacetGroups result;
    for (auto& [key, number] : numbers) {
        number = static_cast<std::uint32_t>(result.groups.size());
        result.groups.push_back({std::get<0>(key), std::get<1>(key), std::get<2>(key)});
    }
    result.of.reserve(facets.size());
    for (std::size_t i = 0; i < facets.size(); ++i)
        result.of.push_back(numbers[{facets.surface[i], facets.inside[i], facets.outside[i]}]);
    return result;
}

std::vector<std::string> group_names(const Mesh& mesh, const std::vector<FacetGroup>& groups) {
    std::vector<int> groups_of_surface(mesh.surface_names.size(), 0);
    for (const FacetGroup& group : groups) ++groups_of_surface[group.surface];
    std::vector<std::string> names;
    for (const FacetGroup& group : groups) {
        std::string name = mesh.surface_names[group.surface];
        if (groups_of_surface[group.surface] > 1) {
            name += ":" + mesh.region_names[group.inside - 1u];
            if (group.outside != 0) name += "|" + mesh.region_names[group.outside - 1u];
        }
        names.push_back(name);
    }
    return names;
}

std::string unique_name(const std::string& name, std::set<std::string>& taken) {
    std::string unique = name;
    for (int number = 2; !taken.insert(unique).second; ++number) unique = name + "_" + std::to_string(number);
    return unique;
}

}  // namespace mortise::io
