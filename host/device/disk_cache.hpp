// Internal to host/device: a folder of byte strings under hashed names. A missing, unwritable or damaged
// cache is never an error: load finds nothing, store does nothing.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace mortise::device {

class DiskCache {
  public:
    /// An empty folder name makes a cache that keeps nothing. Where it has nothing under a key, `read_only`
    /// folders are looked into, in that order.
    explicit DiskCache(std::string folder, std::vector<std::string> read_only = {})
        : folder_(std::move(folder)), read_only_(std::move(read_only)) {}

    bool keeps() const { return !folder_.empty(); }

    /// What store(key) wrote last, byte for byte; nothing if the file is missing or fails its checksum.
    std::optional<std::string> load(const std::string& key) const;

    /// Written to a temporary name and renamed, so that concurrent runs see whole files only. Drops the files
    /// that were stored longest ago when there are more than kMaxFiles.
    void store(const std::string& key, const std::string& bytes) const;

    std::string file_name(const std::string& key) const;

    static constexpr std::size_t kMaxFiles = 256;

  private:
    std::string folder_;
    std::vector<std::string> read_only_;
};

/// 32 hexadecimal digits; equal keys only for equal texts, barring an accident of 2^-64.
std::string hash_text(const std::string& text);

}  // namespace mortise::device
