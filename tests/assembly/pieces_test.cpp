// Meshes of parts of the Morton range, made apart and merged, equal the whole byte for byte.
#include <doctest/doctest.h>

#include <string>

#include "host/device/device.hpp"
#include "host/pipeline/piece.hpp"
#include "mortise/mesher.hpp"
#include "tests/assembly/regions_on_grid.hpp"
#include "tests/mesher/meshed.hpp"

using namespace mortise;

namespace {

void check_same(const Mesh& a, const Mesh& b) {
    CHECK(a.points == b.points);
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        CAPTURE(t);
        CHECK(a.elements[t].nodes == b.elements[t].nodes);
        CHECK(a.elements[t].region == b.elements[t].region);
        CHECK(a.elements[t].kind == b.elements[t].kind);
    }
    CHECK(a.facets.nodes == b.facets.nodes);
    CHECK(a.facets.surface == b.facets.surface);
    CHECK(a.facets.inside == b.facets.inside);
    CHECK(a.facets.outside == b.facets.outside);
    CHECK(a.surface_names == b.surface_names);
}

void check_pieces(const Model& model, bool templates) {
    MeshOptions options;
    options.level = 5;
    options.templates = templates;
    const Mesh whole = test::generate(model, options);
    for (const int pieces : {2, 3, 61}) {
        CAPTURE(pieces);
        options.pieces = pieces;
        check_same(whole, test::generate(model, options));
    }
}

}  // namespace

TEST_CASE("two halves of the Morton range, and other parts, merge into the same bytes") {
    for (const char* name : {"bracket", "star", "housing"}) {
        CAPTURE(name);
        const Model model = read_model(std::string(MORTISE_SOURCE_DIR "/assets/models/") + name + ".csg");
        check_pieces(model, true);
        check_pieces(model, false);
    }
}

TEST_CASE("a device with memory of its own, and scalar kernels as GPUs run them: the same bytes") {
    device::DeviceOptions device_options;
    device_options.copies = true;
    device_options.lanes = 1;
    device_options.work_group_size = 128;
    device::Device own("", device_options), shared;
    const auto mesh_on = [](device::Device& device) {
        const Model model = read_model(MORTISE_SOURCE_DIR "/assets/models/bracket.csg");
        MeshOptions options;
        options.level = 5;
        MeshReport report;
        pipeline::Stages stages(options, report);
        pipeline::Prepared prepared =
            pipeline::prepare([&]() -> device::Device& { return device; }, model, options, stages, report);
        const octree::InRegions in_regions(prepared.tree);
        pipeline::Extracted extracted;
        std::vector<assembly::Piece> pieces;
        pieces.push_back(
            pipeline::make_piece(device, options, prepared, in_regions, {}, stages, 0.4, 0.9, extracted));
        return assembly::merge(std::move(pieces), 0);
    };
    check_same(mesh_on(own), mesh_on(shared));
}

TEST_CASE("meshes larger than a device's largest allocation come in pieces with as many leaves each") {
    octree::Octree tree;
    tree.level = 4;
    tree.in_bits.resize(128);
    tree.page_shift = 7;
    tree.directory_shift = 12;
    tree.page_codes = {0};
    tree.directory = {0, 1, 1};
    for (std::uint32_t word = 0; word <= 128; ++word) {
        tree.in_rank.push_back(word < 96 ? 0 : 32 * (word - 96));  // all leaves in the last quarter
        tree.nio_rank.push_back(0);
    }
    tree.in_count = 1024;
    CHECK(pipeline::pieces_needed(tree, 1 << 30) == 1);
    CHECK(pipeline::pieces_needed(tree, 10000) == 4);  // 32 bytes of nodes each, and some for the surface
    CHECK(pipeline::piece_end(tree, 1, 4) == 32 * 104);
    CHECK(pipeline::piece_end(tree, 2, 4) == 32 * 112);
    CHECK(pipeline::piece_end(tree, 3, 4) == 32 * 120);
}

TEST_CASE("pieces of several regions with interfaces on cell faces") {
    check_pieces(parse_model(test::kRegionsOnGrid, "geo", "regions"), true);
}

TEST_CASE("a number of pieces out of range is refused") {
    Model model;
    model.add_primitive(sphere(1));
    model.regions.push_back({"ball", 0, 0, {}});
    MeshOptions options;
    options.level = 3;
    for (const int pieces : {0, -1, 5000}) {
        options.pieces = pieces;
        CHECK_THROWS_AS(test::generate(model, options), Error);
    }
}
