#include "host/io/block_spool.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "host/io/descriptor.hpp"
#include "mortise/error.hpp"

namespace mortise::io {

Spool::Spool(const std::string& path) : path_(path) {
    const std::size_t slash = path.find_last_of('/');
    const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
    descriptor_ = open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    if (descriptor_ >= 0) return;
    // Not every file system has files without a name.
    std::string name = path + ".XXXXXX";
    descriptor_ = mkostemp(name.data(), O_CLOEXEC);
    if (descriptor_ < 0) fail("create a temporary file beside", errno);
    unlink(name.c_str());
}

Spool::~Spool() {
    if (descriptor_ >= 0) close(descriptor_);
}

std::uint64_t Spool::append(const void* data, std::size_t size) {
    const std::uint64_t begin = size_;
    const int error = write_all(descriptor_, static_cast<const char*>(data), size, begin);
    if (error != 0) fail("write", error);
    size_ += size;
    return begin;
}

void Spool::move_to(TemporaryFile& file, std::uint64_t offset, std::size_t size) {
    buffer_.resize(size);
    const int error = read_all(descriptor_, buffer_.data(), size, offset, EIO);
    if (error != 0) fail("read back", error);
    file.write(buffer_.data(), size);
#ifdef FALLOC_FL_PUNCH_HOLE
    // Whether it works does not matter: it only saves space.
    (void)fallocate(descriptor_, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, static_cast<off_t>(offset),
                    static_cast<off_t>(size));
#endif
}

void Spool::fail(const char* action, int error) const {
    throw Error(ExitCode::kFiles,
                "cannot " + std::string(action) + " '" + path_ + "': " + std::strerror(error));
}

SpooledArray::SpooledArray(Spool& spool, std::vector<std::uint64_t> begins, Packing packing)
    : spool_(spool), packing_(packing), size_(begins.back()), blocks_(block_count(size_)) {
    for (std::size_t r = 0; r + 1 < begins.size(); ++r) runs_.push_back({begins[r], {}});
}

void SpooledArray::add(std::size_t index, std::size_t size, const ByteSource& source) {
    Run& run = runs_[index];
    std::size_t done = 0;
    if (run.at % kBlockSize != 0) {
        done = std::min<std::size_t>(size, kBlockSize - static_cast<std::size_t>(run.at % kBlockSize));
        add_partial(run, 0, done, source);
    }
    // Whole blocks are packed from where they are.
    const std::size_t whole = (size - done) / kBlockSize;
    std::uint64_t block = run.at / kBlockSize;
    const std::size_t shift = done;
    pack_blocks(
        0, whole, whole * kBlockSize,
        [&](std::size_t begin, std::size_t end, char* space) {
            return source(shift + begin, shift + end, space);
        },
        packing_, [&](const void* packed, std::size_t packed_size) { store(block++, packed, packed_size); });
    run.at += whole * kBlockSize;
    done += whole * kBlockSize;
    if (done < size) add_partial(run, done, size - done, source);
}

void SpooledArray::add_partial(Run& run, std::size_t from, std::size_t size, const ByteSource& source) {
    std::vector<std::uint64_t> space(kBlockSize / sizeof(std::uint64_t));
    const char* bytes = source(from, from + size, reinterpret_cast<char*>(space.data()));
    run.partial.insert(run.partial.end(), bytes, bytes + size);
    run.at += size;
    if (run.at % kBlockSize == 0) add_fragment(run);
}

void SpooledArray::add_fragment(Run& run) {
    if (run.partial.empty()) return;
    const std::uint64_t begin = run.at - run.partial.size();
    fragments_[begin / kBlockSize][begin % kBlockSize] = std::move(run.partial);
    run.partial = {};
    auto& pieces = fragments_[begin / kBlockSize];
    if (pieces.begin()->second.size() < kBlockSize) return;
    pack_blocks(0, 1, kBlockSize, memory_source(pieces.begin()->second.data()), packing_,
                [&](const void* packed, std::size_t size) { store(begin / kBlockSize, packed, size); });
    fragments_.erase(begin / kBlockSize);
}

void SpooledArray::store(std::uint64_t block, const void* packed, std::size_t size) {
    blocks_[static_cast<std::size_t>(block)] = {spool_.append(packed, size), size};
}

void SpooledArray::write(TemporaryFile& file) {
    for (Run& run : runs_) add_fragment(run);
    for (const auto& [block, pieces] : fragments_) {
        std::vector<char> bytes;
        for (const auto& [place, piece] : pieces) bytes.insert(bytes.end(), piece.begin(), piece.end());
        const std::uint64_t number = block;
        pack_blocks(0, 1, bytes.size(), memory_source(bytes.data()), packing_,
                    [&](const void* packed, std::size_t size) { store(number, packed, size); });
    }
    fragments_.clear();
    std::vector<std::uint64_t> sizes;
    for (const Block& block : blocks_) sizes.push_back(block.size);
    const std::vector<std::uint64_t> header = array_header(size_, packing_, sizes);
    file.write(header.data(), header.size() * sizeof header[0]);
    for (const Block& block : blocks_)
        spool_.move_to(file, block.offset, static_cast<std::size_t>(block.size));
}

}  // namespace mortise::io
