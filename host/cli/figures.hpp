// Figures of a mesh that cost one pass over it.
#pragma once

#include <array>
#include <cstdint>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "mortise/mesh.hpp"
#include "mortise/model.hpp"

namespace mortise::cli {

struct MeshFigures {
    std::uint64_t nodes = 0;
    std::array<std::uint64_t, kElementTypes> elements{};
    std::array<std::uint64_t, 5> kinds{};                               ///< by ElementKind
    std::array<double, kElementTypes> min_scaled_jacobian{1, 1, 1, 1};  ///< 1 where a type has no elements
    std::optional<Vec3> worst_place;  ///< mean of the worst element's nodes; of a mesh in one piece
    std::vector<std::string> regions;
    std::vector<std::uint64_t> in_region;  ///< elements
    std::vector<std::string> surfaces;
    std::vector<std::uint64_t> on_surface;  ///< facets
    struct Periodic {
        Vec3 shift{};
        std::uint64_t nodes = 0;  ///< that are copies
    };
    std::vector<Periodic> periodic;  ///< by pair of planes

    std::uint64_t element_count() const {
        return std::accumulate(elements.begin(), elements.end(), std::uint64_t{0});
    }
    /// Facets and names of a mesh.
    void add_outline(const Mesh& mesh);
    /// Nodes and elements of a mesh, or of a part of one.
    void add_elements(const Mesh& mesh, const std::vector<float>& jacobians, int threads);
};
/// `threads` host threads, here and above; 0: all cores.
MeshFigures figures_of(const Mesh& mesh, const std::vector<float>& jacobians, int threads);

}  // namespace mortise::cli
