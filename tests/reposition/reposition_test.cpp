// Repositioning: elements away from complex cells become good, nothing else changes, nodes stay on their
// surfaces, and kernels and host threads move the same nodes to the same places. Shapes are judged by
// host/quality, whose code repositioning does not use.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "host/quality/shape.hpp"
#include "host/quality/vector.hpp"
#include "host/reposition/reposition.hpp"
#include "mortise/check.hpp"
#include "tests/improve/raw_mesh.hpp"
#include "tests/mesher/meshed.hpp"
#include "tests/mesher/random_models.hpp"
#include "tests/mesher/random_source.hpp"
#include "tests/tape/bound_models.hpp"

namespace mortise::test {
namespace {

/// A ball of 3 to 20 cells' radius, anywhere on the grid, half of them flattened.
Model random_ball(std::uint64_t seed) {
    RandomSource random(seed);
    const double x = random.uniform(-0.1, 0.1), y = random.uniform(-0.1, 0.1), z = random.uniform(0.7, 1);
    return one_solid([&](Model& model) {
        return model.add_transform({1, 0, 0, x, 0, 1, 0, y, 0, 0, z, 0}, model.add_primitive(sphere(1)));
    });
}

Model gyroid() {
    return formula_model("max(sin(x)*cos(y)+sin(y)*cos(z)+sin(z)*cos(x)-0.3,x^2+y^2+z^2-20)", 5);
}

struct Case {
    std::string name;
    RawMesh raw;
};

std::vector<Case> cases() {
    std::vector<Case> list;
    for (std::uint64_t seed = 1; seed <= 4; ++seed)
        list.push_back({"ball " + std::to_string(seed), raw_mesh(random_ball(seed), 5)});
    list.push_back({"gyroid in a ball", raw_mesh(gyroid(), 5)});
    list.push_back({"crossing cylinders", raw_mesh(crossing_cylinders(), 5)});
    return list;
}

device::Device& shared_device() {
    static device::Device device;
    return device;
}

reposition::Options options_of(const RawMesh& raw) {
    reposition::Options options;
    options.level = raw.level;
    return options;
}

Mesh repositioned(const RawMesh& raw, const reposition::Options& options,
                  reposition::Counters* counters = nullptr, device::Device* device = nullptr) {
    Mesh mesh = raw.mesh;
    const reposition::Counters found =
        reposition::reposition(device != nullptr ? *device : shared_device(), raw.model, options, mesh);
    if (counters != nullptr) *counters = found;
    return mesh;
}

struct Shape {
    double smallest = 180, largest = 0;  ///< dihedral angles, degrees
    double jacobian = 1;

    bool is_good(double slack = 0) const {
        return smallest >= 18 - slack && largest <= 155 + slack && jacobian >= 0.2 - slack;
    }
};

Shape shape_of(const Mesh& mesh, int t, std::size_t i) {
    const auto type = static_cast<ElementType>(t);
    const quality::Corners corners = quality::corners_of(mesh, type, i);
    double cosines[quality::kMostAngles];
    const int count = quality::dihedral_cosines(type, corners, cosines);
    Shape shape;
    shape.jacobian = quality::scaled_jacobian(type, corners);
    for (int k = 0; k < count; ++k) {
        const double angle = std::acos(std::clamp(cosines[k], -1.0, 1.0)) * 180 / std::acos(-1.0);
        shape.smallest = std::min(shape.smallest, angle);
        shape.largest = std::max(shape.largest, angle);
    }
    return shape;
}

std::vector<bool> moved_nodes(const Mesh& before, const Mesh& after) {
    std::vector<bool> moved(before.node_count());
    for (std::size_t i = 0; i < moved.size(); ++i) {
        moved[i] = !std::equal(before.points.begin() + static_cast<std::ptrdiff_t>(3 * i),
                               before.points.begin() + static_cast<std::ptrdiff_t>(3 * i + 3),
                               after.points.begin() + static_cast<std::ptrdiff_t>(3 * i));
    }
    return moved;
}

bool has_moved(const Mesh& mesh, int t, std::size_t i, const std::vector<bool>& moved) {
    const auto count = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(t)]);
    const NodeId* const node = mesh.elements[static_cast<std::size_t>(t)].nodes.data() + i * count;
    return std::any_of(node, node + count, [&](NodeId n) { return moved[n]; });
}

/// Calls visit(type, i) for all elements.
template <class Visit>
void for_all(const Mesh& mesh, const Visit& visit) {
    for (int t = 0; t < kElementTypes; ++t) {
        for (std::size_t i = 0; i < mesh.elements[static_cast<std::size_t>(t)].size(); ++i) visit(t, i);
    }
}

/// Distance of a node from a surface, to first order, in cells.
double off_surface(const RawMesh& raw, const Mesh& mesh, NodeId node, std::uint32_t surface) {
    double x[3];
    for (std::size_t j = 0; j < 3; ++j)
        x[j] = (mesh.points[3 * std::size_t{node} + j] - raw.model.origin[j]) / raw.model.side;
    const SurfaceSample at =
        surface_sample(&raw.model.surfaces[surface], raw.model.expression_ops.data(), x[0], x[1], x[2]);
    return std::fabs(at.value) / std::hypot(at.gradient[0], at.gradient[1], at.gradient[2]) *
           std::ldexp(1, raw.level);
}

/// Cubes inside around moved nodes, from what has moved.
std::vector<std::size_t> moved_cubes(const Mesh& before, const Mesh& after) {
    const std::vector<bool> moved = moved_nodes(before, after);
    std::vector<std::size_t> cubes;
    for (std::size_t i = 0; i < after.elements[0].size(); ++i) {
        if (after.elements[0].kind[i] == static_cast<std::uint8_t>(ElementKind::kIn) &&
            has_moved(after, 0, i, moved))
            cubes.push_back(i);
    }
    return cubes;
}

std::vector<std::size_t> listed(const IndexRuns& runs) {
    std::vector<std::size_t> list;
    for (const IndexRun& run : runs) {
        for (std::size_t i = run.begin; i < run.end; ++i) list.push_back(i);
    }
    return list;
}

}  // namespace

TEST_CASE("cubes inside around nodes that move are told") {
    std::size_t count = 0;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        CAPTURE(seed);
        const RawMesh raw = raw_mesh(random_ball(seed), 6);
        reposition::Counters counters;
        const Mesh mesh = repositioned(raw, options_of(raw), &counters);
        const std::vector<std::size_t> expected = moved_cubes(raw.mesh, mesh);
        CHECK(listed(counters.moved_cubes) == expected);
        count += expected.size();
    }
    CHECK(count > 0);
}

TEST_CASE("smooth surfaces: every element becomes good") {
    std::uint64_t poor = 0;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        CAPTURE(seed);
        const RawMesh raw = raw_mesh(random_ball(seed), seed % 2 == 0 ? 5 : 6);
        reposition::Counters counters;
        const Mesh mesh = repositioned(raw, options_of(raw), &counters);
        poor += counters.poor;
        CHECK(counters.left == 0);
        CHECK((counters.moved > 0) == (counters.poor > 0));
        std::size_t bad = 0, warped = 0;
        for_all(mesh, [&](int t, std::size_t i) {
            const Shape shape = shape_of(mesh, t, i);
            bad += shape.is_good(1e-6) ? 0 : 1;
            warped += t == 0 && shape.jacobian < 0.8 - 1e-6 ? 1 : 0;
        });
        CHECK(bad == 0);
        CHECK(warped == 0);
        const CheckReport check = check_mesh(mesh);
        CHECK(check.valid());
        CHECK(check.euler_characteristic == 2);
    }
    CHECK(poor > 50);
}

TEST_CASE("elements around nodes that moved are good, all others as they were") {
    for (const Case& item : cases()) {
        CAPTURE(item.name);
        reposition::Counters counters;
        const Mesh mesh = repositioned(item.raw, options_of(item.raw), &counters);
        const std::vector<bool> moved = moved_nodes(item.raw.mesh, mesh);
        CHECK(static_cast<std::uint64_t>(std::count(moved.begin(), moved.end(), true)) == counters.moved);
        std::size_t bad = 0, complex = 0, mended = 0;
        for_all(mesh, [&](int t, std::size_t i) {
            if (!has_moved(mesh, t, i, moved)) return;
            bad += shape_of(mesh, t, i).is_good(1e-6) ? 0 : 1;
            mended += shape_of(item.raw.mesh, t, i).is_good() ? 0 : 1;
            complex += mesh.elements[static_cast<std::size_t>(t)].kind[i] ==
                               static_cast<std::uint8_t>(ElementKind::kCnio)
                           ? 1
                           : 0;
        });
        CHECK(bad == 0);
        CHECK(complex == 0);
        CHECK((mended > 0) == (counters.moved > 0));
        CHECK(check_mesh(mesh).valid());
    }
}

TEST_CASE("nodes stay on their one surface; those of creases do not move") {
    std::size_t slid = 0, free = 0;
    for (const Case& item : cases()) {
        CAPTURE(item.name);
        const Mesh mesh = repositioned(item.raw, options_of(item.raw));
        const std::vector<bool> moved = moved_nodes(item.raw.mesh, mesh);
        std::vector<std::set<std::uint32_t>> surfaces(mesh.node_count());
        for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
            for (std::size_t k = 0; k < 4; ++k)
                surfaces[mesh.facets.nodes[4 * f + k]].insert(mesh.facets.surface[f]);
        }
        double farthest = 0;
        for (NodeId n = 0; n < mesh.node_count(); ++n) {
            if (!moved[n]) continue;
            CHECK(surfaces[n].size() <= 1);
            ++(surfaces[n].empty() ? free : slid);
            for (const std::uint32_t s : surfaces[n])
                farthest = std::max(farthest, off_surface(item.raw, mesh, n, s));
        }
        CHECK(farthest < 1e-7);  // the lattice's step is 1.5e-8 of a cell
    }
    CHECK(slid > 20);
    CHECK(free > 20);
}

TEST_CASE("kernels and host threads: the same bits, whatever the threads and work-groups") {
    for (const Case& item : cases()) {
        CAPTURE(item.name);
        reposition::Options options = options_of(item.raw);
        options.method = reposition::Method::kHost;
        options.threads = 1;
        const Mesh expected = repositioned(item.raw, options);
        options.threads = 3;
        CHECK(is_same_mesh(repositioned(item.raw, options), expected));
        options.method = reposition::Method::kDevice;
        for (const int group : {1, 7, 64}) {
            CAPTURE(group);
            device::DeviceOptions device_options;
            device_options.work_group_size = group;
            device::Device device("", device_options);
            CHECK(is_same_mesh(repositioned(item.raw, options, nullptr, &device), expected));
        }
    }
}

TEST_CASE("no rounds, held surfaces: what must stay stays") {
    const RawMesh raw = raw_mesh(random_ball(2), 5);
    reposition::Options options = options_of(raw);
    options.rounds = 0;
    reposition::Counters counters;
    CHECK(is_same_mesh(repositioned(raw, options, &counters), raw.mesh));
    CHECK(counters.poor > 0);
    CHECK(counters.left == counters.poor);
    options.rounds = 4;
    const std::vector<std::uint8_t> held(raw.model.surfaces.size(), 1);
    options.held = &held;
    const std::vector<bool> moved = moved_nodes(raw.mesh, repositioned(raw, options));
    for (const NodeId node : raw.mesh.facets.nodes) CHECK_FALSE(moved[node]);
}

TEST_CASE("random models: valid meshes stay valid, and no element that is not good gets worse") {
    const std::uint64_t count = environment_number("MORTISE_RANDOM_MODELS", 12);
    for (std::uint64_t seed = 1; seed <= count; ++seed) {
        CAPTURE(seed);
        const RawMesh raw = raw_mesh(random_polyhedron(seed), 4);
        const Mesh mesh = repositioned(raw, options_of(raw));
        const std::vector<bool> moved = moved_nodes(raw.mesh, mesh);
        for_all(mesh, [&](int t, std::size_t i) {
            if (has_moved(mesh, t, i, moved)) CHECK(shape_of(mesh, t, i).is_good(1e-6));
        });
        CHECK(check_mesh(mesh).valid());
    }
}

}  // namespace mortise::test
