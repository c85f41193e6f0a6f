// Sections that a face or an edge of a leaf does not see: a rod that crosses a face between its corners and
// its centre, a slot that crosses an edge between its ends. The leaf's other samples may see these, so that
// nothing is hidden in the leaf, but its mesh ends at that face, or has a bridge at that edge.
#include <algorithm>
#include <array>
#include <cmath>

#include "host/probe/leaf.hpp"
#include "kernels/shared/surface.h"

namespace mortise::probe {
namespace {

constexpr int kAcross = 8;  ///< a face is sampled at this many places less one along each edge
/// Cells on both sides of a face, or around an edge, that a rod or a slot must hold. A cap that reaches less
/// far through it is how a mesh approximates a curved surface.
constexpr double kThrough = 0.25;
constexpr int kGrooveSteps = 16;  ///< of a cell's edge, in which the tip of a groove is measured
constexpr double kDiagonal = 0.70710678118654752;

}  // namespace

int LeafProbe::sign_at(std::uint32_t surface, const Vec3& x) const {
    return surface_sign(&model_.surfaces[surface], model_.expression_ops.data(), x[0], x[1], x[2], edge_);
}

Vec3 LeafProbe::on_face(int f, double u, double v) const {
    const auto axis = static_cast<std::size_t>(f / 2);
    Vec3 x{};
    x[axis] = low_[axis] + ((f & 1) != 0 ? edge_ : 0);
    x[(axis + 1) % 3] = low_[(axis + 1) % 3] + u * edge_;
    x[(axis + 2) % 3] = low_[(axis + 2) % 3] + v * edge_;
    return x;
}

/// Place t, 0 to 1, along edge e: along axis e / 4, at the upper end of the next axis for bit 0, of the one
/// after that for bit 1.
Vec3 LeafProbe::on_edge(int e, double t) const {
    const auto axis = static_cast<std::size_t>(e / 4);
    Vec3 x{};
    x[axis] = low_[axis] + t * edge_;
    x[(axis + 1) % 3] = low_[(axis + 1) % 3] + ((e & 1) != 0 ? edge_ : 0);
    x[(axis + 2) % 3] = low_[(axis + 2) % 3] + ((e & 2) != 0 ? edge_ : 0);
    return x;
}

/// Whether the hidden surface's rod, of which x is a part, passes through face f there.
bool LeafProbe::passes_through(int f, const Vec3& x) const {
    const std::uint32_t surface = surfaces_[hidden_[0]];
    for (const double side : {-kThrough, kThrough}) {
        Vec3 beside = x;
        beside[static_cast<std::size_t>(f / 2)] += side * edge_;
        if (sign_at(surface, beside) != -hidden_sign_[0]) return false;
    }
    return true;
}

/// Whether a place of a section lies next to an edge of face f, and the next face in its plane sees the
/// section in its middle: what lies on this side of the edge is a cap of that.
bool LeafProbe::is_cap_across_edge(int f, double u, double v) const {
    const std::uint32_t surface = surfaces_[hidden_[0]];
    const auto differs = [&](double a, double b) {
        return sign_at(surface, on_face(f, a, b)) == -hidden_sign_[0];
    };
    for (int side = 0; side < 4; ++side) {
        const double edge = side % 2;
        const bool along_u = side < 2;
        const double from = along_u ? u : v;
        if (std::fabs(from - edge) > kThrough) continue;
        const auto at = [&](double t) { return along_u ? differs(t, v) : differs(u, t); };
        const double beyond = edge == 0 ? -0.5 : 1.5;
        if (at(0.5 * (from + edge)) && at(edge) && (along_u ? differs(beyond, 0.5) : differs(0.5, beyond)))
            return true;
    }
    return false;
}

/// Steps from x, a place of what is hidden, until that ends, kGrooveSteps at most.
int LeafProbe::steps_to_end(const Vec3& x, const Vec3& step) const {
    const std::uint32_t surface = surfaces_[hidden_[0]];
    Vec3 at = x;
    for (int n = 1; n < kGrooveSteps; ++n) {
        for (std::size_t j = 0; j < 3; ++j) at[j] += step[j];
        if (sign_at(surface, at) != -hidden_sign_[0]) return n;
    }
    return kGrooveSteps;
}

/// The same in eight directions across an axis, each 45 degrees on from the one before.
std::array<int, 8> LeafProbe::steps_around(const Vec3& x, std::size_t axis) const {
    constexpr int kAround[8][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
    std::array<int, 8> found{};
    for (std::size_t k = 0; k < 8; ++k) {
        const double length = edge_ / kGrooveSteps * (k % 2 != 0 ? kDiagonal : 1);
        Vec3 step{};
        step[(axis + 1) % 3] = length * kAround[k][0];
        step[(axis + 2) % 3] = length * kAround[k][1];
        found[k] = steps_to_end(x, step);
    }
    return found;
}

// Walls that part from each other under a crease that a formula hides leave a groove, or a ridge, whose tip
// faces and edges do not see. It is what meshes fill in, and no feature is lost, where it ends no deeper
// below a place than it is wide there, and is open above.

/// Whether x, a place on edge e, lies in such a tip.
bool LeafProbe::is_tip_at_edge(int e, const Vec3& x) const {
    const auto axis = static_cast<std::size_t>(e / 4);
    Vec3 along{}, back{};
    along[axis] = edge_ / kGrooveSteps;
    back[axis] = -along[axis];
    const int width = steps_to_end(x, along) + steps_to_end(x, back);
    const std::array<int, 8> reach = steps_around(x, axis);
    const auto lowest =
        static_cast<std::size_t>(std::min_element(reach.begin(), reach.end()) - reach.begin());
    return reach[lowest] <= width && reach[(lowest + 4) % 8] == kGrooveSteps;
}

/// The same of a place on face f.
bool LeafProbe::is_tip_in_face(int f, const Vec3& x) const {
    const std::array<int, 8> reach = steps_around(x, static_cast<std::size_t>(f / 2));
    for (std::size_t k = 0; k < 8; ++k) {
        const int width = reach[(k + 2) % 8] + reach[(k + 6) % 8];
        if (reach[k] <= width && width < kGrooveSteps && reach[(k + 4) % 8] == kGrooveSteps) return true;
    }
    return false;
}

/// Pieces beside face f that hold parts of a section which the face's corners and centre do not see.
void LeafProbe::find_section(int f) {
    const std::uint32_t surface = surfaces_[hidden_[0]];
    bool negative = false;
    bool positive = false;
    const auto see = [&](double u, double v) {
        const int sign = sign_at(surface, on_face(f, u, v));
        negative = negative || sign < 0;
        positive = positive || sign > 0;
    };
    see(0.5, 0.5);
    for (int c = 0; c < 4; ++c) see(c & 1, c >> 1);
    if (negative == positive) return;
    hidden_sign_[0] = positive ? 1 : -1;
    std::vector<Vec3> points;
    std::vector<std::array<double, 2>> places;
    for (int i = 1; i < kAcross; ++i) {
        for (int j = 1; j < kAcross; ++j) {
            places.push_back({static_cast<double>(i) / kAcross, static_cast<double>(j) / kAcross});
            points.push_back(on_face(f, places.back()[0], places.back()[1]));
        }
    }
    batch_.values(surface, tape::Places(points), values_);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3& x = points[i];
        const bool as_seen = (values_[i] <= 0) == (hidden_sign_[0] < 0);
        Found found;
        if (!as_seen && is_missed(x, found) && passes_through(f, x) &&
            !is_cap_across_edge(f, places[i][0], places[i][1]) && !is_tip_in_face(f, x))
            note_section(found);
    }
}

/// The piece there holds a part of a section.
void LeafProbe::note_section(const Found& found) {
    const Vec3& x = found.point;
    std::uint32_t piece = 0;
    for (int axis = 2; axis >= 0; --axis) {
        const auto a = static_cast<std::size_t>(axis);
        const double at = std::floor((x[a] - low_[a]) / edge_ * kSide);
        const auto k = static_cast<std::uint32_t>(std::min(std::max(at, 0.0), kSide - 1.0));
        piece = (piece << kDepth) | k;
    }
    if (found_.empty()) found_.assign(kSide * kSide * kSide, Found{});
    found_[piece] = found;
}

/// Whether what holds x, a place on edge e, goes on all around the edge. (Values by gradients tell too large
/// a distance inside small holes.)
bool LeafProbe::surrounds(int e, const Vec3& x) const {
    const auto axis = static_cast<std::size_t>(e / 4);
    const std::uint32_t surface = surfaces_[hidden_[0]];
    for (int k = 0; k < 9; ++k) {
        const int across[2] = {k % 3 - 1, k / 3 - 1};
        const double step = kThrough * edge_ * (across[0] * across[1] != 0 ? kDiagonal : 1);
        Vec3 beside = x;
        for (std::size_t j = 0; j < 2; ++j) beside[(axis + 1 + j) % 3] += step * across[j];
        if (sign_at(surface, beside) != -hidden_sign_[0]) return false;
    }
    return true;
}

/// Pieces at edge e that hold what its ends do not see.
void LeafProbe::find_bridge(int e) {
    const std::uint32_t surface = surfaces_[hidden_[0]];
    const int sign = sign_at(surface, on_edge(e, 0));
    if (sign == 0 || sign != sign_at(surface, on_edge(e, 1))) return;
    hidden_sign_[0] = static_cast<std::int8_t>(sign);
    std::vector<Vec3> points;
    for (int i = 1; i < kAcross; ++i) points.push_back(on_edge(e, static_cast<double>(i) / kAcross));
    batch_.values(surface, tape::Places(points), values_);
    for (std::size_t i = 0; i < points.size(); ++i) {
        const bool as_seen = (values_[i] <= 0) == (sign < 0);
        Found found;
        if (!as_seen && surrounds(e, points[i]) && !is_tip_at_edge(e, points[i]) &&
            is_missed(points[i], found))
            note_section(found);
    }
}

/// Appends a component for the sections of each surface that faces and edges do not see.
void LeafProbe::find_sections(std::uint32_t leaf, std::vector<Component>& out) {
    for (const std::uint32_t s : winding_) {
        hidden_.assign(1, s);
        hidden_sign_.assign(1, 0);
        found_.clear();
        for (int f = 0; f < 6; ++f) find_section(f);
        for (int e = 0; e < 12; ++e) find_bridge(e);
        if (found_.empty()) continue;
        Component component;
        component.leaf = leaf;
        double deepest = -1;
        for (std::uint32_t piece = 0; piece < found_.size(); ++piece) {
            if (found_[piece].region < 0) continue;
            component.pieces.push_back(static_cast<std::uint16_t>(piece));
            component.region = static_cast<std::uint16_t>(found_[piece].region);
            if (found_[piece].value <= deepest) continue;
            deepest = found_[piece].value;
            component.point = found_[piece].point;
        }
        hidden_sign_[0] = static_cast<std::int8_t>(-sign_at(surfaces_[s], component.point));
        component.depth = 1;
        component.torn = true;
        measure(component);
        out.push_back(std::move(component));
    }
}

}  // namespace mortise::probe
