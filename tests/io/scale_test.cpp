// MeshFileOptions::scale: the same factor on every coordinate of every format, and on nothing else.
#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "mortise/error.hpp"
#include "mortise/io.hpp"
#include "tests/io/deck.hpp"
#include "tests/io/folder.hpp"
#include "tests/quality/sample_meshes.hpp"

using namespace mortise;
using namespace mortise::samples;

namespace {

MeshFileOptions scaled_by(double scale) {
    MeshFileOptions options;
    options.scale = scale;
    return options;
}

Mesh times(Mesh mesh, double factor) {
    for (double& value : mesh.points) value *= factor;
    return mesh;
}

/// The bytes of a file that was written.
template <class Write>
std::string bytes(const std::string& path, const Write& write) {
    write(path);
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

TEST_CASE("a scale gives the file of a mesh whose coordinates are so many times as large") {
    const Folder folder;
    constexpr double kScale = 0.001;
    const Mesh mesh = times(mixed(), 1.0 / 3), small = times(mesh, kScale);
    for (const char* name : {"a.vtu", "a.msh", "a.inp"}) {
        CAPTURE(name);
        const std::string path = folder.file(name);
        const auto made = [&](const Mesh& m, double scale) {
            return bytes(path, [&](const std::string& p) { write_mesh(m, p, {}, scaled_by(scale)); });
        };
        CHECK((made(mesh, kScale) == made(small, 1)));
        CHECK((made(mesh, kScale) != made(mesh, 1)));
    }
    const std::string foam = folder.file("polyMesh");
    const auto points = [&](const Mesh& m, double scale) {
        write_mesh(m, foam, {}, scaled_by(scale));
        return bytes(foam + "/points", [](const std::string&) {});
    };
    CHECK(points(mesh, kScale) == points(small, 1));

    Features features;
    features.corners.resize(1);
    features.curves.resize(1);
    features.curves[0].nodes = {0, 1};
    features.curves[0].length = 3;
    Features shorter = features;
    shorter.curves[0].length *= kScale;
    const auto creases = [&](const Mesh& m, const Features& f, double scale) {
        return bytes(folder.file("a.vtp"),
                     [&](const std::string& p) { write_features(m, f, p, scaled_by(scale)); });
    };
    CHECK((creases(mesh, features, kScale) == creases(small, shorter, 1)));

    MeshFileStream stream(folder.file("parts.vtu"), scaled_by(kScale));
    MeshTotals totals;
    totals.nodes = mesh.node_count();
    for (std::size_t t = 0; t < kElementTypes; ++t) totals.elements[t] = mesh.elements[t].size();
    Mesh part = mesh;
    part.model_dimension.assign(mesh.node_count(), 3);
    const std::vector<float> jacobians(mesh.element_count(), 1);
    stream.begin(totals, part);
    stream.add(part, jacobians);
    stream.commit();
    CHECK((bytes(folder.file("parts.vtu"), [](const std::string&) {}) ==
           bytes(folder.file("whole.vtu"),
                 [&](const std::string& p) { write_mesh(part, p, jacobians, scaled_by(kScale)); })));
}

TEST_CASE("a scale that is none is refused, and no file is made") {
    const Folder folder;
    for (const double scale : {0.0, -1.0, 1e13, 1e-13, std::numeric_limits<double>::infinity(),
                               std::numeric_limits<double>::quiet_NaN()}) {
        CAPTURE(scale);
        CHECK_THROWS_AS(write_mesh(mixed(), folder.file("a.vtu"), {}, scaled_by(scale)), Error);
        CHECK_THROWS_AS(write_features(mixed(), Features{}, folder.file("a.vtp"), scaled_by(scale)), Error);
        CHECK_THROWS_AS(MeshFileStream(folder.file("a.vtu"), scaled_by(scale)), Error);
    }
    CHECK(folder.entries() == 0);
}
