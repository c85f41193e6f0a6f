// See corners.hpp.
#include "host/report/corners.hpp"

#include <cmath>

#include "host/common/constants.hpp"

namespace mortise::report {
namespace {

constexpr std::size_t kMostSurfaces = 16;  // of a leaf: the nearest to its centre
constexpr double kOnSurface = 1e-9;        // edges of the root box
constexpr double kMerged = 1e-8;           // corners closer than this are one
constexpr double kNear = 0.01;             // how far from a candidate its surroundings are sampled, in cells
constexpr int kLines = 32;                 // about each direction
constexpr int kNewtonSteps = 20;
constexpr double kIsolated = 1e-8;  // squared condition of a point of contact

class CornerFinder {
  public:
    CornerFinder(const tape::BoundModel& model, const Leaf& leaf)
        : model_(model), leaf_(leaf), size_(2 * leaf.cell.half), surfaces_(leaf.surfaces) {
        if (surfaces_.size() <= kMostSurfaces) return;
        std::vector<std::pair<double, std::uint32_t>> near;
        for (const std::uint32_t s : surfaces_) {
            const SurfaceSample f = features::sample(model_, s, leaf_.centre());
            const double gradient = length(Vector{f.gradient[0], f.gradient[1], f.gradient[2]});
            near.push_back({gradient > 0 ? std::fabs(f.value) / gradient : HUGE_VAL, s});
        }
        std::sort(near.begin(), near.end());
        for (std::size_t i = 0; i < kMostSurfaces; ++i) surfaces_[i] = near[i].second;
        surfaces_.resize(kMostSurfaces);
        std::sort(surfaces_.begin(), surfaces_.end());
    }

    void run(std::vector<Corner>& corners) {
        for (std::size_t i = 0; i < surfaces_.size(); ++i) {
            Vector apex;
            if (features::singular_point(model_.surfaces[surfaces_[i]], &apex)) try_apex(i, apex);
            for (std::size_t j = i + 1; j < surfaces_.size(); ++j) {
                find_contact(surfaces_[i], surfaces_[j]);
                for (std::size_t k = j + 1; k < surfaces_.size(); ++k) {
                    find_triple(surfaces_[i], surfaces_[j], surfaces_[k]);
                }
            }
        }
        corners.insert(corners.end(), found_.begin(), found_.end());
    }

  private:
    bool is_plane(std::uint32_t s) const { return model_.surfaces[s].kind == kSurfacePlane; }

    double distance_from_centre(const Vector& x) const {
        const Vector d = x - leaf_.centre();
        return std::max({std::fabs(d.x), std::fabs(d.y), std::fabs(d.z)});
    }
    bool is_inside(const Vector& x) const {
        return distance_from_centre(x) <= leaf_.cell.half * (1 + 1e-9) + kOnSurface;
    }
    bool is_known(const Vector& x) const {
        for (const Corner& corner : found_) {
            if (length(corner.local - x) < kMerged) return true;
        }
        return false;
    }

    /// Calls attempt(start) with the centre and, if `all`, eight more points of the leaf.
    template <class Attempt>
    void from_starts(bool all, const Attempt& attempt) const {
        attempt(leaf_.centre());
        for (unsigned i = 0; all && i < 8; ++i) {
            const double step = 0.5 * leaf_.cell.half;
            attempt(leaf_.centre() + Vector{(i & 1u) != 0 ? step : -step, (i & 2u) != 0 ? step : -step,
                                            (i & 4u) != 0 ? step : -step});
        }
    }

    void find_triple(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        const std::uint32_t triple[3] = {a, b, c};
        from_starts(!(is_plane(a) && is_plane(b) && is_plane(c)), [&](Vector x) {
            for (int step = 0; step < kNewtonSteps; ++step) {
                Vector g[3];
                double f[3];
                for (int i = 0; i < 3; ++i) {
                    const SurfaceSample s = features::sample(model_, triple[i], x);
                    g[i] = {s.gradient[0], s.gradient[1], s.gradient[2]};
                    f[i] = s.value;
                }
                const double determinant = dot(cross(g[0], g[1]), g[2]);
                if (!(std::fabs(determinant) > 0)) return;
                const Vector move =
                    (-1 / determinant) *
                    (f[0] * cross(g[1], g[2]) + f[1] * cross(g[2], g[0]) + f[2] * cross(g[0], g[1]));
                x = x + move;
                if (!(distance_from_centre(x) < 4 * size_)) return;
                if (length(move) < 1e-12) break;
                if (step + 1 == kNewtonSteps) return;
            }
            if (!is_inside(x) || is_known(x)) return;
            const std::vector<std::uint32_t>& meeting = reduced_set(x);
            if (spans(meeting, x)) found_.push_back({x, meeting});
        });
    }

    bool spans(const std::vector<std::uint32_t>& set, const Vector& x) const {
        std::vector<Vector> n;
        for (const std::uint32_t s : set) n.push_back(features::unit_normal(model_, s, x));
        for (std::size_t i = 2; i < n.size(); ++i) {
            for (std::size_t j = 1; j < i; ++j) {
                for (std::size_t k = 0; k < j; ++k) {
                    if (features::is_corner(n[i], n[j], n[k])) return true;
                }
            }
        }
        return false;
    }

    void try_apex(std::size_t i, const Vector& apex) {
        if (!is_inside(apex) || is_known(apex)) return;
        const std::vector<std::uint32_t>& meeting = reduced_set(apex);
        if (std::binary_search(meeting.begin(), meeting.end(), surfaces_[i]))
            found_.push_back({apex, meeting});
    }

    /// f and g over their slopes in cells, and the cross product of their normals: all zero where they touch.
    struct Contact {
        double value[5];
    };
    Contact contact(std::uint32_t a, std::uint32_t b, const Vector& x) const {
        const SurfaceSample f = features::sample(model_, a, x), g = features::sample(model_, b, x);
        const Vector p{f.gradient[0], f.gradient[1], f.gradient[2]};
        const Vector q{g.gradient[0], g.gradient[1], g.gradient[2]};
        const Vector n = cross(features::unit(p), features::unit(q));
        return {{f.value / (length(p) * size_), g.value / (length(q) * size_), n.x, n.y, n.z}};
    }

    /// Gauss-Newton with differences for the five equations of contact. Where the surfaces touch along a
    /// line (a rounding), the point is not isolated, and no corner.
    void find_contact(std::uint32_t a, std::uint32_t b) {
        if (is_plane(a) && is_plane(b)) return;
        const Contact middle = contact(a, b, leaf_.centre());
        const double sine = middle.value[2] * middle.value[2] + middle.value[3] * middle.value[3] +
                            middle.value[4] * middle.value[4];
        if (!(sine < 0.5)) return;
        from_starts(false, [&](Vector x) {
            double condition = 0;
            for (int step = 0; step < kNewtonSteps; ++step) {
                const double h = 1e-5 * size_;
                const Contact f = contact(a, b, x);
                Vector row[5];
                for (int j = 0; j < 3; ++j) {
                    const Vector e{j == 0 ? h : 0, j == 1 ? h : 0, j == 2 ? h : 0};
                    const Contact more = contact(a, b, x + e), less = contact(a, b, x - e);
                    for (int i = 0; i < 5; ++i) {
                        const double slope = (more.value[i] - less.value[i]) / (2 * h) * size_;
                        (j == 0 ? row[i].x : j == 1 ? row[i].y : row[i].z) = slope;
                    }
                }
                Vector m[3], right;  // normal equations
                for (int i = 0; i < 5; ++i) {
                    m[0] = m[0] + row[i].x * row[i];
                    m[1] = m[1] + row[i].y * row[i];
                    m[2] = m[2] + row[i].z * row[i];
                    right = right - f.value[i] * row[i];
                }
                const double determinant = dot(cross(m[0], m[1]), m[2]);
                const double trace = m[0].x + m[1].y + m[2].z;
                if (!(determinant > 0) || !(trace > 0)) return;
                condition = 4 * determinant / (trace * trace * trace);
                const Vector move =
                    (1 / determinant) *
                    (right.x * cross(m[1], m[2]) + right.y * cross(m[2], m[0]) + right.z * cross(m[0], m[1]));
                x = x + size_ * move;
                if (!(distance_from_centre(x) < 2 * size_)) return;
                if (length(move) * size_ < 1e-11) break;
                if (step + 1 == kNewtonSteps) return;
            }
            const Contact end = contact(a, b, x);
            double rest = 0;
            for (const double v : end.value) rest = std::max(rest, std::fabs(v));
            if (!(rest < 1e-6) || condition < kIsolated || !is_inside(x) || is_known(x)) return;
            const std::vector<std::uint32_t>& meeting = reduced_set(x);
            if (std::binary_search(meeting.begin(), meeting.end(), a) &&
                std::binary_search(meeting.begin(), meeting.end(), b)) {
                found_.push_back({x, meeting});
            }
        });
    }

    struct Crossing {
        double t;
        std::size_t surface;  ///< index into the leaf's
        bool operator<(const Crossing& other) const { return t < other.t; }
    };

    void cross_line(std::size_t i, const Vector& from, const Vector& along, double reach,
                    std::vector<Crossing>& crossings) const {
        const std::size_t first = crossings.size();
        for (const double start : {-reach, 0.0, reach}) {
            double t = start;
            for (int step = 0; step < 12; ++step) {
                const SurfaceSample s = features::sample(model_, leaf_.surfaces[i], from + t * along);
                const double slope = dot(Vector{s.gradient[0], s.gradient[1], s.gradient[2]}, along);
                const double move = -s.value / slope;
                if (!std::isfinite(move)) break;
                t += move;
                if (!(std::fabs(t) < 10 * reach)) break;
                if (std::fabs(move) > 1e-9 * reach) continue;
                bool known = false;
                for (std::size_t k = first; k < crossings.size(); ++k) {
                    known = known || std::fabs(crossings[k].t - t) < 1e-6 * reach;
                }
                if (!known) crossings.push_back({t, i});
                break;
            }
        }
    }

    /// Surfaces through x whose flip changes the region near x. Many triples of surfaces meet in one point,
    /// most of them inside the solid.
    const std::vector<std::uint32_t>& reduced_set(const Vector& x) {
        for (const Corner& point : examined_) {
            if (length(point.local - x) < kMerged) return point.surfaces;
        }
        examined_.push_back({x, sample_set(x)});
        return examined_.back().surfaces;
    }

    /// The same, at crossings of lines that pass close by.
    std::vector<std::uint32_t> sample_set(const Vector& x) const {
        std::vector<std::size_t> through;
        std::vector<std::int8_t> signs, trial;
        leaf_.signs_at(model_, x, signs);
        for (std::size_t i = 0; i < leaf_.surfaces.size(); ++i) {
            const SurfaceSample s = features::sample(model_, leaf_.surfaces[i], x);
            const double gradient = length(Vector{s.gradient[0], s.gradient[1], s.gradient[2]});
            Vector apex;
            const bool on = std::fabs(s.value) <= kOnSurface * gradient ||
                            (features::singular_point(model_.surfaces[leaf_.surfaces[i]], &apex) &&
                             length(apex - x) < kOnSurface);
            if (on) through.push_back(i);
        }
        trial = signs;
        for (const std::size_t i : through) trial[i] = 0;
        if (leaf_.region(trial) != kUnknown) return {};
        std::vector<Vector> directions = {features::unit({0.36, 0.48, 0.8}), features::unit({0.8, -0.6, 0.1}),
                                          features::unit({-0.3, 0.5, -0.7})};
        for (std::size_t i = 0; i < through.size() && i < 8; ++i) {
            const Vector n = features::unit_normal(model_, leaf_.surfaces[through[i]], x);
            if (dot(n, n) > 0) directions.push_back(n);
        }
        std::vector<bool> matters(leaf_.surfaces.size(), false);
        const double reach = kNear * size_;
        std::vector<Crossing> crossings;
        for (const Vector& along : directions) {
            const Vector e =
                features::unit(cross(along, std::fabs(along.x) < 0.6 ? Vector{1, 0, 0} : Vector{0, 1, 0}));
            const Vector f = cross(along, e);
            for (int line = 0; line < kLines; ++line) {
                const double angle = kTurn * (line + 0.37) / kLines;
                const Vector from = x + (reach * std::cos(angle)) * e + (reach * std::sin(angle)) * f;
                crossings.clear();
                for (const std::size_t i : through) cross_line(i, from, along, reach, crossings);
                std::sort(crossings.begin(), crossings.end());
                for (std::size_t k = 0; k < crossings.size(); ++k) {
                    const double t = crossings[k].t;
                    const bool alone = (k == 0 || t - crossings[k - 1].t > 2e-6 * reach) &&
                                       (k + 1 == crossings.size() || crossings[k + 1].t - t > 2e-6 * reach);
                    if (!alone) continue;
                    // The others' signs as they are here: crossings of theirs that were not found do not
                    // count for this surface.
                    trial = signs;
                    for (const std::size_t i : through)
                        trial[i] = features::value(model_, leaf_.surfaces[i], from + t * along) <= 0 ? -1 : 1;
                    trial[crossings[k].surface] = -1;
                    const std::int32_t inside = leaf_.region(trial);
                    trial[crossings[k].surface] = 1;
                    if (leaf_.region(trial) != inside) matters[crossings[k].surface] = true;
                }
            }
        }
        std::vector<std::uint32_t> set;
        for (std::size_t i = 0; i < matters.size(); ++i) {
            if (matters[i]) set.push_back(leaf_.surfaces[i]);
        }
        return set;
    }

    const tape::BoundModel& model_;
    const Leaf& leaf_;
    double size_;  ///< of the leaf
    std::vector<std::uint32_t> surfaces_;
    std::vector<Corner> found_;
    std::vector<Corner> examined_;  ///< points and their reduced sets
};

}  // namespace

void find_corners(const tape::BoundModel& model, const Leaf& leaf, std::vector<Corner>& corners) {
    CornerFinder(model, leaf).run(corners);
}

void merge_corners(std::vector<Corner>& corners) {
    std::stable_sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) {
        if (a.local.x != b.local.x) return a.local.x < b.local.x;
        if (a.local.y != b.local.y) return a.local.y < b.local.y;
        return a.local.z < b.local.z;
    });
    std::vector<Corner> kept;
    for (Corner& corner : corners) {
        bool known = false;
        for (std::size_t i = kept.size(); i-- > 0 && corner.local.x - kept[i].local.x < kMerged && !known;) {
            known = length(kept[i].local - corner.local) < kMerged;
            if (!known) continue;
            std::vector<std::uint32_t> both;
            std::set_union(kept[i].surfaces.begin(), kept[i].surfaces.end(), corner.surfaces.begin(),
                           corner.surfaces.end(), std::back_inserter(both));
            kept[i].surfaces = std::move(both);
        }
        if (!known) kept.push_back(std::move(corner));
    }
    corners = std::move(kept);
}

}  // namespace mortise::report
