// Checked reading (POSIX).
#include "host/io/file_reader.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "host/io/descriptor.hpp"
#include "mortise/error.hpp"

namespace mortise::io {
namespace {

constexpr std::size_t kReadSize = std::size_t{1} << 20;
constexpr std::size_t kLineLimit = std::size_t{1} << 16;

[[noreturn]] void fail(const std::string& path, int error) {
    throw Error(ExitCode::kFiles, "cannot read '" + path + "': " + std::strerror(error));
}

}  // namespace

FileReader::FileReader(const std::string& path) : path_(path) {
    descriptor_ = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor_ < 0) fail(path, errno);
    struct stat status;
    int error = fstat(descriptor_, &status) == 0 ? 0 : errno;
    if (error == 0 && S_ISDIR(status.st_mode)) error = EISDIR;
    if (error == 0 && !S_ISREG(status.st_mode)) error = ESPIPE;
    if (error != 0) {
        close(descriptor_);
        fail(path, error);
    }
    size_ = static_cast<std::uint64_t>(status.st_size);
}

FileReader::~FileReader() { close(descriptor_); }

void FileReader::read_at(std::uint64_t offset, void* data, std::size_t size) const {
    if (offset > size_ || size > size_ - offset) damaged("it ends too early");
    constexpr int kAtEnd = -1;  // it has become shorter since it was opened
    const int error = read_all(descriptor_, static_cast<char*>(data), size, offset, kAtEnd);
    if (error == kAtEnd) damaged("it ends too early");
    if (error != 0) fail(path_, error);
}

void FileReader::damaged(const std::string& what) const {
    throw Error(ExitCode::kInput, "'" + path_ + "' is damaged or was not written by mortise: " + what);
}

void SequentialReader::expect(std::uint64_t count, std::uint64_t size) const {
    if (count > remaining() / size) file_.damaged("it ends too early");
}

void SequentialReader::read(void* data, std::size_t size) {
    char* bytes = static_cast<char*>(data);
    while (size > 0) {
        const std::uint64_t used = position_ - buffer_start_;
        if (used >= buffer_.size()) {
            if (size > remaining()) file_.damaged("it ends too early");
            buffer_start_ = position_;
            buffer_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kReadSize, remaining())));
            file_.read_at(position_, buffer_.data(), buffer_.size());
            continue;
        }
        const std::size_t part = std::min(size, static_cast<std::size_t>(buffer_.size() - used));
        std::memcpy(bytes, buffer_.data() + used, part);
        bytes += part;
        size -= part;
        position_ += part;
    }
}

std::string SequentialReader::line() {
    std::string text;
    while (true) {
        const char c = get<char>();
        if (c == '\n') return text;
        if (text.size() == kLineLimit) file_.damaged("a line of text does not end");
        text += c;
    }
}

}  // namespace mortise::io
