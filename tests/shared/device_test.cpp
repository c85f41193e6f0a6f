// kernels/shared on the device: the same layout of every struct, and the same bits from every function, as on
// the host (kernels/layout_probe.cl).
#include <doctest/doctest.h>

#include <cstddef>
#include <cstring>
#include <vector>

#include "host/device/device.hpp"
#include "kernels/shared/bounds.h"
#include "kernels/shared/expression_bounds.h"
#include "kernels/shared/face_plan.h"
#include "kernels/shared/reposition.h"
#include "kernels/shared/snio.h"
#include "kernels/shared/template_table.h"
#include "tests/shared/random_surfaces.hpp"

using namespace mortise;
using mortise::test::RandomSource;

namespace {

struct Entry {
    const char* what;
    std::size_t bytes;
};

#define SIZE(type) \
    Entry { #type, sizeof(type) }
#define OFFSET(type, field) \
    Entry { #type "." #field, offsetof(type, field) }

const std::vector<Entry> kLayout = {SIZE(Surface),
                                    OFFSET(Surface, map),
                                    OFFSET(Surface, form),
                                    OFFSET(Surface, kind),
                                    OFFSET(Surface, first_op),
                                    OFFSET(Surface, op_count),
                                    OFFSET(Surface, padding),
                                    SIZE(SurfaceBounds),
                                    OFFSET(SurfaceBounds, map),
                                    OFFSET(SurfaceBounds, form),
                                    OFFSET(SurfaceBounds, error),
                                    OFFSET(SurfaceBounds, kind),
                                    OFFSET(SurfaceBounds, first_op),
                                    OFFSET(SurfaceBounds, op_count),
                                    OFFSET(SurfaceBounds, padding),
                                    SIZE(SurfaceSample),
                                    OFFSET(SurfaceSample, value),
                                    OFFSET(SurfaceSample, gradient),
                                    SIZE(ExpressionOp),
                                    OFFSET(ExpressionOp, operation),
                                    OFFSET(ExpressionOp, out),
                                    OFFSET(ExpressionOp, a),
                                    OFFSET(ExpressionOp, b),
                                    OFFSET(ExpressionOp, literal),
                                    SIZE(Interval),
                                    OFFSET(Interval, low),
                                    OFFSET(Interval, high),
                                    OFFSET(Interval, partial),
                                    SIZE(TreeNode),
                                    OFFSET(TreeNode, morton),
                                    OFFSET(TreeNode, tape_offset),
                                    OFFSET(TreeNode, tape_length),
                                    SIZE(ChildNode),
                                    OFFSET(ChildNode, place),
                                    OFFSET(ChildNode, tape_length),
                                    SIZE(InNode),
                                    OFFSET(InNode, morton),
                                    OFFSET(InNode, level),
                                    OFFSET(InNode, region),
                                    SIZE(FaceMeshPlan),
                                    OFFSET(FaceMeshPlan, no_apex),
                                    OFFSET(FaceMeshPlan, count),
                                    OFFSET(FaceMeshPlan, padding),
                                    OFFSET(FaceMeshPlan, facet),
                                    OFFSET(FaceMeshPlan, corner),
                                    SIZE(FacePlan),
                                    OFFSET(FacePlan, nodes),
                                    OFFSET(FacePlan, count),
                                    OFFSET(FacePlan, node),
                                    OFFSET(FacePlan, padding),
                                    OFFSET(FacePlan, mesh),
                                    SIZE(LoopPlan),
                                    OFFSET(LoopPlan, size),
                                    OFFSET(LoopPlan, node),
                                    SIZE(FacePlans),
                                    OFFSET(FacePlans, states),
                                    OFFSET(FacePlans, corners),
                                    OFFSET(FacePlans, cell_states),
                                    OFFSET(FacePlans, plan),
                                    OFFSET(FacePlans, loop),
                                    SIZE(SnioLeaf),
                                    OFFSET(SnioLeaf, surface),
                                    OFFSET(SnioLeaf, pattern),
                                    OFFSET(SnioLeaf, region),
                                    OFFSET(SnioLeaf, on),
                                    OFFSET(SnioLeaf, displaced),
                                    OFFSET(SnioLeaf, method),
                                    OFFSET(SnioLeaf, apex),
                                    OFFSET(SnioLeaf, faces),
                                    OFFSET(SnioLeaf, boundary),
                                    OFFSET(SnioLeaf, facet_count),
                                    OFFSET(SnioLeaf, snapped),
                                    OFFSET(SnioLeaf, facets),
                                    OFFSET(SnioLeaf, point),
                                    SIZE(SnioPoints),
                                    OFFSET(SnioPoints, moved),
                                    OFFSET(SnioPoints, root),
                                    SIZE(TemplateRow),
                                    OFFSET(TemplateRow, interior_mean),
                                    OFFSET(TemplateRow, first_node),
                                    OFFSET(TemplateRow, first_facet),
                                    OFFSET(TemplateRow, cuts),
                                    OFFSET(TemplateRow, corners),
                                    OFFSET(TemplateRow, shape),
                                    OFFSET(TemplateRow, elements),
                                    OFFSET(TemplateRow, facets),
                                    OFFSET(TemplateRow, padding),
                                    SIZE(StarElement),
                                    OFFSET(StarElement, node),
                                    OFFSET(StarElement, type),
                                    SIZE(MovableNode),
                                    OFFSET(MovableNode, node),
                                    OFFSET(MovableNode, first),
                                    OFFSET(MovableNode, elements),
                                    OFFSET(MovableNode, facets),
                                    OFFSET(MovableNode, surface),
                                    OFFSET(MovableNode, padding),
                                    SIZE(NodeMove),
                                    OFFSET(NodeMove, point),
                                    OFFSET(NodeMove, before),
                                    OFFSET(NodeMove, wanted),
                                    OFFSET(NodeMove, padding),
                                    SIZE(RepositionScale),
                                    OFFSET(RepositionScale, cell),
                                    OFFSET(RepositionScale, shortest),
                                    OFFSET(RepositionScale, units)};

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0 || (a != a && b != b); }

}  // namespace

TEST_CASE("structs have the same layout on the device") {
    device::Device device;
    device::Buffer out = device.allocate(256 * sizeof(std::uint32_t));
    device.launch(device.kernel("layout_probe.cl", "layout"), 1, out);
    const auto found = device.download<std::uint32_t>(out, 256);
    REQUIRE(found[0] == kLayout.size());
    for (std::size_t i = 0; i < kLayout.size(); ++i) {
        INFO(kLayout[i].what);
        CHECK(found[i + 1] == kLayout[i].bytes);
    }
}

TEST_CASE("surfaces give the same bits on the device") {
    RandomSource random(51);
    const double cell = 1.0 / 32;
    std::vector<Surface> surfaces;
    std::vector<ExpressionOp> ops;
    std::vector<double> points;
    constexpr std::size_t kCount = 5000;
    for (std::size_t i = 0; i < kCount; ++i) {
        surfaces.push_back(test::random_surface(random, static_cast<int>(i) % test::kSurfaceKinds, ops));
        double a[3];
        for (double& x : a) x = random.integer(0, 32) * cell;
        points.insert(points.end(), a, a + 3);
        a[random.integer(0, 2)] += random.integer(1, 8) * cell;
        points.insert(points.end(), a, a + 3);
    }
    device::Device device;
    const device::Buffer device_surfaces = device.upload(surfaces);
    const device::Buffer device_ops = device.upload(ops);
    const device::Buffer device_points = device.upload(points);
    device::Buffer device_values = device.allocate(6 * kCount * sizeof(double));
    device::Buffer device_signs = device.allocate(2 * kCount * sizeof(std::int32_t));
    device.launch(device.kernel("layout_probe.cl", "evaluate"), kCount, device_surfaces, device_ops,
                  device_points, device_values, device_signs, cell);
    const auto values = device.download<double>(device_values, 6 * kCount);
    const auto signs = device.download<std::int32_t>(device_signs, 2 * kCount);
    std::size_t roots = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
        const Surface* s = &surfaces[i];
        const double* a = &points[6 * i];
        const double* b = a + 3;
        CAPTURE(i);
        CAPTURE(s->kind);
        const SurfaceSample sample = surface_sample(s, ops.data(), a[0], a[1], a[2]);
        CHECK(same_bits(values[6 * i], surface_value(s, ops.data(), a[0], a[1], a[2])));
        CHECK(same_bits(values[6 * i + 1], sample.value));
        for (std::size_t j = 0; j < 3; ++j) CHECK(same_bits(values[6 * i + 2 + j], sample.gradient[j]));
        const double root = segment_root(s, ops.data(), a, b);
        CHECK(same_bits(values[6 * i + 5], root));
        CHECK(signs[2 * i] == surface_sign(s, ops.data(), a[0], a[1], a[2], cell));
        if (root == root) CHECK(signs[2 * i + 1] == edge_root(s, ops.data(), a, b));
        roots += root > 0 && root < 1;
    }
    CHECK(roots > kCount / 2);
}
