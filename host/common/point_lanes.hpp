// Points of some elements side by side, where the compiler has lanes (MORTISE_HAS_LANES). Everything is
// inlined: how lanes are passed depends on the machine's registers.
#pragma once

#if defined(__GNUC__) && !defined(__clang__)
#define MORTISE_HAS_LANES 1

#include <cstddef>
#include <utility>

#include "host/common/lattice_rounding.hpp"
#include "host/common/wide.hpp"
#include "mortise/mesh.hpp"

// Said of every function that returns lanes, though none is ever called.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace mortise::lanes {

template <std::size_t kWidth>
struct Points {
    Doubles<kWidth> x, y, z;
};

template <std::size_t kWidth>
[[gnu::always_inline]] inline Points<kWidth> operator-(const Points<kWidth>& a, const Points<kWidth>& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <std::size_t kWidth>
[[gnu::always_inline]] inline Doubles<kWidth> dot(const Points<kWidth>& a, const Points<kWidth>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <std::size_t kWidth>
[[gnu::always_inline]] inline Points<kWidth> cross(const Points<kWidth>& a, const Points<kWidth>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Node k of as many elements as there are lanes, each given by its nodes. Built from single values in
/// registers: an array of lanes that is written one by one and read as a whole waits for the last of them.
template <std::size_t kWidth, std::size_t... kLane>
[[gnu::always_inline]] inline Points<kWidth> load(const double* points, const NodeId* const* elements,
                                                  std::size_t k, std::index_sequence<kLane...>) {
    const double* const at[kWidth] = {points + 3 * std::size_t{elements[kLane][k]}...};
    return {Doubles<kWidth>{at[kLane][0]...}, Doubles<kWidth>{at[kLane][1]...},
            Doubles<kWidth>{at[kLane][2]...}};
}
template <std::size_t kWidth>
[[gnu::always_inline]] inline Points<kWidth> load(const double* points, const NodeId* const* elements,
                                                  std::size_t k) {
    return load<kWidth>(points, elements, k, std::make_index_sequence<kWidth>{});
}

template <class Reals, class Frame>
[[gnu::always_inline]] inline Reals to_cells(const Reals& model, double origin, const Frame& frame) {
    const Reals cells = (model - origin) * frame.per_cell;
    return frame.on_lattice ? round_to_lattice(cells) : cells;
}

/// Node k of some elements, in cells: `frame` has the grid's origin, cells in a model unit (per_cell), and
/// whether nodes lie on the lattice of positions but for the rounding of model coordinates (on_lattice).
template <std::size_t kWidth, class Frame>
[[gnu::always_inline]] inline Points<kWidth> load_in_cells(const double* points,
                                                           const NodeId* const* elements, std::size_t k,
                                                           const Frame& frame) {
    const Points<kWidth> model = load<kWidth>(points, elements, k);
    return {to_cells(model.x, frame.origin[0], frame), to_cells(model.y, frame.origin[1], frame),
            to_cells(model.z, frame.origin[2], frame)};
}

}  // namespace mortise::lanes
#endif
