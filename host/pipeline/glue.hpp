// The neighbourhoods of periodic planes as one mesh, as if the solid went on behind each plane.
//
// One pair of planes has two sides. Of two pairs, where they meet, four neighbourhoods come together, of
// three pairs eight: bit j of a side tells which plane of pair j is near. All sides are moved to the middle
// of the root box, side by side.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/common/face_key.hpp"
#include "host/improve/scope.hpp"
#include "host/pipeline/periodic.hpp"
#include "host/pipeline/prepare.hpp"

namespace mortise::pipeline {

/// A pair of planes on the grid. Arrays: of the first and of the second plane.
struct GluedPair {
    const PeriodicAxis* pair = nullptr;
    std::size_t axis = 0;
    std::array<std::uint32_t, 2> plane{};  ///< surfaces
    std::array<double, 2> at{};            ///< along the axis, in model units
    std::array<std::int64_t, 2> cell{};    ///< the same in cells
    std::array<std::int64_t, 2> shift{};   ///< cells from there to the middle of the root box
    std::vector<NodeId> partner;           ///< as match_plane() returns

    std::int64_t cells_between() const { return std::abs(cell[1] - cell[0]); }
};

struct Gluing {
    std::vector<GluedPair> pairs;
    int level = 0;              ///< of the uniform tree
    std::uint16_t regions = 0;  ///< of side s those from s × regions + 1 on
    std::array<double, 3> origin{};
    double edge = 0;  ///< of a cell

    std::size_t sides() const { return std::size_t{1} << pairs.size(); }
    static std::size_t bit(std::size_t side, std::size_t pair) { return side >> pair & 1; }
    std::size_t side_of(std::uint16_t region) const { return (region - std::size_t{1}) / regions; }
    /// Cells from a plane into the solid, of a place along the axis.
    double depth(std::size_t pair, std::size_t which, double x) const;
    /// The side whose planes are all within `reach` cells of some node of these, or sides().
    std::size_t side_of_nodes(const Mesh& mesh, const NodeId* node, std::size_t count,
                              std::int64_t reach) const;
    /// Of a facet on a plane its pair, else the number of pairs.
    std::size_t pair_of(std::uint32_t surface) const;
};

/// None if a pair cannot be glued: its facets differ, its planes are interfaces, or part of the solid lies
/// behind them. Nodes of the planes are moved to their places exactly.
std::optional<Gluing> make_gluing(const Prepared& prepared, const std::vector<const PeriodicAxis*>& pairs,
                                  Mesh& mesh);

/// The model around glued planes.
struct GluedModel {
    tape::BoundModel bound;
    std::vector<std::uint8_t> held;
    std::vector<tape::Pole> poles;
    std::vector<std::vector<std::uint32_t>> image;   ///< per side and surface of the model, its number here
    std::vector<std::vector<std::uint32_t>> source;  ///< per side and number here, the surface of the model
};

/// Of what is within `reach` cells. None if a surface that does not go on over a plane has an apex there.
std::optional<GluedModel> glue_model(const Gluing& gluing, const Prepared& prepared,
                                     const improve::Options& options, std::int64_t reach, const Mesh& mesh);

struct GluedMesh {
    Mesh mesh;
    std::vector<std::vector<NodeId>> node;  ///< per side and node, its number in the mesh, or kNoNode
    std::vector<std::uint8_t> is_open;      ///< as improve::Options::is_open
    improve::ElementNumbers element;
    std::array<std::vector<std::uint32_t>, 2> facet;  ///< the one or two that it stands for, or kNoNode
};

GluedMesh glue_mesh(const Gluing& gluing, const GluedModel& model, std::int64_t reach, const Mesh& mesh);

/// Puts an improved glued mesh back into the mesh that it is of. False, and `mesh` of no use: a facet does
/// not tell where it belongs.
bool separate(const Gluing& gluing, const GluedModel& model, const GluedMesh& glued, const Mesh& improved,
              const improve::Trace& trace, Mesh& mesh);

}  // namespace mortise::pipeline
