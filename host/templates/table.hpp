// The template table: a template for each of the 126 simple patterns, and its text as a C header.
//
// Templates are searched for one pattern of each shape and carried to the others by the cube's symmetries.
// A pattern and its complement take the same symmetry, so that they share the surface facets.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "host/templates/search.hpp"

namespace mortise::templates {

/// Shapes of simple patterns up to symmetry. Append-only; 0: no template.
struct Shape {
    Pattern pattern;  ///< the one that is searched
    int number;
    const char* name;
};

/// Each with at most four inside corners; the complements have shapes of their own unless symmetric.
const std::vector<Shape>& searched_shapes();

/// 0 for patterns without a template.
int shape_number(Pattern pattern);

struct Table {
    std::array<Template, kPatterns> templates;  ///< no elements: no template
};

/// Searches all shapes: a few seconds.
Table build_table();

/// The text of kernels/shared/template_table.h, with measured quality; the same on every run.
std::string table_text(const Table& table);

}  // namespace mortise::templates
