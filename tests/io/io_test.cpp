// Mesh files: exact round trips, refusals with a reason, nothing left behind, no harm from damaged bytes.
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

#include <doctest/doctest.h>

#include "host/io/element_table.hpp"
#include "host/io/temporary_file.hpp"
#include "mortise/check.hpp"
#include "mortise/error.hpp"
#include "mortise/io.hpp"
#include "tests/io/files.hpp"
#include "tests/io/folder.hpp"
#include "tests/quality/sample_meshes.hpp"

using namespace mortise;
using namespace mortise::samples;
namespace fs = std::filesystem;

namespace {

void check_equal(const Mesh& a, const Mesh& b, bool with_kind) {
    CHECK(a.points.size() == b.points.size());
    // Bytes, not values: signs of zeros and NaN payloads count.
    CHECK((a.points.empty() || std::memcmp(a.points.data(), b.points.data(), 8 * a.points.size()) == 0));
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        CHECK(a.elements[t].nodes == b.elements[t].nodes);
        CHECK(a.elements[t].middles == b.elements[t].middles);
        CHECK(a.elements[t].region == b.elements[t].region);
        if (with_kind) CHECK(a.elements[t].kind == b.elements[t].kind);
        CHECK(a.elements[t].kind.size() == b.elements[t].kind.size());
    }
    CHECK(a.facets.nodes == b.facets.nodes);
    CHECK(a.facets.middles == b.facets.middles);
    CHECK(a.facets.surface == b.facets.surface);
    CHECK(a.facets.inside == b.facets.inside);
    CHECK(a.facets.outside == b.facets.outside);
    CHECK(a.region_names == b.region_names);
    CHECK(a.surface_names == b.surface_names);
}

void write_bytes(const std::string& path, const std::string& bytes) {
    // Some file systems wait for the disk when a file is truncated and written again.
    fs::remove(path);
    std::ofstream(path, std::ios::binary) << bytes;
}

struct FileKind {
    std::string extension;
    MeshFileOptions options;
};
const FileKind kKinds[] = {{".vtu", {}}, {".vtu", {false}}, {".msh", {}}};

}  // namespace

TEST_CASE("round trips are exact: all types, several regions, nothing at all") {
    const Folder folder;
    std::vector<Mesh> meshes = {mixed(), three_regions(), Mesh{}};
    for (int t = 0; t < kElementTypes; ++t) meshes.push_back(unit_element(static_cast<ElementType>(t)));
    Mesh no_facets = mixed();
    no_facets.facets = {};
    no_facets.points[0] = -0.0;
    meshes.push_back(no_facets);
    for (std::size_t i = 0, count = meshes.size(); i < count; ++i) meshes.push_back(with_middles(meshes[i]));
    for (const Mesh& mesh : meshes) {
        for (const auto& [format, options] : kKinds) {
            CAPTURE(format);
            CAPTURE(options.compress);
            const std::string path = folder.file("mesh" + format);
            write_mesh(mesh, path, {}, options);
            check_equal(mesh, read_mesh(path), format == ".vtu");
        }
    }
    CHECK(folder.entries() == 2);
}

TEST_CASE("periodic nodes come back") {
    const Folder folder;
    Mesh second_order = with_middles(periodic_grid(2));
    pair_nodes(second_order);
    for (const Mesh& mesh : {periodic_grid(4), second_order}) {
        for (const auto& [format, options] : kKinds) {
            CAPTURE(format);
            const std::string path = folder.file("mesh" + format);
            write_mesh(mesh, path, {}, options);
            const Mesh back = read_mesh(path);
            check_equal(mesh, back, format == ".vtu");
            REQUIRE(back.periodic.size() == 2);
            for (std::size_t pair = 0; pair < 2; ++pair) {
                CHECK(back.periodic[pair].shift == mesh.periodic[pair].shift);
                CHECK(back.periodic[pair].node == mesh.periodic[pair].node);
                CHECK(back.periodic[pair].original == mesh.periodic[pair].original);
            }
            MeshFileOptions scaled = options;
            scaled.scale = 2;
            write_mesh(mesh, path, {}, scaled);
            CHECK(read_mesh(path).periodic[0].shift[0] == 2 * mesh.periodic[0].shift[0]);
        }
    }
    // Copies that share an original, and one that is its own.
    for (const bool is_own : {false, true}) {
        Mesh folded = periodic_grid(2);
        PeriodicNodes& pair = folded.periodic[0];
        pair.original[0] = is_own ? pair.node[0] : pair.original[1];
        for (const char* name : {"folded.vtu", "folded.msh", "polyMesh"})
            CHECK(error_of([&] { write_mesh(folded, folder.file(name)); }).code() == ExitCode::kMeshing);
    }
    // A pair without nodes comes back, too, from a .vtu.
    Mesh broken = periodic_grid(2);
    broken.periodic[1].original[0] = 1000;
    CHECK_THROWS_AS(write_mesh(broken, folder.file("broken.vtu")), Error);
    broken.periodic[1].original.pop_back();
    CHECK_THROWS_AS(write_mesh(broken, folder.file("broken.vtu")), Error);
}

TEST_CASE("round trip of arrays longer than one block, and of incompressible ones") {
    const Folder folder;
    Mesh mesh = grid(40, 40, 40, 2, [](int i, int j, int k) { return (i + j + k) % 2 + 1; });
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> shift(-0.2, 0.2);
    for (std::size_t i = mesh.points.size() / 2; i < mesh.points.size(); ++i) mesh.points[i] += shift(random);
    for (const auto& [format, options] : kKinds) {
        const std::string path = folder.file("large" + format);
        write_mesh(mesh, path, {}, options);
        check_equal(mesh, read_mesh(path), true);
        const std::string first = read_bytes(path);
        write_mesh(mesh, path, {}, options);
        CHECK(read_bytes(path) == first);
    }
}

TEST_CASE("names of any kind survive") {
    const Folder folder;
    Mesh mesh = mixed();
    mesh.region_names = {"steel \"A\"", "100% \xc3\xa9t\xc3\xa9\nnext <&>"};
    mesh.surface_names = {"", "outer:wall|1", "name 2"};
    for (const auto& [format, options] : kKinds) {
        const std::string path = folder.file("names" + format);
        write_mesh(mesh, path, {}, options);
        check_equal(mesh, read_mesh(path), false);
    }
}

TEST_CASE("the file's cell arrays are announced") {
    const Folder folder;
    const std::string path = folder.file("mesh.vtu");
    write_mesh(mixed(), path);
    const std::string bytes = read_bytes(path);
    for (const char* name :
         {"region", "kind", "scaled_jacobian", "connectivity", "offsets", "types", "Points"})
        CHECK(bytes.find("Name=\"" + std::string(name) + "\"") != std::string::npos);
}

TEST_CASE("scaled Jacobians that are known are written as they are") {
    const Folder folder;
    const Mesh mesh = mixed();
    std::vector<float> jacobians = scaled_jacobians(mesh);
    write_mesh(mesh, folder.file("computed.vtu"));
    write_mesh(mesh, folder.file("given.vtu"), jacobians);
    CHECK(read_bytes(folder.file("computed.vtu")) == read_bytes(folder.file("given.vtu")));
    jacobians[0] = 0.125f;
    write_mesh(mesh, folder.file("other.vtu"), jacobians);
    CHECK(read_bytes(folder.file("computed.vtu")) != read_bytes(folder.file("other.vtu")));
    jacobians.pop_back();
    CHECK(error_of([&] { write_mesh(mesh, folder.file("few.vtu"), jacobians); }).code() ==
          ExitCode::kMeshing);
}

TEST_CASE(
    "formats wind elements as documented: VTK's wedge has its first triangle facing away from the other") {
    // Triple product of the edges from the format's first node to its second, third and the one above it.
    const auto orientation = [](ElementType type, const io::FormatElement& format, int second, int third,
                                int above) {
        const Mesh mesh = unit_element(type);
        const auto edge = [&](int node, int axis) {
            const auto point = [&](int n) {
                return mesh
                    .points[static_cast<std::size_t>(3 * format.nodes[static_cast<std::size_t>(n)] + axis)];
            };
            return point(node) - point(0);
        };
        double sum = 0;
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            sum += edge(above, i) * (edge(second, j) * edge(third, k) - edge(second, k) * edge(third, j));
        }
        return sum > 0 ? 1 : -1;
    };
    CHECK(orientation(ElementType::kHexahedron, io::kElementTable[0].vtk, 1, 3, 4) == 1);
    CHECK(orientation(ElementType::kWedge, io::kElementTable[1].vtk, 1, 2, 3) == -1);
    CHECK(orientation(ElementType::kPyramid, io::kElementTable[2].vtk, 1, 3, 4) == 1);
    CHECK(orientation(ElementType::kTetrahedron, io::kElementTable[3].vtk, 1, 2, 3) == 1);
    CHECK(orientation(ElementType::kHexahedron, io::kElementTable[0].gmsh, 1, 3, 4) == 1);
    CHECK(orientation(ElementType::kWedge, io::kElementTable[1].gmsh, 1, 2, 3) == 1);
    CHECK(orientation(ElementType::kPyramid, io::kElementTable[2].gmsh, 1, 3, 4) == 1);
    CHECK(orientation(ElementType::kTetrahedron, io::kElementTable[3].gmsh, 1, 2, 3) == 1);
}

TEST_CASE("second order has no place in OpenFOAM's meshes") {
    const Folder folder;
    const Error error = error_of([&] { write_mesh(with_middles(mixed()), folder.file("polyMesh")); });
    CHECK(error.code() == ExitCode::kUsage);
    CHECK(std::string(error.what()).find("no elements of second order") != std::string::npos);
    CHECK(folder.entries() == 0);
}

TEST_CASE("the table's middles of second order lie between its corners as the formats say") {
    // Ends of the edges in whose middles the formats' further nodes lie, in the formats' own numbers: VTK's
    // and Gmsh's documentation.
    const std::vector<std::vector<LocalEdge>> gmsh = {
        {{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 5}, {2, 3}, {2, 6}, {3, 7}, {4, 5}, {4, 7}, {5, 6}, {6, 7}},
        {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 4}, {2, 5}, {3, 4}, {3, 5}, {4, 5}},
        {{0, 1}, {0, 3}, {0, 4}, {1, 2}, {1, 4}, {2, 3}, {2, 4}, {3, 4}},
        {{0, 1}, {1, 2}, {2, 0}, {3, 0}, {3, 2}, {3, 1}}};
    const std::vector<std::vector<LocalEdge>> vtk = {
        {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}},
        {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}},
        {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}},
        {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        for (const auto& [format, edges] :
             {std::pair(io::kElementTable[t].gmsh, gmsh[t]), std::pair(io::kElementTable[t].vtk, vtk[t])}) {
            CHECK(edges.size() == io::middles_per_element(t));
            for (std::size_t k = 0; k < edges.size(); ++k) {
                const int a = format.nodes[static_cast<std::size_t>(edges[k][0])];
                const int b = format.nodes[static_cast<std::size_t>(edges[k][1])];
                CHECK(local_edge(static_cast<ElementType>(t), a, b) == format.middles[k]);
            }
        }
    }
}

TEST_CASE("unknown extensions are usage errors") {
    for (const char* path : {"mesh", "mesh.obj", "folder.vtu/mesh", ".vtu", "mesh.VTX", ""}) {
        CAPTURE(path);
        const auto check = [](const Error& error, const char* expected) {
            CHECK(error.code() == ExitCode::kUsage);
            CHECK(std::string(error.what()).find(expected) != std::string::npos);
        };
        const char* const written = "expected .vtu, .msh, .inp, .stl (the surface), or a folder polyMesh";
        check(error_of([&] { write_mesh(mixed(), path); }), written);
        check(error_of([&] { check_writable(path); }), written);
        check(error_of([&] { read_mesh(path); }), "expected .vtu or .msh");
    }
}

TEST_CASE("missing and unwritable folders") {
    const Folder folder;
    for (const auto& [format, options] : kKinds) {
        const std::string missing = folder.file("none/mesh" + format);
        for (const Error& error :
             {error_of([&] { write_mesh(mixed(), missing); }), error_of([&] { check_writable(missing); }),
              error_of([&] { read_mesh(missing); })}) {
            CHECK(error.code() == ExitCode::kFiles);
            CHECK(std::string(error.what()).find(missing) != std::string::npos);
            CHECK(std::string(error.what()).find(std::strerror(ENOENT)) != std::string::npos);
        }
        check_writable(folder.file("mesh" + format));
        CHECK(folder.entries() == 0);
    }
    // A folder where the file should be, and a file where the folder should be.
    fs::create_directory(folder.path / "taken.vtu");
    CHECK(error_of([&] { check_writable(folder.file("taken.vtu")); }).code() == ExitCode::kFiles);
    CHECK(error_of([&] { write_mesh(mixed(), folder.file("taken.vtu")); }).code() == ExitCode::kFiles);
    CHECK(error_of([&] { read_mesh(folder.file("taken.vtu")); }).code() == ExitCode::kFiles);
    write_bytes(folder.file("plain"), "x");
    CHECK(error_of([&] { check_writable(folder.file("plain/mesh.vtu")); }).code() == ExitCode::kFiles);
    CHECK(folder.entries() == 2);
    if (geteuid() != 0) {  // root may write anywhere
        fs::create_directory(folder.path / "locked");
        fs::permissions(folder.path / "locked", fs::perms::owner_read | fs::perms::owner_exec);
        CHECK(error_of([&] { check_writable(folder.file("locked/mesh.vtu")); }).code() == ExitCode::kFiles);
    }
}

TEST_CASE("a full disk: an error with the cause, the old file whole, the temporary file gone") {
    const Folder folder;
    const Mesh mesh = grid(30, 30, 30, 1);
    rlimit before;
    REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    for (const auto& [format, options] : kKinds) {
        const std::string path = folder.file("mesh" + format);
        write_bytes(path, "old");
        rlimit small = before;
        small.rlim_cur = 40000;
        REQUIRE(setrlimit(RLIMIT_FSIZE, &small) == 0);
        const Error error = error_of([&] { write_mesh(mesh, path, {}, options); });
        REQUIRE(setrlimit(RLIMIT_FSIZE, &before) == 0);
        CHECK(error.code() == ExitCode::kFiles);
        CHECK(std::string(error.what()) == "cannot write '" + path + "': " + std::strerror(EFBIG));
        CHECK(read_bytes(path) == "old");
    }
    std::signal(SIGXFSZ, handler);
    CHECK(folder.entries() == 2);
}

TEST_CASE("temporary files: beside the target until committed, removed otherwise") {
    const Folder folder;
    const std::string path = folder.file("data");
    {
        io::TemporaryFile file(path);
        file.write("abandoned");
        CHECK(folder.entries() == 1);
        CHECK_FALSE(fs::exists(path));
        const std::string name = fs::directory_iterator(folder.path)->path().filename().string();
        CHECK(name.find(std::to_string(getpid())) != std::string::npos);
    }
    CHECK(folder.entries() == 0);
    {
        io::TemporaryFile first(path), second(folder.file("other"));
        CHECK(folder.entries() == 2);
        io::remove_temporary_files();
        CHECK(folder.entries() == 0);
    }
    io::TemporaryFile file(path);
    file.write("0123456789");
    file.write_at(3, "xyz", 3);
    file.write("!");
    CHECK(file.size() == 11);
    file.commit();
    CHECK(read_bytes(path) == "012xyz6789!");
    io::remove_temporary_files();
    CHECK(folder.entries() == 1);
}

TEST_CASE("links stay, and what they lead to is replaced; devices and pipes are refused") {
    const Folder folder, elsewhere;
    const std::string link = folder.file("link.vtu");
    const std::string second = folder.file("second.vtu");
    const std::string target = elsewhere.file("target.vtu");
    fs::create_symlink(target, link);
    fs::create_symlink("link.vtu", second);
    for (const char* const text : {"to a file that is not there yet", "to one that is"}) {
        io::TemporaryFile file(second);
        file.write(text);
        CHECK(elsewhere.entries() >= 1);
        file.commit();
        CHECK(fs::is_symlink(link));
        CHECK(fs::is_symlink(second));
        CHECK(read_bytes(target) == text);
    }
    CHECK(elsewhere.entries() == 1);
    CHECK(folder.entries() == 2);
    const auto refusal = [](const std::string& path) {
        return std::string(error_of([&] { write_mesh(mixed(), path); }).what());
    };
    const std::string pipe = folder.file("pipe.vtu");
    REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
    CHECK(refusal(pipe) == "cannot write '" + pipe + "': it is a pipe; give the name of a file");
    CHECK(fs::is_fifo(pipe));
    const std::string device = folder.file("device.vtu");
    fs::create_symlink("/dev/null", device);
    CHECK(refusal(device) == "cannot write '" + device + "': it is a device; give the name of a file");
    const std::string loop = folder.file("loop.vtu");
    fs::create_symlink("loop.vtu", loop);
    CHECK(refusal(loop) == "cannot write '" + loop + "': its symbolic links lead nowhere");
}

TEST_CASE("meshes with indices out of range are refused before anything is written") {
    const Folder folder;
    std::vector<Mesh> meshes(5, mixed());
    const Mesh second_order = with_middles(mixed());
    meshes[0].elements[0].nodes[3] = 1000;
    meshes[1].facets.nodes[3] = 1000;
    meshes[2].facets.surface[0] = 9;
    meshes[3].elements[3].region[0] = 3;
    meshes[4].facets.inside.pop_back();
    for (int i = 0; i < 4; ++i) meshes.push_back(second_order);
    meshes[5].elements[1].middles[2] = 1000;
    meshes[6].facets.middles[0] = 1000;
    meshes[7].elements[2].middles.clear();
    meshes[8].facets.middles.clear();
    for (const Mesh& mesh : meshes) {
        for (const char* name : {"mesh.vtu", "mesh.msh"})
            CHECK(error_of([&] { write_mesh(mesh, folder.file(name)); }).code() == ExitCode::kMeshing);
        CHECK(error_of([&] { write_picture(mesh, folder.file("mesh.png")); }).code() == ExitCode::kMeshing);
    }
    CHECK(folder.entries() == 0);
}

TEST_CASE("truncated files are refused at every length") {
    const Folder folder;
    for (const auto& [format, options] : kKinds) {
        CAPTURE(format);
        CAPTURE(options.compress);
        const std::string path = folder.file("whole" + format), cut = folder.file("cut" + format);
        for (const Mesh& mesh : {with_middles(mixed()), periodic_grid(2)}) {
            write_mesh(mesh, path, {}, options);
            const std::string bytes = read_bytes(path);
            for (std::size_t size = 0; size < bytes.size(); size += size < 200 ? 1 : 7) {
                CAPTURE(size);
                write_bytes(cut, bytes.substr(0, size));
                const Error error = error_of([&] { read_mesh(cut); });
                CHECK(error.code() == ExitCode::kInput);
                CHECK(std::string(error.what()).find(cut) != std::string::npos);
            }
        }
    }
}

TEST_CASE("damaged bytes give an error or a mesh in range, never a crash") {
    const Folder folder;
    std::mt19937 random(7);
    for (const auto& [format, options] : kKinds) {
        const std::string path = folder.file("whole" + format), bad = folder.file("bad" + format);
        write_mesh(mixed(), path, {}, options);
        const std::string first_order = read_bytes(path);
        write_mesh(with_middles(mixed()), path, {}, options);
        const std::string second_order = read_bytes(path);
        write_mesh(periodic_grid(2), path, {}, options);
        const std::string periodic = read_bytes(path);
        int refused = 0;
        for (int trial = 0; trial < 6000; ++trial) {
            std::string damaged = trial % 3 == 0 ? first_order : trial % 3 == 1 ? second_order : periodic;
            const int changes = 1 + trial % 3;
            for (int i = 0; i < changes; ++i) {
                const char values[] = {'\0', '\xff', '9', '"', static_cast<char>(random()), '\x7f'};
                damaged[random() % damaged.size()] = values[random() % sizeof values];
            }
            write_bytes(bad, damaged);
            try {
                const Mesh mesh = read_mesh(bad);
                check_mesh(mesh);  // indices that are out of range would show here
                if (trial % 3 == 2) write_mesh(mesh, folder.file("polyMesh"));
            } catch (const Error& error) {
                ++refused;
                CHECK((error.code() == ExitCode::kInput || error.code() == ExitCode::kDevice ||
                       error.code() == ExitCode::kMeshing || error.code() == ExitCode::kUsage));
            }
        }
        CHECK(refused > 500);
    }
}
