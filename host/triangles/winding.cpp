#include "host/triangles/winding.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/common/constants.hpp"

namespace mortise::triangles {
namespace {

constexpr std::uint32_t kLeafSize = 4;
constexpr double kFar = 2.5;  ///< radii from which a group counts as a dipole

/// Adds up solid angles of triangles (Van Oosterom & Strackee 1983), positive from behind. Half a solid angle
/// is that of a complex number, and the sum of small ones that of their product: most need no arc tangent of
/// their own.
class SolidAngles {
  public:
    void add(const std::array<glm::dvec3, 3>& triangle, const glm::dvec3& point) {
        const glm::dvec3 a = triangle[0] - point;
        const glm::dvec3 b = triangle[1] - point;
        const glm::dvec3 c = triangle[2] - point;
        const double la = glm::length(a);
        const double lb = glm::length(b);
        const double lc = glm::length(c);
        const double imaginary = glm::dot(a, glm::cross(b, c));
        const double real = la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb;
        if (!(std::fabs(imaginary) < kSmall * real)) {
            sum_ += std::atan2(imaginary, real);
            return;
        }
        const double product = real_ * real - imaginary_ * imaginary;
        imaginary_ = real_ * imaginary + imaginary_ * real;
        real_ = product;
        if (++count_ == kMostInProduct) close_product();
    }

    double total() {
        close_product();
        return 2 * sum_;
    }

  private:
    static constexpr double kSmall = 0.4;  ///< tangent of less than an eighth of half a turn
    static constexpr int kMostInProduct = 4;

    void close_product() {
        if (count_ > 0) sum_ += std::atan2(imaginary_, real_);
        real_ = 1;
        imaginary_ = 0;
        count_ = 0;
    }

    double sum_ = 0;  ///< of half the angles
    double real_ = 1, imaginary_ = 0;
    int count_ = 0;
};

bool has_closed_edges(const TriangleSurface& surface) {
    using Edge = std::pair<std::uint32_t, std::uint32_t>;
    std::vector<Edge> forward, back;
    for (const auto& t : surface.triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            (a < b ? forward : back).push_back({std::min(a, b), std::max(a, b)});
        }
    }
    if (forward.size() != back.size()) return false;
    std::sort(forward.begin(), forward.end());
    std::sort(back.begin(), back.end());
    return forward == back;
}

}  // namespace

WindingNumber::WindingNumber(const TriangleSurface& surface) : is_closed_(has_closed_edges(surface)) {
    for (const auto& t : surface.triangles) {
        Triangle triangle;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3& p = surface.points[t[k]];
            triangle[k] = {p[0], p[1], p[2]};
        }
        triangles_.push_back(triangle);
    }
    if (triangles_.empty()) return;
    constexpr std::uint32_t kNone = 0xffffffffU;
    struct Range {
        std::uint32_t first;
        std::uint32_t count;
        std::uint32_t parent;  ///< whose second child this is, or kNone
    };
    const auto middle = [](const Triangle& t) { return t[0] + t[1] + t[2]; };
    std::vector<Range> open = {{0, static_cast<std::uint32_t>(triangles_.size()), kNone}};
    while (!open.empty()) {
        const Range range = open.back();
        open.pop_back();
        const auto index = static_cast<std::uint32_t>(nodes_.size());
        if (range.parent != kNone) nodes_[range.parent].right = index;
        Node node;
        node.first = range.first;
        node.count = range.count;
        const auto begin = triangles_.begin() + range.first;
        const auto end = begin + range.count;
        double total = 0;
        glm::dvec3 low = middle(*begin);
        glm::dvec3 high = low;
        for (auto t = begin; t != end; ++t) {
            const glm::dvec3 area = 0.5 * glm::cross((*t)[1] - (*t)[0], (*t)[2] - (*t)[0]);
            const double size = glm::length(area);
            node.area += area;
            node.centre += size / 3 * middle(*t);
            total += size;
            low = glm::min(low, middle(*t));
            high = glm::max(high, middle(*t));
        }
        node.centre = total > 0 ? node.centre / total : middle(*begin) / 3.0;
        for (auto t = begin; t != end; ++t) {
            for (const glm::dvec3& corner : *t) {
                node.radius = std::max(node.radius, glm::length(corner - node.centre));
            }
        }
        nodes_.push_back(node);
        if (range.count <= kLeafSize) continue;
        const glm::dvec3 extent = high - low;
        const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
        const std::uint32_t half = range.count / 2;
        std::nth_element(begin, begin + half, end, [&](const Triangle& p, const Triangle& q) {
            return middle(p)[axis] < middle(q)[axis];
        });
        open.push_back({range.first + half, range.count - half, index});
        open.push_back({range.first, half, kNone});
    }
}

double WindingNumber::at(const glm::dvec3& point) const {
    if (nodes_.empty()) return 0;
    double far = 0;
    SolidAngles near;
    std::uint32_t stack[64];  // halves at every step: deep enough for 2^32 triangles
    int top = 0;
    stack[0] = 0;
    while (top >= 0) {
        const std::uint32_t index = stack[top--];
        const Node& node = nodes_[index];
        const glm::dvec3 away = node.centre - point;
        const double squared = glm::dot(away, away);
        if (squared > kFar * kFar * node.radius * node.radius) {
            far += glm::dot(away, node.area) / (squared * std::sqrt(squared));
        } else if (node.right == 0) {
            for (std::uint32_t t = node.first; t < node.first + node.count; ++t) {
                near.add(triangles_[t], point);
            }
        } else {
            stack[++top] = node.right;
            stack[++top] = index + 1;
        }
    }
    return (far + near.total()) / (4 * kPi);
}

}  // namespace mortise::triangles
