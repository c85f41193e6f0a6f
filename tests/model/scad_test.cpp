// .scad files: a script in place of the program openscad, so that every outcome can be had; the real one
// where it is installed.
#include <doctest/doctest.h>
#include <stdlib.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "host/model/child_process.hpp"
#include "mortise/model.hpp"
#include "tests/model/contains.hpp"
#include "tests/model/membership.hpp"

namespace fs = std::filesystem;
using namespace mortise;
using mortise::test::contains;
using mortise::test::holds;

namespace {

/// A folder with a fake openscad, alone in PATH while the object lives.
class FakeProgram {
  public:
    /// The body of a shell script; empty: not installed.
    explicit FakeProgram(const std::string& script) {
        path_ = (fs::temp_directory_path() / "mortise-scad-XXXXXX").string();
        REQUIRE(mkdtemp(path_.data()) != nullptr);
        fs::create_directory(path_ + "/bin");
        if (!script.empty()) {
            write("bin/openscad", "#!/bin/sh\n" + script + "\n");
            fs::permissions(path_ + "/bin/openscad", fs::perms::owner_all);
        }
        old_ = std::getenv("PATH");
        setenv("PATH", (path_ + "/bin").c_str(), 1);
    }
    ~FakeProgram() {
        setenv("PATH", old_.c_str(), 1);
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    FakeProgram(const FakeProgram&) = delete;
    FakeProgram& operator=(const FakeProgram&) = delete;

    std::string write(const std::string& name, const std::string& content) const {
        std::ofstream(path_ + "/" + name, std::ios::binary) << content;
        return path_ + "/" + name;
    }
    const std::string& path() const { return path_; }

  private:
    std::string path_;
    std::string old_;
};

std::string message_of(const std::string& path, const ReadOptions& options = {},
                       ExitCode code = ExitCode::kInput) {
    try {
        read_model(path, options);
    } catch (const Error& error) {
        CHECK(error.code() == code);
        return error.what();
    }
    FAIL("expected an error");
    return {};
}

ReadOptions defined(std::vector<std::string> definitions) {
    ReadOptions options;
    options.definitions = std::move(definitions);
    return options;
}

}  // namespace

TEST_CASE("scad: the converted text is read, files are looked for beside the .scad file") {
    const FakeProgram fake("echo 'ECHO: 1' >&2\necho 'import(file = \"parts/tetrahedron.off\");'");
    const std::string path = fake.write("part.scad", "whatever");
    fs::create_directory(fake.path() + "/parts");
    fake.write("parts/tetrahedron.off",
               "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
    const Model model = read_model(path);
    CHECK(model.regions.front().name == "part");
    CHECK(model.source == path);
    CHECK(model.warnings.empty());
}

TEST_CASE("scad: definitions are passed on as they are, one word each") {
    const FakeProgram fake(
        "for word in \"$@\"; do echo \"[$word]\" >&2; done\necho 'ERROR: enough' >&2\n"
        "[ \"$6\" = 'label=\"a b; $HOME\"' ] && [ \"$8\" = 'n=[1, 2]' ] && echo 'cube(2);' >&1\nexit 3");
    const std::string path = fake.write("part.scad", "label = 1; n = 2;");
    CHECK(contains(message_of(path, defined({"label=\"a b; $HOME\"", "n=[1, 2]"})), "openscad: enough"));
    const FakeProgram good(
        "[ \"$6\" = 'label=\"a b; $HOME\"' ] && [ \"$8\" = 'n=[1, 2]' ] && echo 'cube(2);'");
    const Model model = read_model(path, defined({"label=\"a b; $HOME\"", "n=[1, 2]"}));
    CHECK(model.regions.size() == 1);
}

TEST_CASE("scad: warnings of the program are warnings of the model, with their place") {
    const FakeProgram fake(
        "echo 'cube(2);'\necho 'DEPRECATED: old' >&2\n"
        "echo \"WARNING: Ignoring unknown variable 'a' in file sub/part.scad, line 7\" >&2\n"
        "echo \"WARNING: Can't open library 'x.scad'.\" >&2");
    const std::string path = fake.write("part.scad", "\n\n\n\n\n\n\ncube(a);");
    const Model model = read_model(path, defined({"b=1", "cube=2"}));
    REQUIRE(model.warnings.size() == 3);
    CHECK(model.warnings[0] == path + ":7: openscad: Ignoring unknown variable 'a'");
    CHECK(model.warnings[1] == path + ": openscad: Can't open library 'x.scad'.");
    CHECK(model.warnings[2] == path + ": --define b has no effect: the file has no 'b'");
}

TEST_CASE("scad: the program's first error, with its place") {
    const auto message = [](const std::string& script, const std::string& text = "a\nb\nc\n") {
        const FakeProgram fake(script);
        const std::string path = fake.write("part.scad", text);
        const std::string error = message_of(path);
        REQUIRE(error.compare(0, path.size(), path) == 0);
        return error.substr(path.size());
    };
    CHECK(message("echo 'WARNING: w' >&2; echo 'ERROR: Parser error: syntax error in file part.scad, line 2' "
                  ">&2; echo \"Can't parse\" >&2; exit 1") == ":2: openscad: Parser error: syntax error");
    CHECK(message("echo 'ERROR: bad in file lib/other.scad, line 2' >&2; exit 1") ==
          ": openscad: bad in file lib/other.scad, line 2");
    CHECK(message("echo 'ERROR: bad in file part.scad, line 9' >&2; exit 1") ==
          ": openscad: bad, at the end of the file");
    // A failed assertion: exit code 0.
    CHECK(message("echo 'cube(1);'; echo 'ERROR: Assertion failed in file part.scad, line 1' >&2") ==
          ":1: openscad: Assertion failed");
    CHECK(message("echo; echo 'ECHO: 1' >&2; echo 'no display' >&2; exit 4") == ": openscad: no display");
    CHECK(message("exit 4") == ": openscad: failed with exit code 4");
    CHECK(message("kill -9 $$") == ": openscad: failed with exit code 137");
    // The reader's own.
    CHECK(message("echo 'cube(1);'; echo ' roof();'") ==
          " (as .csg):2:2: 'roof' is not supported yet; disable the node with '*' to leave it out");
    CHECK(contains(message("true"), " (as .csg):1:1: the file holds no solid"));
}

TEST_CASE("scad: large output on both streams") {
    const FakeProgram fake(
        "i=0; while [ $i -lt 20000 ]; do echo 'sphere(2); // a line that says nothing'; "
        "echo 'ECHO: another line that says nothing' >&2; i=$((i+1)); done");
    const Model model = read_model(fake.write("part.scad", ""));
    CHECK(model.nodes.size() > 20000);
}

TEST_CASE("scad: a program that hangs is ended") {
    ReadOptions options;
    options.conversion_seconds = 0.5;
    const auto start = std::chrono::steady_clock::now();
    for (const char* script : {"exec /bin/sleep 60", "exec /bin/sleep 60 >/dev/null 2>&1",
                               "trap '' TERM INT; while true; do :; done"}) {
        CAPTURE(script);
        const FakeProgram fake(script);
        CHECK(contains(message_of(fake.write("part.scad", ""), options), "openscad took longer than 0.5 s"));
    }
    CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(20));
}

TEST_CASE("scad: what is left behind by the program is not waited for") {
    const FakeProgram fake("/bin/sleep 30 &\necho 'cube(2);'");
    const auto start = std::chrono::steady_clock::now();
    CHECK(read_model(fake.write("part.scad", "")).regions.size() == 1);
    CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(15));
}

TEST_CASE("scad: bad calls") {
    const FakeProgram none("");
    const std::string path = none.write("part.scad", "cube(1);");
    const std::string message = message_of(path);
    CHECK(contains(message, "apt install openscad"));
    CHECK(contains(message, "openscad -o part.csg part.scad"));
    message_of(none.path() + "/missing.scad", {}, ExitCode::kFiles);
    for (const char* bad : {"size", "=3", "si ze=3", "size=", "3=4", "$=4", "a.b=1"}) {
        CAPTURE(bad);
        CHECK(contains(message_of(path, defined({bad}), ExitCode::kUsage), "expected NAME=VALUE"));
    }
    const std::string csg = none.write("part.csg", "cube(1);");
    CHECK(contains(message_of(csg, defined({"a=1"}), ExitCode::kUsage), "only"));
    const std::string text = "cube(1);";
    CHECK_THROWS_AS(parse_model(text, "scad", "part.scad"), Error);
    // Not a program: execution fails in the child.
    const FakeProgram broken("");
    broken.write("bin/openscad", "\x7f not a program");
    fs::permissions(broken.path() + "/bin/openscad", fs::perms::owner_all);
    CHECK(contains(message_of(broken.write("part.scad", "")), "exit code 127"));
}

TEST_CASE("scad: the real program") {
    if (model_reader::find_program("openscad").empty()) {
        std::printf("scad: openscad is not installed; its test is skipped\n");
        return;
    }
    const std::string path = [] { return std::getenv("PATH"); }();
    const FakeProgram fake("");
    setenv("PATH", path.c_str(), 1);
    fs::create_directory(fake.path() + "/lib");
    fake.write("lib/inner.scad", "module inner() { import(\"../part.off\"); }");
    fake.write("part.off", "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
    const std::string scad = fake.write("a part.scad",
                                        "use <lib/inner.scad>\nside = 1; label = \"\";\nif (label == \"a "
                                        "b\") translate([5, 0, 0]) cube(side);\n"
                                        "inner();\n");
    const Model model = read_model(scad, defined({"side=2", "label=\"a b\""}));
    CHECK(model.warnings.empty());
    CHECK(holds(model, model.regions[0].root, {6.9, 1.9, 1.9}));
    CHECK_FALSE(holds(model, model.regions[0].root, {7.1, 1.9, 1.9}));
    CHECK(holds(model, model.regions[0].root, {0.1, 0.1, 0.1}));
    CHECK_FALSE(holds(model, model.regions[0].root, {0.5, 0.5, 0.5}));
    CHECK(contains(message_of(fake.write("bad.scad", "cube(1);\ncube(;\n")),
                   "/bad.scad:2: openscad: Parser error: syntax error"));
    CHECK(contains(message_of(fake.write("assert.scad", "\nassert(false, \"no\");\n")),
                   "/assert.scad:2: openscad: Assertion 'false' failed: \"no\""));
    CHECK(contains(message_of(scad, defined({"side=)"})), "or in a --define"));
    const Model warned = read_model(fake.write("warned.scad", "cube(3);\nfoo();\n"));
    REQUIRE(warned.warnings.size() == 1);
    CHECK(contains(warned.warnings[0], "/warned.scad:2: openscad: Ignoring unknown module 'foo'"));
}
