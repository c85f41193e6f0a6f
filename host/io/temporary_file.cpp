// Temporary files and the list of their names for signal handlers (POSIX).
#include "host/io/temporary_file.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "host/io/descriptor.hpp"
#include "mortise/error.hpp"

namespace mortise::io {
namespace {

constexpr std::size_t kWriteSize = std::size_t{1} << 22;
constexpr int kSlots = 64;
constexpr std::size_t kNameSize = 4096;

/// A name is written while its slot is kTaken and visible to the handler only while kNamed.
enum SlotState : int { kFree, kTaken, kNamed };
struct Slot {
    std::atomic<int> state{kFree};
    bool is_folder = false;
    char name[kNameSize];
};
Slot slots[kSlots];
std::atomic<unsigned> next_number{0};
static_assert(std::atomic<int>::is_always_lock_free, "remove_temporary_files runs in signal handlers");

constexpr int kMostNested = 4;  ///< folders in each other

int take_slot(const std::string& name, bool is_folder) {
    for (int i = 0; i < kSlots; ++i) {
        int expected = kFree;
        if (!slots[i].state.compare_exchange_strong(expected, kTaken)) continue;
        std::memcpy(slots[i].name, name.c_str(), name.size() + 1);
        slots[i].is_folder = is_folder;
        slots[i].state = kNamed;
        return i;
    }
    return -1;
}

/// What a path leads to by symbolic links, the last of which may lead to a file that is not there yet. A
/// chain without end leads to a link.
std::filesystem::path follow_links(std::filesystem::path path) {
    constexpr int kMostLinks = 40;
    std::error_code ignored;
    for (int i = 0; i < kMostLinks && std::filesystem::is_symlink(path, ignored); ++i) {
        const std::filesystem::path next = std::filesystem::read_symlink(path, ignored);
        path = next.is_absolute() ? next : path.parent_path() / next;
    }
    return path;
}

/// What keeps a file from being there; empty: nothing.
const char* obstacle(const std::filesystem::path& target) {
    std::error_code ignored;
    switch (std::filesystem::symlink_status(target, ignored).type()) {
        case std::filesystem::file_type::directory: return "it is a folder";
        case std::filesystem::file_type::symlink: return "its symbolic links lead nowhere";
        case std::filesystem::file_type::character:
        case std::filesystem::file_type::block: return "it is a device; give the name of a file";
        case std::filesystem::file_type::fifo:
        case std::filesystem::file_type::socket: return "it is a pipe; give the name of a file";
        default: return "";
    }
}

/// No signal arrives in this thread meanwhile: what has been made is in the list before a handler removes it.
class SignalsHeld {
  public:
    SignalsHeld() {
        sigset_t all;
        sigfillset(&all);
        pthread_sigmask(SIG_SETMASK, &all, &before_);
    }
    ~SignalsHeld() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
    SignalsHeld(const SignalsHeld&) = delete;
    SignalsHeld& operator=(const SignalsHeld&) = delete;

  private:
    sigset_t before_{};
};

}  // namespace

void remove_temporary_files() noexcept {
    for (Slot& slot : slots) {
        if (slot.state == kNamed && !slot.is_folder) unlink(slot.name);
    }
    for (int nested = 0; nested < kMostNested; ++nested) {  // whichever comes first
        for (Slot& slot : slots) {
            if (slot.state == kNamed && slot.is_folder) rmdir(slot.name);
        }
    }
}

TemporaryFile::TemporaryFile(const std::string& path) : path_(path) {
    target_ = follow_links(path).string();
    if (const char* const why = obstacle(target_); *why != '\0')
        throw Error(ExitCode::kFiles, "cannot write '" + path_ + "': " + why);
    temporary_ = target_ + "." + std::to_string(getpid()) + "-" + std::to_string(next_number++) + ".tmp";
    if (temporary_.size() >= kNameSize) fail("create", ENAMETOOLONG);
    buffer_.reserve(kWriteSize);
    slot_ = take_slot(temporary_, false);
    if (slot_ < 0) fail("create", EMFILE);
    // A file of that name can only be left over from a dead process with our number.
    unlink(temporary_.c_str());
    descriptor_ = open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ < 0) {
        const int error = errno;
        slots[slot_].state = kFree;
        fail("create", error);
    }
}

TemporaryFile::~TemporaryFile() {
    if (descriptor_ >= 0) {
        close(descriptor_);
        unlink(temporary_.c_str());
    }
    if (slot_ >= 0) slots[slot_].state = kFree;
}

void TemporaryFile::write(const void* data, std::size_t size) {
    const char* bytes = static_cast<const char*>(data);
    if (buffer_.size() + size > kWriteSize) flush();
    if (size > kWriteSize / 16) {
        flush();
        write_all(bytes, size, flushed_);
        flushed_ += size;
        return;
    }
    buffer_.insert(buffer_.end(), bytes, bytes + size);
}

std::uint64_t TemporaryFile::reserve(std::uint64_t size) {
    flush();
    const std::uint64_t begin = flushed_;
    flushed_ += size;
#if defined(__linux__)
    if (size >= kWriteSize) {
        // Space is found in one piece instead of at each write. Where that is not possible, writes go on as
        // ever, and tell if there is none.
        [[maybe_unused]] const int result =
            fallocate(descriptor_, 0, static_cast<off_t>(begin), static_cast<off_t>(size));
    }
#endif
    return begin;
}

void TemporaryFile::write_at(std::uint64_t offset, const void* data, std::size_t size) {
    if (!buffer_.empty()) flush();
    write_all(static_cast<const char*>(data), size, offset);
}

void TemporaryFile::commit() {
    flush();
    const int descriptor = descriptor_;
    descriptor_ = -1;
    // close() reports delayed write errors of network file systems.
    if (close(descriptor) != 0 || rename(temporary_.c_str(), target_.c_str()) != 0) {
        const int error = errno;
        unlink(temporary_.c_str());
        fail("write", error);
    }
}

void TemporaryFile::flush() {
    write_all(buffer_.data(), buffer_.size(), flushed_);
    flushed_ += buffer_.size();
    buffer_.clear();
}

void TemporaryFile::write_all(const char* data, std::size_t size, std::uint64_t offset) {
    const int error = io::write_all(descriptor_, data, size, offset);
    if (error != 0) fail("write", error);
}

void TemporaryFile::fail(const char* action, int error) const {
    throw Error(ExitCode::kFiles,
                "cannot " + std::string(action) + " '" + path_ + "': " + std::strerror(error));
}

NewFolder::NewFolder(const std::string& path) : path_(path) {
    const SignalsHeld held;
    const auto fail = [this](int error) {
        throw Error(ExitCode::kFiles, "cannot create '" + path_ + "': " + std::strerror(error));
    };
    struct stat status;
    if (stat(path_.c_str(), &status) == 0 && S_ISDIR(status.st_mode)) return;
    if (mkdir(path_.c_str(), 0777) != 0) fail(errno);
    slot_ = path_.size() < kNameSize ? take_slot(path_, true) : -1;
    if (slot_ < 0) {
        rmdir(path_.c_str());
        fail(EMFILE);
    }
}

NewFolder::~NewFolder() {
    if (slot_ >= 0) rmdir(path_.c_str());
    keep();
}

void NewFolder::keep() {
    if (slot_ >= 0) slots[slot_].state = kFree;
    slot_ = -1;
}

}  // namespace mortise::io
