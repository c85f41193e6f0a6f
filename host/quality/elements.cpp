// Element by element: repeated nodes, Jacobian, volume, scaled Jacobian, dihedral angles.
#include <algorithm>
#include <cmath>

#include "host/common/constants.hpp"
#include "host/common/parallel.hpp"
#include "host/quality/curved.hpp"
#include "host/quality/passes.hpp"
#include "host/quality/shape.hpp"

namespace mortise::quality {
namespace {

constexpr std::size_t kMeasureChunk = 16384;

/// Neumaier's compensated sum: millions of chunk volumes add up without losing digits.
class Sum {
  public:
    void add(double value) {
        const double next = sum_ + value;
        lost_ += std::fabs(sum_) >= std::fabs(value) ? (sum_ - next) + value : (value - next) + sum_;
        sum_ = next;
    }
    double value() const { return sum_ + lost_; }

  private:
    double sum_ = 0, lost_ = 0;
};

struct ChunkFigures {
    DefectLog log;
    std::vector<double> region_volume;  ///< by region - 1; the last entry: elements without a valid region
    ShapeFigures shape;
};

bool has_repeated_node(const NodeId* nodes, std::size_t count) {
    for (std::size_t i = 1; i < count; ++i) {
        for (std::size_t j = 0; j < i; ++j) {
            if (nodes[i] == nodes[j]) return true;
        }
    }
    return false;
}

Middles middles_of(const Mesh& mesh, ElementType type, std::size_t element) {
    const auto count = static_cast<std::size_t>(kElementEdges[static_cast<std::size_t>(type)]);
    Middles middles;
    for (std::size_t e = 0; e < count; ++e)
        middles.p[e] = point_of(mesh, mesh.block(type).middles[count * element + e]);
    return middles;
}

DefectKind jacobian_defect(ElementType type) {
    return static_cast<DefectKind>(static_cast<int>(DefectKind::kHexahedronJacobian) +
                                   static_cast<int>(type));
}

void check_chunk(const Mesh& mesh, ElementType type, std::size_t begin, std::size_t end,
                 ChunkFigures& figures) {
    const ElementBlock& block = mesh.block(type);
    const std::size_t nodes = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(type)]);
    const std::size_t regions = mesh.region_names.size();
    figures.region_volume.assign(regions + 1, 0.0);
    for (std::size_t i = begin; i < end; ++i) {
        if (has_repeated_node(block.nodes.data() + nodes * i, nodes)) {
            figures.log.add(DefectKind::kElementRepeatedNode, [&] { return element_text(mesh, type, i); });
        }
        const Corners corners = corners_of(mesh, type, i);
        JacobianFigures jacobian = jacobian_figures(type, corners);
        if (!block.middles.empty()) {
            const Middles middles = middles_of(mesh, type, i);
            if (is_curved(type, corners, middles)) jacobian = curved_figures(type, corners, middles);
        }
        if (!jacobian.positive) {
            figures.log.add(jacobian_defect(type), [&] {
                return element_text(mesh, type, i) + ": minimum Jacobian " + number_text(jacobian.minimum);
            });
        }
        const std::size_t region = block.region[i];
        figures.region_volume[region >= 1 && region <= regions ? region - 1 : regions] += jacobian.volume;
        const ShapeFigures shape = shape_figures(type, corners);
        figures.shape.scaled_jacobian = std::min(figures.shape.scaled_jacobian, shape.scaled_jacobian);
        figures.shape.min_cosine = std::min(figures.shape.min_cosine, shape.min_cosine);
        figures.shape.max_cosine = std::max(figures.shape.max_cosine, shape.max_cosine);
    }
}

}  // namespace

void check_elements(const Mesh& mesh, int threads, DefectLog& log, CheckReport& report) {
    std::vector<Sum> volumes(mesh.region_names.size() + 1);
    ShapeFigures all;
    for (int t = 0; t < kElementTypes; ++t) {
        const ElementType type = static_cast<ElementType>(t);
        const std::size_t count = mesh.block(type).size();
        std::vector<ChunkFigures> chunks(chunk_count(count, kMeasureChunk));
        parallel_numbered(count, kMeasureChunk, threads,
                          [&](std::size_t chunk, std::size_t begin, std::size_t end) {
                              check_chunk(mesh, type, begin, end, chunks[chunk]);
                          });
        double& smallest = report.min_scaled_jacobian[static_cast<std::size_t>(t)];
        smallest = 1;
        for (const ChunkFigures& chunk : chunks) {
            log.merge(chunk.log);
            for (std::size_t i = 0; i < volumes.size(); ++i) volumes[i].add(chunk.region_volume[i]);
            smallest = std::min(smallest, chunk.shape.scaled_jacobian);
            all.min_cosine = std::min(all.min_cosine, chunk.shape.min_cosine);
            all.max_cosine = std::max(all.max_cosine, chunk.shape.max_cosine);
        }
    }
    Sum total;
    report.region_volume.clear();
    for (const Sum& volume : volumes) {
        total.add(volume.value());
        report.region_volume.push_back(volume.value());
    }
    report.region_volume.pop_back();
    report.volume = total.value();
    const bool any_angle = all.min_cosine <= all.max_cosine;
    report.min_dihedral = any_angle ? std::acos(all.max_cosine) * kDegrees : 0;
    report.max_dihedral = any_angle ? std::acos(all.min_cosine) * kDegrees : 0;
}

}  // namespace mortise::quality
