#include "host/probe/skin.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/common/sort_unique.hpp"

namespace mortise::probe {
namespace {

constexpr double kBoxesPerReach = 4;  ///< most facets are in two or three boxes then

}  // namespace

Rays::Rays(const Skin& skin, const std::vector<Vec3>& starts, double reach)
    : skin_(skin), box_(reach / kBoxesPerReach) {
    std::vector<Key> near;
    for (const Vec3& start : starts) near.push_back(key_of(start, reach));
    sort_unique(near);
    for (std::size_t i = near.size(); i-- > 0;) {
        const Key own = near[i];
        for (int k = 0; k < 27; ++k)
            near.push_back({own[0] + k % 3 - 1, own[1] + k / 3 % 3 - 1, own[2] + k / 9 - 1});
    }
    sort_unique(near);
    for (std::uint32_t f = 0; f < skin.size(); ++f) {
        if (std::binary_search(near.begin(), near.end(), key_of(skin.middle(f), reach))) list(f);
    }
    std::sort(listed_.begin(), listed_.end());
}

double Rays::first_hit(const Vec3& x, const Vec3& direction, double reach, std::uint32_t own) const {
    // From box to box (Amanatides & Woo 1987).
    Key key = key_of(x, box_);
    Key step{};
    std::array<double, 3> next{};
    std::array<double, 3> stride{};
    for (std::size_t j = 0; j < 3; ++j) {
        const bool up = direction[j] > 0;
        step[j] = up ? 1 : -1;
        if (direction[j] == 0) {
            next[j] = stride[j] = std::numeric_limits<double>::max();
            continue;
        }
        stride[j] = box_ / std::fabs(direction[j]);
        next[j] = ((key[j] + (up ? 1 : 0)) * box_ - x[j]) / direction[j];
    }
    double first = reach;
    for (double entered = 0; entered < first;) {
        auto at = std::lower_bound(listed_.begin(), listed_.end(), std::make_pair(key, 0u));
        for (; at != listed_.end() && at->first == key; ++at) {
            if (at->second == own) continue;
            for (std::size_t part = 0; part < skin_.triangles(at->second); ++part)
                first = std::min(first, hit(skin_.triangle(at->second, part), x, direction, first));
        }
        const std::size_t axis = next[0] <= next[1]   ? (next[0] <= next[2] ? 0 : 2)
                                 : next[1] <= next[2] ? 1
                                                      : 2;
        entered = next[axis];
        next[axis] += stride[axis];
        key[axis] += step[axis];
    }
    return first;
}

Rays::Key Rays::key_of(const Vec3& x, double box) {
    Key key{};
    for (std::size_t j = 0; j < 3; ++j) key[j] = static_cast<std::int32_t>(std::floor(x[j] / box));
    return key;
}

/// In all boxes that the facet's bounds touch.
void Rays::list(std::uint32_t facet) {
    Vec3 low = skin_.triangle(facet, 0)[0];
    Vec3 high = low;
    for (std::size_t part = 0; part < skin_.triangles(facet); ++part) {
        for (const Vec3& corner : skin_.triangle(facet, part)) {
            for (std::size_t j = 0; j < 3; ++j) {
                low[j] = std::min(low[j], corner[j]);
                high[j] = std::max(high[j], corner[j]);
            }
        }
    }
    const Key first = key_of(low, box_);
    const Key last = key_of(high, box_);
    for (std::int32_t i = first[0]; i <= last[0]; ++i) {
        for (std::int32_t j = first[1]; j <= last[1]; ++j) {
            for (std::int32_t k = first[2]; k <= last[2]; ++k) listed_.push_back({{i, j, k}, facet});
        }
    }
}

/// Distance along the ray to a triangle (Möller & Trumbore 1997), or `most` if it is missed.
double Rays::hit(const Triangle& t, const Vec3& x, const Vec3& direction, double most) {
    const Vec3 a = difference(t[1], t[0]);
    const Vec3 b = difference(t[2], t[0]);
    const Vec3 p = cross(direction, b);
    const double determinant = dot(a, p);
    if (determinant == 0) return most;
    const Vec3 from = difference(x, t[0]);
    const double u = dot(from, p) / determinant;
    const Vec3 q = cross(from, a);
    const double v = dot(direction, q) / determinant;
    const double at = dot(b, q) / determinant;
    return u >= 0 && v >= 0 && u + v <= 1 && at > 0 && at < most ? at : most;
}

}  // namespace mortise::probe
