// See disk_cache.hpp. File: "MORTISE1", the key's length (8 bytes) and text, the hash of the content (32
// digits), the content. The whole key is compared, so that a collision of names costs time only.
#include "host/device/disk_cache.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>
#include <vector>

namespace mortise::device {
namespace {

namespace fs = std::filesystem;

constexpr char kMagic[] = "MORTISE1";
constexpr std::size_t kMagicSize = 8;
constexpr std::size_t kHashSize = 32;

std::string header(const std::string& key) {
    const std::uint64_t size = key.size();
    std::array<char, sizeof size> bytes;
    std::memcpy(bytes.data(), &size, sizeof size);
    return std::string(kMagic, kMagicSize) + std::string(bytes.data(), bytes.size()) + key;
}

/// The content of one file, if it is whole and was stored under this key.
std::optional<std::string> load_file(const std::string& path, const std::string& key) {
    std::ifstream file(path, std::ios::binary);
    if (!file) return std::nullopt;
    std::ostringstream all;
    all << file.rdbuf();
    const std::string bytes = all.str();
    const std::string expected = header(key);
    if (bytes.size() < expected.size() + kHashSize || bytes.compare(0, expected.size(), expected) != 0) {
        return std::nullopt;
    }
    std::string content = bytes.substr(expected.size() + kHashSize);
    if (bytes.compare(expected.size(), kHashSize, hash_text(content)) != 0) return std::nullopt;
    return content;
}

/// Files that are being written end so; those of runs that were killed meanwhile stay, and are removed after
/// an hour.
constexpr char kUnfinished[] = ".new";
constexpr std::chrono::hours kLongestWriting{1};

/// A file of its own for this writer, which the umask lets others read as it does any file: what is installed
/// for all users is made here too. Empty if there can be none.
std::string make_unfinished(const std::string& folder) {
    constexpr int kMostTries = 100;  // names may be taken: in containers, processes have the same numbers
    static std::atomic<unsigned> number{0};
    for (int i = 0; i < kMostTries; ++i) {
        const std::string path =
            folder + "/" + std::to_string(getpid()) + "-" + std::to_string(number++) + kUnfinished;
        const int handle = open(path.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
        if (handle < 0 && errno == EEXIST) continue;
        if (handle < 0) break;
        close(handle);
        return path;
    }
    return {};
}

/// Removes the oldest cache files beyond the limit; a file that vanishes meanwhile is another run's doing.
void trim(const std::string& folder) {
    std::error_code error;
    std::vector<std::pair<fs::file_time_type, fs::path>> files;
    std::vector<fs::path> left;
    const fs::file_time_type oldest = fs::file_time_type::clock::now() - kLongestWriting;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
        std::error_code gone;
        const fs::file_time_type time = entry->last_write_time(gone);
        const fs::path extension = entry->path().extension();
        if (extension == ".bin") files.emplace_back(time, entry->path());
        if (extension == kUnfinished && !gone && time < oldest) left.push_back(entry->path());
    }
    for (const fs::path& file : left) fs::remove(file, error);
    if (files.size() <= DiskCache::kMaxFiles) return;
    std::sort(files.begin(), files.end());
    for (std::size_t i = 0; i + DiskCache::kMaxFiles < files.size(); ++i) fs::remove(files[i].second, error);
}

}  // namespace

std::string hash_text(const std::string& text) {
    // Word by word: a run hashes some megabytes before its first kernel.
    std::uint64_t first = 14695981039346656037ull ^ text.size();
    std::uint64_t second = 0x9e3779b97f4a7c15ull;
    for (std::size_t at = 0; at < text.size(); at += sizeof(std::uint64_t)) {
        std::uint64_t word = 0;
        std::memcpy(&word, text.data() + at, std::min(sizeof word, text.size() - at));
        first = (first ^ word) * 0x9fb21c651e98df25ull;
        first ^= first >> 29;
        second = (second + word) * 0xff51afd7ed558ccdull;
        second ^= second >> 32;
    }
    static const char digits[] = "0123456789abcdef";
    std::string name;
    for (const std::uint64_t half : {first, second}) {
        for (int shift = 60; shift >= 0; shift -= 4) name += digits[(half >> shift) & 15u];
    }
    return name;
}

std::string DiskCache::file_name(const std::string& key) const {
    return folder_ + "/" + hash_text(key) + ".bin";
}

std::optional<std::string> DiskCache::load(const std::string& key) const {
    if (keeps()) {
        if (auto found = load_file(file_name(key), key)) return found;
    }
    for (const std::string& folder : read_only_) {
        if (auto found = load_file(DiskCache(folder).file_name(key), key)) return found;
    }
    return std::nullopt;
}

void DiskCache::store(const std::string& key, const std::string& bytes) const {
    if (!keeps()) return;
    std::error_code error;
    fs::create_directories(folder_, error);
    const std::string temporary = make_unfinished(folder_);
    if (temporary.empty()) return;
    std::ofstream file(temporary, std::ios::binary);
    file << header(key) << hash_text(bytes) << bytes;
    file.close();
    if (file) {
        fs::rename(temporary, file_name(key), error);
    }
    if (!file || error) {
        fs::remove(temporary, error);
        return;
    }
    trim(folder_);
}

}  // namespace mortise::device
