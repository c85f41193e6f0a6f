// Pieces of a leaf in which hidden surfaces may have another sign than at the leaf's samples, and points in
// them that differ. All pieces of a depth go through each step together: a formula is read once for all.
#include <algorithm>
#include <cmath>

#include "host/probe/leaf.hpp"

namespace mortise::probe {
namespace {

constexpr std::size_t kNone = ~std::size_t{0};
/// Where gradients are bounded, once for all pieces below: bounds of whole leaves tell little, and those of
/// the smallest pieces cost more than they save.
constexpr int kGradientDepth = 2;
/// Halves of a piece's edge along all axes beyond which a surface is too far, to first order, to be in it.
constexpr double kFar = 4;
/// Each operation of bounds in single precision widens them by far more than it rounds in double precision.
constexpr double kRounding = 1e-6;

}  // namespace

tape::Grid LeafProbe::grid(int depth) const {
    return {{low_[0], low_[1], low_[2]}, std::ldexp(edge_, -depth), std::size_t{1} << depth};
}

/// Marks which of places_ may differ from the samples (contrary_), and in which no surface is undecided.
void LeafProbe::decide(int depth) {
    contrary_.assign(places_.size(), 0);
    decided_.assign(places_.size(), 1);
    for (std::size_t h = 0; h < hidden_.size(); ++h) {
        batch_.classify(surfaces_[hidden_[h]], grid(depth), places_, piece_signs_, &widths_);
        if (depth >= kGradientDepth) keep_away(h, depth);
        for (std::size_t k = 0; k < places_.size(); ++k) {
            if (piece_signs_[k] != hidden_sign_[h]) contrary_[k] = 1;
            if (piece_signs_[k] == 0) decided_[k] = 0;
        }
    }
}

/// Puts the parts of pieces_ that may differ into next_. Where bounds of gradients do not help, to sample the
/// smallest ones costs less than to bound them.
void LeafProbe::halve(int depth) {
    const auto child = [](const Piece& parent, int c) {
        tape::GridPlace place{};
        for (int j = 0; j < 3; ++j)
            place.at[j] = static_cast<std::uint8_t>(2 * parent.place.at[j] + ((c >> j) & 1));
        return place;
    };
    const bool bounded = depth < kDepth || has_slopes_;
    places_.clear();
    for (const Piece& parent : pieces_) {
        for (int c = 0; c < 8 && bounded && !parent.decided; ++c) places_.push_back(child(parent, c));
    }
    decide(depth);
    next_.clear();
    std::size_t k = 0;
    for (const Piece& parent : pieces_) {
        for (int c = 0; c < 8; ++c) {
            if (parent.decided || !bounded) {
                next_.push_back({child(parent, c), parent.decided});
            } else {
                if (contrary_[k] != 0) next_.push_back({places_[k], decided_[k] != 0});
                ++k;
            }
        }
    }
}

/// Gives undecided pieces the hidden surface's sign at the samples where its value in their middle and bounds
/// of its gradient tell that it has no other.
void LeafProbe::keep_away(std::size_t hidden, int depth) {
    constexpr std::size_t kAcross = std::size_t{1} << kGradientDepth;
    const std::uint32_t surface = surfaces_[hidden_[hidden]];
    if (model_.surfaces[surface].kind != kSurfaceExpression) return;
    const tape::Grid cells = grid(depth);
    open_.clear();
    open_places_.clear();
    std::size_t undecided = 0;
    for (std::size_t k = 0; k < places_.size(); ++k) {
        undecided += piece_signs_[k] == 0 ? 1 : 0;
        if (piece_signs_[k] != 0 || !(widths_[k] < kMortiseInfinity)) continue;
        open_.push_back(k);
        open_places_.push_back(places_[k]);
    }
    std::vector<double>& slopes = slopes_[hidden];
    const auto slope_of = [&](const tape::GridPlace& place) -> double& {
        const int shift = depth - kGradientDepth;
        const std::size_t y = static_cast<std::size_t>(place.at[1] >> shift);
        const std::size_t z = static_cast<std::size_t>(place.at[2] >> shift);
        return slopes[static_cast<std::size_t>(place.at[0] >> shift) + kAcross * (y + kAcross * z)];
    };
    if (depth == kGradientDepth) {
        slopes.assign(kAcross * kAcross * kAcross, kMortiseInfinity);
        batch_.slopes(surface, cells, open_places_, values_);
        for (std::size_t i = 0; i < open_.size(); ++i) slope_of(open_places_[i]) = values_[i];
    }
    std::size_t bounded = 0;
    for (std::size_t i = 0; i < open_.size(); ++i) {
        if (!(slope_of(open_places_[i]) < kMortiseInfinity)) continue;
        open_[bounded] = open_[i];
        open_places_[bounded++] = open_places_[i];
    }
    if (depth == kGradientDepth && 2 * bounded < undecided) has_slopes_ = false;
    open_.resize(bounded);
    open_places_.resize(bounded);
    batch_.values(surface, {cells, open_places_}, values_);
    for (std::size_t i = 0; i < open_.size(); ++i) {
        const double reach = 0.5 * cells.edge * slope_of(open_places_[i]) + kRounding * widths_[open_[i]];
        if (hidden_sign_[hidden] * values_[i] > reach) piece_signs_[open_[i]] = hidden_sign_[hidden];
    }
}

void LeafProbe::subdivide() {
    found_.clear();
    has_slopes_ = true;
    slopes_.resize(std::max(slopes_.size(), hidden_.size()));
    pieces_.assign(1, Piece{{{0, 0, 0}}, false});
    for (int depth = 1;; ++depth) {
        halve(depth);
        if (next_.empty()) return;
        const bool full = next_.size() > kMostPieces;
        if (!full) pieces_.swap(next_);
        if (full || depth == kDepth) {
            sample(full ? depth - 1 : depth);
            return;
        }
    }
}

/// Looks for missed points, one for each of some pieces. `sampled`: a hidden surface for which samples_ are
/// known there, or none.
void LeafProbe::find_missed(const std::vector<std::size_t>& pieces, const std::vector<Vec3>& points,
                            std::size_t sampled) {
    contrary_.assign(pieces.size(), 0);
    for (std::size_t h = 0; h < hidden_.size(); ++h) {
        if (h != sampled) batch_.values(surfaces_[hidden_[h]], tape::Places(points), values_);
        for (std::size_t k = 0; k < pieces.size(); ++k) {
            if (tape::sign_of(h == sampled ? samples_[k].value : values_[k]) != hidden_sign_[h])
                contrary_[k] = 1;
        }
    }
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        if (contrary_[k] != 0) is_missed(points[k], missed_[pieces[k]]);
    }
}

/// Moves each piece's point, where samples_ are known, as far beyond the surface as it is before it, within
/// the piece. Pieces that the surface is far from, or where it has no gradient, are dropped.
void LeafProbe::step_beyond(std::vector<std::size_t>& pieces, std::vector<Vec3>& points, int depth) {
    std::size_t kept = 0;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
        if (missed_[pieces[k]].region >= 0) continue;
        const SurfaceSample& f = samples_[k];
        const double squared =
            f.gradient[0] * f.gradient[0] + f.gradient[1] * f.gradient[1] + f.gradient[2] * f.gradient[2];
        if (!(squared > 0) || !(squared < kMortiseInfinity)) continue;
        const tape::Cell box = cell(pieces_[pieces[k]].place.at, depth);
        const double slope = std::fabs(f.gradient[0]) + std::fabs(f.gradient[1]) + std::fabs(f.gradient[2]);
        if (std::fabs(f.value) > kFar * box.half * slope) continue;
        const double factor = 2 * f.value / squared;
        Vec3 x = points[k];
        for (std::size_t j = 0; j < 3; ++j) {
            x[j] =
                std::clamp(x[j] - factor * f.gradient[j], box.centre[j] - box.half, box.centre[j] + box.half);
        }
        pieces[kept] = pieces[k];
        points[kept++] = x;
    }
    pieces.resize(kept);
    points.resize(kept);
}

/// Looks for missed points towards a hidden surface and as far beyond it, twice. For a ball or a tube that is
/// thin compared with the piece the second step ends at its middle.
void LeafProbe::approach(std::size_t hidden, int depth) {
    std::vector<std::size_t> pieces;
    std::vector<Vec3> points;
    samples_.clear();
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
        if (pieces_[i].decided || missed_[i].region >= 0) continue;
        pieces.push_back(i);
        const tape::Cell box = cell(pieces_[i].place.at, depth);
        points.push_back({box.centre[0], box.centre[1], box.centre[2]});
        samples_.push_back(middles_[hidden][i]);
    }
    step_beyond(pieces, points, depth);
    batch_.samples(surfaces_[hidden_[hidden]], tape::Places(points), samples_);
    find_missed(pieces, points, hidden);
    step_beyond(pieces, points, depth);
    find_missed(pieces, points, kNone);
}

/// Looks for a missed point in each piece: its centre, then towards the hidden surfaces where one is not
/// decided.
void LeafProbe::sample(int depth) {
    places_.clear();
    for (const Piece& piece : pieces_) places_.push_back(piece.place);
    missed_.assign(pieces_.size(), Found{});
    contrary_.assign(pieces_.size(), 0);
    middles_.resize(std::max(middles_.size(), hidden_.size()));
    const tape::Grid cells = grid(depth);
    const tape::Places places(cells, places_);
    for (std::size_t h = 0; h < hidden_.size(); ++h) {
        batch_.samples(surfaces_[hidden_[h]], places, middles_[h]);
        for (std::size_t i = 0; i < pieces_.size(); ++i) {
            if (tape::sign_of(middles_[h][i].value) != hidden_sign_[h]) contrary_[i] = 1;
        }
    }
    std::vector<std::size_t> open;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
        if (contrary_[i] == 0 || is_missed(places.point(i), missed_[i]) || pieces_[i].decided) continue;
        open.push_back(i);
    }
    places_.clear();
    for (const std::size_t i : open) places_.push_back(pieces_[i].place);
    decide(depth);
    for (std::size_t k = 0; k < open.size(); ++k) pieces_[open[k]].decided = decided_[k] != 0;
    for (std::size_t h = 0; h < hidden_.size(); ++h) approach(h, depth);
    const auto is_found = [](const Found& found) { return found.region >= 0; };
    if (std::none_of(missed_.begin(), missed_.end(), is_found)) return;
    found_.assign(kPieces, Found{});
    const int shift = kDepth - depth;
    const std::uint32_t edge = 1u << shift;
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
        if (missed_[i].region < 0) continue;
        const std::uint8_t* at = pieces_[i].place.at;
        for (std::uint32_t k = 0; k < edge * edge * edge; ++k) {
            const std::uint32_t x = (std::uint32_t{at[0]} << shift) + k % edge;
            const std::uint32_t y = (std::uint32_t{at[1]} << shift) + k / edge % edge;
            const std::uint32_t z = (std::uint32_t{at[2]} << shift) + k / (edge * edge);
            found_[x + kSide * (y + kSide * z)] = missed_[i];
        }
    }
}

}  // namespace mortise::probe
