// The programs of kernels/ that most runs need.
#pragma once

#include <vector>

#include "host/device/device.hpp"

namespace mortise::pipeline {

/// By the time that PoCL takes to compile them, longest first. A test compares them with what a run builds.
inline const std::vector<device::ProgramName> kUsualPrograms = {
    {"snio/snap.cl", ""},     {"assembly/number.cl", ""}, {"snio/fill.cl", ""},
    {"snio/classify.cl", ""}, {"octree/descend.cl", ""},  {"snio/points.cl", ""},
    {"probe.cl", ""},         {"octree/leaves.cl", ""},   {"scan.cl", "-DSUM=uint"}};

/// What else a run may come to: many elements, cells of several sizes, options that leave stages out.
inline const std::vector<device::ProgramName> kOtherPrograms = {{"snio/share_points.cl", ""},
                                                                {"snio/misfits.cl", ""},
                                                                {"reposition/reposition.cl", ""},
                                                                {"jacobian/own.cl", ""}};

/// Those of the usual ones that a run asks for after it has begun its octree, in that order.
inline const std::vector<device::ProgramName> kLaterPrograms = {
    {"scan.cl", "-DSUM=uint"}, {"octree/leaves.cl", ""}, {"snio/classify.cl", ""},  {"snio/points.cl", ""},
    {"snio/snap.cl", ""},      {"snio/fill.cl", ""},     {"assembly/number.cl", ""}};

}  // namespace mortise::pipeline
