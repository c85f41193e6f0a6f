// Block-wise compression in zlib's format, and back, on all cores. libdeflate takes half of zlib's time.
#include "host/io/compressed_array.hpp"

#include <libdeflate.h>

#include <algorithm>
#include <memory>
#include <new>
#include <thread>

#include "host/common/parallel.hpp"
#include "mortise/error.hpp"

namespace mortise::io {
namespace {

/// The format's own bound: 1032 bytes from each compressed byte.
constexpr std::uint64_t kMaxExpansion = 1040;

/// A sample of the block that shrinks by less than this many percent is not worth compressing.
constexpr std::size_t kSampleSize = std::size_t{1} << 14;
constexpr std::size_t kWorthPercent = 25;

constexpr int kFastest = 1;
constexpr int kStored = 0;

struct FreeCompressor {
    void operator()(libdeflate_compressor* c) const { libdeflate_free_compressor(c); }
    void operator()(libdeflate_decompressor* d) const { libdeflate_free_decompressor(d); }
};
using Compressor = std::unique_ptr<libdeflate_compressor, FreeCompressor>;
using Decompressor = std::unique_ptr<libdeflate_decompressor, FreeCompressor>;

Compressor make_compressor(int level) {
    Compressor compressor(libdeflate_alloc_compressor(level));
    if (!compressor) throw std::bad_alloc();
    return compressor;
}

struct Scratch {
    Scratch() : space(kBlockSize / sizeof(std::uint64_t)) {
        packed.resize(libdeflate_zlib_compress_bound(nullptr, kBlockSize));
    }
    char* bytes() { return reinterpret_cast<char*>(space.data()); }
    std::vector<std::uint64_t> space;  ///< 64-bit for alignment
    std::vector<unsigned char> packed;
    std::size_t packed_size = 0;
    Compressor fastest = make_compressor(kFastest);
    Compressor stored = make_compressor(kStored);
};

std::size_t pack(libdeflate_compressor* compressor, const char* data, std::size_t size, Scratch& scratch) {
    return libdeflate_zlib_compress(compressor, data, size, scratch.packed.data(), scratch.packed.size());
}

/// Stored as it is where a sample from the middle hardly shrinks: coordinates off a grid.
void compress_block(const char* data, std::size_t size, Scratch& scratch) {
    libdeflate_compressor* compressor = scratch.fastest.get();
    if (size > 2 * kSampleSize) {
        const std::size_t sample = pack(compressor, data + size / 2, kSampleSize, scratch);
        if (sample * 100 > kSampleSize * (100 - kWorthPercent)) compressor = scratch.stored.get();
    }
    scratch.packed_size = pack(compressor, data, size, scratch);
}

}  // namespace

ByteSource memory_source(const void* data) {
    const char* bytes = static_cast<const char*>(data);
    return [bytes](std::size_t begin, std::size_t, char*) { return bytes + begin; };
}

void pack_blocks(std::size_t first, std::size_t count, std::size_t size, const ByteSource& source,
                 const std::function<void(const void* packed, std::size_t packed_size)>& take) {
    const std::size_t wave = 4 * std::max(1u, std::thread::hardware_concurrency());
    std::vector<Scratch> scratch(std::min(wave, count));
    const std::size_t last = first + count;
    for (; first < last; first += wave) {
        const std::size_t together = std::min(wave, last - first);
        parallel_chunks(together, 1, [&](std::size_t i, std::size_t, std::size_t) {
            const std::size_t begin = (first + i) * kBlockSize, end = std::min(size, begin + kBlockSize);
            compress_block(source(begin, end, scratch[i].bytes()), end - begin, scratch[i]);
        });
        for (std::size_t i = 0; i < together; ++i) take(scratch[i].packed.data(), scratch[i].packed_size);
    }
}

std::vector<std::uint64_t> block_header(std::uint64_t size) {
    const std::uint64_t blocks = (size + kBlockSize - 1) / kBlockSize;
    std::vector<std::uint64_t> header(kHeaderWords + static_cast<std::size_t>(blocks), 0);
    header[0] = blocks;
    header[1] = kBlockSize;
    header[2] = size % kBlockSize;
    return header;
}

void write_compressed(TemporaryFile& file, std::size_t size, const ByteSource& source) {
    std::vector<std::uint64_t> header = block_header(size);
    const std::uint64_t header_at = file.size();
    file.write(header.data(), header.size() * sizeof header[0]);  // sizes follow at the end
    std::size_t next = kHeaderWords;
    pack_blocks(0, header.size() - kHeaderWords, size, source,
                [&](const void* packed, std::size_t packed_size) {
                    file.write(packed, packed_size);
                    header[next++] = packed_size;
                });
    if (next > kHeaderWords) file.write_at(header_at, header.data(), header.size() * sizeof header[0]);
}

std::vector<char> read_compressed(const FileReader& file, std::uint64_t offset) {
    std::uint64_t head[3];
    file.read_at(offset, head, sizeof head);
    const std::uint64_t blocks = head[0], block_size = head[1], last_size = head[2];
    const std::uint64_t after_head = offset + sizeof head;
    if (blocks == 0) return {};
    if (blocks > (file.size() - after_head) / sizeof(std::uint64_t) || block_size != kBlockSize ||
        last_size >= block_size)
        file.damaged("the header of a compressed array makes no sense");
    std::vector<std::uint64_t> starts(static_cast<std::size_t>(blocks) + 1);
    file.read_at(after_head, starts.data() + 1, static_cast<std::size_t>(blocks) * sizeof starts[0]);
    starts[0] = after_head + blocks * sizeof starts[0];
    for (std::size_t i = 1; i < starts.size(); ++i) {
        if (starts[i] > file.size() - starts[i - 1]) file.damaged("a compressed array ends too late");
        starts[i] += starts[i - 1];
    }
    const std::uint64_t packed_total = starts.back() - starts.front();
    const std::uint64_t full_blocks = last_size == 0 ? blocks : blocks - 1;
    const std::uint64_t total = full_blocks * block_size + last_size;
    if (total > kMaxExpansion * packed_total)
        file.damaged("a compressed array is larger than its bytes can hold");
    std::vector<char> bytes(static_cast<std::size_t>(total));
    parallel_chunks(static_cast<std::size_t>(blocks), 1, [&](std::size_t i, std::size_t, std::size_t) {
        std::vector<unsigned char> packed(static_cast<std::size_t>(starts[i + 1] - starts[i]));
        file.read_at(starts[i], packed.data(), packed.size());
        const std::size_t begin = i * static_cast<std::size_t>(block_size);
        const std::size_t expected =
            std::min<std::size_t>(static_cast<std::size_t>(block_size), bytes.size() - begin);
        const Decompressor decompressor(libdeflate_alloc_decompressor());
        if (!decompressor) throw std::bad_alloc();
        // Without a place for the actual size, any other size is an error.
        const libdeflate_result result = libdeflate_zlib_decompress(
            decompressor.get(), packed.data(), packed.size(), bytes.data() + begin, expected, nullptr);
        if (result != LIBDEFLATE_SUCCESS) file.damaged("a compressed array does not unpack");
    });
    return bytes;
}

}  // namespace mortise::io
