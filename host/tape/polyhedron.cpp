#include "host/tape/polyhedron.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/common/constants.hpp"
#include "host/common/vec3.hpp"
#include "host/tape/arena.hpp"
#include "host/tape/facets.hpp"

namespace mortise::tape {
namespace {

constexpr std::uint32_t kLeafSize = 4;
/// Of a patch's size: above the rounding of distances, below all features.
constexpr double kNoLength = 1e-10;

Vec3 unit_normal(const TriangleSurface& shape, std::uint32_t triangle) {
    const auto& corner = shape.triangles[triangle];
    const Vec3 u = difference(shape.points[corner[1]], shape.points[corner[0]]);
    const Vec3 v = difference(shape.points[corner[2]], shape.points[corner[0]]);
    return unit(cross(u, v));  // not zero: find_facets left out what has no area
}

double angle_at(const TriangleSurface& shape, std::uint32_t triangle, std::size_t k) {
    const auto& corner = shape.triangles[triangle];
    const Vec3 u = difference(shape.points[corner[(k + 1) % 3]], shape.points[corner[k]]);
    const Vec3 v = difference(shape.points[corner[(k + 2) % 3]], shape.points[corner[k]]);
    const double cosine = dot(u, v) / (length(u) * length(v));
    return std::acos(std::clamp(cosine, -1.0, 1.0));
}

/// Writes one patch in the form of kernels/shared/patch.h.
class PatchWriter {
  public:
    PatchWriter(const TriangleSurface& shape, const Facets& facets)
        : shape_(shape), facets_(facets), rim_(shape.triangles.size(), 0) {}

    /// The patch of the given triangles; `patch` is its number.
    Surface write(std::vector<std::uint32_t> triangles, std::uint32_t patch,
                  std::vector<ExpressionOp>& arena) {
        nodes_.clear();
        order_ = std::move(triangles);
        build();
        mark_rims(patch);
        Surface surface{};
        surface.kind = kSurfacePatch;
        surface.map[0] = surface.map[5] = surface.map[10] = 1;
        surface.form[0] = static_cast<double>(nodes_.size());
        surface.form[1] = static_cast<double>(arena.size());  // no other patch starts there
        surface.form[2] =
            kNoLength * length({nodes_[3] - nodes_[0], nodes_[4] - nodes_[1], nodes_[5] - nodes_[2]});
        std::vector<double> data = std::move(nodes_);
        const auto corner_normals = normals_at_corners();
        for (const std::uint32_t t : order_) {
            for (const std::uint32_t corner : shape_.triangles[t]) {
                data.insert(data.end(), shape_.points[corner].begin(), shape_.points[corner].end());
            }
            data.push_back(rim_[t]);
            const Vec3 normal = unit_normal(shape_, t);
            data.insert(data.end(), normal.begin(), normal.end());
            for (const std::uint32_t corner : shape_.triangles[t]) {
                const Vec3& at_corner = corner_normals.at(shape_.points[corner]);
                data.insert(data.end(), at_corner.begin(), at_corner.end());
            }
        }
        append_numbers(data, arena, surface);
        return surface;
    }

  private:
    double middle(std::uint32_t t, std::size_t axis) const {
        const auto& corner = shape_.triangles[t];
        return shape_.points[corner[0]][axis] + shape_.points[corner[1]][axis] +
               shape_.points[corner[2]][axis];
    }

    void build() {
        constexpr std::uint32_t kNoParent = 0xffffffffU;
        struct Range {
            std::uint32_t first;
            std::uint32_t count;
            std::uint32_t parent;  ///< whose second child this is, or kNoParent
        };
        std::vector<Range> open = {{0, static_cast<std::uint32_t>(order_.size()), kNoParent}};
        while (!open.empty()) {
            const Range range = open.back();
            open.pop_back();
            const std::size_t index = nodes_.size() / kPatchNode;
            if (range.parent != kNoParent) nodes_[kPatchNode * range.parent + 6] = static_cast<double>(index);
            const auto begin = order_.begin() + range.first;
            const auto end = begin + range.count;
            Vec3 low = {kInfinity, kInfinity, kInfinity};
            Vec3 high = {-kInfinity, -kInfinity, -kInfinity};
            for (auto t = begin; t != end; ++t) {
                for (const std::uint32_t corner : shape_.triangles[*t]) {
                    for (std::size_t j = 0; j < 3; ++j) {
                        low[j] = std::min(low[j], shape_.points[corner][j]);
                        high[j] = std::max(high[j], shape_.points[corner][j]);
                    }
                }
            }
            nodes_.insert(nodes_.end(), low.begin(), low.end());
            nodes_.insert(nodes_.end(), high.begin(), high.end());
            const bool leaf = range.count <= kLeafSize;
            nodes_.push_back(leaf ? static_cast<double>(range.first) : 0.0);
            nodes_.push_back(leaf ? static_cast<double>(range.count) : -1.0);
            if (leaf) continue;
            std::size_t axis = 0;
            for (std::size_t j = 1; j < 3; ++j) {
                if (high[j] - low[j] > high[axis] - low[axis]) axis = j;
            }
            const std::uint32_t half = range.count / 2;
            std::nth_element(begin, begin + half, end, [&](std::uint32_t p, std::uint32_t q) {
                const double a = middle(p, axis);
                const double b = middle(q, axis);
                return a != b ? a < b : p < q;
            });
            open.push_back({range.first + half, range.count - half, static_cast<std::uint32_t>(index)});
            open.push_back({range.first, half, kNoParent});
        }
    }

    /// Normals at the corners of the patch's triangles by place, weighted by the angles there.
    std::map<Vec3, Vec3> normals_at_corners() const {
        std::map<Vec3, Vec3> result;
        for (const std::uint32_t t : order_) {
            const Vec3 normal = unit_normal(shape_, t);
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3& at = shape_.points[shape_.triangles[t][k]];
                const double angle = angle_at(shape_, t, k);
                Vec3& sum = result.try_emplace(at, Vec3{0, 0, 0}).first->second;
                for (std::size_t j = 0; j < 3; ++j) sum[j] += angle * normal[j];
            }
        }
        for (auto& [place, normal] : result) normal = unit(normal);
        return result;
    }

    /// Bits for the edges beyond which the patch ends, and for all corners at the end of such an edge.
    void mark_rims(std::uint32_t patch) {
        std::vector<Vec3> on_rim;  // places, since points may be doubled
        for (const std::uint32_t t : order_) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t next = facets_.across[t][k];
                const bool inner = next != Facets::kNone && facets_.of_triangle[next] != Facets::kNone &&
                                   facets_.patch_of_plane[facets_.of_triangle[next]] == patch;
                if (inner) continue;
                rim_[t] |= kPatchRimEdge << k;
                on_rim.push_back(shape_.points[shape_.triangles[t][k]]);
                on_rim.push_back(shape_.points[shape_.triangles[t][(k + 1) % 3]]);
            }
        }
        std::sort(on_rim.begin(), on_rim.end());
        for (const std::uint32_t t : order_) {
            for (std::size_t k = 0; k < 3; ++k) {
                if (std::binary_search(on_rim.begin(), on_rim.end(), shape_.points[shape_.triangles[t][k]])) {
                    rim_[t] |= kPatchRimVertex << k;
                }
            }
        }
    }

    const TriangleSurface& shape_;
    const Facets& facets_;
    std::vector<double> nodes_;
    std::vector<std::uint32_t> order_;  ///< triangles, as the leaves list them
    std::vector<int> rim_;              ///< per triangle of the shape
};

}  // namespace

PolyhedronParts make_polyhedron(TriangleSurface shape, double sharp_angle, std::vector<ExpressionOp>& arena) {
    PolyhedronParts parts;
    const Facets facets = find_facets(shape, sharp_angle);
    std::vector<std::vector<std::uint32_t>> triangles(facets.patches);
    for (std::uint32_t t = 0; t < shape.triangles.size(); ++t) {
        if (facets.of_triangle[t] == Facets::kNone) continue;
        triangles[facets.patch_of_plane[facets.of_triangle[t]]].push_back(t);
    }
    std::vector<std::uint32_t> planes(facets.patches, 0);
    for (const std::uint32_t patch : facets.patch_of_plane) ++planes[patch];
    constexpr std::size_t kMostNumbered = 24;
    PatchWriter writer(shape, facets);
    for (std::uint32_t patch = 0; patch < facets.patches; ++patch) {
        if (!shape.group.empty()) {
            const std::string& name = shape.group_names[shape.group[triangles[patch][0]]];
            parts.suffixes.push_back(name.empty() ? "" : "_" + name);
        } else {
            const bool numbered = facets.patches <= kMostNumbered;
            parts.suffixes.push_back(numbered ? "_face" + std::to_string(patch + 1) : "");
        }
        if (planes[patch] > 1) {
            parts.surfaces.push_back(writer.write(triangles[patch], patch, arena));
            continue;
        }
        Surface plane{};
        plane.kind = kSurfacePlane;
        const auto& coefficients = facets.planes[facets.of_triangle[triangles[patch][0]]];
        std::copy(coefficients.begin(), coefficients.end(), plane.map);
        parts.surfaces.push_back(plane);
    }
    std::size_t kept = 0;
    for (std::size_t t = 0; t < shape.triangles.size(); ++t) {
        if (facets.of_triangle[t] == Facets::kNone) continue;
        shape.triangles[kept++] = shape.triangles[t];
        parts.world.surface.push_back(facets.patch_of_plane[facets.of_triangle[t]]);
    }
    shape.triangles.resize(kept);
    parts.world.shape = std::move(shape);
    return parts;
}

TriangleSurface transformed(const TriangleSurface& shape, const Affine& map) {
    TriangleSurface result;
    for (const Vec3& p : shape.points) {
        Vec3 x;
        for (std::size_t i = 0; i < 3; ++i) {
            x[i] = map[4 * i] * p[0] + map[4 * i + 1] * p[1] + map[4 * i + 2] * p[2] + map[4 * i + 3];
        }
        result.points.push_back(x);
    }
    const double determinant = map[0] * (map[5] * map[10] - map[6] * map[9]) -
                               map[1] * (map[4] * map[10] - map[6] * map[8]) +
                               map[2] * (map[4] * map[9] - map[5] * map[8]);
    result.triangles = shape.triangles;
    result.group = shape.group;
    result.group_names = shape.group_names;
    if (determinant < 0) {
        for (auto& triangle : result.triangles) std::swap(triangle[1], triangle[2]);
    }
    return result;
}

Box3 bounds_of(const TriangleSurface& shape) {
    Box3 box{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
    for (const auto& triangle : shape.triangles) {
        for (const std::uint32_t corner : triangle) {
            for (std::size_t j = 0; j < 3; ++j) {
                box.min[j] = std::min(box.min[j], shape.points[corner][j]);
                box.max[j] = std::max(box.max[j], shape.points[corner][j]);
            }
        }
    }
    return box;
}

}  // namespace mortise::tape
