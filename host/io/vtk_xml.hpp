// Writes VTK's XML files: a header that announces arrays, then the arrays, appended raw.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/io/stored_array.hpp"
#include "host/io/temporary_file.hpp"

namespace mortise::io {

/// Appends one array to the file, header and blocks.
using ArrayWriter = std::function<void(TemporaryFile& file)>;

/// The array of `size` bytes that `source` gives.
inline ArrayWriter stored(std::size_t size, const ByteSource& source, Packing packing) {
    return [size, source, packing](TemporaryFile& file) { write_array(file, size, source, packing); };
}

/// Collects the header's text and the arrays that it announces. Sources must live until finish().
class VtkXmlWriter {
  public:
    /// `type`: of the data set, such as UnstructuredGrid. All arrays are packed alike.
    VtkXmlWriter(TemporaryFile& file, const std::string& type, Packing packing);

    void text(const std::string& line) { header_ += line + "\n"; }

    void array(const std::string& type, const std::string& name, const std::string& attributes,
               const ArrayWriter& write);
    void array(const std::string& type, const std::string& name, const std::string& attributes,
               std::size_t size, const ByteSource& source) {
        array(type, name, attributes, stored(size, source, packing_));
    }

    /// An array in memory, for FieldData: with the number of its tuples.
    template <class Value>
    void field(const char* type, const char* name, int components, const std::vector<Value>& values) {
        const std::string attributes =
            (components > 1 ? " NumberOfComponents=\"" + std::to_string(components) + "\"" : std::string()) +
            " NumberOfTuples=\"" + std::to_string(values.size() / static_cast<std::size_t>(components)) +
            "\"";
        array(type, name, attributes, values.size() * sizeof(Value), memory_source(values.data()));
    }

    /// A VTK string array, inline as character codes.
    void names(const char* name, const std::vector<std::string>& values);

    /// Writes everything; nothing may follow.
    void finish();

  private:
    struct ArrayToWrite {
        ArrayWriter write;
        std::uint64_t offset_at;  ///< where the header has room for the offset
    };

    TemporaryFile& file_;
    Packing packing_;
    std::string header_;
    std::vector<ArrayToWrite> arrays_;
};

}  // namespace mortise::io
