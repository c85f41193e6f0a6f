#include "host/tape/primitive_shape.hpp"

namespace mortise::tape {

void set_shape(const Primitive& primitive, Surface& surface) {
    const auto scale_row = [&surface](int row, double factor) {
        for (int j = 0; j < 4; ++j) surface.map[4 * row + j] *= factor;
    };
    switch (primitive.kind) {
        case Primitive::Kind::kSphere:
        case Primitive::Kind::kCylinder:
            surface.kind = kSurfaceQuadric;
            for (int i = 0; i < 3; ++i) scale_row(i, 1 / primitive.radius);
            surface.form[0] = surface.form[1] = 1;
            surface.form[2] = primitive.kind == Primitive::Kind::kSphere ? 1 : 0;
            surface.form[3] = -1;
            break;
        case Primitive::Kind::kDoubleCone:
            surface.kind = kSurfaceQuadric;
            scale_row(2, primitive.slope);
            surface.map[11] += primitive.radius;
            surface.form[0] = surface.form[1] = 1;
            surface.form[2] = -1;
            break;
        case Primitive::Kind::kCone:
            surface.kind = kSurfaceCone;
            scale_row(2, -primitive.slope);
            surface.map[11] -= primitive.radius;
            break;
        case Primitive::Kind::kTorus:
            surface.kind = kSurfaceTorus;
            surface.form[0] = primitive.major;
            surface.form[3] = -primitive.radius * primitive.radius;
            break;
        default: break;
    }
}

}  // namespace mortise::tape
