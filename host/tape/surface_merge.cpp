#include "host/tape/surface_merge.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "host/tape/reference.hpp"

namespace mortise::tape {
namespace {

// Two surfaces whose normalised coefficients differ by less are one. Coordinates are in units of the root
// box.
constexpr double kMergeTolerance = 1e-10;
/// How far apart a coefficient of surfaces within the merge distance may be, as a multiple of it.
constexpr double kCoefficientReach = 16;
/// Within so many merge distances of surfaces that are alike no other may pass: what lies between them and it
/// would lose much of its thickness.
constexpr double kAlone = 3;
/// Places in a signature: of coefficients that grow with the distance from the origin, along x, y and z (of
/// planes the first alone), and of where the data of a rounded solid or a patch begin, which no other has.
constexpr std::size_t kOffsets[] = {3, 6, 8};
constexpr std::size_t kStart = 13;

Surface to_local(Surface s, const Vec3& origin, double side) {
    const int rows = s.kind == kSurfacePlane ? 1 : 3;
    for (int i = 0; i < rows; ++i) {
        double* row = s.map + 4 * i;
        row[3] += row[0] * origin[0] + row[1] * origin[1] + row[2] * origin[2];
        for (int j = 0; j < 3; ++j) row[j] *= side;
    }
    if (s.kind == kSurfacePlane) {
        const double length = std::sqrt(s.map[0] * s.map[0] + s.map[1] * s.map[1] + s.map[2] * s.map[2]);
        for (int j = 0; j < 4; ++j) s.map[j] /= length;
    }
    return s;
}

/// What identifies a surface up to a factor: numbers to compare, scaled to unit size.
std::array<double, 16> signature(const Surface& s) {
    std::array<double, 16> g{};
    if (s.kind == kSurfacePlane) {
        std::copy(s.map, s.map + 4, g.begin());
        return g;
    }
    if (s.kind == kSurfaceTorus || s.kind == kSurfaceExpression || s.kind == kSurfacePatch ||
        s.kind == kSurfaceRounded) {
        std::copy(s.map, s.map + 12, g.begin());
        std::copy(s.form, s.form + 4, g.begin() + 12);
    } else {
        // Quadric in homogeneous coordinates: Σ form_i row_i row_iᵀ. A cone's nappe is told by row 2.
        const double form[3] = {s.kind == kSurfaceCone ? 1 : s.form[0],
                                s.kind == kSurfaceCone ? 1 : s.form[1],
                                s.kind == kSurfaceCone ? -1 : s.form[2]};
        std::size_t at = 0;
        for (int a = 0; a < 4; ++a) {
            for (int b = a; b < 4; ++b) {
                double sum = a == 3 && b == 3 ? s.form[3] : 0;
                for (int i = 0; i < 3; ++i) sum += form[i] * s.map[4 * i + a] * s.map[4 * i + b];
                g[at++] = sum;
            }
        }
        if (s.kind == kSurfaceCone) std::copy(s.map + 8, s.map + 12, g.begin() + 10);
    }
    double norm = 0;
    const std::size_t scaled = s.kind == kSurfaceQuadric || s.kind == kSurfaceCone ? 10 : 0;
    for (std::size_t i = 0; i < scaled; ++i) norm += g[i] * g[i];
    norm = std::sqrt(norm);
    for (std::size_t i = 0; i < scaled && norm > 0; ++i) g[i] /= norm;
    return g;
}

/// +1 equal, -1 equal with the other sign, 0 different.
int compare_exactly(const Surface& a, const std::array<double, 16>& ga, const Surface& b,
                    const std::array<double, 16>& gb, const std::vector<ExpressionOp>& ops) {
    if (a.kind != b.kind) return 0;
    bool same = true;
    bool opposite = a.kind == kSurfacePlane || a.kind == kSurfaceQuadric;
    for (std::size_t i = 0; i < ga.size() && (same || opposite); ++i) {
        const double tolerance = kMergeTolerance * std::max(1.0, std::fabs(ga[i]));
        same = same && std::fabs(ga[i] - gb[i]) <= tolerance;
        opposite = opposite && std::fabs(ga[i] + gb[i]) <= tolerance;
    }
    if (a.kind == kSurfaceExpression && same) {
        if (a.op_count != b.op_count) return 0;
        for (std::uint32_t i = 0; i < a.op_count; ++i) {
            const ExpressionOp& p = ops[a.first_op + i];
            const ExpressionOp& q = ops[b.first_op + i];
            if (p.operation != q.operation || p.out != q.out || p.a != q.a || p.b != q.b ||
                p.literal != q.literal) {
                return 0;
            }
        }
    }
    return same ? 1 : opposite ? -1 : 0;
}

/// Whether surfaces of one kind lie closer than `distance` in the whole cube: +1, -1 with the other sign, 0
/// if not. Planes are compared at the cube's corners, others at points of `a`. Patches, rounded
/// solids and formulas are not compared.
int compare_nearly(const Surface& a, const Surface& b, double distance) {
    constexpr int kSamples = 4;  // along each axis
    constexpr int kLeastFound = 6;
    constexpr int kSteps = 24;
    constexpr double kStill = 1e-13;
    constexpr double kBeyond = 0.05;  // of the cube: points of `a` so far outside still count
    if (a.kind != b.kind || a.kind == kSurfaceExpression || a.kind == kSurfacePatch ||
        a.kind == kSurfaceRounded)
        return 0;
    if (a.kind == kSurfacePlane) {
        const double side = a.map[0] * b.map[0] + a.map[1] * b.map[1] + a.map[2] * b.map[2] > 0 ? 1 : -1;
        for (int c = 0; c < 8; ++c) {
            double difference = a.map[3] - side * b.map[3];
            for (int j = 0; j < 3; ++j) difference += ((c >> j) & 1) * (a.map[j] - side * b.map[j]);
            if (!(std::fabs(difference) <= distance)) return 0;
        }
        return side > 0 ? 1 : -1;
    }
    int found = 0;
    int sign = 0;
    for (int k = 0; k < kSamples * kSamples * kSamples; ++k) {
        Vec3 x = {(k % kSamples + 0.5) / kSamples, (k / kSamples % kSamples + 0.5) / kSamples,
                  (k / kSamples / kSamples + 0.5) / kSamples};
        double moved = 1;
        SurfaceSample at{};
        for (int step = 0; step < kSteps && moved > kStill; ++step) {
            at = surface_sample(&a, nullptr, x[0], x[1], x[2]);
            double square = 0;
            for (const double g : at.gradient) square += g * g;
            if (!(square > 0)) break;
            moved = std::fabs(at.value) / std::sqrt(square);
            for (std::size_t j = 0; j < 3; ++j) x[j] -= at.value / square * at.gradient[j];
        }
        if (!(moved <= kStill)) continue;
        if (!(std::min({x[0], x[1], x[2]}) > -kBeyond && std::max({x[0], x[1], x[2]}) < 1 + kBeyond))
            continue;
        const SurfaceSample other = surface_sample(&b, nullptr, x[0], x[1], x[2]);
        double square = 0;
        double along = 0;
        for (int j = 0; j < 3; ++j) {
            square += other.gradient[j] * other.gradient[j];
            along += other.gradient[j] * at.gradient[j];
        }
        if (!(other.value * other.value <= distance * distance * square)) return 0;
        const int here = along > 0 ? 1 : -1;
        if (sign != 0 && here != sign) return 0;
        sign = here;
        ++found;
    }
    return found >= kLeastFound ? sign : 0;
}

}  // namespace

SurfaceMerge::SurfaceMerge(const CompiledModel& compiled, const Vec3& origin, double side)
    : target(compiled.surfaces.size()), flipped(compiled.surfaces.size(), 0) {
    for (const WorldSurface& world : compiled.surfaces) {
        local_.push_back(to_local(world.surface, origin, side));
        signatures_.push_back(signature(local_.back()));
    }
}

template <class Visit>
void SurfaceMerge::for_near(std::size_t i, double distance, const Visit& visit) const {
    const std::array<double, 16>& own = signatures_[i];
    if (has_start(i)) {
        const auto [begin, end] = by_start_.equal_range(own[kStart]);
        for (auto k = begin; k != end; ++k) visit(k->second);
        return;
    }
    const auto reach_of = [distance](double offset) {
        return std::max(2 * kMergeTolerance * std::max(1.0, offset), kCoefficientReach * distance);
    };
    // Balls of a lattice share one coefficient with many others, but not three.
    const bool is_quadric = local_[i].kind == kSurfaceQuadric || local_[i].kind == kSurfaceCone;
    const auto is_near = [&](const std::array<double, 16>& other) {
        return !is_quadric || std::all_of(std::begin(kOffsets), std::end(kOffsets), [&](std::size_t at) {
            const double offset = std::fabs(own[at]);
            return std::fabs(std::fabs(other[at]) - offset) <= reach_of(offset);
        });
    };
    const double offset = std::fabs(own[kOffsets[0]]);
    const double reach = reach_of(offset);
    const auto end = by_offset_.upper_bound(offset + reach);
    for (auto k = by_offset_.lower_bound(offset - reach); k != end; ++k) {
        if (is_near(signatures_[k->second])) visit(k->second);
    }
}

bool SurfaceMerge::has_start(std::size_t i) const {
    return local_[i].kind == kSurfaceRounded || local_[i].kind == kSurfacePatch;
}

std::uint64_t SurfaceMerge::merge_equal(const std::vector<ExpressionOp>& ops, double distance) {
    std::uint64_t nearly_equal = 0;
    for (std::size_t i = 0; i < local_.size(); ++i) {
        std::size_t found = i;
        bool is_nearly = false;
        for_near(i, distance, [&](std::size_t k) {
            if (k >= found) return;  // the first equal one, whatever the order here
            int equal = compare_exactly(local_[k], signatures_[k], local_[i], signatures_[i], ops);
            const bool nearly = equal == 0;
            if (nearly && distance > 0) equal = compare_nearly(local_[k], local_[i], distance);
            if (equal == 0) return;
            found = k;
            flipped[i] = equal < 0 ? 1 : 0;
            is_nearly = nearly;
        });
        nearly_equal += is_nearly ? 1 : 0;
        target[i] = static_cast<std::uint32_t>(found);
        if (found != i) continue;
        if (has_start(i)) {
            by_start_.emplace(signatures_[i][kStart], i);
        } else {
            by_offset_.emplace(std::fabs(signatures_[i][kOffsets[0]]), i);
        }
    }
    return nearly_equal;
}

std::uint64_t SurfaceMerge::merge_alike(const CompiledModel& compiled, double distance) {
    const std::vector<std::int64_t> uses = find_uses(compiled);
    std::vector<std::size_t> onto(local_.size());
    std::vector<std::uint32_t> turned(local_.size(), 0);
    std::uint64_t alike = 0;
    for (std::size_t i = 0; i < local_.size(); ++i) {
        onto[i] = i;
        if (target[i] != i || uses[i] < 0) continue;
        bool is_alone = true;
        for_near(i, kAlone * distance, [&](std::size_t k) {
            if (k == i || !is_alone) return;
            const int near = compare_nearly(local_[k], local_[i], kAlone * distance);
            if (near == 0) return;
            is_alone = uses[k] >= 0 && (uses[k] ^ (near < 0 ? 1 : 0)) == uses[i];
            if (k >= onto[i] || onto[k] != k || compare_nearly(local_[k], local_[i], distance) == 0) return;
            onto[i] = k;
            turned[i] = near < 0 ? 1 : 0;
        });
        if (!is_alone) onto[i] = i;
        alike += onto[i] != i ? 1 : 0;
    }
    for (std::size_t i = 0; i < local_.size(); ++i) {
        flipped[i] ^= onto[target[i]] != target[i] ? turned[target[i]] : 0;
        target[i] = static_cast<std::uint32_t>(onto[target[i]]);
    }
    return alike;
}

/// Per surface that stands for others: twice the only region that it bounds, plus 1 if it is negated
/// wherever it does; negative if there is no such region.
std::vector<std::int64_t> SurfaceMerge::find_uses(const CompiledModel& compiled) const {
    constexpr std::int64_t kNone = -1, kMixed = -2;
    std::vector<std::int64_t> uses(local_.size(), kNone);
    const auto add = [&](std::uint32_t surface, std::int64_t use) {
        std::int64_t& own = uses[target[surface]];
        own = own == kNone || own == use ? use : kMixed;
    };
    std::vector<std::uint32_t> literals;  // of the formula that ends with the next select
    for (const std::uint32_t word : compiled.tape) {
        const std::uint32_t operation = tape_operation(word);
        if (operation == kTapeLiteral) literals.push_back(word);
        if (operation != kTapeSelect && operation != kTapeSelectConst) continue;
        for (const std::uint32_t literal : literals) {
            const std::uint32_t surface = tape_surface(literal);
            add(surface, 2 * std::int64_t{tape_region(word)} + (tape_negated(literal) ^ flipped[surface]));
        }
        literals.clear();
    }
    for (const WorldPolyhedron& world : compiled.polyhedra) {
        for (const std::uint32_t surface : world.surface) add(surface, kMixed);
    }
    for (const PeriodicSurfaces& pair : compiled.periodic) {
        for (const std::uint32_t surface : {pair.first, pair.second})
            if (surface != PeriodicSurfaces::kNoSurface) add(surface, kMixed);
    }
    return uses;
}

}  // namespace mortise::tape
