// Shape of single elements; definitions in shape.hpp.
#include "host/quality/shape.hpp"

#include <algorithm>

namespace mortise::quality {
namespace {

/// A node and its three neighbours in right-handed order.
using Corner = int[4];

constexpr Corner kHexahedronCorners[] = {{0, 1, 3, 4}, {1, 2, 0, 5}, {2, 3, 1, 6}, {3, 0, 2, 7},
                                         {4, 7, 5, 0}, {5, 4, 6, 1}, {6, 5, 7, 2}, {7, 6, 4, 3}};
constexpr Corner kWedgeCorners[] = {{0, 1, 2, 3}, {1, 2, 0, 4}, {2, 0, 1, 5},
                                    {3, 5, 4, 0}, {4, 3, 5, 1}, {5, 4, 3, 2}};
constexpr Corner kPyramidCorners[] = {{0, 1, 3, 4}, {1, 2, 0, 4}, {2, 3, 1, 4}, {3, 0, 2, 4}};
constexpr Corner kTetrahedronCorners[] = {{0, 1, 2, 3}, {1, 2, 0, 3}, {2, 0, 1, 3}, {3, 1, 0, 2}};

struct CornerList {
    const Corner* corners;
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

void add_angle(const Vector& first_normal, const Vector& second_normal, ShapeFigures& figures) {
    const double square = dot(first_normal, first_normal) * dot(second_normal, second_normal);
    if (!(square > 0)) return;
    const double cosine = -dot(first_normal, second_normal) / std::sqrt(square);
    figures.min_cosine = std::min(figures.min_cosine, std::max(cosine, -1.0));
    figures.max_cosine = std::max(figures.max_cosine, std::min(cosine, 1.0));
}

template <bool with_angles>
ShapeFigures figures_of(ElementType type, const Vector* p) {
    ShapeFigures figures;
    const CornerList list = corner_list(type);
    for (int i = 0; i < list.count; ++i) {
        const Corner& corner = list.corners[i];
        const Vector a = p[corner[1]] - p[corner[0]];
        const Vector b = p[corner[2]] - p[corner[0]];
        const Vector c = p[corner[3]] - p[corner[0]];
        const Vector ab = cross(a, b);
        const double lengths = std::sqrt(dot(a, a) * dot(b, b)) * length(c);
        const double scaled = lengths > 0 ? dot(ab, c) / lengths : 0;
        figures.scaled_jacobian = std::min(figures.scaled_jacobian, scaled);
        if constexpr (with_angles) {
            const Vector bc = cross(b, c), ca = cross(c, a);
            add_angle(ab, ca, figures);
            add_angle(ab, bc, figures);
            add_angle(bc, ca, figures);
        }
    }
    return figures;
}

}  // namespace

ShapeFigures shape_figures(ElementType type, const Corners& corners) {
    return figures_of<true>(type, corners.p);
}

double scaled_jacobian(ElementType type, const Corners& corners) {
    return figures_of<false>(type, corners.p).scaled_jacobian;
}

}  // namespace mortise::quality
