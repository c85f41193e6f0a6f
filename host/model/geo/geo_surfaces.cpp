// Names of surfaces in a .geo model: see geo_surfaces.hpp.
#include "host/model/geo/geo_surfaces.hpp"

#include <algorithm>
#include <unordered_map>
#include <unordered_set>

namespace mortise::model_reader {

std::vector<std::uint32_t> GeoSurfaces::reachable(std::uint32_t root, bool open_only) const {
    std::vector<std::uint32_t> found;
    std::vector<std::uint32_t> pending = {root};
    std::unordered_set<std::uint32_t> seen = {root};
    while (!pending.empty()) {
        const std::uint32_t node = pending.back();
        pending.pop_back();
        if (open_only && node < settled_.size() && settled_[node] != 0) continue;
        found.push_back(node);
        for (const std::uint32_t child : model_.nodes[node].children) {
            if (seen.insert(child).second) pending.push_back(child);
        }
    }
    std::sort(found.begin(), found.end());
    return found;
}

void GeoSurfaces::set_primitive(std::uint32_t node, const std::string& name) {
    CsgNode& primitive = model_.nodes[node];
    primitive.name = name;
    // One condition covers all faces of a brick.
    for (Plane& plane : primitive.primitive.planes) plane.name.clear();
    const auto& triangles = primitive.primitive.triangles;
    if (triangles == nullptr) return;
    auto plain = std::make_shared<TriangleSurface>(*triangles);
    plain->group.assign(plain->triangles.size(), 0);
    plain->group_names = {""};
    primitive.primitive.triangles = std::move(plain);
}

void GeoSurfaces::set_condition(std::uint32_t root, const std::string& name) {
    const std::vector<std::uint32_t> nodes = reachable(root, true);
    grow();
    for (const std::uint32_t node : nodes) {
        if (model_.nodes[node].op == CsgNode::Op::kPrimitive) set_primitive(node, name);
        settled_[node] = 1;
    }
}

void GeoSurfaces::set_face_conditions(std::uint32_t polyhedron, const std::vector<std::uint32_t>& face_of,
                                      const std::vector<std::string>& names, const std::string& prefix) {
    grow();
    if (settled_[polyhedron] != 0) return;
    settled_[polyhedron] = 1;
    CsgNode& node = model_.nodes[polyhedron];
    node.name = prefix;
    auto named = std::make_shared<TriangleSurface>(*node.primitive.triangles);
    named->group_names.clear();
    std::unordered_map<std::string, std::uint32_t> group_of;
    std::vector<std::uint32_t> group_of_face;
    for (const std::string& name : names) {
        const auto [entry, is_new] =
            group_of.emplace(name, static_cast<std::uint32_t>(named->group_names.size()));
        if (is_new) named->group_names.push_back(name);
        group_of_face.push_back(entry->second);
    }
    named->group.clear();
    for (const std::uint32_t face : face_of) named->group.push_back(group_of_face[face]);
    node.primitive.triangles = std::move(named);
}

std::vector<std::uint32_t> GeoSurfaces::primitives(std::uint32_t root) const {
    std::vector<std::uint32_t> found = reachable(root, false);
    found.erase(std::remove_if(
                    found.begin(), found.end(),
                    [this](std::uint32_t node) { return model_.nodes[node].op != CsgNode::Op::kPrimitive; }),
                found.end());
    return found;
}

std::vector<std::uint32_t> GeoSurfaces::common_primitives(std::uint32_t root, std::uint32_t region) const {
    const std::vector<std::uint32_t> inside = reachable(region, false);
    std::vector<std::uint32_t> found;
    for (const std::uint32_t node : reachable(root, false)) {
        const bool bounds = std::binary_search(inside.begin(), inside.end(), node);
        if (bounds && model_.nodes[node].op == CsgNode::Op::kPrimitive) found.push_back(node);
    }
    return found;
}

bool GeoSurfaces::set_size(std::uint32_t root, std::uint32_t region, double size) {
    const std::vector<std::uint32_t> targets = common_primitives(root, region);
    for (const std::uint32_t node : targets) {
        double& wish = model_.nodes[node].surface_size;
        if (wish == 0 || size < wish) wish = size;
    }
    return !targets.empty();
}

bool GeoSurfaces::override_condition(std::uint32_t root, std::uint32_t region,
                                     const std::vector<std::uint32_t>& other_regions,
                                     const std::string& name) {
    const std::vector<std::uint32_t> targets = common_primitives(root, region);
    for (const std::uint32_t other : other_regions) {
        const std::vector<std::uint32_t> elsewhere = reachable(other, false);
        for (const std::uint32_t node : targets) {
            if (std::binary_search(elsewhere.begin(), elsewhere.end(), node)) return false;
        }
    }
    for (const std::uint32_t node : targets) set_primitive(node, name);
    return true;
}

void GeoSurfaces::set_solid(std::uint32_t first, const std::string& solid) {
    for (std::size_t node = first; node < model_.nodes.size(); ++node) {
        CsgNode& primitive = model_.nodes[node];
        if (primitive.op == CsgNode::Op::kPrimitive && primitive.name.empty()) primitive.name = solid;
    }
}

std::uint32_t GeoSurfaces::copy(std::uint32_t node, std::uint32_t first) {
    const std::vector<std::uint32_t> nodes = reachable(node, true);
    // Ascending order: children come first, so a parent knows whether any of them was copied.
    std::unordered_map<std::uint32_t, std::uint32_t> copies;
    for (const std::uint32_t original : nodes) {
        CsgNode twin = model_.nodes[original];
        bool changed = original < first;
        for (std::uint32_t& child : twin.children) {
            const auto found = copies.find(child);
            if (found == copies.end()) continue;
            child = found->second;
            changed = true;
        }
        if (changed) copies[original] = model_.add(std::move(twin));
    }
    const auto found = copies.find(node);
    return found == copies.end() ? node : found->second;
}

}  // namespace mortise::model_reader
