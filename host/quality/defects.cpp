// Names of defects and the texts of their first examples.
#include "host/quality/defects.hpp"

#include <charconv>

#include "host/quality/vector.hpp"

namespace mortise::quality {
namespace {

constexpr std::size_t kKinds = static_cast<std::size_t>(DefectKind::kCount);

/// In the order of DefectKind.
constexpr std::array<const char*, kKinds> kTexts = {
    "arrays of unequal length",
    "element with a node index out of range",
    "listed facet with a node index out of range",
    "element with a region out of range",
    "element of unknown kind",
    "listed facet with a surface out of range",
    "listed facet with a region out of range",
    "surface name used twice",
    "hanging node with unusable masters",
    "hanging node that is not in the middle of its masters",
    "node with a coordinate that is not finite",
    "unused node",
    "coincident nodes",
    "node in the middle of an edge that is used elsewhere",
    "edge with two nodes in its middle",
    "listed facet with other nodes in the middles of its edges than elements",
    "element with a repeated node",
    "duplicate element",
    "hexahedron with non-positive Jacobian",
    "wedge with non-positive Jacobian",
    "pyramid with non-positive Jacobian",
    "tetrahedron with non-positive Jacobian",
    "facet shared by more than two elements",
    "facet with the same orientation in both elements",
    "quadrilaterals with the same nodes in different order",
    "quadrilateral against triangles",
    "face with a hanging node that no element has",
    "face with a hanging node between two regions",
    "boundary not closed",
    "listed facet that is no facet of an element",
    "listed facet between elements of one region",
    "facet listed twice",
    "listed facet with the wrong orientation",
    "listed facet with the wrong regions",
    "listed outer facets not closed",
    "boundary facet missing from the list",
    "interface facet missing from the list",
};

std::string mean_text(const Mesh& mesh, const NodeId* nodes, int count) {
    Vector sum;
    for (int i = 0; i < count; ++i) sum = sum + point_of(mesh, nodes[i]);
    const Vector mean = (1.0 / count) * sum;
    return "(" + number_text(mean.x) + ", " + number_text(mean.y) + ", " + number_text(mean.z) + ")";
}

}  // namespace

void DefectLog::merge(const DefectLog& later) {
    for (std::size_t i = 0; i < entries_.size(); ++i) {
        if (entries_[i].count == 0) entries_[i].first = later.entries_[i].first;
        entries_[i].count += later.entries_[i].count;
    }
}

bool DefectLog::empty() const {
    for (const Entry& entry : entries_) {
        if (entry.count != 0) return false;
    }
    return true;
}

std::vector<Defect> DefectLog::defects() const {
    std::vector<Defect> list;
    for (std::size_t i = 0; i < entries_.size(); ++i) {
        if (entries_[i].count != 0) list.push_back({kTexts[i], entries_[i].count, entries_[i].first});
    }
    return list;
}

const char* element_name(ElementType type) {
    constexpr const char* names[kElementTypes] = {"hexahedron", "wedge", "pyramid", "tetrahedron"};
    return names[static_cast<std::size_t>(type)];
}

std::string number_text(double value) {
    char text[32];
    return {text, std::to_chars(text, text + sizeof text, value, std::chars_format::general, 9).ptr};
}

std::string point_text(const Mesh& mesh, NodeId node) { return mean_text(mesh, &node, 1); }

std::string element_text(const Mesh& mesh, ElementType type, std::size_t element) {
    const int count = kElementNodes[static_cast<std::size_t>(type)];
    const NodeId* nodes = mesh.block(type).nodes.data() + static_cast<std::size_t>(count) * element;
    return std::string(element_name(type)) + " " + std::to_string(element) + " at " +
           mean_text(mesh, nodes, count);
}

std::string facet_text(const Mesh& mesh, const NodeId* nodes, int count) {
    std::string text = "facet (";
    for (int i = 0; i < count; ++i) text += (i == 0 ? "" : ", ") + std::to_string(nodes[i]);
    return text + ") at " + mean_text(mesh, nodes, count);
}

}  // namespace mortise::quality
