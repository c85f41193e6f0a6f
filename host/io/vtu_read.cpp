// Reads the .vtu files of vtu_write.cpp; anything else is refused with a reason.
//
// The text before the raw appended data is cut out, closed and given to pugixml. Nothing in it is trusted: a
// number is compared with the array's true length before it is used.
#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>
#include <pugixml.hpp>
#include <string>

#include "host/io/element_table.hpp"
#include "host/io/formats.hpp"
#include "host/io/stored_array.hpp"

namespace mortise::io {
namespace {

constexpr std::size_t kHeaderStep = std::size_t{1} << 16;
constexpr std::size_t kMaxHeader = std::size_t{1} << 28;  // millions of surface names

class VtuReader {
  public:
    explicit VtuReader(const FileReader& file) : file_(file) {
        expect_end();
        read_header();
        const pugi::xml_node root = document_.child("VTKFile");
        expect_attribute(root, "type", "UnstructuredGrid");
        const std::uint16_t one = 1;
        unsigned char low;
        std::memcpy(&low, &one, 1);
        expect_attribute(root, "byte_order", low == 1 ? "LittleEndian" : "BigEndian");
        expect_attribute(root, "header_type", "UInt64");
        if (root.attribute("compressor")) {
            expect_attribute(root, "compressor", "vtkZLibDataCompressor");
        } else {
            coding_ = Coding::kPlain;
        }
        grid_ = root.child("UnstructuredGrid");
        piece_ = grid_.child("Piece");
        if (!piece_) file_.damaged("no Piece in it");
    }

    pugi::xml_node fields() const { return grid_.child("FieldData"); }
    pugi::xml_node piece() const { return piece_; }

    /// The array of that name and VTK type below `parent`.
    template <class Value>
    std::vector<Value> array(const pugi::xml_node& parent, const char* name, const char* type) const {
        const pugi::xml_node node = parent.find_child_by_attribute("DataArray", "Name", name);
        if (!node) file_.damaged(std::string("no array '") + name + "'");
        if (std::strcmp(node.attribute("type").value(), type) != 0)
            file_.damaged(std::string("array '") + name + "' has type '" + node.attribute("type").value() +
                          "', expected " + type);
        expect_attribute(node, "format", "appended");
        const pugi::xml_attribute offset = node.attribute("offset");
        const std::uint64_t at = offset.as_ullong(std::numeric_limits<std::uint64_t>::max());
        if (!offset || at > file_.size() - data_start_)
            file_.damaged(std::string("array '") + name + "': bad offset");
        const std::vector<char> bytes = read_array(file_, data_start_ + at, coding_);
        if (bytes.size() % sizeof(Value) != 0)
            file_.damaged(std::string("array '") + name + "' ends inside a value");
        std::vector<Value> values(bytes.size() / sizeof(Value));
        if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
        return values;
    }

    std::vector<std::string> names(const char* name) const {
        const pugi::xml_node node = fields().find_child_by_attribute("Array", "Name", name);
        if (!node) file_.damaged(std::string("no array '") + name + "'");
        std::vector<std::string> values;
        std::string value;
        bool open = false;
        for (const char* text = node.child_value(); *(text += std::strspn(text, " \t\r\n")) != 0;) {
            int code = 0;
            const char* begin = text;
            for (; *text >= '0' && *text <= '9' && code < 256; ++text) code = 10 * code + (*text - '0');
            if (text == begin || code > 255)
                file_.damaged(std::string("array '") + name + "': bad character code");
            open = code != 0;
            if (open) {
                value += static_cast<char>(code);
            } else {
                values.push_back(value);
                value.clear();
            }
        }
        if (open) file_.damaged(std::string("array '") + name + "': a name does not end");
        return values;
    }

    [[noreturn]] void damaged(const std::string& what) const { file_.damaged(what); }

  private:
    /// The end tag shows that the file is whole, whichever arrays are read.
    void expect_end() const {
        const std::string end = "</VTKFile>\n";
        std::string tail(end.size(), ' ');
        if (file_.size() >= tail.size()) file_.read_at(file_.size() - tail.size(), &tail[0], tail.size());
        if (tail != end) file_.damaged("it does not end with </VTKFile>");
    }

    void read_header() {
        const std::string marker = "<AppendedData encoding=\"raw\">";
        std::string text;
        std::size_t found = std::string::npos;
        while (found == std::string::npos) {
            const std::uint64_t left = file_.size() - text.size();
            if (left == 0 || text.size() > kMaxHeader) file_.damaged("no appended data in it");
            const std::size_t old = text.size();
            text.resize(old + static_cast<std::size_t>(std::min<std::uint64_t>(kHeaderStep, left)));
            file_.read_at(old, &text[old], text.size() - old);
            found = text.find(marker, old > marker.size() ? old - marker.size() : 0);
        }
        data_start_ = found + marker.size();
        // White space, then an underscore, then the data.
        char c = 0;
        do {
            file_.read_at(data_start_++, &c, 1);
        } while (c == ' ' || c == '\t' || c == '\r' || c == '\n');
        if (c != '_') file_.damaged("no '_' before the appended data");
        text.resize(found);
        text += "</VTKFile>";
        const pugi::xml_parse_result result = document_.load_buffer(text.data(), text.size());
        if (!result)
            file_.damaged(std::string("XML: ") + result.description() + " at byte " +
                          std::to_string(result.offset));
    }

    void expect_attribute(const pugi::xml_node& node, const char* name, const char* value) const {
        const char* found = node.attribute(name).value();
        if (std::strcmp(found, value) != 0)
            file_.damaged(std::string(node.name()) + ": " + name + " is '" + found + "', expected '" + value +
                          "'");
    }

    const FileReader& file_;
    pugi::xml_document document_;
    pugi::xml_node grid_, piece_;
    std::uint64_t data_start_ = 0;
    Coding coding_ = Coding::kZlib;
};

/// Sizes the blocks by the cell types, which must come in the order of ElementType, all of one order.
void read_types(const VtuReader& reader, Mesh& mesh) {
    const pugi::xml_node cells = reader.piece().child("Cells");
    const std::vector<std::uint8_t> types = reader.array<std::uint8_t>(cells, "types", "UInt8");
    const bool second_order =
        !types.empty() && std::any_of(kElementTable.begin(), kElementTable.end(),
                                      [&](const ElementRow& row) { return types[0] == row.vtk.second_type; });
    std::size_t at = 0;
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const std::size_t begin = at;
        while (at < types.size() && types[at] == kElementTable[t].vtk.type_of(second_order)) ++at;
        ElementBlock& block = mesh.elements[t];
        block.region.resize(at - begin);
        block.kind.resize(at - begin);
        block.nodes.resize(nodes_per_element(t) * block.size());
        if (second_order) block.middles.resize(middles_per_element(t) * block.size());
    }
    if (at != types.size())
        reader.damaged(
            "cell " + std::to_string(at) + " has type " + std::to_string(types[at]) +
            ", expected hexahedra (12), wedges (13), pyramids (14), tetrahedra (10) in this order, "
            "or all of second order (25, 26, 27, 24)");
}

template <class Index>
void read_connectivity(const VtuReader& reader, const char* type, Mesh& mesh) {
    const pugi::xml_node cells = reader.piece().child("Cells");
    const std::vector<Index> offsets = reader.array<Index>(cells, "offsets", type);
    if (offsets.size() != mesh.element_count()) reader.damaged("offsets and types differ in length");
    std::uint64_t end = 0;
    std::size_t cell = 0;
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        for (std::size_t i = 0; i < mesh.elements[t].size(); ++i, ++cell) {
            end += all_nodes_per_element(t, mesh.is_second_order());
            if (offsets[cell] < 0 || static_cast<std::uint64_t>(offsets[cell]) != end)
                reader.damaged("offset of cell " + std::to_string(cell) + " does not fit its type");
        }
    }
    const std::vector<Index> connectivity = reader.array<Index>(cells, "connectivity", type);
    if (connectivity.size() != end) reader.damaged("connectivity and offsets differ in length");
    const std::uint64_t nodes = mesh.node_count();
    std::size_t at = 0;
    const auto next = [&] {
        if (connectivity[at] < 0 || static_cast<std::uint64_t>(connectivity[at]) >= nodes)
            reader.damaged("connectivity " + std::to_string(at) + " is no index of a point");
        return static_cast<NodeId>(connectivity[at++]);
    };
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        ElementBlock& block = mesh.elements[t];
        const FormatElement& order = kElementTable[t].vtk;
        const std::size_t corners = nodes_per_element(t), middles = middles_per_element(t);
        for (std::size_t i = 0; i < block.size(); ++i) {
            NodeId* const corner = block.nodes.data() + corners * i;
            for (std::size_t k = 0; k < corners; ++k) corner[order.nodes[k]] = next();
            if (block.middles.empty()) continue;
            NodeId* const middle = block.middles.data() + middles * i;
            for (std::size_t k = 0; k < middles; ++k) middle[order.middles[k]] = next();
        }
    }
}

/// Deals a cell array out to the blocks' member; `limit` is the largest value allowed.
template <class Value, class Member>
void read_cell_data(const VtuReader& reader, const char* name, const char* type, std::int64_t limit,
                    Member member, Mesh& mesh) {
    const std::vector<Value> values = reader.array<Value>(reader.piece().child("CellData"), name, type);
    if (values.size() != mesh.element_count())
        reader.damaged(std::string(name) + " and types differ in length");
    std::size_t at = 0;
    for (ElementBlock& block : mesh.elements) {
        for (auto& out : block.*member) {
            if (values[at] < 0 || static_cast<std::int64_t>(values[at]) > limit)
                reader.damaged(std::string(name) + " of cell " + std::to_string(at) + " is " +
                               std::to_string(values[at]) + ", expected at most " + std::to_string(limit));
            out = static_cast<std::decay_t<decltype(out)>>(values[at++]);
        }
    }
}

void read_periodic(const VtuReader& reader, Mesh& mesh) {
    if (!reader.fields().find_child_by_attribute("DataArray", "Name", "periodic_counts")) return;
    const auto counts = reader.array<std::uint32_t>(reader.fields(), "periodic_counts", "UInt32");
    const auto shifts = reader.array<double>(reader.fields(), "periodic_shifts", "Float64");
    const auto nodes = reader.array<std::uint32_t>(reader.fields(), "periodic_nodes", "UInt32");
    const auto originals = reader.array<std::uint32_t>(reader.fields(), "periodic_originals", "UInt32");
    const std::uint64_t all = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
    if (shifts.size() != 3 * counts.size() || all != nodes.size() || all != originals.size())
        reader.damaged("arrays of periodic nodes of unequal length");
    std::size_t begin = 0;
    for (std::size_t pair = 0; pair < counts.size(); ++pair) {
        PeriodicNodes read;
        std::copy_n(shifts.begin() + static_cast<std::ptrdiff_t>(3 * pair), 3, read.shift.begin());
        const auto from = static_cast<std::ptrdiff_t>(begin);
        const auto to = static_cast<std::ptrdiff_t>(begin += counts[pair]);
        read.node.assign(nodes.begin() + from, nodes.begin() + to);
        read.original.assign(originals.begin() + from, originals.begin() + to);
        mesh.periodic.push_back(std::move(read));
    }
}

}  // namespace

Mesh read_vtu(const FileReader& file) {
    const VtuReader reader(file);
    Mesh mesh;
    mesh.region_names = reader.names("region_names");
    mesh.surface_names = reader.names("surface_names");
    mesh.points = reader.array<double>(reader.piece().child("Points"), "Points", "Float64");
    const pugi::xml_node point_data = reader.piece().child("PointData");
    if (point_data.find_child_by_attribute("DataArray", "Name", "model_dimension")) {
        mesh.model_dimension = reader.array<std::uint8_t>(point_data, "model_dimension", "UInt8");
    }
    read_types(reader, mesh);
    const pugi::xml_node offsets =
        reader.piece().child("Cells").find_child_by_attribute("DataArray", "Name", "offsets");
    if (std::strcmp(offsets.attribute("type").value(), "Int64") == 0) {
        read_connectivity<std::int64_t>(reader, "Int64", mesh);
    } else {
        read_connectivity<std::int32_t>(reader, "Int32", mesh);
    }
    read_cell_data<std::int32_t>(reader, "region", "Int32", 65535, &ElementBlock::region, mesh);
    read_cell_data<std::uint8_t>(reader, "kind", "UInt8", 255, &ElementBlock::kind, mesh);
    mesh.facets.nodes = reader.array<std::uint32_t>(reader.fields(), "facet_nodes", "UInt32");
    mesh.facets.surface = reader.array<std::uint32_t>(reader.fields(), "facet_surface", "UInt32");
    mesh.facets.inside = reader.array<std::uint16_t>(reader.fields(), "facet_inside", "UInt16");
    mesh.facets.outside = reader.array<std::uint16_t>(reader.fields(), "facet_outside", "UInt16");
    if (mesh.is_second_order())
        mesh.facets.middles = reader.array<std::uint32_t>(reader.fields(), "facet_middles", "UInt32");
    if (reader.fields().find_child_by_attribute("DataArray", "Name", "hanging_nodes")) {
        mesh.hanging.node = reader.array<std::uint32_t>(reader.fields(), "hanging_nodes", "UInt32");
        mesh.hanging.masters = reader.array<std::uint32_t>(reader.fields(), "hanging_masters", "UInt32");
    }
    read_periodic(reader, mesh);
    return mesh;
}

}  // namespace mortise::io
