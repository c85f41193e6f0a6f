// Meshes of parts of the Morton range, made apart and merged, equal the whole byte for byte.
#include <doctest/doctest.h>

#include <string>

#include "mortise/mesher.hpp"
#include "tests/assembly/regions_on_grid.hpp"

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
    const Mesh whole = generate_mesh(model, options);
    for (const int pieces : {2, 3, 61}) {
        CAPTURE(pieces);
        options.pieces = pieces;
        check_same(whole, generate_mesh(model, options));
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
        CHECK_THROWS_AS(generate_mesh(model, options), Error);
    }
}
