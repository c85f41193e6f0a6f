// Reads the .msh files of msh_write.cpp; text files go to gmsh_text_read.cpp, anything else is refused with a
// reason.
//
// Counts are compared with the bytes left in the file before anything is allocated for them.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "host/common/face_key.hpp"
#include "host/common/sort_unique.hpp"
#include "host/io/element_table.hpp"
#include "host/io/facet_groups.hpp"
#include "host/io/formats.hpp"
#include "host/io/msh_format.hpp"

namespace mortise::io {
namespace {

class MshReader {
  public:
    explicit MshReader(const FileReader& file) : file_(file), bytes_(file) {}

    Mesh read() {
        if (bytes_.line() != "$MeshFormat") file_.damaged("it does not begin with $MeshFormat");
        if (bytes_.line() != "4.1 1 8") file_.damaged("expected Gmsh format 4.1, binary, 8-byte sizes");
        if (bytes_.get<int>() != 1) file_.damaged("other byte order");
        expect_line("");
        expect_line("$EndMeshFormat");
        expect_line("$Comments");
        read_comments();
        expect_line("$PhysicalNames");
        while (bytes_.line() != "$EndPhysicalNames") continue;
        expect_line("$Entities");
        skip_entities();
        expect_line("$Nodes");
        read_nodes();
        expect_line("$Elements");
        read_elements();
        if (!pair_of_link_.empty()) {
            expect_line("$Periodic");
            read_periodic();
        }
        return std::move(mesh_);
    }

  private:
    void expect_line(const std::string& text) {
        const std::string line = bytes_.line();
        if (line != text) file_.damaged("'" + line.substr(0, 40) + "' found, expected '" + text + "'");
    }

    /// A line of a keyword, if not empty, and `count` numbers.
    std::vector<std::uint64_t> numbers(const std::string& keyword, std::size_t count) {
        return numbers_of(bytes_.line(), keyword, count);
    }

    std::vector<std::uint64_t> numbers_of(const std::string& line, const std::string& keyword,
                                          std::size_t count) {
        std::istringstream stream(line);
        std::string word;
        if (!keyword.empty()) stream >> word;
        std::vector<std::uint64_t> values(count);
        for (std::uint64_t& value : values) stream >> value;
        if (word != keyword || !stream || !(stream >> std::ws).eof() || line.find('-') != std::string::npos)
            file_.damaged("'" + line.substr(0, 40) + "' found, expected " + keyword + " and " +
                          std::to_string(count) + " numbers");
        return values;
    }

    std::vector<std::string> names(const std::string& keyword) {
        const std::uint64_t count = numbers(keyword, 1)[0];
        bytes_.expect(count, 6);
        std::vector<std::string> values(static_cast<std::size_t>(count));
        for (std::string& value : values) {
            const std::string line = bytes_.line();
            if (line.compare(0, 5, "name ") != 0 || !decode_name(line.substr(5), value))
                file_.damaged("'" + line.substr(0, 40) + "' found, expected a name");
        }
        return values;
    }

    void read_comments() {
        expect_line(kMshSignature);
        mesh_.region_names = names("regions");
        mesh_.surface_names = names("surfaces");
        const std::uint64_t groups = numbers("groups", 1)[0];
        bytes_.expect(groups, 6);
        for (std::uint64_t i = 0; i < groups; ++i) {
            const std::vector<std::uint64_t> values = numbers("", 3);
            if (values[0] >= mesh_.surface_names.size() || values[1] > 65535 || values[2] > 65535)
                file_.damaged("group " + std::to_string(i + 1) + " refers to what is not there");
            groups_.push_back({static_cast<std::uint32_t>(values[0]), static_cast<std::uint16_t>(values[1]),
                               static_cast<std::uint16_t>(values[2])});
        }
        const std::string line = bytes_.line();
        second_order_ = line.compare(0, std::string(kMshSecondCounts).size(), kMshSecondCounts) == 0;
        const std::vector<std::uint64_t> counts =
            numbers_of(line, second_order_ ? kMshSecondCounts : kMshCounts, 1 + kElementTypes);
        bytes_.expect(counts[0], 4 * sizeof(std::uint64_t));
        mesh_.facets.nodes.resize(4 * static_cast<std::size_t>(counts[0]));
        if (second_order_) mesh_.facets.middles.resize(mesh_.facets.nodes.size());
        mesh_.facets.surface.resize(static_cast<std::size_t>(counts[0]));
        mesh_.facets.inside.resize(static_cast<std::size_t>(counts[0]));
        mesh_.facets.outside.resize(static_cast<std::size_t>(counts[0]));
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            const std::size_t count = static_cast<std::size_t>(counts[t + 1]);
            bytes_.expect(count, (1 + all_nodes_per_element(t, second_order_)) * sizeof(std::uint64_t));
            mesh_.elements[t].nodes.resize(count * nodes_per_element(t));
            if (second_order_) mesh_.elements[t].middles.resize(count * middles_per_element(t));
            mesh_.elements[t].region.resize(count);
            mesh_.elements[t].kind.resize(count);
        }
        const std::string last = bytes_.line();
        if (last == "$EndComments") return;
        const std::vector<std::uint64_t> periodic = numbers_of(last, kMshPeriodic, 2);
        bytes_.expect(std::max(periodic[0], periodic[1]), 2);
        mesh_.periodic.resize(static_cast<std::size_t>(periodic[0]));
        for (std::uint64_t link = 0; link < periodic[1]; ++link) {
            pair_of_link_.push_back(static_cast<std::size_t>(numbers("", 1)[0]));
            if (pair_of_link_.back() >= mesh_.periodic.size()) file_.damaged("a periodic link of no pair");
        }
        expect_line("$EndComments");
    }

    void skip(std::uint64_t count, std::size_t size) {
        bytes_.expect(count, size);
        std::vector<char> ignored(size);
        for (std::uint64_t i = 0; i < count; ++i) bytes_.read(ignored.data(), size);
    }

    void skip_entities() {
        if (bytes_.get<std::uint64_t>() != 0 || bytes_.get<std::uint64_t>() != 0)
            file_.damaged("point or curve entities, which mortise does not write");
        const std::uint64_t surfaces = bytes_.get<std::uint64_t>(), volumes = bytes_.get<std::uint64_t>();
        bytes_.expect(surfaces, 1);
        bytes_.expect(volumes, 1);
        for (std::uint64_t i = 0; i < surfaces + volumes; ++i) {
            skip(1, sizeof(int) + 6 * sizeof(double));
            skip(bytes_.get<std::uint64_t>(), sizeof(int));
            skip(bytes_.get<std::uint64_t>(), sizeof(int));
        }
        expect_line("");
        expect_line("$EndEntities");
    }

    void read_nodes() {
        const std::uint64_t blocks = bytes_.get<std::uint64_t>(), count = bytes_.get<std::uint64_t>();
        skip(2, sizeof(std::uint64_t));
        if (blocks != (count > 0 ? 1u : 0u))
            file_.damaged("nodes in several blocks, which mortise does not write");
        if (count > 0) {
            skip(3, sizeof(int));
            if (bytes_.get<std::uint64_t>() != count) file_.damaged("numbers of nodes do not agree");
            bytes_.expect(count, sizeof(std::uint64_t) + 3 * sizeof(double));
            if (count >= kNoNode) file_.damaged("too many nodes");
            for (std::uint64_t tag = 1; tag <= count; ++tag) {
                if (bytes_.get<std::uint64_t>() != tag) file_.damaged("node tags out of order");
            }
            mesh_.points.resize(3 * static_cast<std::size_t>(count));
            bytes_.read(mesh_.points.data(), mesh_.points.size() * sizeof(double));
        }
        expect_line("");
        expect_line("$EndNodes");
    }

    void read_elements() {
        const std::uint64_t blocks = bytes_.get<std::uint64_t>(), total = bytes_.get<std::uint64_t>();
        skip(2, sizeof(std::uint64_t));
        if (total != mesh_.facets.size() + mesh_.element_count())
            file_.damaged("numbers of elements do not agree");
        seen_.assign(static_cast<std::size_t>(total), false);
        std::uint64_t read = 0;
        for (std::uint64_t i = 0; i < blocks; ++i) {
            const int dimension = bytes_.get<int>(), entity = bytes_.get<int>(), type = bytes_.get<int>();
            const std::uint64_t count = bytes_.get<std::uint64_t>();
            if (count == 0 || count > total - read) file_.damaged("numbers of elements do not agree");
            read += count;
            dimension == 2 ? read_facets(entity, type, count) : read_volume_elements(entity, type, count);
        }
        if (read != total) file_.damaged("numbers of elements do not agree");
        expect_line("");
        expect_line("$EndElements");
    }

    void read_periodic() {
        const std::uint64_t links = bytes_.get<std::uint64_t>();
        if (links != pair_of_link_.size()) file_.damaged("numbers of periodic links do not agree");
        std::vector<std::vector<std::pair<NodeId, NodeId>>> nodes(mesh_.periodic.size());
        for (const std::size_t pair : pair_of_link_) {
            skip(3, sizeof(int));
            double map[16];
            if (bytes_.get<std::uint64_t>() != std::size(map)) file_.damaged("a periodic link without a map");
            bytes_.read(map, sizeof map);
            mesh_.periodic[pair].shift = {map[3], map[7], map[11]};
            const std::uint64_t count = bytes_.get<std::uint64_t>();
            bytes_.expect(count, 2 * sizeof(std::uint64_t));
            for (std::uint64_t n = 0; n < count; ++n) {
                const NodeId node = next_node();
                nodes[pair].emplace_back(node, next_node());
            }
        }
        for (std::size_t pair = 0; pair < nodes.size(); ++pair) {
            // Surfaces of one plane share the nodes between them.
            sort_unique(nodes[pair]);
            for (const auto& [node, original] : nodes[pair]) {
                mesh_.periodic[pair].node.push_back(node);
                mesh_.periodic[pair].original.push_back(original);
            }
        }
        expect_line("");
        expect_line("$EndPeriodic");
    }

    /// The tag of the next element as an index in [first, first + count), not seen before, less `first`.
    std::size_t next_index(std::size_t first, std::size_t count) {
        const std::uint64_t tag = bytes_.get<std::uint64_t>();
        if (tag <= first || tag > first + count || seen_[static_cast<std::size_t>(tag - 1)])
            file_.damaged("element tag " + std::to_string(tag) + " out of range or used twice");
        seen_[static_cast<std::size_t>(tag - 1)] = true;
        return static_cast<std::size_t>(tag - 1) - first;
    }

    NodeId next_node() {
        const std::uint64_t tag = bytes_.get<std::uint64_t>();
        if (tag == 0 || tag > mesh_.node_count())
            file_.damaged("node tag " + std::to_string(tag) + " out of range");
        return static_cast<NodeId>(tag - 1);
    }

    void read_facets(int entity, int type, std::uint64_t count) {
        const int triangle = second_order_ ? kGmshSecondTriangle : kGmshTriangle;
        const int quadrilateral = second_order_ ? kGmshSecondQuadrilateral : kGmshQuadrilateral;
        if (entity < 1 || static_cast<std::size_t>(entity) > groups_.size() ||
            (type != triangle && type != quadrilateral))
            file_.damaged("surface elements of an unknown entity or type");
        const FacetGroup& group = groups_[static_cast<std::size_t>(entity - 1)];
        FacetBlock& facets = mesh_.facets;
        for (std::uint64_t i = 0; i < count; ++i) {
            const std::size_t at = next_index(0, facets.size());
            NodeId* nodes = facets.nodes.data() + 4 * at;
            read_corners(nodes, type == triangle);
            if (second_order_) read_corners(facets.middles.data() + 4 * at, type == triangle);
            facets.surface[at] = group.surface;
            facets.inside[at] = group.inside;
            facets.outside[at] = group.outside;
        }
    }

    /// Four, of which the last two are one in a triangle.
    void read_corners(NodeId* nodes, bool is_triangle) {
        for (int k = 0; k < 3; ++k) nodes[k] = next_node();
        nodes[3] = is_triangle ? nodes[2] : next_node();
    }

    void read_volume_elements(int entity, int type, std::uint64_t count) {
        std::size_t t = 0, first = mesh_.facets.size();
        while (t < kElementTypes && kElementTable[t].gmsh.type_of(second_order_) != type)
            first += mesh_.elements[t++].size();
        if (t == kElementTypes || entity < 1 ||
            static_cast<std::size_t>(entity) > mesh_.region_names.size() || entity > 65535)
            file_.damaged("volume elements of an unknown entity or type");
        ElementBlock& block = mesh_.elements[t];
        const FormatElement& format = kElementTable[t].gmsh;
        const std::size_t corners = nodes_per_element(t), middles = middles_per_element(t);
        for (std::uint64_t i = 0; i < count; ++i) {
            const std::size_t at = next_index(first, block.size());
            NodeId* const corner = block.nodes.data() + corners * at;
            for (std::size_t k = 0; k < corners; ++k) corner[format.nodes[k]] = next_node();
            NodeId* const middle = block.middles.data() + middles * at;
            for (std::size_t k = 0; second_order_ && k < middles; ++k)
                middle[format.middles[k]] = next_node();
            block.region[at] = static_cast<std::uint16_t>(entity);
        }
    }

    const FileReader& file_;
    SequentialReader bytes_;
    Mesh mesh_;
    bool second_order_ = false;
    std::vector<FacetGroup> groups_;
    std::vector<std::size_t> pair_of_link_;  ///< index into Mesh::periodic
    std::vector<bool> seen_;                 ///< by element tag - 1
};

}  // namespace

Mesh read_msh(const FileReader& file) {
    SequentialReader bytes(file);
    bytes.line();
    // "4.1 1 8" is ours; a 0 in the second place means text.
    const std::string format = bytes.line();
    const std::size_t blank = format.find(' ');
    if (blank != std::string::npos && format.compare(blank, 2, " 0") == 0) return read_gmsh_text(file);
    return MshReader(file).read();
}

}  // namespace mortise::io
