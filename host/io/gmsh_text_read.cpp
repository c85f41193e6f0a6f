// Reads .msh files of other programs: Gmsh's text formats 4.1 and 2.2, elements of first or second order
// (serendipity: without nodes in faces and inside).
//
// Only volume elements are taken, and the nodes that they use, in the file's order. Each volume entity
// becomes a region; the facets are the boundary and the interfaces between regions, without the model's
// surfaces.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "host/common/face_key.hpp"
#include "host/io/element_table.hpp"
#include "host/io/formats.hpp"

namespace mortise::io {
namespace {

/// Points, lines, triangles and quadrilaterals, which are left out.
constexpr std::array<int, 8> kLowerTypes = {
    15, 1, kGmshTriangle, kGmshQuadrilateral, 8, kGmshSecondTriangle, 10, kGmshSecondQuadrilateral};

/// Numbers of one line.
class Line {
  public:
    Line(const FileReader& file, std::string text) : file_(file), text_(std::move(text)) {}

    double number() {
        // Not strtod, which reads 1.5 as 1 where a program has set a locale with decimal commas.
        while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
        if (at_ + 1 < text_.size() && text_[at_] == '+' && text_[at_ + 1] != '-') ++at_;
        long double value = 0;  // what is too small for a double is 0
        const char* const end = text_.data() + text_.size();
        const auto [next, failure] = std::from_chars(text_.data() + at_, end, value);
        if (failure == std::errc::invalid_argument)
            file_.damaged("'" + text_.substr(0, 40) + "' found, expected more numbers");
        const auto result = static_cast<double>(value);
        if (failure != std::errc() || !std::isfinite(result))
            file_.damaged("'" + text_.substr(0, 40) + "' found, expected finite numbers");
        at_ = static_cast<std::size_t>(next - text_.data());
        return result;
    }
    std::uint64_t whole() {
        const double value = number();
        if (!(value >= 0 && value <= 9e15 && value == std::floor(value))) {
            file_.damaged("'" + text_.substr(0, 40) + "' found, expected whole numbers");
        }
        return static_cast<std::uint64_t>(value);
    }

  private:
    const FileReader& file_;
    std::string text_;
    std::size_t at_ = 0;
};

class GmshTextReader {
  public:
    explicit GmshTextReader(const FileReader& file) : file_(file), bytes_(file) {}

    Mesh read() {
        if (text() != "$MeshFormat") file_.damaged("it does not begin with $MeshFormat");
        Line format = line();
        const double version = format.number();
        if (format.number() != 0)
            file_.damaged("a binary Gmsh file that mortise did not write; save it as text");
        if (version != 4.1 && version != 2.2) file_.damaged("expected Gmsh format 4.1 or 2.2");
        skip_to("$EndMeshFormat");
        while (bytes_.remaining() > 0) {
            const std::string section = text();
            if (section == "$Nodes") {
                version == 4.1 ? read_nodes_4() : read_nodes_2();
                skip_to("$EndNodes");
            } else if (section == "$Elements") {
                version == 4.1 ? read_elements_4() : read_elements_2();
                skip_to("$EndElements");
            } else if (!section.empty() && section[0] == '$') {
                skip_to("$End" + section.substr(1));
            }
        }
        if (mesh_.element_count() == 0) file_.damaged("no volume elements in it");
        number_regions();
        take_used_nodes();
        list_facets();
        return std::move(mesh_);
    }

  private:
    std::string text() {
        std::string line = bytes_.line();
        while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
        return line;
    }
    Line line() { return {file_, text()}; }
    void skip_to(const std::string& end) {
        while (text() != end) continue;  // the end of the file throws
    }

    void add_node(std::uint64_t tag, Line& coordinates) {
        if (!places_.emplace(tag, static_cast<NodeId>(mesh_.node_count())).second) {
            file_.damaged("node " + std::to_string(tag) + " is listed twice");
        }
        if (mesh_.node_count() >= kNoNode) file_.damaged("too many nodes");
        for (int j = 0; j < 3; ++j) mesh_.points.push_back(coordinates.number());
    }

    void read_nodes_4() {
        const std::uint64_t blocks = line().whole();
        for (std::uint64_t b = 0; b < blocks; ++b) {
            Line head = line();
            for (int skipped = 0; skipped < 3; ++skipped) head.number();
            const std::uint64_t count = head.whole();
            bytes_.expect(count, 2);
            std::vector<std::uint64_t> tags;
            for (std::uint64_t i = 0; i < count; ++i) tags.push_back(line().whole());
            for (const std::uint64_t tag : tags) {
                Line coordinates = line();
                add_node(tag, coordinates);
            }
        }
    }

    void read_nodes_2() {
        const std::uint64_t count = line().whole();
        for (std::uint64_t i = 0; i < count; ++i) {
            Line node = line();
            const std::uint64_t tag = node.whole();
            add_node(tag, node);
        }
    }

    /// Our type of an element and whether it is of second order.
    std::pair<std::size_t, bool> type_of(std::uint64_t type) const {
        for (const bool second_order : {false, true}) {
            for (std::size_t t = 0; t < kElementTypes; ++t) {
                if (static_cast<std::uint64_t>(kElementTable[t].gmsh.type_of(second_order)) == type)
                    return {t, second_order};
            }
        }
        file_.damaged("element type " + std::to_string(type) +
                      "; elements of first order can be read, and of second order those of 20, 15, 13 and 10 "
                      "nodes");
    }

    NodeId node_of(std::uint64_t tag) const {
        const auto found = places_.find(tag);
        if (found == places_.end())
            file_.damaged("an element uses node " + std::to_string(tag) + ", which is not there");
        return found->second;
    }

    /// One element; its type and entity are known, the nodes come next.
    void add_element(std::uint64_t type, std::uint64_t entity, Line& nodes) {
        for (const int lower : kLowerTypes) {
            if (type == static_cast<std::uint64_t>(lower)) return;
        }
        const auto [t, second_order] = type_of(type);
        if (mesh_.element_count() > 0 && second_order != mesh_.is_second_order())
            file_.damaged("elements of first and of second order in one mesh");
        ElementBlock& block = mesh_.elements[t];
        const FormatElement& format = kElementTable[t].gmsh;
        const auto read = [&](std::vector<NodeId>& list, std::size_t count, const auto& order) {
            const std::size_t first = list.size();
            list.resize(first + count);
            for (std::size_t k = 0; k < count; ++k)
                list[first + static_cast<std::size_t>(order[k])] = node_of(nodes.whole());
        };
        read(block.nodes, nodes_per_element(t), format.nodes);
        if (second_order) read(block.middles, middles_per_element(t), format.middles);
        const auto region = entities_.emplace(entity, entities_.size() + 1).first;
        if (region->second > 65535) file_.damaged("more than 65535 volume entities");
        block.region.push_back(static_cast<std::uint16_t>(region->second));
        block.kind.push_back(static_cast<std::uint8_t>(ElementKind::kCnio));
    }

    void read_elements_4() {
        const std::uint64_t blocks = line().whole();
        for (std::uint64_t b = 0; b < blocks; ++b) {
            Line head = line();
            head.number();
            const std::uint64_t entity = head.whole(), type = head.whole(), count = head.whole();
            for (std::uint64_t i = 0; i < count; ++i) {
                Line element = line();
                element.number();
                add_element(type, entity, element);
            }
        }
    }

    void read_elements_2() {
        const std::uint64_t count = line().whole();
        for (std::uint64_t i = 0; i < count; ++i) {
            Line element = line();
            element.number();
            const std::uint64_t type = element.whole(), tags = element.whole();
            std::uint64_t entity = 0;  // the second tag, the elementary entity
            for (std::uint64_t k = 0; k < tags; ++k) {
                const std::uint64_t tag = element.whole();
                if (k < 2) entity = tag;
            }
            add_element(type, entity, element);
        }
    }

    /// Regions in the order of their entities' tags.
    void number_regions() {
        std::vector<std::uint16_t> target(entities_.size() + 1, 0);
        for (const auto& [entity, region] : entities_) {
            mesh_.region_names.push_back("volume_" + std::to_string(entity));
            target[region] = static_cast<std::uint16_t>(mesh_.region_names.size());
        }
        for (ElementBlock& block : mesh_.elements) {
            for (std::uint16_t& region : block.region) region = target[region];
        }
    }

    void take_used_nodes() {
        std::vector<NodeId> place(mesh_.node_count(), kNoNode);
        for (const ElementBlock& block : mesh_.elements) {
            for (const auto* list : {&block.nodes, &block.middles}) {
                for (const NodeId node : *list) place[node] = 0;
            }
        }
        NodeId next = 0;
        for (std::size_t i = 0; i < place.size(); ++i) {
            if (place[i] == kNoNode) continue;
            for (std::size_t j = 0; j < 3; ++j)
                mesh_.points[3 * std::size_t{next} + j] = mesh_.points[3 * i + j];
            place[i] = next++;
        }
        mesh_.points.resize(3 * std::size_t{next});
        for (ElementBlock& block : mesh_.elements) {
            for (auto* list : {&block.nodes, &block.middles}) {
                for (NodeId& node : *list) node = place[node];
            }
        }
    }

    /// Nodes in the middles of a face's edges; a triangle repeats its last one.
    static std::array<NodeId, 4> middles_of(const ElementBlock& block, ElementType type, std::size_t element,
                                            const LocalFace& face) {
        const std::size_t corners = corner_count(face);
        const auto edges = static_cast<std::size_t>(local_edges(type).count);
        std::array<NodeId, 4> middles{};
        for (std::size_t k = 0; k < 4; ++k) {
            const std::size_t side = std::min(k, corners - 1);
            const int edge = local_edge(type, face[side], face[(side + 1) % corners]);
            middles[k] = block.middles[edges * element + static_cast<std::size_t>(edge)];
        }
        return middles;
    }

    /// Faces of elements without a partner, and those between two regions, seen from the lower region.
    void list_facets() {
        struct Face {
            FaceKey key;
            std::array<NodeId, 4> nodes;
            std::array<NodeId, 4> middles;  ///< of second order: as FacetBlock::middles
            std::uint16_t region;
        };
        const bool second_order = mesh_.is_second_order();
        std::vector<Face> faces;
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            const ElementBlock& block = mesh_.elements[t];
            const LocalFaces local = local_faces(static_cast<ElementType>(t));
            for (std::size_t i = 0; i < block.size(); ++i) {
                for (int f = 0; f < local.count; ++f) {
                    Face face{{}, {}, {}, block.region[i]};
                    for (std::size_t k = 0; k < 4; ++k) {
                        const int corner = local.faces[f][k];
                        face.key[k] =
                            corner < 0
                                ? kNoNode
                                : block.nodes[nodes_per_element(t) * i + static_cast<std::size_t>(corner)];
                        face.nodes[k] = corner < 0 ? face.nodes[k - 1] : face.key[k];
                    }
                    std::sort(face.key.begin(), face.key.end());
                    if (second_order)
                        face.middles = middles_of(block, static_cast<ElementType>(t), i, local.faces[f]);
                    faces.push_back(face);
                }
            }
        }
        std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
            return std::tie(a.key, a.region, a.nodes) < std::tie(b.key, b.region, b.nodes);
        });
        mesh_.surface_names = {"boundary", "interface"};
        for (std::size_t i = 0, j = 0; i < faces.size(); i = j) {
            while (j < faces.size() && faces[j].key == faces[i].key) ++j;
            const std::uint16_t outside = j - i == 1 ? std::uint16_t{0} : faces[j - 1].region;
            if (outside == faces[i].region) continue;
            mesh_.facets.nodes.insert(mesh_.facets.nodes.end(), faces[i].nodes.begin(), faces[i].nodes.end());
            if (second_order)
                mesh_.facets.middles.insert(mesh_.facets.middles.end(), faces[i].middles.begin(),
                                            faces[i].middles.end());
            mesh_.facets.surface.push_back(outside == 0 ? 0 : 1);
            mesh_.facets.inside.push_back(faces[i].region);
            mesh_.facets.outside.push_back(outside);
        }
    }

    const FileReader& file_;
    SequentialReader bytes_;
    Mesh mesh_;
    std::map<std::uint64_t, NodeId> places_;         ///< by tag
    std::map<std::uint64_t, std::size_t> entities_;  ///< region by the order of first use
};

}  // namespace

Mesh read_gmsh_text(const FileReader& file) { return GmshTextReader(file).read(); }

}  // namespace mortise::io
