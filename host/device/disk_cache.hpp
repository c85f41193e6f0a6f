// Internal to host/device: a folder of byte strings under hashed names. A missing, unwritable or damaged
// cache is never an error: load finds nothing, store does nothing.
#pragma once

#include <optional>
#include <string>

namespace mortise::device {

class DiskCache {
  public:
    /// An empty folder name makes a cache that never holds anything.
    explicit DiskCache(std::string folder) : folder_(std::move(folder)) {}

    /// What store(key) wrote last, byte for byte; nothing if the file is missing or fails its checksum.
    std::optional<std::string> load(const std::string& key) const;

    /// Written to a temporary name and renamed, so that concurrent runs see whole files only. Drops the files
    /// that were stored longest ago when there are more than kMaxFiles.
    void store(const std::string& key, const std::string& bytes) const;

    std::string file_name(const std::string& key) const;

    static constexpr std::size_t kMaxFiles = 256;

  private:
    std::string folder_;
};

/// 32 hexadecimal digits; equal keys only for equal texts, barring an accident of 2^-64.
std::string hash_text(const std::string& text);

}  // namespace mortise::device
