// write_picture: an orthographic view of the outer boundary, or of a cut, seen from the right, front and
// above.
//
// Depth is a fraction of the model's extent, kept as float: facets closer to each other than 1e-7 of it may
// show through.
#include <png.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "host/common/vec3.hpp"
#include "host/io/cut_faces.hpp"
#include "host/io/formats.hpp"
#include "host/io/raster.hpp"
#include "mortise/error.hpp"
#include "mortise/io.hpp"

namespace mortise {
namespace {

using io::Colour;
using io::ScreenPoint;

constexpr int kSamples = 2;
constexpr int kMaxSize = 16384;
constexpr double kMargin = 0.04;  // of the picture, on each side
constexpr Vec3 kTowardsEye = {1.0, -1.3, 0.9};
constexpr Vec3 kTowardsLight = {0.25, -0.75, 1.0};

/// Colours of surfaces, by index; muted, and neighbours easy to tell apart.
constexpr std::array<Colour, 12> kPalette = {{{0.48f, 0.67f, 0.85f},
                                              {0.95f, 0.70f, 0.42f},
                                              {0.55f, 0.77f, 0.55f},
                                              {0.87f, 0.55f, 0.55f},
                                              {0.69f, 0.61f, 0.82f},
                                              {0.93f, 0.84f, 0.50f},
                                              {0.47f, 0.76f, 0.75f},
                                              {0.90f, 0.65f, 0.78f},
                                              {0.72f, 0.62f, 0.52f},
                                              {0.66f, 0.75f, 0.38f},
                                              {0.60f, 0.66f, 0.72f},
                                              {0.80f, 0.55f, 0.38f}}};

/// Palette colour; every round through the palette is a little darker.
Colour surface_colour(std::uint32_t surface) {
    const Colour base = kPalette[surface % kPalette.size()];
    const float shade = 1.0f - 0.12f * static_cast<float>((surface / kPalette.size()) % 4);
    return {base.red * shade, base.green * shade, base.blue * shade};
}

constexpr float kPale = 0.4f;  ///< how much of a region's colour cut faces have, beside white
/// By ElementKind: what makes cut faces darker.
constexpr std::array<float, 5> kKindShades = {1.0f, 0.88f, 0.8f, 0.84f, 0.66f};

Colour colour_of(const io::DrawnFace& face) {
    if (face.is_facet) return surface_colour(face.surface);
    const Colour base = surface_colour(face.region - 1u);
    const float shade = face.kind < kKindShades.size() ? kKindShades[face.kind] : 1.0f;
    const auto pale = [shade](float part) { return shade * (1 - kPale + kPale * part); };
    return {pale(base.red), pale(base.green), pale(base.blue)};
}

Colour lit(const Colour& colour, const Vec3& normal) {
    // Light from one side, a weaker reflection from the ground and the dark.
    const double facing = dot(normal, unit(kTowardsLight));
    const float light =
        static_cast<float>(0.62 + 0.42 * std::max(0.0, facing) - 0.14 * std::max(0.0, -facing));
    return {colour.red * light, colour.green * light, colour.blue * light};
}

/// Outward normal: half the cross product of the diagonals is the area vector, of a triangle too, whose last
/// node is repeated.
Vec3 normal(const std::array<Vec3, 4>& p) {
    return unit(cross(difference(p[2], p[0]), difference(p[3], p[1])));
}

/// Maps model to picture so that the faces fill it.
class View {
  public:
    View(const Mesh& mesh, const std::vector<io::DrawnFace>& faces, int width, int height) : mesh_(mesh) {
        eye_ = unit(kTowardsEye);
        right_ = unit(cross({0, 0, 1}, eye_));
        up_ = cross(eye_, right_);
        constexpr double infinity = std::numeric_limits<double>::infinity();
        double low[3] = {infinity, infinity, infinity}, high[3] = {-infinity, -infinity, -infinity};
        for (const io::DrawnFace& face : faces) {
            for (const NodeId node : face.node) {
                const Vec3 p = point(node);
                const double along[3] = {dot(p, right_), dot(p, up_), dot(p, eye_)};
                for (int axis = 0; axis < 3; ++axis) {
                    low[axis] = std::min(low[axis], along[axis]);
                    high[axis] = std::max(high[axis], along[axis]);
                }
            }
        }
        const double free = 1 - 2 * kMargin;
        const double scale = std::min(free * width / (high[0] - low[0]), free * height / (high[1] - low[1]));
        scale_ = std::isfinite(scale) ? scale : 1;
        depth_scale_ = high[2] > low[2] ? 1 / (high[2] - low[2]) : 1;
        nearest_ = high[2];
        centre_[0] = 0.5 * width - scale_ * 0.5 * (low[0] + high[0]);
        centre_[1] = 0.5 * height + scale_ * 0.5 * (low[1] + high[1]);
    }

    Vec3 point(NodeId node) const {
        const double* p = mesh_.points.data() + 3 * static_cast<std::size_t>(node);
        return {p[0], p[1], p[2]};
    }

    ScreenPoint screen(const Vec3& p) const {
        return {centre_[0] + scale_ * dot(p, right_), centre_[1] - scale_ * dot(p, up_),
                depth_scale_ * (nearest_ - dot(p, eye_))};
    }

  private:
    const Mesh& mesh_;
    Vec3 eye_{}, right_{}, up_{};
    double scale_ = 1, depth_scale_ = 1, nearest_ = 0;
    double centre_[2] = {0, 0};
};

void write_png(const std::vector<std::uint8_t>& pixels, int width, int height, const std::string& path) {
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = static_cast<png_uint_32>(width);
    image.height = static_cast<png_uint_32>(height);
    image.format = PNG_FORMAT_RGB;
    image.flags = PNG_IMAGE_FLAG_FAST;
    // Libpng's bound, so that one call is enough.
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
    std::vector<char> bytes(size);
    if (png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr) == 0)
        throw Error(ExitCode::kFiles, "cannot write '" + path + "': libpng: " + image.message);
    io::TemporaryFile file(path);
    file.write(bytes.data(), size);
    file.commit();
}

}  // namespace

void write_picture(const Mesh& mesh, const std::string& path, const PictureOptions& options) {
    const int width = options.width, height = options.height;
    if (width < 1 || height < 1 || width > kMaxSize || height > kMaxSize)
        throw Error(ExitCode::kUsage, "picture size " + std::to_string(width) + " x " +
                                          std::to_string(height) + ": expected 1 to " +
                                          std::to_string(kMaxSize) + " in each direction");
    if (options.cut && (options.cut->axis < 0 || options.cut->axis > 2))
        throw Error(ExitCode::kUsage, "picture cut across axis " + std::to_string(options.cut->axis) +
                                          ": expected 0, 1 or 2 for x, y or z");
    const std::string error = io::find_range_error(mesh);
    if (!error.empty())
        throw Error(ExitCode::kMeshing,
                    "cannot write '" + path + "': invalid mesh: " + error + "; see check_mesh");
    const std::vector<io::DrawnFace> faces =
        options.cut ? io::faces_behind(mesh, *options.cut) : io::outer_faces(mesh);
    io::Raster raster(width, height, kSamples);
    if (!faces.empty()) {
        const View view(mesh, faces, width, height);
        for (const io::DrawnFace& face : faces) {
            std::array<Vec3, 4> p;
            std::array<ScreenPoint, 4> corners;
            for (std::size_t k = 0; k < 4; ++k) {
                p[k] = view.point(face.node[k]);
                corners[k] = view.screen(p[k]);
            }
            raster.draw(corners.data(), face.node[2] == face.node[3] ? 3 : 4,
                        lit(colour_of(face), normal(p)));
        }
    }
    write_png(raster.pixels(), width, height, path);
}

}  // namespace mortise
