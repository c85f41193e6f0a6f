// See facet_tree.hpp.
#include "host/report/facet_tree.hpp"

#include <algorithm>
#include <cmath>

#include "kernels/shared/lattice.h"

namespace mortise::report {
namespace {

constexpr std::size_t kPerLeaf = 2;
/// Boxes farther than the best distance by less than this are looked into all the same: rounding.
constexpr double kSlack = 1 + 1e-9;

double squared_segment_distance(const Vector& p, const Vector& a, const Vector& b) {
    const Vector along = b - a;
    const double square = dot(along, along);
    const double t = square > 0 ? std::clamp(dot(p - a, along) / square, 0.0, 1.0) : 0;
    const Vector d = p - (a + t * along);
    return dot(d, d);
}

Vector least(const Vector& a, const Vector& b) {
    return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
Vector greatest(const Vector& a, const Vector& b) {
    return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}

}  // namespace

double triangle_distance(const Vector& p, const Vector& a, const Vector& b, const Vector& c) {
    const Vector normal = cross(b - a, c - a);
    const double square = dot(normal, normal);
    // Over the triangle: on the inner side of its three edges.
    if (square > 0 && dot(cross(b - a, p - a), normal) >= 0 && dot(cross(c - b, p - b), normal) >= 0 &&
        dot(cross(a - c, p - c), normal) >= 0) {
        return std::fabs(dot(p - a, normal)) / std::sqrt(square);
    }
    return std::sqrt(std::min({squared_segment_distance(p, a, b), squared_segment_distance(p, b, c),
                               squared_segment_distance(p, c, a)}));
}

FacetTree::FacetTree(const Mesh& mesh, const tape::BoundModel& model) {
    for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
        const NodeId* n = mesh.facets.nodes.data() + 4 * f;
        Vector p[4];
        for (int k = 0; k < 4; ++k) p[k] = features::to_local(model, features::point_of(mesh, n[k]));
        if (corner_count(n) == 3) {
            triangles_.push_back({p[0], p[1], p[2]});
            continue;
        }
        const Vector mean = 0.25 * (p[0] + p[1] + p[2] + p[3]);
        for (int k = 0; k < 4; ++k) triangles_.push_back({p[k], p[(k + 1) % 4], mean});
    }
    if (triangles_.empty()) return;
    sort_along_curve();
    add_boxes();
}

void FacetTree::sort_along_curve() {
    const double cells = 1u << kMaxTreeLevel;
    const auto cell = [&](double x) {
        return static_cast<std::uint32_t>(std::clamp(x * cells, 0.0, cells - 1));
    };
    std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
    for (const Triangle& t : triangles_) {
        const Vector centre = (1.0 / 3) * (t.a + t.b + t.c);
        order.push_back({morton_encode(cell(centre.x), cell(centre.y), cell(centre.z)),
                         static_cast<std::uint32_t>(order.size())});
    }
    std::sort(order.begin(), order.end());
    std::vector<Triangle> sorted;
    sorted.reserve(order.size());
    for (const auto& entry : order) sorted.push_back(triangles_[entry.second]);
    triangles_ = std::move(sorted);
}

void FacetTree::add_boxes() {
    leaves_ = 1;
    while (leaves_ * kPerLeaf < triangles_.size()) leaves_ *= 2;
    boxes_.assign(2 * leaves_ - 1, {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}});
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
        const Box own = box_of(triangles_[i]);
        Box& box = boxes_[leaves_ - 1 + i / kPerLeaf];
        box.low = least(box.low, own.low);
        box.high = greatest(box.high, own.high);
    }
    for (std::size_t i = leaves_ - 1; i-- > 0;) {
        boxes_[i].low = least(boxes_[2 * i + 1].low, boxes_[2 * i + 2].low);
        boxes_[i].high = greatest(boxes_[2 * i + 1].high, boxes_[2 * i + 2].high);
    }
}

FacetTree::Box FacetTree::box_of(const Triangle& t) {
    return {least(t.a, least(t.b, t.c)), greatest(t.a, greatest(t.b, t.c))};
}

inline double FacetTree::squared_distance(const Box& box, const Vector& p) {
    const Vector d = greatest(greatest(box.low - p, p - box.high), {});
    return dot(d, d);
}

double FacetTree::distance(const Vector& local) const {
    double best = HUGE_VAL;
    if (triangles_.empty()) return best;
    struct Entry {
        std::size_t box;
        double squared;
    };
    Entry open[64];  // one per row of the tree, and one more
    std::size_t count = 0;
    open[count++] = {0, squared_distance(boxes_[0], local)};
    while (count > 0) {
        const Entry entry = open[--count];
        if (!(entry.squared <= best * best * kSlack)) continue;
        if (entry.box >= leaves_ - 1) {
            const std::size_t begin = (entry.box - (leaves_ - 1)) * kPerLeaf;
            const std::size_t end = std::min(begin + kPerLeaf, triangles_.size());
            for (std::size_t i = begin; i < end; ++i) {
                const Triangle& t = triangles_[i];
                if (!(squared_distance(box_of(t), local) <= best * best * kSlack)) continue;
                best = std::min(best, triangle_distance(local, t.a, t.b, t.c));
            }
            continue;
        }
        Entry near = {2 * entry.box + 1, squared_distance(boxes_[2 * entry.box + 1], local)};
        Entry far = {2 * entry.box + 2, squared_distance(boxes_[2 * entry.box + 2], local)};
        if (far.squared < near.squared) std::swap(near, far);
        open[count++] = far;
        open[count++] = near;
    }
    return best;
}

}  // namespace mortise::report
