// Compression in zlib's format by libdeflate, which takes half of zlib's time.
#include "host/io/stored_array.hpp"

#include <libdeflate.h>

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <new>

#include "host/common/parallel.hpp"
#include "mortise/error.hpp"

namespace mortise::io {
namespace {

/// The format's own bound: 1032 bytes from each compressed byte.
constexpr std::uint64_t kMaxExpansion = 1040;

/// A sample of the block that shrinks by less than this many percent is not worth compressing.
constexpr std::size_t kSampleSize = std::size_t{1} << 14;
constexpr std::size_t kWorthPercent = 25;

/// Blocks that are packed before the last of them must have been taken.
constexpr std::size_t kWave = 64;

/// Bytes that a thread makes and writes at a time: it has them in its cache.
constexpr std::size_t kPlainPart = std::size_t{1} << 18;

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

/// What one thread packs with.
struct Packer {
    explicit Packer(Coding wanted) : coding(wanted), space(kBlockSize / sizeof(std::uint64_t)) {
        if (wanted == Coding::kPlain) return;
        packed.resize(libdeflate_zlib_compress_bound(nullptr, kBlockSize));
        fastest = make_compressor(kFastest);
        stored = make_compressor(kStored);
    }
    char* bytes() { return reinterpret_cast<char*>(space.data()); }
    Coding coding;
    std::vector<std::uint64_t> space;  ///< 64-bit for alignment
    std::vector<unsigned char> packed;
    Compressor fastest;
    Compressor stored;
};

/// Of a block; they belong to a packer or to the source.
struct Packed {
    const void* data;
    std::size_t size;
};

/// A packer for each thread, made when it is first needed.
class Packers {
  public:
    explicit Packers(Packing packing)
        : coding_(packing.coding), packers_(static_cast<std::size_t>(thread_count(packing.threads))) {}
    Packer& of(int thread) {
        std::unique_ptr<Packer>& packer = packers_[static_cast<std::size_t>(thread)];
        if (!packer) packer = std::make_unique<Packer>(coding_);
        return *packer;
    }

  private:
    Coding coding_;
    std::vector<std::unique_ptr<Packer>> packers_;
};

/// Hands blocks on in order, from whichever thread has the one whose turn it is; those that come early wait
/// here, not their threads.
class InOrder {
  public:
    using Take = std::function<void(const void* packed, std::size_t packed_size)>;
    InOrder(std::size_t first, const Take& take) : next_(first), take_(take) {}

    void add(std::size_t block, const Packed& packed) {
        std::unique_lock<std::mutex> lock(mutex_);
        if (block != next_) {
            const auto* bytes = static_cast<const char*>(packed.data);
            early_[block].assign(bytes, bytes + packed.size);
            return;
        }
        // Nobody else has this block's turn until next_ is raised.
        lock.unlock();
        take_(packed.data, packed.size);
        for (lock.lock(); !early_.empty() && early_.begin()->first == next_ + 1; lock.lock()) {
            const std::vector<char> bytes = std::move(early_.begin()->second);
            early_.erase(early_.begin());
            ++next_;
            lock.unlock();
            take_(bytes.data(), bytes.size());
        }
        ++next_;
    }

  private:
    std::mutex mutex_;
    std::size_t next_;  ///< the block that is taken, or is to be taken next
    std::map<std::size_t, std::vector<char>> early_;
    const Take& take_;
};

std::size_t compress(libdeflate_compressor* compressor, const char* data, std::size_t size, Packer& packer) {
    return libdeflate_zlib_compress(compressor, data, size, packer.packed.data(), packer.packed.size());
}

/// Stored as it is where a sample from the middle hardly shrinks: coordinates off a grid.
Packed pack_block(const char* data, std::size_t size, Packer& packer) {
    if (packer.coding == Coding::kPlain) return {data, size};
    libdeflate_compressor* compressor = packer.fastest.get();
    if (size > 2 * kSampleSize) {
        const std::size_t sample = compress(compressor, data + size / 2, kSampleSize, packer);
        if (sample * 100 > kSampleSize * (100 - kWorthPercent)) compressor = packer.stored.get();
    }
    const std::size_t packed_size = compress(compressor, data, size, packer);
    return {packer.packed.data(), packed_size};
}

std::vector<char> read_plain(const FileReader& file, std::uint64_t offset) {
    std::uint64_t size = 0;
    file.read_at(offset, &size, sizeof size);
    if (size > file.size() - offset - sizeof size) file.damaged("an array ends too late");
    std::vector<char> bytes(static_cast<std::size_t>(size));
    const std::size_t blocks = block_count(size);
    parallel_chunks(blocks, 1, 0, [&](std::size_t i, std::size_t, int) {
        const std::size_t begin = i * kBlockSize;
        file.read_at(offset + sizeof size + begin, bytes.data() + begin,
                     std::min(kBlockSize, bytes.size() - begin));
    });
    return bytes;
}

}  // namespace

ByteSource memory_source(const void* data) {
    const char* bytes = static_cast<const char*>(data);
    return [bytes](std::size_t begin, std::size_t, char*) { return bytes + begin; };
}

void pack_blocks(std::size_t first, std::size_t count, std::size_t size, const ByteSource& source,
                 Packing packing,
                 const std::function<void(const void* packed, std::size_t packed_size)>& take) {
    Packers packers(packing);
    const std::size_t last = first + count;
    // In waves, or a slow disk would leave the whole array waiting in memory.
    for (; first < last; first += kWave) {
        InOrder in_order(first, take);
        const std::size_t together = std::min(kWave, last - first);
        parallel_chunks(together, 1, packing.threads, [&](std::size_t i, std::size_t, int thread) {
            Packer& packer = packers.of(thread);
            const std::size_t begin = (first + i) * kBlockSize, end = std::min(size, begin + kBlockSize);
            in_order.add(first + i, pack_block(source(begin, end, packer.bytes()), end - begin, packer));
        });
    }
}

std::vector<std::uint64_t> array_header(std::uint64_t size, Packing packing,
                                        const std::vector<std::uint64_t>& packed_sizes) {
    if (packing.coding == Coding::kPlain) return {size};
    std::vector<std::uint64_t> header = {block_count(size), kBlockSize, size % kBlockSize};
    header.insert(header.end(), packed_sizes.begin(), packed_sizes.end());
    return header;
}

/// Where a block lies is known: each thread writes what it has made. Parts begin at multiples of their size
/// in the file, where they fill whole pages: a quarter faster than from where the array happens to begin.
static void write_plain(TemporaryFile& file, std::size_t size, const ByteSource& source, Packing packing) {
    constexpr std::size_t value = sizeof(std::uint64_t);  // the largest of an array
    file.put(std::uint64_t{size});
    const std::uint64_t at = file.reserve(size);
    const auto lead = static_cast<std::size_t>(at % kPlainPart);
    Packers packers(packing);
    parallel_chunks(lead + size, kPlainPart, packing.threads,
                    [&](std::size_t part_begin, std::size_t part_end, int thread) {
                        if (part_end <= lead) return;
                        const std::size_t begin = std::max(part_begin, lead) - lead, end = part_end - lead;
                        const std::size_t first = begin / value * value;
                        const std::size_t last = std::min(size, (end + value - 1) / value * value);
                        const char* bytes = source(first, last, packers.of(thread).bytes());
                        file.write_at(at + begin, bytes + (begin - first), end - begin);
                    });
}

void write_array(TemporaryFile& file, std::size_t size, const ByteSource& source, Packing packing) {
    if (packing.coding == Coding::kPlain) return write_plain(file, size, source, packing);
    std::vector<std::uint64_t> sizes(block_count(size), 0);
    const std::uint64_t header_at = file.size();
    const auto header = [&] { return array_header(size, packing, sizes); };
    const std::vector<std::uint64_t> empty = header();
    file.write(empty.data(), empty.size() * sizeof empty[0]);  // sizes follow at the end
    std::size_t next = 0;
    pack_blocks(0, sizes.size(), size, source, packing, [&](const void* packed, std::size_t packed_size) {
        file.write(packed, packed_size);
        sizes[next++] = packed_size;
    });
    const std::vector<std::uint64_t> full = header();
    if (full != empty) file.write_at(header_at, full.data(), full.size() * sizeof full[0]);
}

std::vector<char> read_array(const FileReader& file, std::uint64_t offset, Coding coding) {
    if (coding == Coding::kPlain) return read_plain(file, offset);
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
    parallel_chunks(static_cast<std::size_t>(blocks), 1, 0, [&](std::size_t i, std::size_t, int) {
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
