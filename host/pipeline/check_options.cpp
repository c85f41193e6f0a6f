#include "host/pipeline/check_options.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "host/common/message_text.hpp"
#include "host/octree/octree.hpp"
#include "host/pipeline/periodic_box.hpp"
#include "mortise/error.hpp"

namespace mortise {
namespace pipeline {
namespace {

constexpr int kMostPieces = 4096;
constexpr double kAny = std::numeric_limits<double>::max();

[[noreturn]] void refuse(const std::string& text) { throw Error(ExitCode::kUsage, text); }

/// An option that is a number, and what it may be.
struct Range {
    const char* name;  ///< as MeshOptions and the command line have it
    double value;
    double low, high;
    const char* use;  ///< instead of the range, if that says little
    const char* unit = "";
};

void check_range(const Range& range) {
    if (range.value >= range.low && range.value <= range.high) return;
    std::string text = range.name + (" " + rounded_text(range.value)) + " is out of range; use ";
    if (range.use != nullptr) {
        text += range.use;
    } else {
        text += rounded_text(range.low) + " to " + rounded_text(range.high) + range.unit;
    }
    refuse(text);
}

void check_length(const std::string& name, double value, bool may_be_zero) {
    if (std::isfinite(value) && (value > 0 || (may_be_zero && value == 0))) return;
    refuse(name + " " + rounded_text(value) + " is out of range; use a positive length" +
           (may_be_zero ? ", or 0 for none" : ""));
}

void check_sizes(const MeshOptions& options) {
    check_length("size_min (--size-min)", options.size_min, true);
    check_length("size_max (--size-max)", options.size_max, true);
    for (const auto& [name, size] : options.named_sizes) check_length("size of '" + name + "'", size, false);
    for (const SizeSource& source : options.sizes) {
        const std::string place = " around " + place_text(source.at);
        check_length("size" + place, source.size, false);
        if (!std::isfinite(source.at[0] + source.at[1] + source.at[2]))
            refuse("the size" + place + " has no place; use finite coordinates");
        if (!(source.grading >= 0 && std::isfinite(source.grading)))
            refuse("growth " + rounded_text(source.grading) + " of the size" + place +
                   " is out of range; use 0 or more");
    }
    if (options.size_max > 0 && options.size_min > options.size_max) {
        refuse("the smallest cell size " + rounded_text(options.size_min) + " is above the largest, " +
               rounded_text(options.size_max) + "; give size_min (--size-min) up to size_max (--size-max)");
    }
    if (options.curvature_elements > 0 && options.refine == 0)
        refuse("curvature_elements (--curvature-elements) " + rounded_text(options.curvature_elements) +
               " works within refine (--refine), which is 0; give both");
    if (options.curvature_elements > 0 && options.curvature_elements < kLeastCurvatureElements)
        refuse("curvature_elements (--curvature-elements) " + rounded_text(options.curvature_elements) +
               " is out of range; use a number from 3, or 0 for none");
}

/// Options that exclude each other, and what is true without one of them.
void check_together(const MeshOptions& options) {
    const bool layers = options.layers.count > 0;
    const std::pair<bool, const char*> wrong[] = {
        {options.level > 0 && options.size > 0, "level and size (--level, --size) are both given"},
        {options.hanging && options.tetrahedra,
         "hanging and tetrahedra (--hanging, --elements tet): only hexahedra have hanging nodes"},
        {options.hanging && options.second_order,
         "hanging and second_order (--hanging, --order 2): only elements of first order have hanging nodes"},
        {layers && options.hanging,
         "layers and hanging (--layers, --hanging): layers need a mesh that conforms"},
        {layers && options.second_order,
         "layers and second_order (--layers, --order 2): layers are of first order"},
        {layers && !options.periodic.empty(),
         "layers and periodic (--layers, --periodic): layers do not go with periodic faces yet"},
    };
    for (const auto& [is_wrong, text] : wrong) {
        if (is_wrong) refuse(std::string(text) + "; leave one of the two out");
    }
    if (options.min_angle > kLeastMinAngle && !options.improve)
        refuse(
            "min_angle (--min-angle) without improve (--no-improve): elements reach larger angles by being "
            "improved only");
}

void check_box(const Box3& box) {
    for (std::size_t j = 0; j < 3; ++j) {
        const std::string along = std::string(" along ") + "xyz"[j];
        if (!std::isfinite(box.max[j] - box.min[j])) refuse("the box is not finite" + along);
        if (!(box.min[j] < box.max[j]))
            refuse("the box is empty" + along + "; give its minimum corner, then its maximum corner");
    }
}

}  // namespace

void check_work_group(int size) {
    check_range({"work-group size", double(size), 0, kAny, "0 for the device's default, or a size from 1"});
}

}  // namespace pipeline

void check_options(const MeshOptions& options) {
    using namespace pipeline;
    const Range ranges[] = {
        {"level", double(options.level), 0, octree::kMaxUniformLevel, "1 to 11, or 0 for the default"},
        {"size (--size)", options.size, 0, kAny, "a positive length"},
        {"smooth (--smooth)", double(options.smooth), 0, kMostSmooth, nullptr, " rounds"},
        {"threads", double(options.threads), 0, kAny, "0 for all cores, or a count from 1"},
        {"pieces", double(options.pieces), 1, kMostPieces, nullptr},
        {"refine (--refine)", double(options.refine), 0, kMaxLevel, nullptr, " levels"},
        {"interior_coarsening (--interior-coarsening)", double(options.interior_coarsening), 0, kMaxLevel,
         nullptr, " levels"},
        {"curvature_elements (--curvature-elements)", options.curvature_elements, 0, kAny,
         "a number from 3, or 0 for none"},
        {"merge_distance (--merge)", options.merge_distance, 0, kMostMergeDistance, nullptr, " of a cell"},
        {"count of layers (--layers)", double(options.layers.count), 0, kMostLayers, nullptr},
        {"growth of layers (--layer-growth)", options.layers.growth, kLeastLayerGrowth, kMostLayerGrowth,
         nullptr},
        {"min_angle (--min-angle)", options.min_angle, kLeastMinAngle, kMostMinAngle, nullptr, " degrees"},
    };
    static_assert(octree::kMaxUniformLevel == kMostLevel && kMostLevel == 11, "as the range of `level` says");
    for (const Range& range : ranges) check_range(range);
    check_work_group(options.work_group_size);
    check_sizes(options);
    check_length("height of the first layer (--first-layer)", options.layers.first, true);
    if (options.box) check_box(*options.box);
    axes_of(options.periodic);
    check_together(options);
}

}  // namespace mortise
