// Which face of which element a facet is.
#pragma once

#include <cstdint>
#include <vector>

#include "mortise/mesh.hpp"

namespace mortise::io {

struct FacetSide {
    std::uint64_t element;  ///< in the order in which Mesh::elements lists them, type after type
    std::uint8_t face;      ///< of local_faces()
    ElementType type;
};

/// Per facet the element of its region `inside`, the first if there are several. Throws Error(kMeshing) if
/// there is none.
std::vector<FacetSide> facet_sides(const Mesh& mesh, int threads);

}  // namespace mortise::io
