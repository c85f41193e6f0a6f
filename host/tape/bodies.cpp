#include "host/tape/bodies.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "host/common/disjoint_sets.hpp"
#include "host/common/vec3.hpp"
#include "host/tape/polyhedron.hpp"

namespace mortise::tape {
namespace {

constexpr std::size_t kMostBodies = 4096;  ///< with more, comparing all boxes takes too long

struct Body {
    std::vector<std::uint32_t> triangles;
    Box3 box;
};

/// Triangles that are joined by points, in order of their first ones.
std::vector<Body> find_bodies(const TriangleSurface& shape) {
    DisjointSets sets(shape.points.size());
    for (const auto& t : shape.triangles) {
        sets.join(t[0], t[1]);
        sets.join(t[0], t[2]);
    }
    constexpr std::uint32_t kNone = 0xffffffffu;
    std::vector<std::uint32_t> body_of(shape.points.size(), kNone);
    std::vector<Body> bodies;
    for (std::uint32_t t = 0; t < shape.triangles.size(); ++t) {
        std::uint32_t& body = body_of[sets.find(shape.triangles[t][0])];
        if (body == kNone) {
            body = static_cast<std::uint32_t>(bodies.size());
            const Vec3& p = shape.points[shape.triangles[t][0]];
            bodies.push_back({{}, {p, p}});
        }
        bodies[body].triangles.push_back(t);
        for (const std::uint32_t corner : shape.triangles[t]) {
            for (std::size_t j = 0; j < 3; ++j) {
                double &low = bodies[body].box.min[j], &high = bodies[body].box.max[j];
                low = std::min(low, shape.points[corner][j]);
                high = std::max(high, shape.points[corner][j]);
            }
        }
    }
    return bodies;
}

/// Whether every edge has two triangles, one in each direction.
bool is_closed(const TriangleSurface& shape) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> forward, backward;
    for (const auto& t : shape.triangles) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            (a < b ? forward : backward).push_back(std::minmax(a, b));
        }
    }
    std::sort(forward.begin(), forward.end());
    std::sort(backward.begin(), backward.end());
    return forward == backward && std::adjacent_find(forward.begin(), forward.end()) == forward.end();
}

bool is_outward(const TriangleSurface& shape, const Body& body) {
    const Vec3& origin = shape.points[shape.triangles[body.triangles[0]][0]];
    double volume = 0;
    for (const std::uint32_t t : body.triangles) {
        const auto& corner = shape.triangles[t];
        volume += dot(
            difference(shape.points[corner[0]], origin),
            cross(difference(shape.points[corner[1]], origin), difference(shape.points[corner[2]], origin)));
    }
    return volume > 0;
}

bool touch(const Box3& a, const Box3& b) {
    for (std::size_t j = 0; j < 3; ++j) {
        if (a.min[j] > b.max[j] || b.min[j] > a.max[j]) return false;
    }
    return true;
}

/// Deals bodies out to layers, each to the first in which its box touches no other.
std::vector<std::vector<const Body*>> deal_out(const std::vector<Body>& bodies) {
    std::vector<std::vector<const Body*>> layers;
    for (const Body& body : bodies) {
        const auto free = std::find_if(layers.begin(), layers.end(), [&](const auto& layer) {
            return std::none_of(layer.begin(), layer.end(),
                                [&](const Body* other) { return touch(other->box, body.box); });
        });
        if (free == layers.end())
            layers.push_back({&body});
        else
            free->push_back(&body);
    }
    return layers;
}

WorldPolyhedron take(const WorldPolyhedron& whole, const std::vector<const Body*>& layer) {
    constexpr std::uint32_t kNone = 0xffffffffu;
    WorldPolyhedron part;
    std::vector<std::uint32_t> place(whole.shape.points.size(), kNone);
    for (const Body* body : layer) {
        for (const std::uint32_t t : body->triangles) {
            std::array<std::uint32_t, 3> corners = whole.shape.triangles[t];
            for (std::uint32_t& corner : corners) {
                if (place[corner] == kNone) {
                    place[corner] = static_cast<std::uint32_t>(part.shape.points.size());
                    part.shape.points.push_back(whole.shape.points[corner]);
                }
                corner = place[corner];
            }
            part.shape.triangles.push_back(corners);
            part.surface.push_back(whole.surface[t]);
        }
    }
    return part;
}

}  // namespace

std::vector<WorldPolyhedron> split_bodies(WorldPolyhedron polyhedron) {
    const auto whole = [&] {
        std::vector<WorldPolyhedron> one;
        one.push_back(std::move(polyhedron));
        return one;
    };
    const TriangleSurface& shape = polyhedron.shape;
    const std::vector<Body> bodies = find_bodies(shape);
    if (bodies.size() < 2 || bodies.size() > kMostBodies) return whole();
    const auto layers = deal_out(bodies);
    if (layers.size() < 2 || !is_closed(shape) ||
        !std::all_of(bodies.begin(), bodies.end(), [&](const Body& body) { return is_outward(shape, body); }))
        return whole();
    std::vector<WorldPolyhedron> parts;
    for (const auto& layer : layers) parts.push_back(take(polyhedron, layer));
    return parts;
}

}  // namespace mortise::tape
