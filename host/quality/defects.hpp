// Collects defects by kind: how many, and a description of the first.
//
// Parallel passes keep one log per chunk and merge them in chunk order, so "first" does not depend on
// threads.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "mortise/check.hpp"

namespace mortise::quality {

/// Every kind of defect, in the order of the report; texts in defects.cpp.
enum class DefectKind : std::uint8_t {
    kArrayLength,
    kElementNodeRange,
    kFacetNodeRange,
    kElementRegion,
    kElementKind,
    kFacetSurface,
    kFacetRegion,
    kSurfaceName,
    kHangingNode,
    kHangingPlace,
    kNodeNotFinite,
    kNodeUnused,
    kNodeCoincident,
    kMiddleShared,
    kMiddleTwice,
    kListedMiddle,
    kElementRepeatedNode,
    kElementDuplicate,
    kHexahedronJacobian,
    kWedgeJacobian,
    kPyramidJacobian,
    kTetrahedronJacobian,
    kFacetShared,
    kFacetSameOrientation,
    kFacetQuadrilateralOrder,
    kFacetQuadrilateralTriangles,
    kHangingFace,
    kHangingRegion,
    kBoundaryOpen,
    kListedNowhere,
    kListedInside,
    kListedTwice,
    kListedOrientation,
    kListedRegions,
    kListedOpen,
    kMissingBoundary,
    kMissingInterface,
    kCount
};

class DefectLog {
  public:
    /// Counts one defect; `describe` makes the text and is called for the first of its kind only.
    template <class Describe>
    void add(DefectKind kind, const Describe& describe) {
        Entry& entry = entries_[static_cast<std::size_t>(kind)];
        if (entry.count++ == 0) entry.first = describe();
    }

    /// Appends a log whose defects come after those of this one.
    void merge(const DefectLog& later);

    std::uint64_t count(DefectKind kind) const { return entries_[static_cast<std::size_t>(kind)].count; }
    bool empty() const;
    std::vector<Defect> defects() const;

  private:
    struct Entry {
        std::uint64_t count = 0;
        std::string first;
    };
    std::array<Entry, static_cast<std::size_t>(DefectKind::kCount)> entries_;
};

const char* element_name(ElementType type);

/// "(0.1, 0.2, 0.3)".
std::string point_text(const Mesh& mesh, NodeId node);

/// "hexahedron 17 at (0.1, 0.2, 0.3)": index within its type, mean of its nodes.
std::string element_text(const Mesh& mesh, ElementType type, std::size_t element);

/// "facet (1, 2, 3) at (0.1, 0.2, 0.3)": its nodes and their mean; `count` is 3 or 4.
std::string facet_text(const Mesh& mesh, const NodeId* nodes, int count);

/// A number with nine significant digits.
std::string number_text(double value);

}  // namespace mortise::quality
