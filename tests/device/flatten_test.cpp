// The include flattener and the disk cache: host code only.
#include <doctest/doctest.h>

#include <map>

#include "host/device/build_options.hpp"
#include "host/device/disk_cache.hpp"
#include "host/device/flatten.hpp"
#include "host/device/kernel_source.hpp"
#include "mortise/error.hpp"
#include "scratch.hpp"

using namespace mortise;
using namespace mortise::device;

namespace {

KernelReader reader(const std::map<std::string, std::string>& files) {
    return [files](const std::string& path) -> std::optional<std::string> {
        const auto found = files.find(path);
        if (found == files.end()) return std::nullopt;
        return found->second;
    };
}

}  // namespace

TEST_CASE("flattening takes each header once and keeps file and line") {
    const std::string text =
        flatten_kernel("octree/a.cl", reader({
                                          {"octree/a.cl",
                                           "// first line\n"
                                           "#include \"shared/b.h\"\n"
                                           "  #  include \"kernels/shared/c.h\" // again\n"
                                           "third\n"},
                                          {"shared/b.h", "#pragma once\n#include \"c.h\"\nb2\n"},
                                          {"shared/c.h", "c1"},
                                      }));
    CHECK(text ==
          "#line 1 \"kernels/octree/a.cl\"\n"
          "// first line\n"
          "#line 1 \"kernels/shared/b.h\"\n"
          "\n"
          "#line 1 \"kernels/shared/c.h\"\n"
          "c1\n"
          "#line 3 \"kernels/shared/b.h\"\n"
          "b2\n"
          "#line 3 \"kernels/octree/a.cl\"\n"
          "\n"
          "third\n");
}

TEST_CASE("compilers that do not heed #line: their places become files and lines") {
    const std::string text =
        "#pragma P\n" +
        flatten_kernel("a.cl", reader({{"a.cl", "#include \"b.h\"\na2\n"}, {"b.h", "b1\nb2\n"}}));
    // 1 prelude, 2 #line of a.cl, 3 #line of b.h, 4 b1, 5 b2, 6 #line, 7 a2
    CHECK(with_places("<kernel>:5:31: error: x\n<kernel>:7:1: note: y", text) ==
          "kernels/b.h:2:31: error: x\nkernels/a.cl:2:1: note: y");
    for (const std::string log :
         {"", "<kernel>:1:2: prelude", "<kernel>:", "<kernel>:99999999999999999999:1: z",
          "kernels/b.h:2:31: error", "<kernel>:5"}) {
        CHECK(with_places(log, text) == log);
    }
}

TEST_CASE("flattening takes .def files each time, and leaves comments and angle brackets alone") {
    const std::string text = flatten_kernel("a.cl", reader({
                                                        {"a.cl",
                                                         "#include \"list.def\"\n"
                                                         "#include \"list.def\"\n"
                                                         "/* block\n"
                                                         "#include \"missing.h\"\n"
                                                         "*/ #include <cstdint>\n"
                                                         "// #include \"missing.h\"\n"
                                                         "\"/*\" #include_next\n"},
                                                        {"list.def", "ITEM\n"},
                                                    }));
    CHECK(text ==
          "#line 1 \"kernels/a.cl\"\n"
          "#line 1 \"kernels/list.def\"\nITEM\n#line 2 \"kernels/a.cl\"\n"
          "#line 1 \"kernels/list.def\"\nITEM\n#line 3 \"kernels/a.cl\"\n"
          "/* block\n#include \"missing.h\"\n*/ #include <cstdint>\n// #include \"missing.h\"\n\"/*\" "
          "#include_next\n");
}

TEST_CASE("flattening names the place of an include that it cannot follow") {
    const auto flatten = [](const std::map<std::string, std::string>& files) {
        return device_error([&] { flatten_kernel("x/a.cl", reader(files)); });
    };
    CHECK(
        contains(flatten({{"x/a.cl", "\n#include \"shared/none.h\"\n"}}), "kernels/x/a.cl:2: include file"));
    CHECK(contains(flatten({{"x/a.cl", "#include \"../../etc.h\"\n"}, {"../etc.h", ""}}), "not found"));
    CHECK(contains(flatten({{"x/a.cl", "#include \"b.h\n"}}), "no closing quote"));
    CHECK(contains(flatten({{"x/a.cl", "#include \"l.def\"\n"}, {"x/l.def", "#include \"l.def\"\n"}}),
                   "kernels/x/l.def:1: includes nest deeper"));
    CHECK(contains(flatten({}), "kernels/x/a.cl not found"));
}

TEST_CASE("embedded kernels: all there, and equal to what the folder gives") {
    CHECK(embedded_kernels().size() >= 2);
    CHECK(contains(kernel_source("scan.cl", {}), "#line 1 \"kernels/scan.cl\"\n"));
    ScratchFolder folder;
    folder.write("scan.cl", "changed\n");
    CHECK(kernel_source("scan.cl", folder.path()) == "#line 1 \"kernels/scan.cl\"\nchanged\n");
    CHECK(kernel_source("probe.cl", folder.path()) == kernel_source("probe.cl", {}));
    CHECK(contains(device_error([&] { kernel_source("none.cl", folder.path()); }), "kernels/none.cl"));
    CHECK(contains(device_error([&] { kernel_source("scan.cl", folder.path() + "/none"); }),
                   "MORTISE_KERNELS"));
}

TEST_CASE("disk cache: what was stored, or nothing") {
    ScratchFolder folder;
    const DiskCache cache(folder.path() + "/new/folder");
    const std::string bytes("a\0b\xff", 4);
    CHECK_FALSE(cache.load("key"));
    cache.store("key", bytes);
    REQUIRE(cache.load("key"));
    CHECK(*cache.load("key") == bytes);
    CHECK_FALSE(cache.load("other key"));
    cache.store("key", "second");
    CHECK(*cache.load("key") == "second");

    SUBCASE("damaged anywhere, or cut off anywhere") {
        const std::string whole = read_text(cache.file_name("key"));
        for (std::size_t i = 0; i < whole.size(); ++i) {
            std::string damaged = whole;
            damaged[i] = static_cast<char>(damaged[i] ^ 1);
            std::ofstream(cache.file_name("key"), std::ios::binary) << damaged;
            CHECK_FALSE(cache.load("key"));
            std::ofstream(cache.file_name("key"), std::ios::binary) << whole.substr(0, i);
            CHECK_FALSE(cache.load("key"));
        }
    }
    SUBCASE("of another key under the same name") {
        std::filesystem::copy_file(cache.file_name("key"), cache.file_name("other key"));
        CHECK_FALSE(cache.load("other key"));
    }
    SUBCASE("a folder that cannot be made, or none") {
        for (const char* name : {"/dev/null/cache", ""}) {
            const DiskCache unusable(name);
            unusable.store("key", bytes);
            CHECK_FALSE(unusable.load("key"));
        }
    }
    SUBCASE("folders that are read only, behind its own") {
        const DiskCache behind(folder.path() + "/own", {"/dev/null/none", folder.path() + "/new/folder"});
        CHECK(*behind.load("key") == "second");
        CHECK_FALSE(behind.load("other key"));
        behind.store("key", "own");
        CHECK(*behind.load("key") == "own");
        CHECK(*cache.load("key") == "second");
        CHECK(*DiskCache("", {folder.path() + "/new/folder"}).load("key") == "second");
    }
    SUBCASE("no more than so many files") {
        for (std::size_t i = 0; i < DiskCache::kMaxFiles + 5; ++i) cache.store(std::to_string(i), "x");
        std::size_t files = 0;
        for (const auto& entry : std::filesystem::directory_iterator(folder.path() + "/new/folder")) {
            files += entry.is_regular_file() ? 1 : 0;
        }
        CHECK(files == DiskCache::kMaxFiles);
    }
}
