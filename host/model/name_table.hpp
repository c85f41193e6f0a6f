// Names of a file and a number for each: a hash table with open addressing, for files of millions of names.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

namespace mortise::model_reader {

/// Names are kept as views: their text outlives the table.
class NameTable {
  public:
    struct Entry {
        std::string_view name;  ///< as it was set first; no data: a free place
        std::uint32_t hash = 0;
        std::uint32_t value = 0;
    };

    /// nullptr if there is no such name. Valid until the next `set`.
    const Entry* find(std::string_view name) const {
        if (count_ == 0) return nullptr;
        const Entry& entry = entries_[place_of(name, hash_of(name))];
        return entry.name.data() == nullptr ? nullptr : &entry;
    }

    /// Gives a name its value, instead of an older one.
    void set(std::string_view name, std::uint32_t value) {
        if (2 * (count_ + 1) > entries_.size()) grow();
        const std::uint32_t hash = hash_of(name);
        Entry& entry = entries_[place_of(name, hash)];
        if (entry.name.data() == nullptr) {
            entry.name = name;
            entry.hash = hash;
            ++count_;
        }
        entry.value = value;
    }

  private:
    /// Names that differ in their last (hexadecimal) digit only lie beside each other: names are often
    /// counted, and every miss of the cache costs more than the rest of a line.
    static std::uint32_t hash_of(std::string_view name) {
        if (name.empty()) return 0;
        const std::string_view counted = name.substr(0, name.size() - 1);
        const auto last = static_cast<unsigned char>(name.back());
        const auto hash = static_cast<std::uint32_t>(std::hash<std::string_view>()(counted));
        return (hash & ~15U) | ((last + 9U * (last >> 6U)) & 15U);
    }

    /// Of the entry with that name, or of the free one where it belongs.
    std::size_t place_of(std::string_view name, std::uint32_t hash) const {
        std::size_t place = hash & (entries_.size() - 1);
        while (entries_[place].name.data() != nullptr &&
               (entries_[place].hash != hash || entries_[place].name != name)) {
            place = (place + 1) & (entries_.size() - 1);
        }
        return place;
    }

    void grow() {
        std::vector<Entry> old(entries_.empty() ? 64 : 2 * entries_.size());
        old.swap(entries_);
        for (const Entry& entry : old) {
            if (entry.name.data() != nullptr) entries_[place_of(entry.name, entry.hash)] = entry;
        }
    }

    std::vector<Entry> entries_;  ///< a power of two of them, half of them free at least
    std::size_t count_ = 0;
};

}  // namespace mortise::model_reader
