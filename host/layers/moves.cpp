#include "host/layers/moves.hpp"

#include <algorithm>

#include "host/common/parallel.hpp"
#include "host/common/vec3.hpp"

namespace mortise::layers {
namespace {

/// Conjugate gradients end when the residual has shrunk so far, or after so many steps.
constexpr double kSmallResidual = 1e-3;
constexpr int kMostSteps = 60;

/// How far from a crease the wall's nodes give way, in heights of the layers.
constexpr double kGivingWay = 10;
constexpr double kMostHeld = 100;  ///< edges in that distance, at most

template <class Work>
void for_slots(const std::vector<std::uint32_t>& slots, int threads, const Work& work) {
    parallel_chunks(slots.size(), kNodeChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) work(slots[i]);
    });
}

/// Added up chunk by chunk, so that the result does not depend on the threads.
template <class Term>
double total(const std::vector<std::uint32_t>& slots, int threads, const Term& term) {
    std::vector<double> parts(chunk_count(slots.size(), kNodeChunk));
    parallel_numbered(slots.size(), kNodeChunk, threads,
                      [&](std::size_t chunk, std::size_t begin, std::size_t end) {
                          for (std::size_t i = begin; i < end; ++i) parts[chunk] += term(slots[i]);
                      });
    double all = 0;
    for (const double part : parts) all += part;
    return all;
}

}  // namespace

Moves::Moves(const Band& band, const Slides& slides, const Growth& growth, int threads)
    : band_(band),
      slides_(slides),
      growth_(growth),
      threads_(threads),
      hold_(growth.reach.size()),
      is_frozen_(band.node.size()),
      move_(band.node.size()),
      residual_(band.node.size()),
      step_(band.node.size()),
      image_(band.node.size()) {
    for (std::size_t i = 0; i < hold_.size(); ++i) {
        // As if each node were bound to its place by springs, so that moves along the wall fade
        // exponentially.
        const double steps = std::min(growth.edges[i] / (kGivingWay * growth.height[i]), kMostHeld);
        hold_[i] = 0.5 * band.weight[i] * steps * steps;
    }
    guess();
}

void Moves::freeze(std::size_t slot) {
    is_frozen_[slot] = 1;
    move_[slot] = {};
}

Vec3 Moves::free_part(std::size_t slot, const Vec3& move) const {
    if (is_frozen_[slot] != 0) return {};
    return slot < walls() ? growth_.fixed[slot].free_part(move) : slides_.along(band_.node[slot], move);
}

Vec3 Moves::force(std::size_t slot, const Vectors& move) const {
    const Vec3 result = free_part(slot, laplacian(slot, move));
    return slot < walls() ? sum(result, scaled(free_part(slot, move[slot]), hold_[slot])) : result;
}

double Moves::stiffness(std::size_t slot) const {
    return band_.weight[slot] + (slot < walls() ? hold_[slot] : 0);
}

Vec3 Moves::laplacian(std::size_t slot, const Vectors& move) const {
    Vec3 result = scaled(move[slot], band_.weight[slot]);
    const float* conductance = band_.conductance.data() + band_.neighbours.first(slot);
    for (const std::uint32_t other : band_.neighbours[slot])
        result = difference(result, scaled(move[other], double{*conductance++}));
    return result;
}

/// The walls' moves, and behind them ring by ring the mean of the ring before, a little less.
void Moves::guess() {
    std::copy(growth_.reach.begin(), growth_.reach.end(), move_.begin());
    const auto rings = static_cast<double>(band_.ring.size() - 1);
    for (std::size_t r = 1; r + 1 < band_.ring.size(); ++r) {
        const std::size_t first = band_.ring[r];
        const double fade = (rings - static_cast<double>(r)) / (rings - static_cast<double>(r - 1));
        parallel_chunks(band_.ring[r + 1] - first, kNodeChunk, threads_,
                        [&](std::size_t begin, std::size_t end, int) {
                            for (std::size_t s = first + begin; s < first + end; ++s)
                                move_[s] = free_part(s, scaled(mean_of_ring(s, r - 1), fade));
                        });
    }
}

Vec3 Moves::mean_of_ring(std::size_t slot, std::size_t ring) const {
    Vec3 total{};
    double count = 0;
    for (const std::uint32_t other : band_.neighbours[slot]) {
        if (other >= band_.ring[ring + 1] || other < band_.ring[ring]) continue;
        total = sum(total, move_[other]);
        ++count;
    }
    return count > 0 ? scaled(total, 1 / count) : total;
}

// With L the Laplacian of the band's edges, P what nodes may freely do and H what holds the wall's nodes in
// place: P L (fixed part + P v) + H P v = 0, by conjugate gradients with the diagonal of L + H.
void Moves::solve(const std::vector<double>& share, const std::vector<std::uint32_t>& active) {
    for_slots(active, threads_, [&](std::size_t s) {
        if (s < walls())
            move_[s] =
                share[s] == 0 ? Vec3{} : sum(scaled(growth_.reach[s], share[s]), free_part(s, move_[s]));
    });
    Slots free;  // that move at all
    for (const std::uint32_t s : active) {
        if (is_frozen_[s] == 0 && (s >= walls() || (share[s] > 0 && growth_.fixed[s].count < 3)))
            free.push_back(s);
    }
    const auto energy_of = [&] {
        return total(free, threads_,
                     [&](std::size_t s) { return squared_length(residual_[s]) / stiffness(s); });
    };
    for_slots(free, threads_, [&](std::size_t s) {
        residual_[s] = scaled(force(s, move_), -1);
        step_[s] = scaled(residual_[s], 1 / stiffness(s));
    });
    // What shrinks is measured by what would be there if nothing had moved yet.
    const double whole =
        total(free, threads_, [&](std::size_t s) { return band_.weight[s] * squared_length(move_[s]); });
    double energy = energy_of();
    for (int i = 0; i < kMostSteps && energy > kSmallResidual * kSmallResidual * whole; ++i) {
        for_slots(free, threads_, [&](std::size_t s) { image_[s] = force(s, step_); });
        const double along = total(free, threads_, [&](std::size_t s) { return dot(step_[s], image_[s]); });
        if (!(along > 0)) break;
        const double far = energy / along;
        for_slots(free, threads_, [&](std::size_t s) {
            move_[s] = sum(move_[s], scaled(step_[s], far));
            residual_[s] = difference(residual_[s], scaled(image_[s], far));
        });
        const double before = energy;
        energy = energy_of();
        for_slots(free, threads_, [&](std::size_t s) {
            step_[s] = sum(scaled(residual_[s], 1 / stiffness(s)), scaled(step_[s], energy / before));
        });
    }
    for_slots(free, threads_, [&](std::size_t s) { step_[s] = {}; });
}

}  // namespace mortise::layers
