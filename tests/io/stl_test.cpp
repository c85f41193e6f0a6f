// Surfaces as binary STL, read back by a reader of the tests' own.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <utility>

#include "mortise/check.hpp"
#include "mortise/error.hpp"
#include "mortise/io.hpp"
#include "tests/io/folder.hpp"
#include "tests/quality/hanging_meshes.hpp"
#include "tests/quality/sample_meshes.hpp"

using namespace mortise;
using namespace mortise::samples;

namespace {

using StlPoint = std::array<float, 3>;

struct StlFile {
    std::vector<std::array<StlPoint, 3>> triangles;
    std::vector<StlPoint> normals;

    double volume() const {
        double sum = 0;
        for (const auto& [a, b, c] : triangles) {
            sum += double(a[0]) * (double(b[1]) * c[2] - double(b[2]) * c[1]) -
                   double(a[1]) * (double(b[0]) * c[2] - double(b[2]) * c[0]) +
                   double(a[2]) * (double(b[0]) * c[1] - double(b[1]) * c[0]);
        }
        return sum / 6;
    }

    /// Every edge is passed as often in one direction as in the other.
    bool is_closed() const {
        std::map<std::pair<StlPoint, StlPoint>, int> passed;
        for (const auto& corner : triangles) {
            for (std::size_t k = 0; k < 3; ++k) {
                const StlPoint &a = corner[k], &b = corner[(k + 1) % 3];
                ++passed[{a, b}];
                --passed[{b, a}];
            }
        }
        return std::all_of(passed.begin(), passed.end(), [](const auto& edge) { return edge.second == 0; });
    }
};

StlFile written_surface(const Mesh& mesh, const MeshFileOptions& options = {}) {
    const Folder folder;
    const std::string path = folder.file("mesh.stl");
    write_mesh(mesh, path, {}, options);
    CHECK(folder.entries() == 1);
    std::ifstream file(path, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(file), {});
    REQUIRE(bytes.size() >= 84);
    CHECK(bytes.compare(0, 5, "solid") != 0);
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + 80, sizeof count);
    REQUIRE(bytes.size() == 84 + 50 * std::size_t{count});
    StlFile result;
    for (std::size_t i = 0; i < count; ++i) {
        std::array<StlPoint, 4> numbers;
        std::memcpy(&numbers, bytes.data() + 84 + 50 * i, sizeof numbers);
        result.normals.push_back(numbers[0]);
        result.triangles.push_back({numbers[1], numbers[2], numbers[3]});
    }
    return result;
}

}  // namespace

TEST_CASE("the surface of any mesh is closed, seen from outside, and encloses its volume") {
    for (const Mesh& mesh : {mixed(), large_among_small(), with_middles(mixed())}) {
        const StlFile surface = written_surface(mesh);
        CHECK(surface.is_closed());
        CHECK(surface.volume() == doctest::Approx(check_mesh(mesh).volume).epsilon(1e-5));
        for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
            const auto& [a, b, c] = surface.triangles[i];
            for (const StlPoint* other : {&b, &c}) {
                double along = 0;
                for (std::size_t j = 0; j < 3; ++j)
                    along += double(surface.normals[i][j]) * (double((*other)[j]) - double(a[j]));
                CHECK(std::fabs(along) < 1e-5);
            }
        }
    }
}

TEST_CASE("coordinates are scaled, and nodes that single precision does not tell apart leave no holes") {
    MeshFileOptions metres;
    metres.scale = 0.001;
    CHECK(written_surface(mixed(), metres).volume() ==
          doctest::Approx(1e-9 * check_mesh(mixed()).volume).epsilon(1e-4));
    Mesh flat = grid(4, 4, 4, 1);
    for (std::size_t i = 0; i < flat.points.size(); i += 3) flat.points[i] = 1e6 + 1e-3 * flat.points[i];
    const StlFile surface = written_surface(flat);
    CHECK(surface.is_closed());
    CHECK(surface.triangles.size() < 2 * flat.facets.size());
}

TEST_CASE("surfaces that others have made are not written over") {
    const Folder folder;
    const std::string path = folder.file("part.stl");
    std::ofstream(path) << "solid part\nendsolid part\n";
    CHECK_THROWS_WITH_AS(write_mesh(mixed(), path), doctest::Contains("may belong to a model"), Error);
    CHECK_THROWS_WITH_AS(check_writable(path), doctest::Contains("may belong to a model"), Error);
    std::filesystem::remove(path);
    write_mesh(mixed(), path);
    CHECK_NOTHROW(check_writable(path));
    CHECK_NOTHROW(write_mesh(mixed(), path));
}

TEST_CASE(".stl files are no meshes") {
    const Folder folder;
    write_mesh(mixed(), folder.file("a.STL"));
    CHECK_THROWS_WITH_AS(read_mesh(folder.file("a.STL")), doctest::Contains("have a surface only"), Error);
}
