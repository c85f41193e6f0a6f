// For tests/shared: what the device makes of kernels/shared, to be compared with the host.
//
// layout: sizes and offsets of every struct, in the order of tests/shared/device_test.cpp.
// evaluate: surfaces at points and along segments; the bits must equal the host's (shared/platform.h).
#define MORTISE_ONE_LANE
#include "shared/bounds.h"
#include "shared/expression_bounds.h"
#include "shared/face_plan.h"
#include "shared/lattice.h"
#include "shared/reposition.h"
#include "shared/snio.h"
#include "shared/surface.h"
#include "shared/template_table.h"

#define SIZE(type) out[at++] = (uint)sizeof(type)
#define OFFSET(type, field)                                                  \
    {                                                                        \
        type probe;                                                          \
        out[at++] = (uint)((const char*)&probe.field - (const char*)&probe); \
    }

// Writes out[0] = number of entries, then the entries. One work-item.
MORTISE_KERNEL void layout(__global uint* out, uint items) {
    uint at = 1;
    if (get_global_id(0) >= items) return;
    SIZE(Surface);
    OFFSET(Surface, map)
    OFFSET(Surface, form)
    OFFSET(Surface, kind)
    OFFSET(Surface, first_op)
    OFFSET(Surface, op_count)
    OFFSET(Surface, padding)
    SIZE(SurfaceBounds);
    OFFSET(SurfaceBounds, map)
    OFFSET(SurfaceBounds, form)
    OFFSET(SurfaceBounds, error)
    OFFSET(SurfaceBounds, kind)
    OFFSET(SurfaceBounds, first_op)
    OFFSET(SurfaceBounds, op_count)
    OFFSET(SurfaceBounds, padding)
    SIZE(SurfaceSample);
    OFFSET(SurfaceSample, value)
    OFFSET(SurfaceSample, gradient)
    SIZE(ExpressionOp);
    OFFSET(ExpressionOp, operation)
    OFFSET(ExpressionOp, out)
    OFFSET(ExpressionOp, a)
    OFFSET(ExpressionOp, b)
    OFFSET(ExpressionOp, literal)
    SIZE(Interval);
    OFFSET(Interval, low)
    OFFSET(Interval, high)
    OFFSET(Interval, partial)
    SIZE(TreeNode);
    OFFSET(TreeNode, morton)
    OFFSET(TreeNode, tape_offset)
    OFFSET(TreeNode, tape_length)
    SIZE(ChildNode);
    OFFSET(ChildNode, place)
    OFFSET(ChildNode, tape_length)
    SIZE(InNode);
    OFFSET(InNode, morton)
    OFFSET(InNode, level)
    OFFSET(InNode, region)
    SIZE(FaceMeshPlan);
    OFFSET(FaceMeshPlan, no_apex)
    OFFSET(FaceMeshPlan, count)
    OFFSET(FaceMeshPlan, padding)
    OFFSET(FaceMeshPlan, facet)
    OFFSET(FaceMeshPlan, corner)
    SIZE(FacePlan);
    OFFSET(FacePlan, nodes)
    OFFSET(FacePlan, count)
    OFFSET(FacePlan, node)
    OFFSET(FacePlan, padding)
    OFFSET(FacePlan, mesh)
    SIZE(LoopPlan);
    OFFSET(LoopPlan, size)
    OFFSET(LoopPlan, node)
    SIZE(FacePlans);
    OFFSET(FacePlans, states)
    OFFSET(FacePlans, corners)
    OFFSET(FacePlans, cell_states)
    OFFSET(FacePlans, plan)
    OFFSET(FacePlans, loop)
    SIZE(SnioLeaf);
    OFFSET(SnioLeaf, surface)
    OFFSET(SnioLeaf, pattern)
    OFFSET(SnioLeaf, region)
    OFFSET(SnioLeaf, on)
    OFFSET(SnioLeaf, displaced)
    OFFSET(SnioLeaf, method)
    OFFSET(SnioLeaf, apex)
    OFFSET(SnioLeaf, faces)
    OFFSET(SnioLeaf, boundary)
    OFFSET(SnioLeaf, facet_count)
    OFFSET(SnioLeaf, snapped)
    OFFSET(SnioLeaf, facets)
    OFFSET(SnioLeaf, point)
    SIZE(SnioPoints);
    OFFSET(SnioPoints, moved)
    OFFSET(SnioPoints, root)
    SIZE(TemplateRow);
    OFFSET(TemplateRow, interior_mean)
    OFFSET(TemplateRow, first_node)
    OFFSET(TemplateRow, first_facet)
    OFFSET(TemplateRow, cuts)
    OFFSET(TemplateRow, corners)
    OFFSET(TemplateRow, shape)
    OFFSET(TemplateRow, elements)
    OFFSET(TemplateRow, facets)
    OFFSET(TemplateRow, padding)
    SIZE(StarElement);
    OFFSET(StarElement, node)
    OFFSET(StarElement, type)
    SIZE(MovableNode);
    OFFSET(MovableNode, node)
    OFFSET(MovableNode, first)
    OFFSET(MovableNode, elements)
    OFFSET(MovableNode, facets)
    OFFSET(MovableNode, surface)
    OFFSET(MovableNode, padding)
    SIZE(NodeMove);
    OFFSET(NodeMove, point)
    OFFSET(NodeMove, before)
    OFFSET(NodeMove, wanted)
    OFFSET(NodeMove, padding)
    SIZE(RepositionScale);
    OFFSET(RepositionScale, cell)
    OFFSET(RepositionScale, shortest)
    OFFSET(RepositionScale, units)
    out[0] = at - 1;
}

// Reads points[6i] … points[6i + 5], the ends of segment i, and surface i. Writes values[6i …]: value,
// sampled value, gradient, root; and signs[2i …]: sign at the first end, root in lattice units. One work-item
// handles one segment.
MORTISE_KERNEL void evaluate(__global const Surface* surfaces, __global const ExpressionOp* ops,
                             __global const double* points, __global double* values, __global int* signs,
                             double cell_size, uint items) {
    const uint item = get_global_id(0);
    if (item >= items) return;
    double a[3];
    double b[3];
    SurfaceSample sample;
    for (int j = 0; j < 3; ++j) {
        a[j] = points[6 * item + j];
        b[j] = points[6 * item + 3 + j];
    }
    sample = surface_sample(surfaces + item, ops, a[0], a[1], a[2]);
    values[6 * item] = surface_value(surfaces + item, ops, a[0], a[1], a[2]);
    values[6 * item + 1] = sample.value;
    for (int j = 0; j < 3; ++j) values[6 * item + 2 + j] = sample.gradient[j];
    values[6 * item + 5] = segment_root(surfaces + item, ops, a, b);
    signs[2 * item] = surface_sign(surfaces + item, ops, a[0], a[1], a[2], cell_size);
    signs[2 * item + 1] = edge_root(surfaces + item, ops, a, b);
}
