// See elements.hpp.
#include "host/report/elements.hpp"

#include <algorithm>
#include <cmath>

#include "host/common/constants.hpp"
#include "host/common/parallel.hpp"
#include "host/quality/shape.hpp"

namespace mortise::report {
namespace {

constexpr std::size_t kChunk = 16384;
constexpr std::size_t kFineBins = 3600;  // of 0.05 degrees, for percentiles
constexpr std::size_t kFinePerBin = 100;

/// Angles of one chunk of elements: integers and extremes, so that the order of chunks does not matter.
struct AngleCounts {
    std::vector<std::uint64_t> bins = std::vector<std::uint64_t>(kFineBins, 0);
    double min_cosine = 1;
    double max_cosine = -1;

    void add(double cosine) {
        if (!(cosine >= -1 && cosine <= 1)) return;  // coordinates that are no numbers
        min_cosine = std::min(min_cosine, cosine);
        max_cosine = std::max(max_cosine, cosine);
        const double bin = kDegrees * std::acos(cosine) * (kFineBins / 180.0);
        ++bins[std::min(static_cast<std::size_t>(bin), kFineBins - 1)];
    }
    void add(const AngleCounts& other) {
        for (std::size_t i = 0; i < kFineBins; ++i) bins[i] += other.bins[i];
        min_cosine = std::min(min_cosine, other.min_cosine);
        max_cosine = std::max(max_cosine, other.max_cosine);
    }
};

/// Coordinates that are no numbers make an element as bad as a flat one.
double scaled_or_zero(ElementType type, const quality::Corners& corners) {
    for (const quality::Vector& p : corners.p) {
        if (!std::isfinite(p.x + p.y + p.z)) return 0;
    }
    return quality::scaled_jacobian(type, corners);
}

/// Rank of the quantile of 1 % among `count` sorted values.
std::uint64_t low_rank(std::uint64_t count) { return (count - 1) / 100; }

AngleFigures angle_figures(const AngleCounts& counts) {
    AngleFigures figures;
    for (std::size_t i = 0; i < kFineBins; ++i) {
        figures.histogram[i / kFinePerBin] += counts.bins[i];
        figures.count += counts.bins[i];
    }
    if (figures.count == 0) return figures;
    figures.minimum = kDegrees * std::acos(counts.max_cosine);
    figures.maximum = kDegrees * std::acos(counts.min_cosine);
    const std::uint64_t rank = low_rank(figures.count);
    const double width = 180.0 / kFineBins;
    std::uint64_t below = 0;
    std::size_t bin = 0;
    while (below + counts.bins[bin] <= rank) below += counts.bins[bin++];
    figures.low_percentile = std::max(figures.minimum, static_cast<double>(bin) * width);
    std::uint64_t above = 0;
    bin = kFineBins;
    while (above + counts.bins[bin - 1] <= rank) above += counts.bins[--bin];
    figures.high_percentile = std::min(figures.maximum, static_cast<double>(bin) * width);
    return figures;
}

ElementShape shape_of(std::vector<double> values) {
    ElementShape shape;
    shape.count = values.size();
    if (values.empty()) return shape;
    double sum = 0;
    for (const double value : values) {
        sum += value;
        if (value > 0) {
            ++shape.histogram[std::min(static_cast<std::size_t>(20 * value), shape.histogram.size() - 1)];
        } else {
            ++shape.not_positive;
        }
    }
    const auto rank = values.begin() + static_cast<std::ptrdiff_t>(low_rank(values.size()));
    std::nth_element(values.begin(), rank, values.end());
    shape.percentile = *rank;
    shape.minimum = *std::min_element(values.begin(), rank + 1);
    shape.mean = sum / static_cast<double>(values.size());
    return shape;
}

struct Candidate {
    double value;
    int type;
    std::size_t index;
    bool operator<(const Candidate& other) const {
        if (value != other.value) return value < other.value;
        return type != other.type ? type < other.type : index < other.index;
    }
};

WorstElement describe(const Mesh& mesh, const Candidate& candidate) {
    WorstElement worst;
    worst.type = static_cast<ElementType>(candidate.type);
    worst.index = candidate.index;
    worst.scaled_jacobian = candidate.value;
    const quality::Corners corners = quality::corners_of(mesh, worst.type, candidate.index);
    const quality::ShapeFigures figures = quality::shape_figures(worst.type, corners);
    worst.min_dihedral = kDegrees * std::acos(figures.max_cosine);
    worst.max_dihedral = kDegrees * std::acos(figures.min_cosine);
    const int nodes = kElementNodes[static_cast<std::size_t>(candidate.type)];
    quality::Vector sum;
    for (int i = 0; i < nodes; ++i) sum = sum + corners.p[i];
    worst.place = {sum.x / nodes, sum.y / nodes, sum.z / nodes};
    worst.kind = static_cast<ElementKind>(mesh.block(worst.type).kind[candidate.index]);
    return worst;
}

}  // namespace

void report_elements(const Mesh& mesh, int worst, int threads, QualityReport& report) {
    const std::size_t keep = static_cast<std::size_t>(std::max(worst, 0));
    AngleCounts angles;
    std::vector<Candidate> candidates;
    for (int t = 0; t < kElementTypes; ++t) {
        const ElementType type = static_cast<ElementType>(t);
        const std::size_t count = mesh.block(type).size();
        std::vector<double> values(count);
        std::vector<AngleCounts> counts(static_cast<std::size_t>(thread_count(threads)));
        parallel_chunks(count, kChunk, threads, [&](std::size_t begin, std::size_t end, int thread) {
            AngleCounts& mine = counts[static_cast<std::size_t>(thread)];
            double cosines[quality::kMostAngles];
            for (std::size_t i = begin; i < end; ++i) {
                const quality::Corners corners = quality::corners_of(mesh, type, i);
                values[i] = scaled_or_zero(type, corners);
                const int found = quality::dihedral_cosines(type, corners, cosines);
                for (int k = 0; k < found; ++k) mine.add(cosines[k]);
            }
        });
        for (const AngleCounts& part : counts) angles.add(part);
        for (std::size_t i = 0; i < count; ++i) {
            const Candidate candidate{values[i], t, i};
            if (candidates.size() == keep && (keep == 0 || !(candidate < candidates.front()))) continue;
            candidates.push_back(candidate);
            std::push_heap(candidates.begin(), candidates.end());
            if (candidates.size() <= keep) continue;
            std::pop_heap(candidates.begin(), candidates.end());
            candidates.pop_back();
        }
        report.shapes[static_cast<std::size_t>(t)] = shape_of(std::move(values));
    }
    report.angles = angle_figures(angles);
    std::sort(candidates.begin(), candidates.end());
    for (const Candidate& candidate : candidates) report.worst.push_back(describe(mesh, candidate));
}

}  // namespace mortise::report

namespace mortise {

QualityReport element_quality(const Mesh& mesh, int worst) {
    quality::require_elements(mesh);
    QualityReport report;
    report::report_elements(mesh, worst, 0, report);
    return report;
}

}  // namespace mortise
