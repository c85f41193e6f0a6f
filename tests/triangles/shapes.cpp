#include "tests/triangles/shapes.hpp"

#include <cmath>
#include <map>

#include "tests/mesher/random_source.hpp"
#include "tests/mesher/solids.hpp"

namespace mortise::test {

TriangleSurface prism(const std::vector<std::array<double, 2>>& outline, double height, bool named) {
    TriangleSurface result;
    const auto n = static_cast<std::uint32_t>(outline.size());
    for (const double z : {0.0, height}) {
        for (const auto& p : outline) result.points.push_back({p[0], p[1], z});
    }
    for (std::uint32_t i = 1; i + 1 < n; ++i) {
        result.triangles.push_back({0, i + 1, i});
        result.triangles.push_back({n, n + i, n + i + 1});
    }
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t j = (i + 1) % n;
        result.triangles.push_back({i, j, n + j});
        result.triangles.push_back({i, n + j, n + i});
    }
    if (named) {
        result.group_names = {"bottom", "top", "side"};
        for (std::uint32_t i = 1; i + 1 < n; ++i) result.group.insert(result.group.end(), {0, 1});
        result.group.resize(result.triangles.size(), 2);
    }
    return result;
}

TriangleSurface l_block() { return prism({{1, 1}, {1, 3}, {0, 3}, {0, 0}, {3, 0}, {3, 1}}, 1); }

TriangleSurface unit_sphere(int depth) {
    TriangleSurface s;
    s.points = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    s.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int step = 0; step < depth; ++step) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [entry, is_new] = middles.try_emplace({std::min(a, b), std::max(a, b)},
                                                             static_cast<std::uint32_t>(s.points.size()));
            if (is_new) {
                Vec3 m;
                for (std::size_t j = 0; j < 3; ++j) m[j] = s.points[a][j] + s.points[b][j];
                const double length = std::sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
                for (double& x : m) x /= length;
                s.points.push_back(m);
            }
            return entry->second;
        };
        std::vector<std::array<std::uint32_t, 3>> finer;
        for (const auto& t : s.triangles) {
            const std::uint32_t a = middle(t[0], t[1]);
            const std::uint32_t b = middle(t[1], t[2]);
            const std::uint32_t c = middle(t[2], t[0]);
            finer.insert(finer.end(), {{t[0], a, c}, {a, t[1], b}, {c, b, t[2]}, {a, b, c}});
        }
        s.triangles = std::move(finer);
    }
    return s;
}

TriangleSurface random_star(std::uint64_t seed, int depth, double low, double high) {
    RandomSource random(seed);
    TriangleSurface s = unit_sphere(depth);
    for (Vec3& p : s.points) {
        const double radius = random.uniform(low, high);
        for (double& x : p) x *= radius;
    }
    return s;
}

Model solid_of(TriangleSurface surface, double sharp_angle, const Affine& map) {
    Model model;
    model.source = "test model";
    std::uint32_t root = model.add_primitive(polyhedron(std::move(surface), sharp_angle), "part");
    if (map != kIdentity) root = model.add_transform(map, root);
    add_region(model, root, "solid");
    return model;
}

}  // namespace mortise::test
