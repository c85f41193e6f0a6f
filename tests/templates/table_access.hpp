// The committed table as the tests see it: kTemplateRows unpacked, and the face rule written anew.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "host/templates/pattern.hpp"
#include "kernels/shared/lattice.h"
#include "kernels/shared/template_table.h"

namespace template_tests {

using mortise::ElementType;
using mortise::templates::Element;
using mortise::templates::Facet;
using mortise::templates::Pattern;

inline bool has_template(int pattern) { return kTemplateRows[pattern].shape != 0; }

inline std::vector<Element> elements_of(int pattern) {
    const TemplateRow& row = kTemplateRows[pattern];
    std::vector<Element> elements;
    std::size_t at = row.first_node;
    for (std::size_t type = 0; type < mortise::kElementTypes; ++type) {
        for (int i = 0; i < row.elements[type]; ++i) {
            Element element;
            element.type = static_cast<ElementType>(type);
            const auto size = static_cast<std::size_t>(mortise::kElementNodes[type]);
            for (std::size_t n = 0; n < size; ++n) element.nodes[n] = kTemplateNodes[at++];
            elements.push_back(element);
        }
    }
    return elements;
}

inline std::vector<Facet> surface_of(int pattern) {
    const TemplateRow& row = kTemplateRows[pattern];
    std::vector<Facet> facets;
    for (std::size_t i = row.first_facet; i < std::size_t{row.first_facet} + row.facets; ++i) {
        const u8* n = kTemplateFacets + 4 * i;
        facets.push_back(n[2] == n[3] ? mortise::templates::triangle(n[0], n[1], n[2])
                                      : mortise::templates::quad(n[0], n[1], n[2], n[3]));
    }
    return facets;
}

/// The face rule in the face's own frame (kFaceCorners), seen from the side of that frame's normal u x v.
inline std::vector<Facet> face_rule(int pattern, int face) {
    const u8* corner = kFaceCorners[face];
    const u8* edge = kFaceEdges[face];
    const auto in = [&](int i) { return (pattern >> corner[i % 4] & 1) != 0; };
    const auto at = [&](int i) { return corner[i % 4]; };
    const auto cut = [&](int i) { return static_cast<u8>(kTemplateCutCode + edge[i % 4]); };
    using mortise::templates::quad;
    using mortise::templates::triangle;
    const int count = in(0) + in(1) + in(2) + in(3);
    if (count == 0) return {};
    if (count == 4) return {quad(at(0), at(1), at(2), at(3))};
    int i = 0;  // the first inside corner after an outside one
    while (!in(i) || in(i + 3)) ++i;
    if (count == 1) return {triangle(at(i), cut(i), cut(i + 3))};
    if (count == 2) return {quad(at(i), at(i + 1), cut(i + 1), cut(i + 3))};
    return {triangle(at(i + 1), at(i + 2), cut(i + 2)), triangle(at(i + 1), cut(i + 2), cut(i + 3)),
            triangle(at(i + 1), cut(i + 3), at(i))};
}

/// u x v of the face's frame points out of the cell: for axis 1 the frame (x, z) is left-handed.
inline bool frame_is_outward(int face) { return (face % 2 == 1) != (face / 2 == 1); }

/// The face's facets, outward.
inline std::vector<Facet> face_facets(int pattern, int face) {
    std::vector<Facet> facets = face_rule(pattern, face);
    if (!frame_is_outward(face)) {
        for (Facet& facet : facets) facet = mortise::templates::reversed(facet);
    }
    return facets;
}

inline std::vector<std::uint32_t> sorted_keys(const std::vector<Facet>& facets) {
    std::vector<std::uint32_t> keys;
    for (const Facet& facet : facets) keys.push_back(mortise::templates::facet_key(facet));
    std::sort(keys.begin(), keys.end());
    return keys;
}

}  // namespace template_tests
