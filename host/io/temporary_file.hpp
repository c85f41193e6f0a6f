// Files that appear whole or not at all: written under a temporary name beside the target, then renamed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace mortise::io {

/// Removes every temporary file that is open now, then every NewFolder that is empty. Async-signal-safe: for
/// handlers of signals that end the process; the TemporaryFile objects are of no use afterwards.
void remove_temporary_files() noexcept;

/// A file being written. Every failure throws Error(kFiles) with the target's path and the cause, and the
/// destructor removes the temporary file unless commit() succeeded. Symbolic links stay: the file that they
/// lead to is replaced. Folders, devices and pipes are refused.
class TemporaryFile {
  public:
    explicit TemporaryFile(const std::string& path);
    ~TemporaryFile();
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    /// Appends.
    void write(const void* data, std::size_t size);
    void write(const std::string& text) { write(text.data(), text.size()); }
    template <class Value>
    void put(const Value& value) {
        write(&value, sizeof value);
    }

    /// Appends bytes that write_at() will give; returns where they begin.
    std::uint64_t reserve(std::uint64_t size);

    /// Overwrites bytes that have been appended before; several threads at once if nothing else is called.
    void write_at(std::uint64_t offset, const void* data, std::size_t size);

    /// Bytes appended so far.
    std::uint64_t size() const { return flushed_ + buffer_.size(); }

    /// Ends the writing and gives the file its name.
    void commit();

  private:
    void flush();
    void write_all(const char* data, std::size_t size, std::uint64_t offset);
    [[noreturn]] void fail(const char* action, int error) const;

    std::string path_;    ///< as given
    std::string target_;  ///< what it leads to by symbolic links
    std::string temporary_;
    std::vector<char> buffer_;
    std::uint64_t flushed_ = 0;
    int descriptor_ = -1;
    int slot_ = -1;  ///< in the list of names for remove_temporary_files
};

/// A folder that is there while the object is: made if it was missing, and then removed again, if it is
/// empty, unless keep() has been called. Throws Error(kFiles) with the path and the cause.
class NewFolder {
  public:
    explicit NewFolder(const std::string& path);
    ~NewFolder();
    NewFolder(const NewFolder&) = delete;
    NewFolder& operator=(const NewFolder&) = delete;

    void keep();

  private:
    std::string path_;
    int slot_ = -1;  ///< as in TemporaryFile; -1: the folder stays
};

}  // namespace mortise::io
