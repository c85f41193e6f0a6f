// A simple polygon as a formula of half-planes in which each edge occurs once.
//
// Dobkin, Guibas, Hershberger, Snoeyink: An efficient algorithm for finding the CSG representation of a
// simple polygon, Algorithmica 10 (1993).
#pragma once

#include <cstdint>
#include <vector>

#include "host/model/outlines/contours.hpp"

namespace mortise::model_reader {

/// And / or over half-planes, without complements; children come before their users, the root last. An
/// operation's children never have the operation's own type.
struct PolygonFormula {
    struct Node {
        enum class Type : std::uint8_t { kEdge, kAnd, kOr };
        Type type = Type::kEdge;
        std::uint32_t edge = 0;  ///< kEdge: from point `edge` to the next one; inside is on its left
        std::vector<std::uint32_t> children{};
    };
    std::vector<Node> nodes;
};

/// Precondition: a simple, counter-clockwise loop of at least three points, no three in a row collinear.
PolygonFormula polygon_formula(const std::vector<Vec2>& loop);

}  // namespace mortise::model_reader
