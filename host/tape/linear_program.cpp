#include "host/tape/linear_program.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/common/random.hpp"

namespace mortise::tape {
namespace {

constexpr double kSlack = 1e-9;
constexpr double kParallel = 1e-12;  ///< normals that are shorter have no direction

/// In the first N coordinates only.
template <std::size_t N>
double dot_in(const Vec3& a, const Vec3& b) {
    double sum = 0;
    for (std::size_t j = 0; j < N; ++j) sum += a[j] * b[j];
    return sum;
}

/// a + factor · b in N coordinates but `dropped`, those after it moved down by one.
template <std::size_t N>
Vec3 drop(const Vec3& a, double factor, const Vec3& b, std::size_t dropped) {
    Vec3 result{};
    for (std::size_t j = 0, k = 0; j < N; ++j) {
        if (j != dropped) result[k++] = a[j] + factor * b[j];
    }
    return result;
}

/// Appends what a half-space is on the plane, in its coordinates but `dropped`; false: nothing.
template <std::size_t N>
bool restrict_to(const HalfSpace& plane, std::size_t dropped, const Vec3& normal, double offset,
                 std::vector<HalfSpace>& on_plane) {
    const double factor = -normal[dropped] / plane.normal[dropped];
    HalfSpace cut{drop<N>(normal, factor, plane.normal, dropped), offset + factor * plane.offset};
    const double length = std::sqrt(dot_in<N - 1>(cut.normal, cut.normal));
    if (length < kParallel) return cut.offset >= -kSlack;
    for (std::size_t j = 0; j + 1 < N; ++j) cut.normal[j] /= length;
    cut.offset /= length;
    on_plane.push_back(cut);
    return true;
}

template <std::size_t N>
std::optional<Vec3> solve(const std::vector<HalfSpace>& half_spaces, const Vec3& direction) {
    if constexpr (N == 0) {
        return Vec3{};
    } else {
        Vec3 x{};
        for (std::size_t j = 0; j < N; ++j) x[j] = std::copysign(kFarthest, direction[j]);
        for (std::size_t i = 0; i < half_spaces.size(); ++i) {
            const HalfSpace& bound = half_spaces[i];
            if (dot_in<N>(bound.normal, x) <= bound.offset + kSlack) continue;
            // The best point is on its plane: one variable less.
            std::size_t dropped = 0;
            for (std::size_t j = 1; j < N; ++j) {
                if (std::fabs(bound.normal[j]) > std::fabs(bound.normal[dropped])) dropped = j;
            }
            std::vector<HalfSpace> on_plane;
            Vec3 axis{};
            axis[dropped] = 1;
            bool reached = restrict_to<N>(bound, dropped, axis, kFarthest, on_plane);
            axis[dropped] = -1;
            reached = reached && restrict_to<N>(bound, dropped, axis, kFarthest, on_plane);
            for (std::size_t k = 0; k < i && reached; ++k) {
                const HalfSpace& other = half_spaces[k];
                reached = restrict_to<N>(bound, dropped, other.normal, other.offset + kSlack, on_plane);
            }
            if (!reached) return std::nullopt;
            const double factor = -direction[dropped] / bound.normal[dropped];
            const std::optional<Vec3> best =
                solve<N - 1>(on_plane, drop<N>(direction, factor, bound.normal, dropped));
            if (!best) return std::nullopt;
            double rest = bound.offset;
            for (std::size_t j = 0, k = 0; j < N; ++j) {
                if (j == dropped) continue;
                x[j] = (*best)[k++];
                rest -= bound.normal[j] * x[j];
            }
            x[dropped] = rest / bound.normal[dropped];
        }
        return x;
    }
}

}  // namespace

std::optional<Vec3> farthest(const std::vector<HalfSpace>& half_spaces, const Vec3& direction) {
    std::vector<HalfSpace> shuffled = half_spaces;
    Random random(1);
    for (std::size_t i = shuffled.size(); i > 1; --i)
        std::swap(shuffled[i - 1], shuffled[static_cast<std::size_t>(random.uniform() * i)]);
    return solve<3>(shuffled, direction);
}

}  // namespace mortise::tape
