// A model in OpenSCAD's CSG format, read from a text.
#pragma once

#include <string>

#include "mortise/model.hpp"

namespace mortise::test {

inline Model read_csg(const std::string& text, Facets facets = Facets::kSmooth) {
    ReadOptions options;
    options.facets = facets;
    return parse_model(text, "csg", "part.csg", options);
}

}  // namespace mortise::test
