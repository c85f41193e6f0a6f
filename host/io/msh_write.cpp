// Writes .msh: Gmsh 4.1, binary.
//
// Volume entity r and physical volume r are region r. Facets with the same surface and regions form a surface
// entity and a physical surface of its own, named like the model's surface; where a surface has facets
// between several pairs of regions, ":inside" or ":inside|outside" follows. A volume lists the surface
// entities around it, negative where it lies in front of them. All nodes belong to the first volume entity:
// Gmsh accepts any classification, and ours has no curves or points.
//
// Element tags number facets, then elements, in mesh order, so that the grouping by entities loses nothing.
// What Gmsh has no place for stands in a $Comments section: names as they are, each surface entity's surface
// and regions, and each periodic link's pair of planes. The `kind` of elements is not stored. A mesh of
// second order has Gmsh's types of second order throughout, facets included. Surface entities that are copies
// of others (Mesh::periodic) are linked in $Periodic, with their nodes.
#include <algorithm>
#include <limits>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/common/periodic_originals.hpp"
#include "host/common/sort_unique.hpp"
#include "host/common/vec3.hpp"
#include "host/io/coordinates.hpp"
#include "host/io/element_table.hpp"
#include "host/io/facet_groups.hpp"
#include "host/io/formats.hpp"
#include "host/io/msh_format.hpp"
#include "host/io/periodic_links.hpp"

namespace mortise::io {
namespace {

/// Elements or facets of one entity and one Gmsh type.
struct Block {
    int dimension;
    int entity;
    int type;
    std::vector<std::size_t> items;
};

struct Box {
    double low[3] = {0, 0, 0};
    double high[3] = {0, 0, 0};
    bool empty = true;
    void add(const Vec3& p) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis] = empty ? p[axis] : std::min(low[axis], p[axis]);
            high[axis] = empty ? p[axis] : std::max(high[axis], p[axis]);
        }
        empty = false;
    }
};

class MshWriter {
  public:
    MshWriter(const Mesh& mesh, const MeshFileOptions& options, TemporaryFile& file)
        : mesh_(mesh),
          points_(mesh.points, options.scale),
          scale_(options.scale),
          file_(file),
          second_order_(mesh.is_second_order()) {}

    void write() {
        list_blocks();
        file_.write("$MeshFormat\n4.1 1 8\n");
        file_.put<int>(1);
        file_.write("\n$EndMeshFormat\n");
        write_comments();
        write_physical_names();
        write_entities();
        write_nodes();
        write_elements();
        write_periodic();
    }

  private:
    int regions() const { return static_cast<int>(mesh_.region_names.size()); }

    void list_blocks() {
        const FacetBlock& facets = mesh_.facets;
        FacetGroups grouped = group_facets(facets);
        groups_ = std::move(grouped.groups);
        links_ = periodic_links(mesh_, grouped.of);
        for (int entity = 1; entity <= static_cast<int>(groups_.size()); ++entity) {
            blocks_.push_back({2, entity, second_order_ ? kGmshSecondTriangle : kGmshTriangle, {}});
            blocks_.push_back({2, entity, second_order_ ? kGmshSecondQuadrilateral : kGmshQuadrilateral, {}});
        }
        for (std::size_t i = 0; i < facets.size(); ++i)
            blocks_[2 * std::size_t{grouped.of[i]} + (facets.facet(i).size() == 3 ? 0 : 1)].items.push_back(
                i);
    }

    void write_comments() {
        std::string text = "$Comments\n" + std::string(kMshSignature) + "\n";
        text += "regions " + std::to_string(mesh_.region_names.size()) + "\n";
        for (const std::string& name : mesh_.region_names) text += "name " + encode_name(name) + "\n";
        text += "surfaces " + std::to_string(mesh_.surface_names.size()) + "\n";
        for (const std::string& name : mesh_.surface_names) text += "name " + encode_name(name) + "\n";
        text += "groups " + std::to_string(groups_.size()) + "\n";
        for (const FacetGroup& group : groups_)
            text += std::to_string(group.surface) + " " + std::to_string(group.inside) + " " +
                    std::to_string(group.outside) + "\n";
        text += std::string(second_order_ ? kMshSecondCounts : kMshCounts) + " " +
                std::to_string(mesh_.facets.size());
        for (const ElementBlock& block : mesh_.elements) text += " " + std::to_string(block.size());
        text += "\n";
        if (!links_.empty()) {
            text += std::string(kMshPeriodic) + " " + std::to_string(mesh_.periodic.size()) + " " +
                    std::to_string(links_.size()) + "\n";
            for (const PeriodicLink& link : links_) text += std::to_string(link.pair) + "\n";
        }
        file_.write(text + "$EndComments\n");
    }

    /// The name without what would end it early in a file, made unique by a number.
    static std::string physical_name(std::string name, std::set<std::string>& taken) {
        for (char& c : name) {
            if (c == '"' || static_cast<unsigned char>(c) < 0x20) c = '_';
        }
        return unique_name(name, taken);
    }

    void write_physical_names() {
        std::string text =
            "$PhysicalNames\n" + std::to_string(groups_.size() + mesh_.region_names.size()) + "\n";
        std::set<std::string> taken;
        const std::vector<std::string> names = group_names(mesh_, groups_);
        for (std::size_t i = 0; i < names.size(); ++i)
            text += "2 " + std::to_string(i + 1) + " \"" + physical_name(names[i], taken) + "\"\n";
        taken.clear();
        for (std::size_t i = 0; i < mesh_.region_names.size(); ++i)
            text +=
                "3 " + std::to_string(i + 1) + " \"" + physical_name(mesh_.region_names[i], taken) + "\"\n";
        file_.write(text + "$EndPhysicalNames\n");
    }

    void put_entity(int tag, const Box& box, const std::vector<int>& bounding) {
        file_.put<int>(tag);
        file_.write(box.low, sizeof box.low);
        file_.write(box.high, sizeof box.high);
        file_.put<std::uint64_t>(1);  // physical groups: the one of the same number
        file_.put<int>(tag);
        file_.put<std::uint64_t>(bounding.size());
        file_.write(bounding.data(), bounding.size() * sizeof(int));
    }

    Vec3 point(NodeId node) const {
        const std::size_t first = 3 * std::size_t{node};
        return {points_[first], points_[first + 1], points_[first + 2]};
    }

    void write_entities() {
        std::vector<Box> surface_boxes(groups_.size()), volume_boxes(mesh_.region_names.size());
        for (const Block& block : blocks_) {
            for (const std::size_t i : block.items) {
                for (std::size_t k = 4 * i; k < 4 * i + 4; ++k)
                    surface_boxes[static_cast<std::size_t>(block.entity - 1)].add(
                        point(mesh_.facets.nodes[k]));
            }
        }
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            const ElementBlock& block = mesh_.elements[t];
            for (std::size_t i = 0; i < block.nodes.size(); ++i)
                volume_boxes[block.region[i / nodes_per_element(t)] - 1u].add(point(block.nodes[i]));
        }
        std::vector<std::vector<int>> bounding(mesh_.region_names.size());
        for (std::size_t i = 0; i < groups_.size(); ++i) {
            const int tag = static_cast<int>(i + 1);
            bounding[groups_[i].inside - 1u].push_back(tag);
            if (groups_[i].outside != 0) bounding[groups_[i].outside - 1u].push_back(-tag);
        }
        file_.write("$Entities\n");
        for (const std::size_t count :
             {std::size_t{0}, std::size_t{0}, groups_.size(), mesh_.region_names.size()})
            file_.put<std::uint64_t>(count);
        for (std::size_t i = 0; i < groups_.size(); ++i)
            put_entity(static_cast<int>(i + 1), surface_boxes[i], {});
        for (std::size_t i = 0; i < volume_boxes.size(); ++i)
            put_entity(static_cast<int>(i + 1), volume_boxes[i], bounding[i]);
        file_.write("\n$EndEntities\n");
    }

    void write_nodes() {
        const std::uint64_t count = mesh_.node_count();
        file_.write("$Nodes\n");
        for (const std::uint64_t value : {std::uint64_t{count > 0}, count, std::uint64_t{count > 0}, count})
            file_.put(value);
        if (count > 0) {
            file_.put<int>(3);
            file_.put<int>(1);
            file_.put<int>(0);  // no parameters
            file_.put(count);
            for (std::uint64_t tag = 1; tag <= count; ++tag) file_.put(tag);
            points_.write(file_);
        }
        file_.write("\n$EndNodes\n");
    }

    void write_elements() {
        // Which elements each region has, by type, in mesh order.
        std::vector<std::size_t> counts(kElementTypes * static_cast<std::size_t>(regions()), 0);
        const auto slot = [this](std::size_t t, std::size_t region) {
            return t * static_cast<std::size_t>(regions()) + region - 1;
        };
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            for (const std::uint16_t region : mesh_.elements[t].region) ++counts[slot(t, region)];
        }
        std::uint64_t entity_blocks = 0;
        for (const Block& block : blocks_) entity_blocks += !block.items.empty();
        for (const std::size_t count : counts) entity_blocks += count != 0;
        const std::uint64_t total = mesh_.facets.size() + mesh_.element_count();
        file_.write("$Elements\n");
        for (const std::uint64_t value : {entity_blocks, total, std::uint64_t{total > 0}, total})
            file_.put(value);
        for (const Block& block : blocks_) {
            if (block.items.empty()) continue;
            put_block_header(block.dimension, block.entity, block.type, block.items.size());
            const bool is_triangle = block.type == kGmshTriangle || block.type == kGmshSecondTriangle;
            for (const std::size_t i : block.items) put_facet(i, is_triangle ? 3 : 4);
        }
        std::uint64_t first_tag = mesh_.facets.size() + 1;
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            write_type(t, first_tag, counts.data() + (regions() > 0 ? slot(t, 1) : 0));
            first_tag += mesh_.elements[t].size();
        }
        file_.write("\n$EndElements\n");
    }

    /// One block per region that has elements of type t; `counts` says how many, by region.
    void write_type(std::size_t t, std::uint64_t first_tag, const std::size_t* counts) {
        const ElementBlock& block = mesh_.elements[t];
        const FormatElement& format = kElementTable[t].gmsh;
        const std::size_t corners = nodes_per_element(t), middles = middles_per_element(t);
        const auto put = [&](std::size_t i) {
            NodeId nodes[kMostNodes];
            for (std::size_t k = 0; k < corners; ++k)
                nodes[k] = block.nodes[corners * i + at(format.nodes[k])];
            for (std::size_t k = 0; second_order_ && k < middles; ++k)
                nodes[corners + k] = block.middles[middles * i + at(format.middles[k])];
            put_element(first_tag + i, nodes, all_nodes_per_element(t, second_order_));
        };
        // With one region the elements are in order already; else a stable counting sort brings them there.
        std::vector<std::size_t> order;
        if (regions() > 1) {
            std::vector<std::size_t> cursor(static_cast<std::size_t>(regions()) + 1, 0);
            for (std::size_t r = 0; r < static_cast<std::size_t>(regions()); ++r)
                cursor[r + 1] = cursor[r] + counts[r];
            order.resize(block.size());
            for (std::size_t i = 0; i < block.size(); ++i) order[cursor[block.region[i] - 1u]++] = i;
        }
        std::size_t next = 0;
        for (int region = 1; region <= regions(); ++region) {
            const std::size_t count = counts[region - 1];
            if (count == 0) continue;
            put_block_header(3, region, format.type_of(second_order_), count);
            for (const std::size_t end = next + count; next < end; ++next)
                put(order.empty() ? next : order[next]);
        }
    }

    /// One link for each surface entity that is a copy of another.
    void write_periodic() {
        if (links_.empty()) return;
        file_.write("$Periodic\n");
        file_.put<std::uint64_t>(links_.size());
        std::vector<NodeId> originals;  // of the pair's nodes; links come by pair
        std::size_t known = mesh_.periodic.size();
        for (const PeriodicLink& link : links_) {
            const PeriodicNodes& pair = mesh_.periodic[link.pair];
            if (link.pair != known) originals = originals_of(pair, mesh_.node_count());
            known = link.pair;
            file_.put<int>(2);
            file_.put<int>(static_cast<int>(link.copy) + 1);
            file_.put<int>(static_cast<int>(link.original) + 1);
            double map[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
            for (std::size_t j = 0; j < 3; ++j) map[4 * j + 3] = pair.shift[j] * scale_;
            file_.put<std::uint64_t>(16);
            file_.write(map, sizeof map);
            const std::vector<NodeId> nodes = nodes_of(link.copy);
            file_.put<std::uint64_t>(nodes.size());
            for (const NodeId node : nodes) {
                file_.put(std::uint64_t{node} + 1);
                file_.put(std::uint64_t{originals[node]} + 1);
            }
        }
        file_.write("\n$EndPeriodic\n");
    }

    /// The nodes of a group's facets, ascending.
    std::vector<NodeId> nodes_of(std::uint32_t group) const {
        std::vector<NodeId> nodes;
        for (const std::size_t block : {2 * std::size_t{group}, 2 * std::size_t{group} + 1}) {
            for (const std::size_t f : blocks_[block].items) {
                for (std::size_t k = 4 * f; k < 4 * f + 4; ++k) {
                    nodes.push_back(mesh_.facets.nodes[k]);
                    if (second_order_) nodes.push_back(mesh_.facets.middles[k]);
                }
            }
        }
        sort_unique(nodes);
        return nodes;
    }

    void put_block_header(int dimension, int entity, int type, std::uint64_t count) {
        file_.put(dimension);
        file_.put(entity);
        file_.put(type);
        file_.put(count);
    }

    static std::size_t at(int index) { return static_cast<std::size_t>(index); }

    /// A triangle or a quadrilateral: its corners, then the middles of its edges.
    void put_facet(std::size_t i, std::size_t corners) {
        NodeId nodes[8];
        std::copy_n(mesh_.facets.nodes.data() + 4 * i, corners, nodes);
        if (second_order_) std::copy_n(mesh_.facets.middles.data() + 4 * i, corners, nodes + corners);
        put_element(i + 1, nodes, second_order_ ? 2 * corners : corners);
    }

    static constexpr std::size_t kMostNodes = 20;  ///< of an element

    void put_element(std::uint64_t tag, const NodeId* nodes, std::size_t count) {
        std::uint64_t line[1 + kMostNodes];
        line[0] = tag;
        for (std::size_t k = 0; k < count; ++k) line[k + 1] = std::uint64_t{nodes[k]} + 1;
        file_.write(line, (count + 1) * sizeof line[0]);
    }

    const Mesh& mesh_;
    const Coordinates points_;
    const double scale_;
    TemporaryFile& file_;
    const bool second_order_;
    std::vector<FacetGroup> groups_;  ///< surface entity i + 1
    std::vector<PeriodicLink> links_;
    std::vector<Block> blocks_;  ///< triangles and quadrilaterals of each group
};

}  // namespace

void write_msh(const Mesh& mesh, const MeshFileOptions& options, TemporaryFile& file) {
    MshWriter(mesh, options, file).write();
}

}  // namespace mortise::io
