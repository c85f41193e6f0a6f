// The geometry of SVG: path data, transforms, basic shapes.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "host/model/outlines/contours.hpp"
#include "host/model/outlines/drawings.hpp"

namespace mortise::model_reader {

/// x' = a x + c y + e, y' = b x + d y + f, in SVG's order a b c d e f.
using SvgMap = std::array<double, 6>;
inline constexpr SvgMap kSvgIdentity = {1, 0, 0, 1, 0, 0};
SvgMap svg_compose(const SvgMap& outer, const SvgMap& inner);

/// Subpaths of one shape; `open` tells which do not end where they began.
struct SvgOutline {
    Contours loops;
    std::vector<char> open;
};

/// How many straight pieces a curve gets; `unit` is the length of a user unit in the result.
struct SvgFineness {
    const DrawingOptions& options;
    double unit = 1;
};

/// These throw std::invalid_argument with a message that quotes what was not understood.
SvgOutline svg_path(std::string_view data, const SvgFineness& fineness);
SvgMap svg_transform(std::string_view text);
/// Numbers with blanks and commas between.
std::vector<double> svg_numbers(std::string_view text);
SvgOutline svg_ellipse(double cx, double cy, double rx, double ry, const SvgFineness& fineness);
SvgOutline svg_rectangle(double x, double y, double width, double height, double rx, double ry,
                         const SvgFineness& fineness);

}  // namespace mortise::model_reader
