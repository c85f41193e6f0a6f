#include "host/pipeline/check_options.hpp"

#include <cmath>
#include <limits>

#include "host/octree/octree.hpp"
#include "host/pipeline/message_text.hpp"
#include "host/pipeline/periodic_box.hpp"
#include "mortise/error.hpp"

namespace mortise::pipeline {
namespace {

constexpr int kMostPieces = 4096;
constexpr double kAny = std::numeric_limits<double>::max();

[[noreturn]] void refuse(const std::string& text) { throw Error(ExitCode::kUsage, text); }

/// An option that is a number, and what it may be.
struct Range {
    const char* name;
    double value;
    double low, high;
    const char* use;  ///< instead of the range, if that says little
    const char* unit = "";
};

void check_range(const Range& range) {
    if (range.value >= range.low && range.value <= range.high) return;
    std::string text = range.name + (" " + number_text(range.value)) + " is out of range; use ";
    if (range.use != nullptr) {
        text += range.use;
    } else {
        text += number_text(range.low) + " to " + number_text(range.high) + range.unit;
    }
    refuse(text);
}

void check_length(const std::string& name, double value, bool may_be_zero) {
    if (std::isfinite(value) && (value > 0 || (may_be_zero && value == 0))) return;
    refuse(name + " " + number_text(value) + " is out of range; use a positive length" +
           (may_be_zero ? ", or 0 for none" : ""));
}

void check_sizes(const MeshOptions& options) {
    check_length("size_min", options.size_min, true);
    check_length("size_max", options.size_max, true);
    for (const auto& [name, size] : options.named_sizes) check_length("size of '" + name + "'", size, false);
    for (const SizeSource& source : options.sizes) {
        const std::string place = " around " + place_text(source.at);
        check_length("size" + place, source.size, false);
        if (!std::isfinite(source.at[0] + source.at[1] + source.at[2]))
            refuse("the size" + place + " has no place; use finite coordinates");
        if (!(source.grading >= 0 && std::isfinite(source.grading)))
            refuse("grading " + number_text(source.grading) + " of the size" + place +
                   " is out of range; use 0 or more");
    }
    if (options.size_max > 0 && options.size_min > options.size_max) {
        refuse("the smallest cell size " + number_text(options.size_min) + " is above the largest, " +
               number_text(options.size_max) + "; give size_min (--size-min) up to size_max (--size-max)");
    }
    if (options.curvature_elements > 0 && options.refine == 0)
        refuse("curvature_elements " + number_text(options.curvature_elements) +
               " works within refine, which is 0; give both");
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

void check_options(const MeshOptions& options) {
    const Range ranges[] = {
        {"level", double(options.level), 0, octree::kMaxUniformLevel, "1 to 11, or 0 for the default"},
        {"cell size", options.size, 0, kAny, "a positive length"},
        {"smooth", double(options.smooth), 0, kMostSmooth, nullptr, " rounds"},
        {"threads", double(options.threads), 0, kAny, "0 for all cores, or a count from 1"},
        {"pieces", double(options.pieces), 1, kMostPieces, nullptr},
        {"refine", double(options.refine), 0, kMaxLevel, nullptr, " levels"},
        {"interior_coarsening", double(options.interior_coarsening), 0, kMaxLevel, nullptr, " levels"},
        {"curvature_elements", options.curvature_elements, 0, kAny, "a positive number, or 0 for none"},
        {"merge_distance", options.merge_distance, 0, kMostMergeDistance, nullptr, " of a cell"},
        {"count of layers", double(options.layers.count), 0, kMostLayers, nullptr},
        {"growth of layers", options.layers.growth, kLeastLayerGrowth, kMostLayerGrowth, nullptr},
        {"smallest angle", options.min_angle, kLeastMinAngle, kMostMinAngle, nullptr, " degrees"},
    };
    static_assert(octree::kMaxUniformLevel == kMostLevel && kMostLevel == 11, "as the range of `level` says");
    for (const Range& range : ranges) check_range(range);
    check_work_group(options.work_group_size);
    check_sizes(options);
    if (options.level > 0 && options.size > 0) {
        refuse("level " + std::to_string(options.level) + " and cell size " + number_text(options.size) +
               " are both given; leave one of them 0");
    }
    if (options.hanging && options.tetrahedra)
        refuse("hanging nodes are those of hexahedra; leave them or tetrahedra away");
    if (options.hanging && options.second_order)
        refuse("hanging nodes are those of elements of first order; leave them or second_order away");
    check_length("height of the first layer", options.layers.first, true);
    if (options.layers.count > 0 && options.hanging)
        refuse("layers need a mesh that conforms; leave them or hanging nodes away");
    if (options.layers.count > 0 && options.second_order)
        refuse("layers are of first order; leave them or second_order away");
    if (options.min_angle > kLeastMinAngle && !options.improve)
        refuse("a smallest angle needs elements to be improved");
    if (options.box) check_box(*options.box);
    axes_of(options.periodic);
    if (options.layers.count > 0 && !options.periodic.empty())
        refuse("layers do not go with periodic faces yet; leave them or periodic away");
}

}  // namespace mortise::pipeline
