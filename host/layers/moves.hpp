// How the nodes of the band move if the wall's nodes move as the layers want.
#pragma once

#include <cstdint>
#include <vector>

#include "host/layers/band.hpp"
#include "host/layers/growth.hpp"
#include "host/layers/slides.hpp"
#include "mortise/model.hpp"

namespace mortise::layers {

/// The moves of all nodes of the band if the wall's nodes move by shares of Growth::reach. Between these and
/// the nodes that stay they fade as a potential would, with edges as conductors, 1/length each; nodes that
/// slide do so along their surfaces. The wall's nodes, too, move where heights leave them free: beside a
/// crease, whose nodes come nearer, they give way, within some heights of the layers.
class Moves {
  public:
    Moves(const Band& band, const Slides& slides, const Growth& growth, int threads);

    /// By slot.
    const std::vector<Vec3>& all() const { return move_; }

    /// Moves of the slots that are `active` anew; all others stay. `share`: by place of the wall node.
    void solve(const std::vector<double>& share, const std::vector<std::uint32_t>& active);

    /// A node that does not move at all from now on.
    void freeze(std::size_t slot);

  private:
    using Vectors = std::vector<Vec3>;
    using Slots = std::vector<std::uint32_t>;

    std::size_t walls() const { return growth_.reach.size(); }
    Vec3 free_part(std::size_t slot, const Vec3& move) const;
    Vec3 laplacian(std::size_t slot, const Vectors& move) const;
    Vec3 force(std::size_t slot, const Vectors& move) const;
    double stiffness(std::size_t slot) const;
    Vec3 mean_of_ring(std::size_t slot, std::size_t ring) const;
    void guess();

    const Band& band_;
    const Slides& slides_;
    const Growth& growth_;
    const int threads_;
    std::vector<double> hold_;  ///< by place of the wall node: what holds it at its place along the wall
    std::vector<std::uint8_t> is_frozen_;
    Vectors move_;
    // By slot; of conjugate gradients. Between solutions step_ is zero; the others are of no use then.
    Vectors residual_, step_, image_;
};

}  // namespace mortise::layers
