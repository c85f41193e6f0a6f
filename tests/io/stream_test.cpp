// Mesh files written from parts: the same bytes as from the whole mesh, wherever it is cut.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include <doctest/doctest.h>

#include "mortise/check.hpp"
#include "mortise/error.hpp"
#include "mortise/io.hpp"
#include "tests/io/folder.hpp"
#include "tests/quality/sample_meshes.hpp"

using namespace mortise;
namespace fs = std::filesystem;

namespace {

std::string bytes_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// Arrays of several blocks and of all types, with values that do not compress; node numbers are random:
/// writing does not look at them.
Mesh large_mesh(std::mt19937& random) {
    Mesh mesh;
    mesh.region_names = {"a", "b"};
    mesh.surface_names = {"s"};
    const std::size_t nodes = 150'007;
    for (std::size_t i = 0; i < 3 * nodes; ++i)
        mesh.points.push_back(1e-3 * static_cast<double>(random() % 100'000));
    for (std::size_t i = 0; i < nodes; ++i)
        mesh.model_dimension.push_back(static_cast<std::uint8_t>(random() % 4));
    const std::size_t counts[kElementTypes] = {101'003, 7, 0, 260'111};
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        ElementBlock& block = mesh.elements[t];
        for (std::size_t i = 0; i < counts[t]; ++i) {
            for (int k = 0; k < kElementNodes[t]; ++k)
                block.nodes.push_back(static_cast<NodeId>(random() % nodes));
            block.region.push_back(static_cast<std::uint16_t>(1 + random() % 2));
            block.kind.push_back(static_cast<std::uint8_t>(random() % 4));
        }
    }
    mesh.facets.nodes = {1, 2, 3, 3};
    mesh.facets.surface = {0};
    mesh.facets.inside = {1};
    mesh.facets.outside = {2};
    return mesh;
}

template <class T>
std::vector<T> slice(const std::vector<T>& values, std::size_t begin, std::size_t end, std::size_t stride) {
    return {values.begin() + static_cast<std::ptrdiff_t>(begin * stride),
            values.begin() + static_cast<std::ptrdiff_t>(end * stride)};
}

/// Writes a mesh in parts that end at random places, or are empty.
void write_in_parts(const Mesh& mesh, const std::vector<float>& jacobians, const std::string& path,
                    const MeshFileOptions& options, std::size_t parts, std::mt19937& random) {
    MeshTotals totals;
    totals.nodes = mesh.node_count();
    std::array<std::vector<std::size_t>, kElementTypes + 1> cuts;
    const auto cut = [&](std::size_t count) {
        std::vector<std::size_t> list = {0};
        for (std::size_t p = 1; p < parts; ++p) list.push_back(random() % (count + 1));
        list.push_back(count);
        std::sort(list.begin(), list.end());
        return list;
    };
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        totals.elements[t] = mesh.elements[t].size();
        cuts[t] = cut(mesh.elements[t].size());
    }
    cuts[kElementTypes] = cut(mesh.node_count());
    Mesh outline;
    outline.facets = mesh.facets;
    outline.region_names = mesh.region_names;
    outline.surface_names = mesh.surface_names;
    MeshFileStream file(path, options);
    file.begin(totals, outline);
    outline = {};
    for (std::size_t p = 0; p < parts; ++p) {
        Mesh part;
        std::vector<float> quality;
        const auto& n = cuts[kElementTypes];
        part.points = slice(mesh.points, n[p], n[p + 1], 3);
        part.model_dimension = slice(mesh.model_dimension, n[p], n[p + 1], 1);
        std::size_t first = 0;
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            const std::size_t begin = cuts[t][p], end = cuts[t][p + 1];
            const ElementBlock& block = mesh.elements[t];
            part.elements[t] = {slice(block.nodes, begin, end, static_cast<std::size_t>(kElementNodes[t])),
                                slice(block.region, begin, end, 1),
                                slice(block.kind, begin, end, 1),
                                {}};
            const auto values = slice(jacobians, first + begin, first + end, 1);
            quality.insert(quality.end(), values.begin(), values.end());
            first += block.size();
        }
        file.add(part, quality);
    }
    file.commit();
}

}  // namespace

TEST_CASE("a mesh in parts gives the bytes of the whole") {
    const Folder folder;
    std::mt19937 random(7);
    const Mesh mesh = large_mesh(random);
    std::vector<float> jacobians;
    for (std::size_t i = 0; i < mesh.element_count(); ++i)
        jacobians.push_back(1e-3f * static_cast<float>(random() % 1000));
    for (const bool compress : {true, false}) {
        write_mesh(mesh, folder.path / "whole.vtu", jacobians, {compress});
        const std::string whole = bytes_of(folder.path / "whole.vtu");
        for (const std::size_t parts : {1u, 2u, 5u, 60u}) {
            CAPTURE(compress);
            CAPTURE(parts);
            write_in_parts(mesh, jacobians, folder.path / "parts.vtu", {compress}, parts, random);
            CHECK((bytes_of(folder.path / "parts.vtu") == whole));
        }
    }
}

TEST_CASE("small meshes, whose arrays share one block") {
    const Folder folder;
    std::mt19937 random(8);
    for (Mesh mesh : {samples::mixed(), samples::unit_element(ElementType::kTetrahedron)}) {
        mesh.model_dimension.assign(mesh.node_count(), 3);
        const std::vector<float> jacobians = scaled_jacobians(mesh);
        for (const bool compress : {true, false}) {
            write_mesh(mesh, folder.path / "whole.vtu", jacobians, {compress});
            for (const std::size_t parts : {1u, 3u, 10u}) {
                write_in_parts(mesh, jacobians, folder.path / "parts.vtu", {compress}, parts, random);
                CHECK((bytes_of(folder.path / "parts.vtu") == bytes_of(folder.path / "whole.vtu")));
            }
        }
    }
}

TEST_CASE("a stream that is not committed leaves nothing behind") {
    const Folder folder;
    {
        MeshFileStream file(folder.path / "mesh.vtu");
        Mesh outline;
        outline.region_names = {"a"};
        file.begin({4, {0, 0, 0, 1}}, outline);
    }
    CHECK(fs::is_empty(folder.path));
}

TEST_CASE("only .vtu can be written in parts, and only where there is a folder") {
    const Folder folder;
    CHECK_THROWS_WITH_AS(MeshFileStream(folder.path / "mesh.msh"),
                         doctest::Contains("can be written as .vtu only"), Error);
    CHECK_THROWS_AS(MeshFileStream(folder.path / "mesh.xyz"), Error);
    CHECK_THROWS_AS(MeshFileStream(folder.path / "missing" / "mesh.vtu"), Error);
}
