// See vtk_xml.hpp.
#include "host/io/vtk_xml.hpp"

#include <cstring>

namespace mortise::io {
namespace {

constexpr std::size_t kOffsetDigits = 20;

bool is_little_endian() {
    const std::uint16_t one = 1;
    unsigned char low;
    std::memcpy(&low, &one, 1);
    return low == 1;
}

}  // namespace

VtkXmlWriter::VtkXmlWriter(TemporaryFile& file, const std::string& type, Packing packing)
    : file_(file), packing_(packing) {
    text("<?xml version=\"1.0\"?>");
    text("<VTKFile type=\"" + type + "\" version=\"1.0\" byte_order=\"" +
         std::string(is_little_endian() ? "LittleEndian" : "BigEndian") + "\" header_type=\"UInt64\"" +
         (packing.coding == Coding::kZlib ? " compressor=\"vtkZLibDataCompressor\"" : "") + ">");
}

void VtkXmlWriter::array(const std::string& type, const std::string& name, const std::string& attributes,
                         const ArrayWriter& write) {
    header_ += "<DataArray type=\"" + type + "\" Name=\"" + name + "\"" + attributes +
               " format=\"appended\" offset=\"";
    arrays_.push_back({write, header_.size()});
    header_ += std::string(kOffsetDigits + 1, ' ') + "/>\n";
}

void VtkXmlWriter::names(const char* name, const std::vector<std::string>& values) {
    std::string line = "<Array type=\"String\" Name=\"" + std::string(name) + "\" NumberOfTuples=\"" +
                       std::to_string(values.size()) + "\" format=\"ascii\">";
    for (const std::string& value : values) {
        line += "\n";
        for (const char c : value) line += std::to_string(static_cast<unsigned char>(c)) + " ";
        line += "0";
    }
    text(line + "\n</Array>");
}

void VtkXmlWriter::finish() {
    text("<AppendedData encoding=\"raw\">");
    header_ += "_";
    file_.write(header_);
    const std::uint64_t base = file_.size();
    for (const ArrayToWrite& array : arrays_) {
        // The quote follows the number, the room left stays blank behind it.
        const std::string offset = std::to_string(file_.size() - base) + "\"";
        array.write(file_);
        file_.write_at(array.offset_at, offset.data(), offset.size());
    }
    file_.write("\n</AppendedData>\n</VTKFile>\n");
}

}  // namespace mortise::io
