// The device's scaled Jacobians: our own kernel and CLBlast's product against each other and host/quality.
#include <doctest/doctest.h>
#include <stdlib.h>  // setenv

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "host/jacobian/jacobian.hpp"
#include "mortise/check.hpp"
#include "mortise/error.hpp"
#include "tests/quality/sample_meshes.hpp"

using namespace mortise;
using jacobian::Method;

namespace {

/// Products take CLBlast's compile time, so all tests share one device.
device::Device& shared_device() {
    static device::Device device;
    return device;
}

/// The form of the kernels that GPUs run.
device::Device& scalar_device() {
    static device::Device device({}, [] {
        device::DeviceOptions options;
        options.lanes = 1;
        options.work_group_size = 7;
        options.copies = true;
        return options;
    }());
    return device;
}

/// Uniform in [-1, 1]; SplitMix64 (Steele, Lea & Flood 2014).
class Random {
  public:
    double next() {
        std::uint64_t word = state_ += 0x9e3779b97f4a7c15u;
        word = (word ^ (word >> 30)) * 0xbf58476d1ce4e5b9u;
        word = (word ^ (word >> 27)) * 0x94d049bb133111ebu;
        word ^= word >> 31;
        return std::ldexp(static_cast<double>(word >> 11), -52) - 1;
    }

  private:
    std::uint64_t state_ = 7;
};

const std::vector<std::array<double, 3>> kShapes[kElementTypes] = {
    {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}},
    {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}},
    {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}},
    {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

/// Elements of the usual shapes with nodes moved by up to `warp`, at random places and in random sizes; nodes
/// of their own.
void add_random(Mesh& mesh, ElementType type, std::size_t count, double warp, Random& random) {
    const auto& shape = kShapes[static_cast<std::size_t>(type)];
    for (std::size_t i = 0; i < count; ++i) {
        const double size = std::exp2(10 * random.next());
        const double place[3] = {100 * random.next(), 100 * random.next(), 100 * random.next()};
        std::vector<NodeId> nodes(shape.size());
        const auto first = static_cast<NodeId>(mesh.node_count());
        mesh.points.resize(mesh.points.size() + 3 * shape.size());
        for (std::size_t n = 0; n < shape.size(); ++n) {
            nodes[n] = first + static_cast<NodeId>(shape.size() - 1 - n);
            for (std::size_t j = 0; j < 3; ++j) {
                mesh.points[3 * nodes[n] + j] = place[j] + size * (shape[n][j] + warp * random.next());
            }
        }
        samples::add_element(mesh, type, nodes);
    }
}

ElementType type_of(int t) { return static_cast<ElementType>(t); }

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

/// All ways agree to the bit with each other, for either width of lanes, and to rounding with the
/// independent check.
void compare(const Mesh& mesh) {
    const std::vector<float> expected = scaled_jacobians(mesh);
    const std::vector<float> own = jacobian::scaled_jacobians(shared_device(), mesh, Method::kOwn);
    const std::vector<float> scalar = jacobian::scaled_jacobians(scalar_device(), mesh, Method::kOwn);
    const std::vector<float> product = jacobian::scaled_jacobians(shared_device(), mesh, Method::kProduct);
    REQUIRE(own.size() == expected.size());
    for (const int threads : {1, 3}) {
        const std::vector<float> host =
            jacobian::scaled_jacobians(shared_device(), mesh, Method::kHost, threads);
        CHECK(same_bits(own, host));
    }
    CHECK(same_bits(own, product));
    CHECK(same_bits(own, scalar));
    std::size_t different = 0;
    for (std::size_t i = 0; i < own.size(); ++i) {
        if (!(std::fabs(own[i] - expected[i]) <= 1e-6f * std::fabs(expected[i]))) ++different;
    }
    CHECK(different == 0);
}

}  // namespace

TEST_CASE("known scaled Jacobians") {
    Mesh mesh;
    Random random;
    for (int t = 0; t < kElementTypes; ++t) add_random(mesh, type_of(t), 1, 0, random);
    const std::vector<float> own = jacobian::scaled_jacobians(shared_device(), mesh, Method::kOwn);
    REQUIRE(own.size() == 4);
    CHECK(own[0] == doctest::Approx(1));
    CHECK(own[1] == doctest::Approx(std::sqrt(0.5)));
    CHECK(own[2] == doctest::Approx(std::sqrt(2.0 / 3)));  // |(1/2, 1/2, 1)| = sqrt(3/2)
    CHECK(own[3] == doctest::Approx(0.5));  // at a node beside the right angles: 1 / (√2 √2)
    compare(mesh);
}

TEST_CASE("both ways agree with the check on random elements, valid and not") {
    // Small and large warps; sizes on both sides of work-groups, and of CLBlast's two kinds of kernel.
    for (const double warp : {0.0, 0.1, 0.5, 2.0}) {
        for (const std::size_t count : {1, 2, 7, 33, 1001}) {
            CAPTURE(warp);
            CAPTURE(count);
            Mesh mesh;
            Random random;
            for (int t = 0; t < kElementTypes; ++t)
                add_random(mesh, type_of(t), count + static_cast<std::size_t>(t), warp, random);
            compare(mesh);
        }
    }
}

TEST_CASE("one type alone, more elements than one product takes") {
    Random random;
    for (int t = 0; t < kElementTypes; ++t) {
        CAPTURE(t);
        Mesh mesh;
        add_random(mesh, type_of(t), (std::size_t{1} << 17) + 3, 0.2, random);
        compare(mesh);
    }
}

TEST_CASE("singular elements are 0, elements inside out negative") {
    for (int t = 0; t < kElementTypes; ++t) {
        CAPTURE(t);
        const auto& shape = kShapes[t];
        const auto count = static_cast<NodeId>(shape.size());
        Mesh mesh;
        for (const auto& p : shape) samples::add_node(mesh, p[0], p[1], p[2]);
        for (const auto& p : shape) samples::add_node(mesh, p[0], p[1], 0);      // flat
        for (const auto& p : shape) samples::add_node(mesh, p[0], p[1], -p[2]);  // inside out
        std::vector<NodeId> nodes(count);
        for (NodeId first = 0; first < 3 * count; first += count) {
            for (NodeId n = 0; n < count; ++n) nodes[n] = first + n;
            samples::add_element(mesh, type_of(t), nodes);
        }
        samples::add_element(mesh, type_of(t), std::vector<NodeId>(count, 2));  // a point
        for (NodeId n = 0; n < count; ++n) nodes[n] = n;
        nodes[1] = nodes[0];  // an edge without length
        samples::add_element(mesh, type_of(t), nodes);
        compare(mesh);
        for (const Method method : {Method::kOwn, Method::kProduct}) {
            const std::vector<float> values = jacobian::scaled_jacobians(shared_device(), mesh, method);
            CHECK(values[0] > 0);
            CHECK(values[1] == 0);
            CHECK(values[2] < 0);
            CHECK(values[3] == 0);
            CHECK(values[4] <= 0);
        }
    }
}

TEST_CASE("cubes inside are 1 without a look, but for those that have moved") {
    Mesh mesh;
    Random random;
    constexpr std::size_t kCount = 4099;
    add_random(mesh, ElementType::kHexahedron, kCount, 0, random);
    add_random(mesh, ElementType::kTetrahedron, 9, 0.1, random);
    const auto warp = [&](std::size_t cube) {
        const NodeId* const node = mesh.elements[0].nodes.data() + 8 * cube;
        double* const p = mesh.points.data() + 3 * std::size_t{node[0]};
        p[1] += 0.3 * (mesh.points[3 * std::size_t{node[1]}] - p[0]);
    };
    const IndexRuns moved = {{5, 6}, {2000, 2010}, {kCount - 1, kCount}};
    for (const IndexRun& run : moved) {
        for (std::size_t i = run.begin; i < run.end; ++i) warp(i);
    }
    mesh.elements[0].kind.assign(kCount, static_cast<std::uint8_t>(ElementKind::kIn));
    for (const std::size_t other : {std::size_t{100}, std::size_t{2011}, kCount - 2}) {
        warp(other);
        mesh.elements[0].kind[other] = static_cast<std::uint8_t>(ElementKind::kSnio);
    }
    const std::vector<float> all = jacobian::scaled_jacobians(shared_device(), mesh, Method::kHost);
    CHECK(std::count_if(all.begin(), all.begin() + kCount, [](float v) { return v < 1; }) == 12 + 3);
    for (const Method method : {Method::kHost, Method::kOwn, Method::kProduct}) {
        CHECK(
            same_bits(all, jacobian::scaled_jacobians(shared_device(), mesh, method, 2, {&moved, nullptr})));
        CHECK(
            same_bits(all, jacobian::scaled_jacobians(scalar_device(), mesh, method, 2, {&moved, nullptr})));
    }
    // Far from those that count, so that a look would tell.
    warp(3000);
    for (const Method method : {Method::kHost, Method::kOwn}) {
        CHECK(
            same_bits(all, jacobian::scaled_jacobians(shared_device(), mesh, method, 2, {&moved, nullptr})));
        CHECK_FALSE(same_bits(all, jacobian::scaled_jacobians(shared_device(), mesh, method, 2)));
    }
}

TEST_CASE(
    "sixths of cubes have the scaled Jacobian that their nodes give, as far from the origin as is said") {
    Random random;
    for (int repeat = 0; repeat < 200; ++repeat) {
        // Cubes of one size at places of a grid that lies anywhere.
        const double edge = std::exp2(20 * random.next());
        const double reach = jacobian::kExactEdges * edge - 100 * edge;
        Vec3 origin;
        for (double& x : origin) x = reach * random.next();
        Mesh mesh;
        ElementBlock& block = mesh.block(ElementType::kTetrahedron);
        const std::size_t cubes = 50;
        for (std::size_t i = 0; i < cubes; ++i) {
            Vec3 cell;
            for (double& x : cell) x = std::floor(49 * (1 + random.next()));
            // Along the axes one after another, in any of the six orders.
            std::array<std::size_t, 3> axes = {0, 1, 2};
            do {
                std::array<double, 3> at = {cell[0], cell[1], cell[2]};
                for (std::size_t k = 0; k < 4; ++k) {
                    block.nodes.push_back(static_cast<NodeId>(mesh.node_count()));
                    for (std::size_t j = 0; j < 3; ++j) mesh.points.push_back(origin[j] + edge * at[j]);
                    if (k < 3) at[axes[k]] += 1;
                }
                const bool even = axes[1] == (axes[0] + 1) % 3;
                if (!even)
                    std::swap(block.nodes[block.nodes.size() - 1], block.nodes[block.nodes.size() - 2]);
                block.region.push_back(1);
                block.kind.push_back(static_cast<std::uint8_t>(ElementKind::kIn));
            } while (std::next_permutation(axes.begin(), axes.end()));
        }
        add_random(mesh, ElementType::kTetrahedron, 20, 0.1, random);
        const std::vector<float> all = mortise::scaled_jacobians(mesh);
        const IndexRuns sixths = {{0, 60}, {66, 6 * cubes}};
        for (const Method method : {Method::kHost, Method::kOwn})
            REQUIRE(same_bits(
                all, jacobian::scaled_jacobians(shared_device(), mesh, method, 2, {nullptr, &sixths})));
        if (repeat > 0) continue;
        // They are not looked at.
        mesh.points[0] += 0.1 * edge;
        REQUIRE(same_bits(
            all, jacobian::scaled_jacobians(shared_device(), mesh, Method::kOwn, 2, {nullptr, &sixths})));
    }
}

TEST_CASE("empty meshes") {
    Mesh mesh;
    samples::add_node(mesh, 1, 2, 3);
    for (const Method method : {Method::kHost, Method::kOwn, Method::kProduct}) {
        CHECK(jacobian::scaled_jacobians(shared_device(), Mesh{}, method).empty());
        CHECK(jacobian::scaled_jacobians(shared_device(), mesh, method).empty());
    }
}

TEST_CASE("the way follows size and the environment") {
    CHECK(jacobian::usual_method(1000) == Method::kHost);
    CHECK(jacobian::usual_method(10000000) == Method::kOwn);
    unsetenv("MORTISE_JACOBIANS");
    CHECK_FALSE(jacobian::wanted_method());
    setenv("MORTISE_JACOBIANS", "host", 1);
    CHECK(jacobian::wanted_method() == Method::kHost);
    setenv("MORTISE_JACOBIANS", "own", 1);
    CHECK(jacobian::wanted_method() == Method::kOwn);
    setenv("MORTISE_JACOBIANS", "clblast", 1);
    CHECK(jacobian::wanted_method() == Method::kProduct);
    setenv("MORTISE_JACOBIANS", "blas", 1);
    std::string message;
    try {
        jacobian::wanted_method();
    } catch (const Error& error) {
        CHECK(error.code() == ExitCode::kUsage);
        message = error.what();
    }
    CHECK(message.find("host, own or clblast") != std::string::npos);
    unsetenv("MORTISE_JACOBIANS");
}

TEST_CASE("CLBlast stays out of the usual way") {
    device::Device device;
    Mesh mesh;
    Random random;
    for (int t = 0; t < kElementTypes; ++t) add_random(mesh, type_of(t), 5, 0.1, random);
    jacobian::scaled_jacobians(device, mesh, jacobian::usual_method(std::size_t{1} << 30));
    const std::vector<device::KernelTime> times = device.times();
    CHECK(times.size() == kElementTypes);
    for (const device::KernelTime& time : times) CHECK(time.entry.find("_jacobians") != std::string::npos);
}

TEST_CASE("products: small matrices, and what is refused") {
    device::Device& device = shared_device();
    for (const std::size_t m : {1, 3, 70}) {
        const std::size_t n = 5, k = 4;
        std::vector<double> a(m * k), b(k * n), expected(m * n, 0.0);
        for (std::size_t i = 0; i < a.size(); ++i) a[i] = static_cast<double>(i % 13) - 6;
        for (std::size_t i = 0; i < b.size(); ++i) b[i] = static_cast<double>(i % 7) - 3;
        for (std::size_t j = 0; j < n; ++j)
            for (std::size_t i = 0; i < k; ++i)
                for (std::size_t r = 0; r < m; ++r) expected[r + m * j] += a[r + m * i] * b[i + k * j];
        const device::Buffer left = device.upload(a), right = device.upload(b);
        device::Buffer out = device.allocate(m * n * sizeof(double));
        device.multiply(left, right, out, m, n, k).wait();
        CHECK(device.download<double>(out, m * n) == expected);
        CHECK_THROWS_AS(device.multiply(left, right, out, m + 1, n, k), Error);
        CHECK_THROWS_AS(device.multiply(left, right, out, m, n, 0), Error);
        CHECK(device.multiply(left, right, out, 0, n, k).done());
    }
}
