#include "host/pipeline/periodic_box.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>

#include "host/common/box_faces.hpp"
#include "host/pipeline/check_options.hpp"
#include "mortise/error.hpp"

namespace mortise::pipeline {

std::vector<std::size_t> axes_of(const std::string& periodic) {
    std::vector<std::size_t> axes;
    for (const char letter : periodic) {
        const std::size_t axis = std::string("xyz").find(letter);
        if (axis == std::string::npos || std::find(axes.begin(), axes.end(), axis) != axes.end())
            throw Error(ExitCode::kUsage, "periodic axes '" + periodic +
                                              "': expected some of the letters x, y and z, each once");
        axes.push_back(axis);
    }
    std::sort(axes.begin(), axes.end());
    return axes;
}

PeriodicTask repeat_in_box(const Model& model, const MeshOptions& options) {
    check_options(options);
    check_model(model);
    const std::optional<Box3> box = options.box ? options.box : model.clip;
    if (!box)
        throw Error(ExitCode::kUsage,
                    "periodic faces are those of a box that cuts the solid, and there is none; give the box "
                    "that is repeated (--box X0 Y0 Z0 X1 Y1 Z1)");
    PeriodicTask task = {model, options};
    task.options.box.reset();
    task.options.periodic.clear();
    Model& result = task.model;
    if (!options.box) result.clip.reset();
    std::array<std::array<std::uint32_t, 2>, 3> plane{};
    std::vector<std::uint32_t> parts;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t side = 0; side < 2; ++side) {
            const Vec3 corner = side == 0 ? box->min : box->max;
            Vec3 normal{};
            normal[axis] = side == 0 ? -1 : 1;
            plane[axis][side] =
                result.add_primitive(half_space(corner, normal), kBoxFaceNames[2 * axis + side]);
            parts.push_back(plane[axis][side]);
        }
    }
    for (Region& region : result.regions) {
        std::vector<std::uint32_t> children = parts;
        children.push_back(region.root);
        region.root = result.add_operation(CsgNode::Op::kIntersection, std::move(children));
    }
    for (const std::size_t axis : axes_of(options.periodic))
        result.periodic.push_back({{plane[axis][0]}, {plane[axis][1]}, std::string(1, "xyz"[axis]), {}});
    return task;
}

}  // namespace mortise::pipeline
