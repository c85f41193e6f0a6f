// The committed template table, combinatorially: which patterns, which facets, who agrees with whom.
#include <doctest/doctest.h>

#include <array>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string>

#include "host/templates/measure.hpp"
#include "host/templates/table.hpp"
#include "tests/templates/table_access.hpp"

using namespace mortise::templates;
using namespace template_tests;

TEST_CASE("numbering agrees with lattice.h") {
    for (int e = 0; e < kEdges; ++e) {
        CHECK(edge_corners(e)[0] == kEdgeCorners[e][0]);
        CHECK(edge_corners(e)[1] == kEdgeCorners[e][1]);
    }
    for (int f = 0; f < kFaces; ++f) {
        for (int i = 0; i < 4; ++i) {
            CHECK(on_face(kFaceCorners[f][i], f));
            CHECK(edge_between(kFaceCorners[f][i], kFaceCorners[f][(i + 1) % 4]) == kFaceEdges[f][i]);
        }
    }
}

TEST_CASE("a row has the same size on host and device") {
    static_assert(sizeof(TemplateRow) == 20, "kernels read 20-byte rows");
    CHECK(std::size(kTemplateRows) == kPatterns);
}

TEST_CASE("126 simple patterns of nine shapes have a template") {
    std::map<int, int> count;
    for (int p = 0; p < kPatterns; ++p) {
        const bool expected = p != 0 && p != 255 && is_simple(static_cast<Pattern>(p));
        CHECK(has_template(p) == expected);
        if (expected) ++count[kTemplateRows[p].shape];
    }
    // corner, edge, three in a row, face, tripod, chain of four; complements of the third, second, first
    const std::map<int, int> expected = {{1, 8},  {2, 12}, {3, 24}, {4, 6}, {5, 8},
                                         {6, 24}, {7, 24}, {8, 12}, {9, 8}};
    CHECK(count == expected);
}

TEST_CASE("the separable patterns are those that planes make: 104 with 0 and 255") {
    Random random(3);
    std::set<int> made;
    for (int i = 0; i < 200000; ++i) {
        std::array<double, 3> n{};
        for (double& x : n) x = 2 * random.uniform() - 1;
        const double offset = 6 * random.uniform() - 3;
        int pattern = 0;
        for (int c = 0; c < kCorners; ++c) {
            const double at = (c & 1) * n[0] + (c >> 1 & 1) * n[1] + (c >> 2 & 1) * n[2];
            if (at < offset) pattern |= 1 << c;
        }
        made.insert(pattern);
    }
    CHECK(made.size() == 104);
    for (int p = 1; p < 255; ++p) {
        CHECK(is_separable(static_cast<Pattern>(p)) == (made.count(p) != 0));
    }
}

TEST_CASE("rows name exactly the nodes in use") {
    for (int p = 0; p < kPatterns; ++p) {
        if (!has_template(p)) continue;
        const TemplateRow& row = kTemplateRows[p];
        CAPTURE(p);
        NodeSet used = 0;
        for (const Element& element : elements_of(p)) {
            const auto size =
                static_cast<std::size_t>(mortise::kElementNodes[static_cast<std::size_t>(element.type)]);
            for (std::size_t i = 0; i < size; ++i) used |= 1U << element.nodes[i];
        }
        CHECK((used & 0xffU) == static_cast<NodeSet>(p));
        CHECK(row.corners == p);
        CHECK((used >> kTemplateCutCode & 0xfffU) == row.cuts);
        for (int e = 0; e < kEdges; ++e) {
            const bool cut = (p >> kEdgeCorners[e][0] & 1) != (p >> kEdgeCorners[e][1] & 1);
            CHECK((row.cuts >> e & 1) == cut);
        }
        CHECK((used >> kTemplateInteriorCode & 1U) == (row.interior_mean != 0 ? 1U : 0U));
        const NodeSet fixed = row.corners | static_cast<NodeSet>(row.cuts) << kTemplateCutCode;
        CHECK((row.interior_mean & ~fixed) == 0);
    }
}

TEST_CASE("element facets pair up, or are exactly the face rule's and the surface's") {
    for (int p = 0; p < kPatterns; ++p) {
        if (!has_template(p)) continue;
        CAPTURE(p);
        std::map<std::uint32_t, Facet> open;
        bool repeated = false;
        for (const Element& element : elements_of(p)) {
            for (const Facet& facet : element_facets(element)) {
                if (open.erase(facet_key(reversed(facet))) != 0) continue;
                repeated = repeated || !open.emplace(facet_key(facet), facet).second;
            }
        }
        CHECK_FALSE(repeated);
        std::array<std::vector<Facet>, kFaces> on_faces;
        std::vector<Facet> elsewhere;
        for (const auto& item : open) {
            int face = 0;
            while (face < kFaces && (node_set(item.second) & ~face_nodes(face)) != 0) ++face;
            (face < kFaces ? on_faces[static_cast<std::size_t>(face)] : elsewhere).push_back(item.second);
        }
        for (int f = 0; f < kFaces; ++f) {
            CHECK(sorted_keys(on_faces[static_cast<std::size_t>(f)]) == sorted_keys(face_facets(p, f)));
            CHECK(sorted_keys(face_mesh(static_cast<Pattern>(p), f)) == sorted_keys(face_facets(p, f)));
        }
        CHECK(sorted_keys(elsewhere) == sorted_keys(surface_of(p)));
    }
}

TEST_CASE("neighbours agree on every shared face") {
    // Corner codes and cut codes of a side-1 face, moved to the side-0 face of the next cell.
    int pairs = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const auto moved = [&](Facet facet) {
            for (std::size_t i = 0; i < static_cast<std::size_t>(facet.size); ++i) {
                u8& node = facet.nodes[i];
                if (node < kTemplateCutCode) {
                    node = static_cast<u8>(node ^ (1 << axis));
                } else {
                    const auto ends = edge_corners(node - kTemplateCutCode);
                    node = static_cast<u8>(kTemplateCutCode +
                                           edge_between(ends[0] ^ (1 << axis), ends[1] ^ (1 << axis)));
                }
            }
            return reversed(facet);
        };
        const auto facets_on = [](int pattern, int face) {
            std::vector<Facet> facets;
            for (const Element& element : elements_of(pattern)) {
                for (const Facet& facet : element_facets(element)) {
                    if ((node_set(facet) & ~face_nodes(face)) == 0) facets.push_back(facet);
                }
            }
            return facets;
        };
        for (int p = 0; p < kPatterns; ++p) {
            if (!has_template(p)) continue;
            std::vector<Facet> left;
            for (const Facet& facet : facets_on(p, 2 * axis + 1)) left.push_back(moved(facet));
            for (int q = 0; q < kPatterns; ++q) {
                bool same = has_template(q);
                for (int c = 0; c < kCorners; ++c) {
                    if ((c >> axis & 1) == 1) same = same && (p >> c & 1) == (q >> (c ^ (1 << axis)) & 1);
                }
                if (!same) continue;
                ++pairs;
                CHECK(sorted_keys(left) == sorted_keys(facets_on(q, 2 * axis)));
            }
        }
    }
    CHECK(pairs > 3000);
}

TEST_CASE("a pattern and its complement share the surface") {
    for (int p = 0; p < kPatterns; ++p) {
        if (!has_template(p)) continue;
        std::vector<Facet> complement = surface_of(255 - p);
        for (Facet& facet : complement) facet = reversed(facet);
        CHECK(sorted_keys(surface_of(p)) == sorted_keys(complement));
    }
}

TEST_CASE("the generator reproduces the committed table byte for byte") {
    std::ifstream file(MORTISE_TEMPLATE_TABLE, std::ios::binary);
    REQUIRE(file.good());
    const std::string committed{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    const bool same = committed == table_text(build_table());
    CHECK_MESSAGE(same, "kernels/shared/template_table.h is out of date: run generate_templates on it");
}
