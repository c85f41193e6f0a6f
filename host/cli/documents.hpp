// What `mortise` reports about meshes, for people and as JSON. JSON names are append-only.
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "mortise/check.hpp"
#include "mortise/mesher.hpp"

namespace mortise::cli {

using Json = nlohmann::ordered_json;

inline constexpr std::array<const char*, kElementTypes> kElementNames = {"hexahedra", "wedges", "pyramids",
                                                                         "tetrahedra"};

/// The figures of a mesh that cost one pass over it.
struct MeshFigures {
    std::uint64_t nodes = 0;
    std::array<std::uint64_t, kElementTypes> elements{};
    std::array<std::uint64_t, 4> kinds{};                               ///< by ElementKind
    std::array<double, kElementTypes> min_scaled_jacobian{1, 1, 1, 1};  ///< 1 where a type has no elements
    std::optional<Vec3> worst_place;  ///< mean of the worst element's nodes; of a mesh in one piece
    std::vector<std::string> regions;
    std::vector<std::uint64_t> in_region;  ///< elements
    std::vector<std::string> surfaces;
    std::vector<std::uint64_t> on_surface;  ///< facets

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

/// Adds a warning of the worst element, and what to do about it, if it is far below what improvement leaves
/// elsewhere; whether it did. Meshes that were not improved have none.
bool warn_of_slivers(const MeshFigures& figures, const MeshOptions& options, MeshReport& report);

Json mesh_document(const MeshReport& report, const MeshFigures& figures);
Json check_document(const CheckReport& report);

/// Indented, with a line break at the end; bytes that are not UTF-8 are replaced.
std::string to_text(const Json& document);
/// The same in one line, without its break.
std::string to_line(const Json& document);

/// "120 hexahedra, 8 wedges": types without elements are left out.
std::string list_elements(const std::array<std::uint64_t, kElementTypes>& elements);

/// "(1, 2.5, -3)".
std::string place_text(const Vec3& place);

/// "0.71 hexahedra, 0.2 wedges".
std::string list_jacobians(const std::array<std::uint64_t, kElementTypes>& elements,
                           const std::array<double, kElementTypes>& jacobians);

/// A number with a few significant digits.
std::string short_number(double value, int digits = 4);

/// What, how often and where, in one line.
std::string describe(const Defect& defect);

}  // namespace mortise::cli
