// Shape of single elements; definitions in shape.hpp.
#include "host/quality/shape.hpp"

#include <algorithm>
#include <string>

#include "mortise/error.hpp"

namespace mortise::quality {
namespace {

/// A node and its three neighbours in right-handed order.
using CornerNodes = int[4];

constexpr CornerNodes kHexahedronCorners[] = {{0, 1, 3, 4}, {1, 2, 0, 5}, {2, 3, 1, 6}, {3, 0, 2, 7},
                                              {4, 7, 5, 0}, {5, 4, 6, 1}, {6, 5, 7, 2}, {7, 6, 4, 3}};
constexpr CornerNodes kWedgeCorners[] = {{0, 1, 2, 3}, {1, 2, 0, 4}, {2, 0, 1, 5},
                                         {3, 5, 4, 0}, {4, 3, 5, 1}, {5, 4, 3, 2}};
constexpr CornerNodes kPyramidCorners[] = {{0, 1, 3, 4}, {1, 2, 0, 4}, {2, 3, 1, 4}, {3, 0, 2, 4}};
constexpr CornerNodes kTetrahedronCorners[] = {{0, 1, 2, 3}, {1, 2, 0, 3}, {2, 0, 1, 3}, {3, 1, 0, 2}};

struct CornerList {
    const CornerNodes* corners;
    int count;
};

CornerList corner_list(ElementType type) {
    switch (type) {
        case ElementType::kHexahedron: return {kHexahedronCorners, 8};
        case ElementType::kWedge: return {kWedgeCorners, 6};
        case ElementType::kPyramid: return {kPyramidCorners, 4};
        default: return {kTetrahedronCorners, 4};
    }
}

/// False: there is no angle.
bool find_cosine(const Vector& first_normal, const Vector& second_normal, double* cosine) {
    const double square = dot(first_normal, first_normal) * dot(second_normal, second_normal);
    if (!(square > 0)) return false;
    *cosine = std::clamp(-dot(first_normal, second_normal) / std::sqrt(square), -1.0, 1.0);
    return true;
}

void add_angle(const Vector& first_normal, const Vector& second_normal, ShapeFigures& figures) {
    double cosine;
    if (!find_cosine(first_normal, second_normal, &cosine)) return;
    figures.min_cosine = std::min(figures.min_cosine, cosine);
    figures.max_cosine = std::max(figures.max_cosine, cosine);
}

template <bool with_angles>
ShapeFigures figures_of(ElementType type, const Vector* p) {
    ShapeFigures figures;
    double smallest = 1;
    const CornerList list = corner_list(type);
    for (int i = 0; i < list.count; ++i) {
        const CornerNodes& corner = list.corners[i];
        const Vector a = p[corner[1]] - p[corner[0]];
        const Vector b = p[corner[2]] - p[corner[0]];
        const Vector c = p[corner[3]] - p[corner[0]];
        const Vector ab = cross(a, b);
        // The square, with the sign, as the kernels have it (kernels/jacobian/corner_value.h).
        const double determinant = dot(ab, c), squares = dot(a, a) * dot(b, b) * dot(c, c);
        const double square = squares > 0 ? determinant * std::fabs(determinant) / squares : 0;
        smallest = std::min(smallest, square);
        if constexpr (with_angles) {
            const Vector bc = cross(b, c), ca = cross(c, a);
            add_angle(ab, ca, figures);
            add_angle(ab, bc, figures);
            add_angle(bc, ca, figures);
        }
    }
    figures.scaled_jacobian = std::copysign(std::sqrt(std::fabs(smallest)), smallest);
    return figures;
}

}  // namespace

void require_elements(const Mesh& mesh) {
    const std::size_t nodes = mesh.node_count();
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = mesh.elements[t];
        const bool fits = block.nodes.size() == block.size() * static_cast<std::size_t>(kElementNodes[t]) &&
                          block.kind.size() == block.size();
        if (fits && std::all_of(block.nodes.begin(), block.nodes.end(),
                                [nodes](NodeId node) { return node < nodes; }))
            continue;
        throw Error(ExitCode::kMeshing,
                    std::string("invalid mesh: elements with ") +
                        (fits ? "a node index out of range" : "arrays of unequal length") +
                        "; see check_mesh");
    }
}

ShapeFigures shape_figures(ElementType type, const Corners& corners) {
    return figures_of<true>(type, corners.p);
}

int dihedral_cosines(ElementType type, const Corners& corners, double* cosines) {
    const CornerList list = corner_list(type);
    const Vector* p = corners.p;
    int count = 0;
    for (int i = 0; i < list.count; ++i) {
        const CornerNodes& corner = list.corners[i];
        const Vector a = p[corner[1]] - p[corner[0]];
        const Vector b = p[corner[2]] - p[corner[0]];
        const Vector c = p[corner[3]] - p[corner[0]];
        const Vector ab = cross(a, b), bc = cross(b, c), ca = cross(c, a);
        count += find_cosine(ab, ca, cosines + count) ? 1 : 0;
        count += find_cosine(ab, bc, cosines + count) ? 1 : 0;
        count += find_cosine(bc, ca, cosines + count) ? 1 : 0;
    }
    return count;
}

double scaled_jacobian(ElementType type, const Corners& corners) {
    return figures_of<false>(type, corners.p).scaled_jacobian;
}

}  // namespace mortise::quality
