// Arrays in VTK's binary layouts, made block by block.
//
// Compressed: a header of UInt64, then zlib streams of equal uncompressed size. Header: number of blocks,
// uncompressed block size, uncompressed size of the last block if it is shorter (else 0), compressed size of
// each block. Plain: the number of bytes as UInt64, then the bytes. Blocks are made and compressed by several
// threads and written in order, plain parts where they belong: the bytes do not depend on the number of
// threads. Source: VTK file formats, "appended data".
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "host/io/file_reader.hpp"
#include "host/io/temporary_file.hpp"

namespace mortise::io {

enum class Coding { kZlib, kPlain };

/// How arrays are stored, and by how many host threads, 0: all cores.
struct Packing {
    Coding coding = Coding::kZlib;
    int threads = 0;
};

inline constexpr std::size_t kBlockSize = std::size_t{1} << 20;

/// Gives the bytes [begin, end) of an array; both are multiples of the value size (a power of two) or the
/// array's end. Either fills `space` (kBlockSize bytes, aligned for any value) and returns it, or returns a
/// pointer to bytes that exist already. At most kBlockSize bytes; called from several threads at once.
using ByteSource = std::function<const char*(std::size_t begin, std::size_t end, char* space)>;

/// Packs the blocks first … first + count - 1 of what `source` gives (block i is its bytes from
/// i * kBlockSize on, up to `size`) and hands them to `take` in order, from any of the threads but one at a
/// time.
void pack_blocks(std::size_t first, std::size_t count, std::size_t size, const ByteSource& source,
                 Packing packing,
                 const std::function<void(const void* packed, std::size_t packed_size)>& take);

inline std::size_t block_count(std::uint64_t size) {
    return static_cast<std::size_t>((size + kBlockSize - 1) / kBlockSize);
}

/// The header of an array of `size` bytes, whose blocks have these sizes when packed.
std::vector<std::uint64_t> array_header(std::uint64_t size, Packing packing,
                                        const std::vector<std::uint64_t>& packed_sizes);

/// Appends an array of `size` bytes to the file.
void write_array(TemporaryFile& file, std::size_t size, const ByteSource& source, Packing packing);

/// Source of an array that lies in memory as it is to be stored.
ByteSource memory_source(const void* data);

/// Reads an array that starts at `offset`. Throws Error(kInput) for anything that does not fit together;
/// never allocates more than about a thousand times what the file holds (the most that zlib can expand).
std::vector<char> read_array(const FileReader& file, std::uint64_t offset, Coding coding);

}  // namespace mortise::io
