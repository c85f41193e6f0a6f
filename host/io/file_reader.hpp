// Reading of files that may be damaged: every access is checked against the file's size.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

namespace mortise::io {

/// Random access to a file. Throws Error(kFiles) if the system reports a failure.
class FileReader {
  public:
    explicit FileReader(const std::string& path);
    ~FileReader();
    FileReader(const FileReader&) = delete;
    FileReader& operator=(const FileReader&) = delete;

    const std::string& path() const { return path_; }
    std::uint64_t size() const { return size_; }

    /// Reads exactly `size` bytes; throws Error(kInput) if the file ends before.
    void read_at(std::uint64_t offset, void* data, std::size_t size) const;

    /// Throws Error(kInput): the file is not what it should be.
    [[noreturn]] void damaged(const std::string& what) const;

  private:
    std::string path_;
    std::uint64_t size_ = 0;
    int descriptor_ = -1;
};

/// Reads a file from front to back through a buffer.
class SequentialReader {
  public:
    explicit SequentialReader(const FileReader& file) : file_(file) {}

    std::uint64_t remaining() const { return file_.size() - position_; }

    /// Throws Error(kInput) unless at least count × size bytes are left: called before allocating for them.
    void expect(std::uint64_t count, std::uint64_t size) const;

    void read(void* data, std::size_t size);
    template <class Value>
    Value get() {
        static_assert(std::is_trivially_copyable<Value>::value, "raw bytes");
        Value value;
        read(&value, sizeof value);
        return value;
    }

    /// The text up to the next line feed, without it; at most 64 KiB.
    std::string line();

  private:
    const FileReader& file_;
    std::uint64_t position_ = 0;
    std::vector<char> buffer_;
    std::uint64_t buffer_start_ = 0;  ///< position of buffer_[0] in the file
};

}  // namespace mortise::io
