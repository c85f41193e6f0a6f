// Point membership straight from the definitions in mortise/model.hpp: an oracle for the readers. It shares
// no code with the library.
#pragma once

#include <string>

#include "mortise/model.hpp"

namespace mortise::test {

/// Whether the solid of a node holds a point. Recursive: not for deep trees.
bool holds(const Model& model, std::uint32_t node, const Vec3& point);

/// 1-based index of the region that a point belongs to; 0: none.
std::size_t region_at(const Model& model, const Vec3& point);

/// What parse_model throws for a text, as "code message"; empty if it throws nothing.
std::string refusal(const std::string& text, const std::string& format);

}  // namespace mortise::test
