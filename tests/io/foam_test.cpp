// OpenFOAM's polyMesh, read back by a reader of this test's own: closed cells, faces in order, patches,
// zones.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>

#include "host/io/formats.hpp"
#include "mortise/error.hpp"
#include "mortise/io.hpp"
#include "tests/io/folder.hpp"
#include "tests/quality/hanging_meshes.hpp"

using namespace mortise;
using namespace mortise::samples;
namespace fs = std::filesystem;

namespace {

/// The words of a file after its header, parentheses and braces by themselves.
std::vector<std::string> words_of(const std::string& path) {
    std::ifstream stream(path);
    std::string text{std::istreambuf_iterator<char>(stream), {}};
    text.erase(0, text.find('}') + 1);
    std::string spaced;
    for (const char c : text) {
        if (std::string("(){};").find(c) == std::string::npos) {
            spaced += c;
        } else {
            spaced += std::string(" ") + c + " ";
        }
    }
    std::istringstream words(spaced);
    return {std::istream_iterator<std::string>(words), {}};
}

std::vector<double> numbers_of(const std::string& path) {
    std::vector<double> numbers;
    for (const std::string& word : words_of(path)) {
        if (word != "(" && word != ")") numbers.push_back(std::stod(word));
    }
    return numbers;
}

using Point = std::array<double, 3>;

struct FoamMesh {
    explicit FoamMesh(const std::string& folder) {
        const std::vector<double> coordinates = numbers_of(folder + "/points");
        for (std::size_t i = 1; i + 2 < coordinates.size(); i += 3)
            points.push_back({coordinates[i], coordinates[i + 1], coordinates[i + 2]});
        CHECK(static_cast<double>(points.size()) == coordinates[0]);
        const std::vector<double> corners = numbers_of(folder + "/faces");
        for (std::size_t i = 1; i < corners.size();) {
            const auto count = static_cast<std::size_t>(corners[i++]);
            faces.emplace_back(corners.begin() + static_cast<std::ptrdiff_t>(i),
                               corners.begin() + static_cast<std::ptrdiff_t>(i + count));
            i += count;
        }
        CHECK(static_cast<double>(faces.size()) == corners[0]);
        owner = numbers_of(folder + "/owner");
        owner.erase(owner.begin());
        neighbour = numbers_of(folder + "/neighbour");
        neighbour.erase(neighbour.begin());
        patches = words_of(folder + "/boundary");
        zones = words_of(folder + "/cellZones");
    }

    std::size_t cells() const {
        return 1 + static_cast<std::size_t>(std::max(*std::max_element(owner.begin(), owner.end()),
                                                     *std::max_element(neighbour.begin(), neighbour.end())));
    }

    /// Volume of each cell, by the divergence theorem over its faces' triangles from their mean.
    std::vector<double> volumes() const {
        std::vector<double> result(cells(), 0.0);
        for (std::size_t f = 0; f < faces.size(); ++f) {
            Point mean{};
            for (const std::size_t node : faces[f]) {
                for (std::size_t j = 0; j < 3; ++j)
                    mean[j] += points[node][j] / static_cast<double>(faces[f].size());
            }
            double sum = 0;
            for (std::size_t k = 0; k < faces[f].size(); ++k) {
                const Point& a = points[faces[f][k]];
                const Point& b = points[faces[f][(k + 1) % faces[f].size()]];
                sum += (mean[0] * (a[1] * b[2] - a[2] * b[1]) + mean[1] * (a[2] * b[0] - a[0] * b[2]) +
                        mean[2] * (a[0] * b[1] - a[1] * b[0])) /
                       6;
            }
            result[static_cast<std::size_t>(owner[f])] += sum;
            if (f < neighbour.size()) result[static_cast<std::size_t>(neighbour[f])] -= sum;
        }
        return result;
    }

    /// Each cell's faces run along each of its edges once in both directions.
    bool cells_are_closed() const {
        std::vector<std::map<std::pair<std::size_t, std::size_t>, int>> edges(cells());
        for (std::size_t f = 0; f < faces.size(); ++f) {
            for (std::size_t k = 0; k < faces[f].size(); ++k) {
                const std::size_t a = faces[f][k], b = faces[f][(k + 1) % faces[f].size()];
                ++edges[static_cast<std::size_t>(owner[f])][{a, b}];
                if (f < neighbour.size()) ++edges[static_cast<std::size_t>(neighbour[f])][{b, a}];
            }
        }
        for (const auto& cell : edges) {
            for (const auto& [edge, count] : cell) {
                const auto back = cell.find({edge.second, edge.first});
                if (count != 1 || back == cell.end() || back->second != 1) return false;
            }
        }
        return true;
    }

    /// owner < neighbour, and inner faces ascend by both.
    bool is_upper_triangular() const {
        for (std::size_t f = 0; f < neighbour.size(); ++f) {
            if (owner[f] >= neighbour[f]) return false;
            if (f > 0 &&
                std::make_pair(owner[f - 1], neighbour[f - 1]) >= std::make_pair(owner[f], neighbour[f]))
                return false;
        }
        return true;
    }

    std::vector<Point> points;
    std::vector<std::vector<std::size_t>> faces;
    std::vector<double> owner, neighbour;
    std::vector<std::string> patches, zones;
};

/// The number after a word, the n-th time that it occurs.
int number_after(const std::vector<std::string>& words, const std::string& word, int n = 1) {
    for (std::size_t i = 0; i + 1 < words.size(); ++i) {
        if (words[i] == word && --n == 0) return std::stoi(words[i + 1]);
    }
    return -1;
}

bool holds(const std::vector<std::string>& words, const std::string& word) {
    return std::find(words.begin(), words.end(), word) != words.end();
}

Error error_of(const Mesh& mesh, const std::string& path) {
    try {
        write_mesh(mesh, path);
    } catch (const Error& error) {
        return error;
    }
    FAIL("no error");
    return Error(ExitCode::kOk, "");
}

}  // namespace

TEST_CASE("elements of all types as polyhedra") {
    const Folder folder;
    const std::string path = folder.file("polyMesh");
    const Mesh mesh = mixed();
    write_mesh(mesh, path);
    const FoamMesh foam(path);
    CHECK(foam.points.size() == mesh.node_count());
    for (std::size_t i = 0; i < mesh.points.size(); ++i) CHECK(foam.points[i / 3][i % 3] == mesh.points[i]);
    CHECK(foam.cells() == 4);
    CHECK(foam.cells_are_closed());
    CHECK(foam.is_upper_triangular());
    CHECK(foam.neighbour.size() == 3);
    const std::vector<double> volumes = foam.volumes();
    CHECK(volumes[0] == doctest::Approx(1));
    CHECK(volumes[1] == doctest::Approx(0.5));
    CHECK(volumes[2] == doctest::Approx(1.0 / 3));
    CHECK(volumes[3] > 0);
    // One outer surface; a zone for each region.
    CHECK(foam.patches.front() == "1");
    CHECK(holds(foam.patches, "wall"));
    CHECK(number_after(foam.patches, "nFaces") == static_cast<int>(foam.faces.size()) - 3);
    CHECK(number_after(foam.patches, "startFace") == 3);
    CHECK(foam.zones.front() == "2");
    CHECK(holds(foam.zones, "region_1"));
    CHECK(holds(foam.zones, "region_2"));
}

TEST_CASE("patches of type wall, where the caller names them") {
    const Folder folder;
    const std::string path = folder.file("polyMesh");
    Mesh mesh = mixed();
    mesh.surface_names[0] = "hull";
    MeshFileOptions options;
    for (const bool named : {false, true}) {
        options.walls = {named ? "hull" : "interface_1"};
        write_mesh(mesh, path, {}, options);
        CHECK(holds(FoamMesh(path).patches, "wall") == named);
        CHECK(holds(FoamMesh(path).patches, "patch") == !named);
    }
}

TEST_CASE("patches are the outer surfaces, in order, under names that OpenFOAM reads") {
    const Folder folder;
    Mesh mesh = grid(3, 2, 1, 1);
    mesh.surface_names = {"a wall", "a_wall", "unused"};
    for (std::size_t i = 0; i < mesh.facets.size(); i += 3) mesh.facets.surface[i] = 1;
    write_mesh(mesh, folder.file("polyMesh/"));
    const FoamMesh foam(folder.file("polyMesh"));
    CHECK(foam.cells_are_closed());
    CHECK(foam.is_upper_triangular());
    CHECK(foam.patches.front() == "2");
    CHECK(holds(foam.patches, "a_wall"));
    CHECK(holds(foam.patches, "a_wall_2"));
    const int first = number_after(foam.patches, "nFaces"), second = number_after(foam.patches, "nFaces", 2);
    CHECK(first + second == static_cast<int>(mesh.facets.size()));
    CHECK(second == static_cast<int>((mesh.facets.size() + 2) / 3));
    CHECK(number_after(foam.patches, "startFace", 2) == static_cast<int>(foam.neighbour.size()) + first);
}

TEST_CASE("periodic surfaces are cyclic patches: the same faces in the same order") {
    const Folder folder;
    const std::string path = folder.file("polyMesh");
    const Mesh mesh = periodic_grid(4);
    write_mesh(mesh, path);
    const FoamMesh foam(path);
    CHECK(foam.cells_are_closed());
    CHECK(foam.is_upper_triangular());
    CHECK(std::count(foam.patches.begin(), foam.patches.end(), "cyclic") == 4);
    CHECK(std::count(foam.patches.begin(), foam.patches.end(), "patch") == 1);
    for (std::size_t axis = 0; axis < 2; ++axis) {
        CAPTURE(axis);
        const std::string low = std::string(1, "xy"[axis]) + "min", high = std::string(1, "xy"[axis]) + "max";
        const auto entry = [&](const std::string& name) {
            const std::vector<std::string> head = {name, "{"};
            return std::search(foam.patches.begin(), foam.patches.end(), head.begin(), head.end());
        };
        const auto start = [&](const std::string& name) {
            return static_cast<std::size_t>(number_after({entry(name), foam.patches.end()}, "startFace"));
        };
        // Each names the other.
        const auto partner = [&](const std::string& name) {
            return *(std::find(entry(name), foam.patches.end(), "neighbourPatch") + 1);
        };
        CHECK(partner(low) == high);
        CHECK(partner(high) == low);
        for (std::size_t i = 0; i < 16; ++i) {
            const std::vector<std::size_t>& first = foam.faces[start(low) + i];
            const std::vector<std::size_t>& second = foam.faces[start(high) + i];
            REQUIRE(first.size() == second.size());
            // Corner 0 is the same, and they run against each other.
            for (std::size_t k = 0; k < first.size(); ++k) {
                Point moved = foam.points[first[k]];
                moved[axis] += 1;
                CHECK(moved == foam.points[second[(second.size() - k) % second.size()]]);
            }
        }
    }
}

TEST_CASE("numbers that OpenFOAM and CalculiX do not have are refused") {
    CHECK_NOTHROW(io::check_numbers(0x7fffffff, "polyMesh"));
    CHECK_THROWS_WITH_AS(io::check_numbers(0x80000000, "polyMesh"),
                         doctest::Contains("2147483648 elements or faces"), Error);
}

TEST_CASE("a face with hanging nodes is four") {
    const Folder folder;
    const Mesh mesh = large_among_small();
    write_mesh(mesh, folder.file("polyMesh"));
    const FoamMesh foam(folder.file("polyMesh"));
    CHECK(foam.cells() == 57);
    CHECK(foam.cells_are_closed());
    CHECK(foam.is_upper_triangular());
    const std::vector<double> volumes = foam.volumes();
    CHECK(volumes.back() == doctest::Approx(8));
    for (std::size_t i = 0; i < 56; ++i) CHECK(volumes[i] == doctest::Approx(1));
    // The larger cube has 24 faces, all of four corners.
    CHECK(std::count(foam.neighbour.begin(), foam.neighbour.end(), 56.0) == 24);
    for (const auto& face : foam.faces) CHECK(face.size() == 4);
}

TEST_CASE("edges with hanging nodes have a corner more") {
    const Folder folder;
    write_mesh(large_among_small(3), folder.file("polyMesh"));
    const FoamMesh foam(folder.file("polyMesh"));
    CHECK(foam.cells_are_closed());
    CHECK(foam.is_upper_triangular());
    std::size_t with_eight = 0;
    for (const auto& face : foam.faces) with_eight += face.size() == 8;
    CHECK(with_eight == 2);  // between the large cubes
}

TEST_CASE("a .vtu keeps hanging nodes, a .msh is refused") {
    const Folder folder;
    const Mesh mesh = large_among_small();
    write_mesh(mesh, folder.file("a.vtu"));
    const Mesh back = read_mesh(folder.file("a.vtu"));
    CHECK(back.hanging.node == mesh.hanging.node);
    CHECK(back.hanging.masters == mesh.hanging.masters);
    const Error error = error_of(mesh, folder.file("a.msh"));
    CHECK(error.code() == ExitCode::kUsage);
    CHECK(std::string(error.what()).find("hanging") != std::string::npos);
    CHECK(folder.entries() == 1);
}

TEST_CASE("another mesh in the folder is replaced, what else lies there stays") {
    const Folder folder;
    const std::string path = folder.file("polyMesh");
    write_mesh(grid(2, 2, 2, 1), path);
    for (const char* name : {"faceZones", "points.gz", "cellLevel", "notes"})
        std::ofstream(path + "/" + name) << "old";
    write_mesh(mixed(), path);
    CHECK(FoamMesh(path).cells() == 4);
    CHECK(fs::exists(path + "/notes"));
    for (const char* name : {"faceZones", "points.gz", "cellLevel"})
        CHECK_FALSE(fs::exists(path + "/" + name));
}

TEST_CASE("nothing is left of a polyMesh that cannot be written") {
    const Folder folder;
    Mesh broken = mixed();
    broken.facets = {};  // outer faces without a surface
    for (const char* path : {"polyMesh", "case/constant/polyMesh"}) {
        CHECK_NOTHROW(check_writable(folder.file(path)));
        CHECK(error_of(broken, folder.file(path)).code() == ExitCode::kMeshing);
        CHECK(folder.entries() == 0);
    }
    CHECK(error_of(mixed(), folder.file("a/missing/case/polyMesh")).code() == ExitCode::kFiles);
    CHECK_THROWS_AS(check_writable(folder.file("a/missing/case/polyMesh")), Error);
    std::ofstream(folder.file("polyMesh")) << "a file";
    CHECK_THROWS_AS(check_writable(folder.file("polyMesh")), Error);
    std::ofstream(folder.file("file")) << "no folder";
    for (const char* path : {"file/polyMesh", "file/constant/polyMesh"})
        CHECK_THROWS_AS(check_writable(folder.file(path)), Error);
    std::filesystem::remove(folder.file("file"));
    std::filesystem::create_symlink("nowhere", folder.file("link"));
    CHECK_THROWS_AS(check_writable(folder.file("link/constant/polyMesh")), Error);
    std::filesystem::remove(folder.file("link"));
    CHECK(error_of(mixed(), folder.file("polyMesh")).code() == ExitCode::kFiles);
    CHECK(folder.entries() == 1);
}

TEST_CASE("only a folder of that name is OpenFOAM's") {
    for (const char* path : {"polyMesh", "polyMesh/", "case/constant/polyMesh", "/polyMesh//"})
        CHECK(is_mesh_folder(path));
    for (const char* path : {"", "/", "polymesh", "apolyMesh", "polyMesh/x", "polyMesh.vtu"})
        CHECK_FALSE(is_mesh_folder(path));
    CHECK_THROWS_AS(read_mesh("case/constant/polyMesh"), Error);
}
