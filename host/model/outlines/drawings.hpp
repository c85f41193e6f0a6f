// Readers of plane drawings for import(): DXF and SVG.
#pragma once

#include <string>
#include <vector>

#include "host/model/outlines/contours.hpp"

namespace mortise::model_reader {

struct DrawingOptions {
    std::string layer;    ///< DXF: only this layer; empty: all. SVG: only the group of that id or label
    Vec2 origin{};        ///< DXF: this point of the drawing becomes the origin
    double scale = 1;     ///< DXF, after the shift
    double dpi = 72;      ///< SVG: pixels per inch
    bool center = false;  ///< the box's middle becomes the origin
    double fn = 0;        ///< $fn, $fa, $fs: how finely curves are drawn
    double fa = 12;
    double fs = 2;
};

/// Pieces whose union is the drawing. Errors name line and column. What has no area or is not read (text,
/// dimensions, lines that do not close) is left out with a warning.
std::vector<Contours> read_dxf(const std::string& content, const std::string& source,
                               const DrawingOptions& options, std::vector<std::string>& warnings);
std::vector<Contours> read_svg(const std::string& content, const std::string& source,
                               const DrawingOptions& options, std::vector<std::string>& warnings);

/// Moves the middle of all pieces' box to the origin.
void center_pieces(std::vector<Contours>& pieces);

}  // namespace mortise::model_reader
