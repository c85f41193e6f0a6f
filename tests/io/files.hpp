// What tests of files share: the error of a call, the bytes of a file, a mesh of several regions.
#pragma once

#include <fstream>
#include <iterator>
#include <string>

#include <doctest/doctest.h>

#include "mortise/error.hpp"
#include "tests/quality/sample_meshes.hpp"

/// The error that a call throws: its code and message.
template <class Call>
mortise::Error error_of(const Call& call) {
    try {
        call();
    } catch (const mortise::Error& error) {
        return error;
    }
    FAIL("no error");
    return mortise::Error(mortise::ExitCode::kOk, "");
}

inline std::string read_bytes(const std::string& path) {
    std::ifstream stream(path, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(stream), {});
}

inline mortise::Mesh three_regions() {
    return mortise::samples::grid(4, 3, 3, 3, [](int i, int j, int) { return i == 3 ? 2 : j == 1 ? 3 : 1; });
}
