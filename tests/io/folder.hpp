// A folder that disappears with its contents.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <iterator>
#include <string>

#include <doctest/doctest.h>

struct Folder {
    Folder() {
        std::string name = (std::filesystem::temp_directory_path() / "mortise-io-XXXXXX").string();
        REQUIRE(mkdtemp(name.data()) != nullptr);
        path = name;
    }
    ~Folder() { std::filesystem::remove_all(path); }
    std::string file(const std::string& name) const { return (path / name).string(); }
    std::size_t entries() const {
        return static_cast<std::size_t>(
            std::distance(std::filesystem::directory_iterator(path), std::filesystem::directory_iterator()));
    }
    std::filesystem::path path;
};
