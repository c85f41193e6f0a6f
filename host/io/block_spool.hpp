// Arrays that come in parts, compressed as they come, to be joined into a file at the end.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "host/io/stored_array.hpp"

namespace mortise::io {

/// A temporary file without a name: it is gone with the process, however that ends.
class Spool {
  public:
    /// In the folder of `path`, whose name messages tell. Errors: Error(kFiles).
    explicit Spool(const std::string& path);
    ~Spool();
    Spool(const Spool&) = delete;
    Spool& operator=(const Spool&) = delete;

    /// Appends, and returns where.
    std::uint64_t append(const void* data, std::size_t size);
    /// Copies bytes to the end of the file, and frees their place on the disk where the system can.
    void move_to(TemporaryFile& file, std::uint64_t offset, std::size_t size);

  private:
    [[noreturn]] void fail(const char* action, int error) const;

    std::string path_;
    int descriptor_ = -1;
    std::uint64_t size_ = 0;
    std::vector<char> buffer_;
};

/// One array in the layout of stored_array.hpp, made of runs that are filled side by side, each from its
/// begin to its end. What is kept in memory: a block or two for each run.
class SpooledArray {
  public:
    /// Run r has the bytes [begins[r], begins[r + 1]) of the array.
    SpooledArray(Spool& spool, std::vector<std::uint64_t> begins, Packing packing);

    /// The next `size` bytes of a run; `source` as in write_array, with 0 for the first of them.
    void add(std::size_t run, std::size_t size, const ByteSource& source);

    /// Appends the whole array to the file. All runs must be full.
    void write(TemporaryFile& file);

  private:
    struct Block {
        std::uint64_t offset;
        std::uint64_t size;
    };
    struct Run {
        std::uint64_t at;           ///< next byte of the array
        std::vector<char> partial;  ///< bytes before `at` that do not fill a block yet
    };

    void add_partial(Run& run, std::size_t from, std::size_t size, const ByteSource& source);
    void store(std::uint64_t block, const void* packed, std::size_t size);
    /// Bytes of a block that several runs share, or that ends the array.
    void add_fragment(Run& run);

    Spool& spool_;
    Packing packing_;
    std::uint64_t size_;
    std::vector<Run> runs_;
    std::vector<Block> blocks_;
    std::map<std::uint64_t, std::map<std::uint64_t, std::vector<char>>> fragments_;  ///< by block, by place
};

}  // namespace mortise::io
