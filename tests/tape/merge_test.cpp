// Surfaces that are taken for others close to them: nothing appears or goes between them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/tape/reference.hpp"
#include "tests/mesher/random_source.hpp"
#include "tests/mesher/solids.hpp"

using namespace mortise;
using namespace mortise::test;

namespace {

constexpr double kDistance = 1e-3;  // of the root cube

tape::BoundModel bind_alike(const Model& model, double distance) {
    return tape::bind(tape::compile(model), {-1, -1, -1}, 2, {0, distance});
}

std::uint64_t count_alike(const Model& model) { return bind_alike(model, kDistance).alike; }

/// Boxes with faces at few places along each axis, and a little beside these.
Model crowded_boxes(RandomSource& random) {
    Model model;
    const auto box = [&] {
        Vec3 low{}, high{};
        for (std::size_t j = 0; j < 3; ++j) {
            const auto at = [&](int place) {
                const int beside = random.integer(-3, 3);
                return -0.6 + 0.3 * place + beside * random.uniform(0.1, 0.6) * kDistance;
            };
            const int first = random.integer(0, 3);
            low[j] = at(first);
            high[j] = at(random.integer(first + 1, 4));
        }
        return add_box(model, low, high);
    };
    const int regions = random.integer(1, 2);
    for (int r = 0; r < regions; ++r) {
        NodeIndex root = box();
        for (int i = random.integer(1, 4); i > 0; --i) {
            const int kind = random.integer(0, 3);
            root = kind == 0   ? subtract(model, {root, box()})
                   : kind == 1 ? intersect(model, {root, unite(model, {box(), box()})})
                               : unite(model, {root, box()});
        }
        add_region(model, root, r == 0 ? "first" : "second");
    }
    return model;
}

/// The regions along a line parallel to an axis, each once where it goes on.
std::vector<std::int32_t> along(const tape::BoundModel& model, std::size_t axis, Vec3 x) {
    std::vector<double> ends = {0, 1};
    for (const Surface& s : model.surfaces) {
        if (s.map[axis] != 0) ends.push_back(-s.map[3] / s.map[axis]);
    }
    std::sort(ends.begin(), ends.end());
    std::vector<std::int32_t> found;
    for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
        if (ends[i + 1] - ends[i] < 1e-9) continue;
        x[axis] = 0.5 * (ends[i] + ends[i + 1]);
        const std::int32_t region = tape::region_at(model, x[0], x[1], x[2]);
        if (found.empty() || found.back() != region) found.push_back(region);
    }
    return found;
}

bool is_near_a_plane(const tape::BoundModel& model, std::size_t axis, const Vec3& x) {
    return std::any_of(model.surfaces.begin(), model.surfaces.end(), [&](const Surface& s) {
        return s.map[axis] == 0 &&
               std::fabs(s.map[0] * x[0] + s.map[1] * x[1] + s.map[2] * x[2] + s.map[3]) < 4 * kDistance;
    });
}

}  // namespace

TEST_CASE("faces that are taken for others beside them: the same regions along any line, no film less") {
    std::uint64_t merged = 0, lines = 0;
    for (std::uint64_t seed = 0; seed < 600; ++seed) {
        CAPTURE(seed);
        RandomSource random(seed);
        const Model model = crowded_boxes(random);
        tape::BoundModel apart;
        try {
            apart = bind_alike(model, 0);
        } catch (const Error&) {
            continue;  // nothing is left of it
        }
        const tape::BoundModel alike = bind_alike(model, kDistance);
        CHECK(alike.surfaces.size() + alike.alike == apart.surfaces.size());
        merged += alike.alike;
        for (int i = 0; i < 60; ++i) {
            const auto axis = static_cast<std::size_t>(i % 3);
            const Vec3 x = {random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1)};
            if (is_near_a_plane(apart, axis, x)) continue;
            ++lines;
            CHECK(along(alike, axis, x) == along(apart, axis, x));
        }
    }
    CHECK(merged > 500);
    CHECK(lines > 10000);
}

TEST_CASE("surfaces are taken for others beside them only where nothing can lie between") {
    const double by = 0.5 * 2 * kDistance;  // half of the distance, in model units
    const auto solid = [](const auto& build) {
        Model model;
        add_region(model, build(model), "part");
        return model;
    };
    const auto plate = [](Model& m, double top) { return add_box(m, {-0.7, -0.7, -0.4}, {0.7, 0.7, top}); };
    const auto wall = [](Model& m, double top) { return add_box(m, {0.2, -0.5, -0.3}, {0.5, 0.5, top}); };
    // A step, of planes or of rods, is none; a higher one is.
    CHECK(count_alike(solid([&](Model& m) { return unite(m, {plate(m, 0), wall(m, by)}); })) == 1);
    CHECK(count_alike(solid([&](Model& m) { return unite(m, {plate(m, 0), wall(m, 3 * by)}); })) == 0);
    CHECK(count_alike(solid([&](Model& m) {
              return unite(m, {add_cylinder(m, 0.5, -0.6, 0.1), add_cylinder(m, 0.5 + by, -0.2, 0.6)});
          })) == 1);
    CHECK(count_alike(solid([&](Model& m) {
              return subtract(
                  m, {plate(m, 0), add_cylinder(m, 0.3, -0.6, -0.2), add_cylinder(m, 0.3 + by, -0.3, 1)});
          })) == 1);
    // A gap, a film that a pocket leaves, one that it nearly leaves, and a coating.
    CHECK(count_alike(solid([&](Model& m) {
              return unite(m, {plate(m, 0), add_box(m, {-0.5, -0.5, by}, {0.5, 0.5, 0.4})});
          })) == 0);
    for (const double bottom : {-0.4 + by, -0.4 - by})
        CHECK(count_alike(solid([&](Model& m) {
                  return subtract(m, {plate(m, 0), add_box(m, {-0.5, -0.5, bottom}, {0.5, 0.5, 0.4})});
              })) == 0);
    Model coated;
    add_region(coated, plate(coated, 0), "core");
    add_region(coated, plate(coated, by), "coating");
    CHECK(count_alike(coated) == 0);
    // A step with a film in front of it.
    CHECK(
        count_alike(solid([&](Model& m) {
            return unite(m, {plate(m, 0), wall(m, by), add_box(m, {-0.5, -0.5, 1.5 * by}, {0.5, 0.5, 0.4})});
        })) == 0);
}
