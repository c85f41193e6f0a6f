#include "host/sizing/signs.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/vec3.hpp"
#include "host/sizing/arrangement.hpp"

namespace mortise::sizing {
namespace {

constexpr double kOn = 1e-9;
constexpr double kMoreBent = 1.5;   ///< what curved sheets may do between the samples
constexpr int kMostAtOnePoint = 8;  ///< planes: 256 choices

}  // namespace

PossibleSigns::Plane PossibleSigns::flatten(const Sheet& sheet, const tape::Cell& cell) {
    Plane plane{sheet.normal, 0, kOn, 0};
    for (std::size_t j = 0; j < 3; ++j)
        plane.offset += sheet.normal[j] * (cell.centre[j] - sheet.foot[j]) / cell.half;
    if (sheet.flat) return plane;
    const tape::Cell unit = {{0, 0, 0}, 1};
    for (std::size_t i = 0; i < Sheet::kSamples; ++i) {
        const double error = std::fabs(sheet.distance[i] / cell.half - plane.at(sample_point(unit, i)));
        plane.tolerance = std::max(plane.tolerance, kMoreBent * error);
    }
    return plane;
}

/// The choices around a point: planes through it take any sign.
void PossibleSigns::add(const Vec3& x) {
    for (const double c : x) {
        if (!(std::fabs(c) <= 1 + kOn)) return;
    }
    std::uint32_t negative = 0;
    std::uint32_t open = any_;
    int count = 0;
    for (const Plane& plane : planes_) {
        const double value = plane.at(x);
        if (!(std::fabs(value) > plane.tolerance)) {
            open |= plane.bit;
            ++count;
        } else if (value < 0) {
            negative |= plane.bit;
        }
    }
    if (count > kMostAtOnePoint) failed_ = true;
    if (failed_) return;
    for (std::uint32_t chosen = open;; chosen = (chosen - 1) & open) {
        const std::uint32_t choice = negative | chosen;
        if (!seen_[choice]) {
            seen_[choice] = true;
            choices_.push_back(choice);
        }
        if (chosen == 0) break;
    }
}

void PossibleSigns::add_edges_and_corners() {
    for (int corner = 0; corner < 8; ++corner) {
        const auto end = [corner](int axis) { return ((corner >> axis) & 1) != 0 ? 1.0 : -1.0; };
        add({end(0), end(1), end(2)});
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (((corner >> axis) & 1) != 0) continue;  // each edge from its lower corner
            for (const Plane& plane : planes_) {
                Vec3 x = {end(0), end(1), end(2)};
                x[axis] = 0;
                x[axis] = -plane.at(x) / plane.normal[axis];
                add(x);
            }
        }
    }
}

/// Where two planes cut the faces.
void PossibleSigns::add_pair(const Plane& p, const Plane& q) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t u = (axis + 1) % 3;
        const std::size_t v = (axis + 2) % 3;
        const double determinant = p.normal[u] * q.normal[v] - p.normal[v] * q.normal[u];
        for (const double end : {-1.0, 1.0}) {
            const double right_p = -p.offset - p.normal[axis] * end;
            const double right_q = -q.offset - q.normal[axis] * end;
            Vec3 x{};
            x[axis] = end;
            x[u] = (right_p * q.normal[v] - right_q * p.normal[v]) / determinant;
            x[v] = (p.normal[u] * right_q - q.normal[u] * right_p) / determinant;
            add(x);
        }
    }
}

void PossibleSigns::add_triple(const Plane& p, const Plane& q, const Plane& r) {
    const Vec3 qr = cross(q.normal, r.normal);
    const Vec3 rp = cross(r.normal, p.normal);
    const Vec3 pq = cross(p.normal, q.normal);
    const double determinant = dot(p.normal, qr);
    Vec3 x{};
    for (std::size_t j = 0; j < 3; ++j)
        x[j] = -(p.offset * qr[j] + q.offset * rp[j] + r.offset * pq[j]) / determinant;
    add(x);
}

/// Sheets beside each other: one choice of their signs does not occur. Takes curved sheets at their word, the
/// samples, where planes with a thickness are careful: else redundant walls close to a round one split
/// without end.
void PossibleSigns::forbid_pairs(const std::vector<Sheet>& sheets, const tape::Cell& cell) {
    constexpr double kBent = 0.06;  // of half an edge
    for (std::size_t a = 0; a < sheets.size(); ++a) {
        for (std::size_t b = 0; b < a; ++b) {
            if (!sheets[a].steady || !sheets[b].steady || (sheets[a].flat && sheets[b].flat)) continue;
            for (std::uint32_t pair = 0; pair < 4; ++pair) {
                const double sign_a = (pair & 1) != 0 ? -1 : 1;
                const double sign_b = (pair & 2) != 0 ? -1 : 1;
                bool occurs = false;  // where both signs hold, the sum is positive
                for (std::size_t i = 0; i < Sheet::kSamples && !occurs; ++i) {
                    occurs =
                        sign_a * sheets[a].distance[i] + sign_b * sheets[b].distance[i] > -kBent * cell.half;
                }
                if (occurs) continue;
                const auto is_pair = [&](std::uint32_t choice) {
                    return ((choice >> a) & 1) == (pair & 1) && ((choice >> b) & 1) == (pair >> 1);
                };
                choices_.erase(std::remove_if(choices_.begin(), choices_.end(), is_pair), choices_.end());
            }
        }
    }
}

/// Every cell of an arrangement of planes in a cube has a vertex: a corner of the cube, or where one plane
/// cuts an edge, two cut a face, or three meet.
bool PossibleSigns::find(const std::vector<Sheet>& sheets, const tape::Cell& cell) {
    choices_.clear();
    if (sheets.size() > Arrangement::kMost) return false;
    planes_.clear();
    any_ = 0;
    failed_ = false;
    for (std::size_t i = 0; i < sheets.size(); ++i) {
        const std::uint32_t bit = std::uint32_t{1} << i;
        if (sheets[i].steady) {
            planes_.push_back(flatten(sheets[i], cell));
            planes_.back().bit = bit;
        } else {
            any_ |= bit;
        }
    }
    if (sheets.size() - planes_.size() > kMostAtOnePoint) return false;
    seen_.assign(std::size_t{1} << sheets.size(), false);
    add_edges_and_corners();
    for (std::size_t a = 0; a < planes_.size() && !failed_; ++a) {
        for (std::size_t b = 0; b < a; ++b) {
            add_pair(planes_[a], planes_[b]);
            for (std::size_t c = 0; c < b; ++c) add_triple(planes_[a], planes_[b], planes_[c]);
        }
    }
    if (failed_) return false;
    std::sort(choices_.begin(), choices_.end());
    forbid_pairs(sheets, cell);
    return true;
}

}  // namespace mortise::sizing
