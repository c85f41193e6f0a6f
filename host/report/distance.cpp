// See distance.hpp.
#include "host/report/distance.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/constants.hpp"
#include "host/common/random.hpp"
#include "host/report/facet_tree.hpp"

namespace mortise::report {
namespace {

constexpr std::size_t kSampleChunk = 2048;
constexpr std::size_t kMostPoints = 300000;
constexpr int kLineSteps = 8;    // that a line in a leaf is looked at in
constexpr int kBisections = 40;  // of one of them: 2⁻⁴³ of a cell

/// A sum and the largest of many values, with the place of the largest.
struct Tally {
    std::uint64_t count = 0;
    std::uint64_t unmeasured = 0;
    double weight = 0, sum = 0, maximum = -1;
    Vector place;

    void add(double value, double by, const Vector& at) {
        if (!std::isfinite(value)) return;
        ++count;
        weight += by;
        sum += by * value;
        if (value > maximum) {
            maximum = value;
            place = at;
        }
    }
    void add(const Tally& later) {
        count += later.count;
        unmeasured += later.unmeasured;
        weight += later.weight;
        sum += later.sum;
        if (later.maximum > maximum) {
            maximum = later.maximum;
            place = later.place;
        }
    }
};

Vec3 place_of(const tape::BoundModel& model, const Vector& local) {
    const Vector p = features::to_model(model, local);
    return {p.x, p.y, p.z};
}

DistanceFigures figures_of(const Tally& tally, const tape::BoundModel& model) {
    DistanceFigures figures;
    figures.samples = tally.count;
    figures.unmeasured = tally.unmeasured;
    if (tally.count == 0) return figures;
    figures.maximum = model.side * tally.maximum;
    figures.mean = model.side * (tally.sum / tally.weight);
    figures.place = place_of(model, tally.place);
    return figures;
}

/// The point of a surface that belongs to a sample.
struct Foot {
    Vector at;
    bool is_found = false;
    bool is_smooth = false;  ///< the surface has a normal there
};

/// Where Newton's method along the gradient ends. Steps are limited: near a centre the gradient is small.
Foot project(const tape::BoundModel& model, std::uint32_t surface, const Vector& from) {
    constexpr int kSteps = 40;
    constexpr double kLongest = 0.1;  // edges of the root box
    constexpr double kSettled = 1e-14;
    constexpr double kNearlySettled = 1e-7;  // kinks, and rounding
    Vector x = from;
    double size = HUGE_VAL;
    for (int step = 0; step < kSteps; ++step) {
        const SurfaceSample s = features::sample(model, surface, x);
        const Vector g{s.gradient[0], s.gradient[1], s.gradient[2]};
        Vector move = (-s.value / dot(g, g)) * g;
        if (s.value == 0) move = {};
        size = length(move);
        if (!std::isfinite(size)) break;
        if (size > kLongest) move = (kLongest / size) * move;
        x = x + move;
        if (size < kSettled) break;
    }
    const bool is_found = size < kNearlySettled;
    return {x, is_found, is_found};
}

/// The nearest place on a line through a sample, to both sides, where a formula changes its sign: it may jump
/// there, or be no number beyond, so that gradients lead elsewhere. Not farther than `reach`.
Foot find_change(const tape::BoundModel& model, std::uint32_t surface, const Vector& from,
                 const Vector& direction, double reach) {
    constexpr int kDoublings = 24;
    const auto is_inside = [&](double t) {
        return features::value(model, surface, from + t * direction) <= 0;
    };
    const bool here = is_inside(0);
    double low = 0;
    for (int k = kDoublings; k >= 0; --k) {
        double high = std::ldexp(reach, -k);
        for (const double side : {1.0, -1.0}) {
            if (is_inside(side * high) == here) continue;
            for (int i = 0; i < kBisections; ++i) {
                const double middle = 0.5 * (low + high);
                (is_inside(side * middle) == here ? low : high) = middle;
            }
            return {from + (side * high) * direction, true, false};
        }
        low = high;
    }
    return {};
}

/// The foot of a sample on its facet's surface. `normal`: the facet's, of unit length; `size`: its longest
/// edge.
Foot find_foot(const tape::BoundModel& model, std::uint32_t surface, const Vector& sample,
               const Vector& normal, double size) {
    // Facets lie closer to smooth surfaces than this, in their size.
    constexpr double kUsual = 0.05;
    const Foot smooth = project(model, surface, sample);
    if (model.surfaces[surface].kind != kSurfaceExpression) return {smooth.at, true, true};
    if (smooth.is_found && length(smooth.at - sample) <= kUsual * size) return smooth;
    // As when a vertex of the grid lies where a formula is no number: it is asked a little beside.
    const Vector aside = 1e-6 * size * Vector{0.62, 0.53, 0.58};
    const Vector from = std::isfinite(features::value(model, surface, sample)) ? sample : sample + aside;
    const Foot beside = smooth.is_found ? smooth : project(model, surface, from);
    double reach = beside.is_found ? std::min(size, 0.9 * length(beside.at - from)) : size;
    Foot nearest = beside;
    // Near an edge of a jump the nearest part of it may face any way; most jump along an axis.
    const Vector directions[] = {
        normal, features::unit_normal(model, surface, from), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (const Vector& direction : directions) {
        if (!(dot(direction, direction) > 0)) continue;
        const Foot change = find_change(model, surface, from, direction, reach);
        if (!change.is_found) continue;
        nearest = change;
        reach = length(change.at - from);
    }
    return nearest;
}

constexpr std::size_t kMostSamples = 13;

std::size_t facet_samples(const Vector* p, bool is_triangle, Vector* samples) {
    std::size_t count = 0;
    const int corners = is_triangle ? 3 : 4;
    for (int k = 0; k < corners; ++k) {
        samples[count++] = p[k];
        samples[count++] = 0.5 * (p[k] + p[(k + 1) % corners]);
    }
    if (is_triangle) {
        for (int k = 0; k < 3; ++k) {
            samples[count++] = (2.0 / 3) * p[k] + (1.0 / 6) * (p[(k + 1) % 3] + p[(k + 2) % 3]);
        }
        samples[count++] = (1.0 / 3) * (p[0] + p[1] + p[2]);
    } else {
        for (int k = 0; k < 4; ++k) {
            samples[count++] =
                0.5625 * p[k] + 0.1875 * (p[(k + 1) % 4] + p[(k + 3) % 4]) + 0.0625 * p[(k + 2) % 4];
        }
        samples[count++] = 0.25 * (p[0] + p[1] + p[2] + p[3]);
    }
    return count;
}

}  // namespace

void report_facets(const Mesh& mesh, const std::vector<std::uint32_t>& facet_surface,
                   const tape::BoundModel& model, int threads, QualityReport& report) {
    const std::size_t count = mesh.facets.size();
    std::vector<Tally> distances(chunk_count(count, kSampleChunk)), angles(distances.size());
    parallel_chunks(count, kSampleChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        Tally& distance = distances[begin / kSampleChunk];
        Tally& angle = angles[begin / kSampleChunk];
        for (std::size_t f = begin; f < end; ++f) {
            const NodeId* n = mesh.facets.nodes.data() + 4 * f;
            Vector p[4], samples[kMostSamples];
            double size = 0;
            for (int k = 0; k < 4; ++k) {
                p[k] = features::to_local(model, features::point_of(mesh, n[k]));
                if (k > 0) size = std::max(size, length(p[k] - p[k - 1]));
            }
            // A quadrilateral's normal is that of its diagonals.
            const Vector normal =
                corner_count(n) == 3 ? cross(p[1] - p[0], p[2] - p[0]) : cross(p[2] - p[0], p[3] - p[1]);
            const Vector direction = features::unit(normal);
            const std::size_t number = facet_samples(p, corner_count(n) == 3, samples);
            Foot foot;
            for (std::size_t i = 0; i < number; ++i) {
                foot = find_foot(model, facet_surface[f], samples[i], direction, size);
                if (foot.is_found)
                    distance.add(length(foot.at - samples[i]), 1, samples[i]);
                else
                    ++distance.unmeasured;
            }
            // The last sample is the facet's mean.
            if (!foot.is_smooth) continue;
            const Vector true_normal = features::unit_normal(model, facet_surface[f], foot.at);
            if (dot(normal, normal) == 0 || dot(true_normal, true_normal) == 0) continue;
            angle.add(kDegrees *
                          std::atan2(length(cross(normal, true_normal)), std::fabs(dot(normal, true_normal))),
                      length(normal), samples[number - 1]);
        }
    });
    Tally distance, angle;
    for (const Tally& part : distances) distance.add(part);
    for (const Tally& part : angles) angle.add(part);
    report.mesh_to_model = figures_of(distance, model);
    if (angle.count == 0) return;
    report.max_normal_angle = angle.maximum;
    report.mean_normal_angle = angle.sum / angle.weight;
    report.max_normal_place = place_of(model, angle.place);
}

void sample_boundary(const tape::BoundModel& model, const Leaf& leaf, const Depth& depth,
                     std::vector<BoundaryPoint>& points) {
    Random random(leaf.number);
    std::vector<std::int8_t> signs;
    const double size = 2 * leaf.cell.half;
    const double edge = std::ldexp(size, depth.deepest);
    for (int axis = 0; axis < 3; ++axis) {
        double x[3];
        for (int j = 0; j < 3; ++j) x[j] = leaf.cell.centre[j] + (random.uniform() - 0.5) * size;
        const double low = leaf.cell.centre[axis] - leaf.cell.half;
        const auto at = [&](double t) {
            x[axis] = low + t * size;
            return Vector{x[0], x[1], x[2]};
        };
        const auto region_at = [&](double t) {
            leaf.signs_at(model, at(t), signs);
            return leaf.region(signs);
        };
        std::int32_t before = region_at(0);
        for (int step = 1; step <= kLineSteps; ++step) {
            const std::int32_t after = region_at(static_cast<double>(step) / kLineSteps);
            if (before != after) {
                double from = static_cast<double>(step - 1) / kLineSteps,
                       to = static_cast<double>(step) / kLineSteps;
                for (int i = 0; i < kBisections; ++i) {
                    const double middle = 0.5 * (from + to);
                    (region_at(middle) == before ? from : to) = middle;
                }
                points.push_back({at(0.5 * (from + to)), edge * edge});
            }
            before = after;
        }
    }
}

DistanceFigures distance_to_facets(const Mesh& mesh, const tape::BoundModel& model,
                                   const std::vector<BoundaryPoint>& points, int threads) {
    const FacetTree tree(mesh, model);
    const std::size_t stride = points.size() / kMostPoints + 1;
    const std::size_t count = (points.size() + stride - 1) / stride;
    std::vector<Tally> parts(chunk_count(count, kSampleChunk));
    parallel_chunks(count, kSampleChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) {
            const BoundaryPoint& point = points[i * stride];
            parts[begin / kSampleChunk].add(tree.distance(point.local), point.weight, point.local);
        }
    });
    Tally all;
    for (const Tally& part : parts) all.add(part);
    return figures_of(all, model);
}

}  // namespace mortise::report
