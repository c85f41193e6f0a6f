// Columns through a mesh against point membership of the model: see membership_scan.hpp.
#include "tests/mesher/membership_scan.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "tests/mesher/random_source.hpp"
#include "tests/model/membership.hpp"

namespace mortise::test {
namespace {

/// Where a vertical line passes a facet.
struct Crossing {
    double height;
    std::uint16_t below, above;  ///< regions
    bool operator<(const Crossing& other) const { return height < other.height; }
};

/// Facets that touch are passed at one height, but for rounding: puts those in an order in which each begins
/// where the last one ends. What is more than 1e-9 of `scale` apart keeps its order.
void order_touching(std::vector<Crossing>& crossings, double scale) {
    std::uint16_t region = 0;
    for (auto at = crossings.begin(); at != crossings.end(); ++at) {
        auto next = at;
        while (next != crossings.end() && next->below != region && next->height - at->height < 1e-9 * scale)
            ++next;
        if (next != crossings.end() && next->below == region) std::iter_swap(at, next);
        region = at->above;
    }
}

/// The facets that may meet a column, by the columns' grid. A facet is listed in every cell its bounds touch.
class FacetGrid {
  public:
    FacetGrid(const Mesh& mesh, const Box3& box, int lines)
        : mesh_(mesh), lines_(lines), scale_(box.max[2] - box.min[2]) {
        cells_.resize(static_cast<std::size_t>(lines) * static_cast<std::size_t>(lines));
        for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
            int low[2], high[2];
            for (std::size_t j = 0; j < 2; ++j) {
                double least = point(f, 0)[j], most = least;
                for (std::size_t k = 1; k < 4; ++k) {
                    least = std::min(least, point(f, k)[j]);
                    most = std::max(most, point(f, k)[j]);
                }
                low[j] = column(least, box, j);
                high[j] = column(most, box, j);
            }
            for (int y = low[1]; y <= high[1]; ++y) {
                for (int x = low[0]; x <= high[0]; ++x) cells_[index(x, y)].push_back(f);
            }
        }
    }

    /// Crossings of the vertical line through (x, y), from below.
    void cross(int column_x, int column_y, double x, double y, std::vector<Crossing>& crossings) const {
        crossings.clear();
        for (const std::size_t f : cells_[index(column_x, column_y)]) {
            cross_triangle(f, 0, 1, 2, x, y, crossings);
            if (mesh_.facets.nodes[4 * f + 3] != mesh_.facets.nodes[4 * f + 2]) {
                cross_triangle(f, 0, 2, 3, x, y, crossings);
            }
        }
        std::sort(crossings.begin(), crossings.end());
        order_touching(crossings, scale_);
    }

  private:
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(lines_) + static_cast<std::size_t>(x);
    }
    const double* point(std::size_t facet, std::size_t corner) const {
        return mesh_.points.data() + 3 * mesh_.facets.nodes[4 * facet + corner];
    }
    int column(double value, const Box3& box, std::size_t axis) const {
        const double t = (value - box.min[axis]) / (box.max[axis] - box.min[axis]) * lines_;
        return std::clamp(static_cast<int>(std::floor(t)), 0, lines_ - 1);
    }
    void cross_triangle(std::size_t f, std::size_t i, std::size_t j, std::size_t k, double x, double y,
                        std::vector<Crossing>& crossings) const {
        const double *a = point(f, i), *b = point(f, j), *c = point(f, k);
        const auto side = [&](const double* p, const double* q) {
            return (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
        };
        const double u = side(b, c), v = side(c, a), w = side(a, b);
        const bool up = u > 0 && v > 0 && w > 0, down = u < 0 && v < 0 && w < 0;
        if (!up && !down) return;
        const double z = (u * a[2] + v * b[2] + w * c[2]) / (u + v + w);
        const std::uint16_t inside = mesh_.facets.inside[f], outside = mesh_.facets.outside[f];
        crossings.push_back(up ? Crossing{z, inside, outside} : Crossing{z, outside, inside});
    }

    const Mesh& mesh_;
    int lines_;
    double scale_;
    std::vector<std::vector<std::size_t>> cells_;
};

/// Whether the model names one region only within `reach` of p: on rays, then, where those tell nothing else,
/// at random points, or films and slits of a hundredth of a cell pass between the rays.
bool is_uniform(const Model& model, const Vec3& p, double reach) {
    constexpr int kSteps = 24, kPoints = 200000;
    const std::size_t region = region_at(model, p);
    const auto is_other = [&](double x, double y, double z) {
        return region_at(model, {p[0] + x, p[1] + y, p[2] + z}) != region;
    };
    for (int dz = -1; dz <= 1; ++dz) {
        for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) {
                if (dx == 0 && dy == 0 && dz == 0) continue;
                const double step = reach / (kSteps * std::sqrt(dx * dx + dy * dy + dz * dz));
                for (int s = 1; s <= kSteps; ++s) {
                    const double t = s * step;
                    if (is_other(t * dx, t * dy, t * dz)) return false;
                }
            }
        }
    }
    RandomSource random(11);
    for (int i = 0; i < kPoints; ++i) {
        const double x = random.uniform(-reach, reach), y = random.uniform(-reach, reach),
                     z = random.uniform(-reach, reach);
        if (x * x + y * y + z * z <= reach * reach && is_other(x, y, z)) return false;
    }
    return true;
}

}  // namespace

ScanResult scan_membership(const Model& model, const Mesh& mesh, const Box3& box, double cell, int lines) {
    ScanResult result;
    result.model_volume.assign(model.regions.size(), 0);
    const FacetGrid grid(mesh, box, lines);
    RandomSource random(7);
    Vec3 step{};
    for (std::size_t j = 0; j < 3; ++j) step[j] = (box.max[j] - box.min[j]) / lines;
    result.sample_volume = step[0] * step[1] * step[2];
    std::vector<Crossing> crossings;
    // By region: samples in the column, and in the one before it.
    std::vector<double> here(model.regions.size()), before(model.regions.size());
    result.volume_spread.assign(model.regions.size(), 0);
    for (int j = 0; j < lines; ++j) {
        for (int i = 0; i < lines; ++i) {
            const double x = box.min[0] + step[0] * (i + random.uniform(0, 1));
            const double y = box.min[1] + step[1] * (j + random.uniform(0, 1));
            grid.cross(i, j, x, y, crossings);
            std::size_t next = 0, in_mesh = 0;
            std::fill(here.begin(), here.end(), 0);
            for (int k = 0; k < lines; ++k) {
                const Vec3 p = {x, y, box.min[2] + step[2] * (k + random.uniform(0, 1))};
                while (next < crossings.size() && crossings[next].height < p[2]) {
                    in_mesh = crossings[next++].above;
                }
                const std::size_t in_model = region_at(model, p);
                ++result.samples;
                if (in_model > 0) ++here[in_model - 1];
                if (in_model == in_mesh) continue;
                ++result.wrong;
                if (!is_uniform(model, p, 0.5 * cell)) continue;
                ++result.wrong_far;
                if (!result.first_far.empty()) continue;
                std::ostringstream text;
                text.precision(10);
                text << "(" << p[0] << ", " << p[1] << ", " << p[2] << "): region " << in_model
                     << " in the model, " << in_mesh << " in the mesh";
                result.first_far = text.str();
            }
            for (std::size_t r = 0; r < here.size(); ++r) {
                result.model_volume[r] += here[r] * result.sample_volume;
                // Cochran, Sampling Techniques (1977), §5A.12: of pairs of strata with one sample each.
                if (i % 2 == 1) result.volume_spread[r] += (here[r] - before[r]) * (here[r] - before[r]);
            }
            std::swap(here, before);
        }
    }
    for (double& spread : result.volume_spread) spread = std::sqrt(spread) * result.sample_volume;
    result.wrong_volume = static_cast<double>(result.wrong) * result.sample_volume;
    return result;
}

}  // namespace mortise::test
